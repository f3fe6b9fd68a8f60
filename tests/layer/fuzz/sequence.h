// One fuzzed application: a seeded sequence of all calls that the layer intercepts or implements, with valid and
// destroyed handles, handles of other types, null pointers, wrong structure types, wrong counts and times, chains of
// unknown structures. Every call and its result is one line of the transcript, free of handles, path atoms and times,
// so that the same seed over two chains gives the same text where both answer alike. What the spec never allows is a
// violation.
#pragma once

#include <functional>
#include <initializer_list>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "tests/layer/fuzz/own_calls.h"
#include "tests/layer/fuzz/random.h"
#include "tests/layer/mini_loader/mini_loader.h"

namespace omni::test {

// The handles of one type that the sequence has made.
template <class Handle>
struct Pool {
  std::vector<Handle> live;
  std::vector<Handle> dead;
};

struct SequenceOptions {
  std::uint64_t seed = 0;
  int steps = 60;
  // The layer's own extensions are enabled, most of the time each.
  bool ours = false;
  // How long the service is waited for, before the first step: for the device, and for a scene.
  std::int64_t patience_ns = 0;
  // Called between two steps: what happens outside of the application.
  std::function<void(Random&)> world = {};
  // Called once the session is focused and attached: waits for the pen. The function syncs.
  std::function<void(const std::function<std::string()>& sync_and_profile)> arrive = {};
};

class Sequence {
 public:
  Sequence(const MiniLoader& loader, const SequenceOptions& options);
  ~Sequence();
  Sequence(const Sequence&) = delete;
  Sequence& operator=(const Sequence&) = delete;

  const std::vector<std::string>& transcript() const { return lines_; }
  const std::vector<std::string>& violations() const { return violations_; }

 private:
  // sequence.cc
  void Prepare();
  void PrepareOurs();
  void Step();
  void Say(const char* call, XrResult result, const std::string& rest = {});
  void Violation(const std::string& text);
  // The results that the specification allows for the call, besides XR_SUCCESS.
  void Expect(const char* call, XrResult result, std::initializer_list<XrResult> known);
  template <class Handle>
  Handle Pick(const Pool<Handle>& pool);
  // Destroys one of them, or an invalid one; none: it was rejected.
  template <class Handle>
  std::optional<Handle> Drop(Pool<Handle>& pool, XrResult(XRAPI_PTR* destroy)(Handle), const char* what);
  // There is none; most calls would only return that error.
  template <class Handle>
  bool Lacks(const Pool<Handle>& pool) {
    return pool.live.empty() && random_.Percent(80);
  }
  template <class T>
  T* OrNull(T* pointer);
  // The handle is a child of the session: both end together.
  template <class Handle>
  void Keep(Pool<Handle>& pool, Handle handle, XrSession session);
  template <class Handle>
  void Bury(Pool<Handle>& pool, XrSession session);
  // Mostly a space of the session that this handle is, or is a child of.
  XrSpace SpaceFor(const void* handle);
  XrStructureType Type(XrStructureType right);
  const void* Chain();
  XrPath AnyPath();
  XrPath HandPath();
  XrPath Interned(const std::string& text);
  std::string Text(XrPath path);

  // calls_actions.cc
  void Paths();
  void MakeSet();
  void MakeAction(XrActionType type);
  void DropSet();
  void DropAction();
  void Suggest(bool sane);
  void Attach(bool sane);
  XrResult SyncOnce(bool sane);
  void Bool();
  void Float();
  void Vector();
  void PoseState();
  void Profile();
  void Sources();
  void SourceName();
  template <class State>
  void CheckState(const char* call, const State& state, bool rests);

  // calls_session.cc
  void MakeSession();
  void DropSession();
  void Begin();
  void End();
  void Exit();
  void Poll();
  void Frame();
  void Views();
  void ActionSpace();
  void ReferenceSpace();
  void DropSpace();
  void Locate();
  XrPosef AnyPose();
  void CheckPlace(XrSpaceLocationFlags flags, const XrPosef& pose);
  void CheckSpeed(XrSpaceLocationFlags place, XrSpaceVelocityFlags flags, const XrVector3f& linear,
                  const XrVector3f& angular);
  static std::string PoseText(const XrPosef& pose);

  // calls_locate.cc
  void LocateMany();
  void MakeHand();
  void DropHand();
  void Joints();
  XrTime AnyTime();

  // calls_haptics.cc
  void Vibrate();
  void Stop();
  void Shape();
  void SampleRate();
  XrAction HapticAction();
  XrSession MainSession();
  void CheckHaptic(const char* call, XrResult result);
  float AnyNumber();
  XrDuration AnyDuration();

  // calls_force.cc
  void MakeForce();
  void DropForce();
  void Push();
  void Constrain();
  void StopForce();
  void ForceState();
  void ForceProperties();
  void SystemSays();

  // calls_scene.cc
  void MakeScene();
  void DropScene();
  void SceneState();
  void SceneNodes();
  void PlaceScene();
  void MoveNodes();
  void SceneMaterial();
  void Contacts();
  void SceneMesh();
  XrHapticNodeIdOMNIX1 AnyNode();

  // calls_models.cc
  void ModelIds();
  void MakeModel();
  void DropModel();
  void ModelProperties();
  void ModelState();
  void ModelSpace();
  void ModelPaths();
  void MakeAsset();
  void DropAsset();
  void AssetData();
  void AssetNodes();

  SequenceOptions options_;
  Random random_;
  Functions f_;
  OwnCalls own_;
  XrInstance instance_ = XR_NULL_HANDLE;
  XrSystemId system_ = XR_NULL_SYSTEM_ID;
  Pool<XrSession> sessions_;
  Pool<XrActionSet> sets_;
  Pool<XrAction> actions_;
  Pool<XrSpace> spaces_;
  Pool<XrHandTrackerEXT> hands_;
  Pool<XrRenderModelEXT> models_;
  Pool<XrRenderModelAssetEXT> assets_;
  std::vector<XrRenderModelIdEXT> model_ids_;
  std::vector<XrUuidEXT> cache_ids_;
  Pool<XrForceFeedbackOMNIX1> forces_;
  Pool<XrHapticSceneOMNIX1> scenes_;
  std::vector<XrHapticNodeIdOMNIX1> nodes_;
  std::map<const void*, XrSession> session_of_;
  XrAction vibration_ = XR_NULL_HANDLE;
  std::vector<XrPath> paths_;
  std::set<XrSession> waited_;  // a frame was waited for and not begun: another wait would block
  std::vector<std::string> lines_;
  std::vector<std::string> violations_;
  int made_ = 0;  // names must differ
  XrBaseInStructure unknown_{};
};

}  // namespace omni::test
