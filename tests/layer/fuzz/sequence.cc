#include "tests/layer/fuzz/sequence.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <string_view>

#include "tests/layer/fuzz/pick.h"
#include "tests/layer/mini_loader/chain_app.h"
#include "tests/layer/support/app.h"

namespace omni::test {
namespace {

const std::vector<std::string> kPaths = {
    "/user/hand/left",
    "/user/hand/right",
    "/user/gamepad",
    "/user/head",
    "/user/hand",
    "/interaction_profiles/oculus/touch_controller",
    "/interaction_profiles/khr/simple_controller",
    "/interaction_profiles/logitech/mx_ink_stylus_logitech",
    "/interaction_profiles/nobody/nothing",
    "/user/hand/left/input/trigger/value",
    "/user/hand/right/input/trigger/value",
    "/user/hand/right/input/trigger",
    "/user/hand/left/input/thumbstick",
    "/user/hand/right/input/thumbstick",
    "/user/hand/right/input/a/click",
    "/user/hand/left/input/x/click",
    "/user/hand/right/input/x/click",
    "/user/hand/left/input/grip/pose",
    "/user/hand/right/input/aim/pose",
    "/user/hand/right/input/grip",
    "/user/hand/left/output/haptic",
    "/user/hand/right/output/haptic",
    "/user/hand/right/input/select/click",
};

constexpr XrStructureType kUnknownType = static_cast<XrStructureType>(1999999999);

constexpr const char* kOwnExtensions[] = {XR_FB_HAPTIC_AMPLITUDE_ENVELOPE_EXTENSION_NAME,
                                          XR_FB_HAPTIC_PCM_EXTENSION_NAME, XR_OMNIX1_FORCE_FEEDBACK_EXTENSION_NAME,
                                          XR_OMNIX1_HAPTIC_SCENE_EXTENSION_NAME};

}  // namespace

OwnCalls LoadOwn(const MiniLoader& loader, XrInstance instance) {
  OwnCalls calls;
#define OMNI_LOAD(name) calls.name = reinterpret_cast<PFN_xr##name>(loader.Get(instance, "xr" #name));
  OMNI_FORCE_CALLS(OMNI_LOAD)
  OMNI_SCENE_CALLS(OMNI_LOAD)
  OMNI_MODEL_CALLS(OMNI_LOAD)
  OMNI_LOAD(GetDeviceSampleRateFB)
#undef OMNI_LOAD
  return calls;
}

Sequence::Sequence(const MiniLoader& loader, const SequenceOptions& options)
    : options_(options), random_(options.seed) {
  ChainOptions chain;
  if (random_.Percent(50)) chain.api_version = XR_MAKE_VERSION(1, 1, 0);
  chain.extensions.push_back(XR_KHR_LOCATE_SPACES_EXTENSION_NAME);
  chain.extensions.push_back(XR_EXT_HAND_TRACKING_EXTENSION_NAME);
  for (const char* name :
       {XR_EXT_UUID_EXTENSION_NAME, XR_EXT_RENDER_MODEL_EXTENSION_NAME, XR_EXT_INTERACTION_RENDER_MODEL_EXTENSION_NAME})
    chain.extensions.push_back(name);
  bool force = false;  // without it there is no instance with the scene's
  for (const char* own : kOwnExtensions) {
    if (!options_.ours || !random_.Percent(85)) continue;
    const std::string_view name = own;
    force = force || name == XR_OMNIX1_FORCE_FEEDBACK_EXTENSION_NAME;
    if (force || name != XR_OMNIX1_HAPTIC_SCENE_EXTENSION_NAME) chain.extensions.push_back(own);
  }
  if (XR_FAILED(loader.CreateInstance(InstanceInfo(chain), &instance_))) throw std::runtime_error("xrCreateInstance");
  f_ = loader.Load(instance_);
  own_ = LoadOwn(loader, instance_);
  const XrSystemGetInfo info{XR_TYPE_SYSTEM_GET_INFO, nullptr, XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY};
  f_.GetSystem(instance_, &info, &system_);
  for (const std::string& text : kPaths) paths_.push_back(Interned(text));
  unknown_.type = kUnknownType;
  if (random_.Percent(85)) Prepare();
  for (int i = 0; i < options_.steps; ++i) {
    if (options_.world) options_.world(random_);
    Step();
  }
}

Sequence::~Sequence() { f_.DestroyInstance(instance_); }

// An application with session, actions and spaces set up, so that the calls that follow have an effect.
void Sequence::Prepare() {
  MakeSet();
  for (const XrActionType type : {XR_ACTION_TYPE_POSE_INPUT, XR_ACTION_TYPE_BOOLEAN_INPUT, XR_ACTION_TYPE_FLOAT_INPUT,
                                  XR_ACTION_TYPE_VECTOR2F_INPUT, XR_ACTION_TYPE_VIBRATION_OUTPUT})
    MakeAction(type);
  if (actions_.live.size() == 5) vibration_ = actions_.live.back();
  if (random_.Percent(30)) {
    MakeSet();
    MakeAction(XR_ACTION_TYPE_BOOLEAN_INPUT);
  }
  MakeSession();
  Suggest(true);
  Attach(true);
  for (int i = 0; i < 12; ++i) Poll();
  if (sessions_.live.empty() || !options_.arrive) return;
  const XrSession session = sessions_.live.front();
  options_.arrive([&] {
    SyncOnce(true);
    XrInteractionProfileState profile{XR_TYPE_INTERACTION_PROFILE_STATE, nullptr, XR_NULL_PATH};
    f_.GetCurrentInteractionProfile(session, Interned("/user/hand/right"), &profile);
    return Text(profile.interactionProfile);
  });
  PrepareOurs();
}

// A scene that is loaded and a device that is held, if the service is quick enough.
void Sequence::PrepareOurs() {
  const std::int64_t end = Now_ns() + options_.patience_ns;
  while (Now_ns() < end && (nodes_.empty() || forces_.live.empty())) {
    SyncOnce(true);
    if (forces_.live.empty()) MakeForce();
    if (scenes_.live.empty()) MakeScene();
    SceneNodes();
    Pause_ms(2);
  }
}

void Sequence::Step() {
  struct Weighted {
    int weight;
    void (*call)(Sequence&);
  };
  static constexpr XrActionType kTypes[] = {XR_ACTION_TYPE_BOOLEAN_INPUT, XR_ACTION_TYPE_FLOAT_INPUT,
                                            XR_ACTION_TYPE_VECTOR2F_INPUT, XR_ACTION_TYPE_POSE_INPUT,
                                            XR_ACTION_TYPE_VIBRATION_OUTPUT};
  static constexpr Weighted kCalls[] = {
      {2, [](Sequence& s) { s.Paths(); }},
      {2, [](Sequence& s) { s.MakeSet(); }},
      {3, [](Sequence& s) { s.MakeAction(kTypes[s.random_.Below(5)]); }},
      {1, [](Sequence& s) { s.DropSet(); }},
      {1, [](Sequence& s) { s.DropAction(); }},
      {4, [](Sequence& s) { s.Suggest(false); }},
      {2, [](Sequence& s) { s.Attach(false); }},
      {14, [](Sequence& s) { s.SyncOnce(s.random_.Percent(60)); }},
      {6, [](Sequence& s) { s.Bool(); }},
      {6, [](Sequence& s) { s.Float(); }},
      {4, [](Sequence& s) { s.Vector(); }},
      {4, [](Sequence& s) { s.PoseState(); }},
      {5, [](Sequence& s) { s.Profile(); }},
      {3, [](Sequence& s) { s.Sources(); }},
      {3, [](Sequence& s) { s.SourceName(); }},
      {1, [](Sequence& s) { s.MakeSession(); }},
      {1, [](Sequence& s) { s.DropSession(); }},
      {1, [](Sequence& s) { s.Begin(); }},
      {1, [](Sequence& s) { s.End(); }},
      {1, [](Sequence& s) { s.Exit(); }},
      {8, [](Sequence& s) { s.Poll(); }},
      {1, [](Sequence& s) { s.Frame(); }},
      {2, [](Sequence& s) { s.Views(); }},
      {6, [](Sequence& s) { s.ActionSpace(); }},
      {3, [](Sequence& s) { s.ReferenceSpace(); }},
      {1, [](Sequence& s) { s.DropSpace(); }},
      {14, [](Sequence& s) { s.Locate(); }},
      {6, [](Sequence& s) { s.LocateMany(); }},
      {1, [](Sequence& s) { s.MakeHand(); }},
      {1, [](Sequence& s) { s.DropHand(); }},
      {3, [](Sequence& s) { s.Joints(); }},
      {4, [](Sequence& s) { s.Vibrate(); }},
      {2, [](Sequence& s) { s.Stop(); }},
      {6, [](Sequence& s) { s.Shape(); }},
      {2, [](Sequence& s) { s.SampleRate(); }},
      {3, [](Sequence& s) { s.MakeForce(); }},
      {1, [](Sequence& s) { s.DropForce(); }},
      {4, [](Sequence& s) { s.Push(); }},
      {4, [](Sequence& s) { s.Constrain(); }},
      {1, [](Sequence& s) { s.StopForce(); }},
      {3, [](Sequence& s) { s.ForceState(); }},
      {2, [](Sequence& s) { s.ForceProperties(); }},
      {1, [](Sequence& s) { s.SystemSays(); }},
      {3, [](Sequence& s) { s.MakeScene(); }},
      {1, [](Sequence& s) { s.DropScene(); }},
      {3, [](Sequence& s) { s.SceneState(); }},
      {3, [](Sequence& s) { s.SceneNodes(); }},
      {3, [](Sequence& s) { s.PlaceScene(); }},
      {4, [](Sequence& s) { s.MoveNodes(); }},
      {2, [](Sequence& s) { s.SceneMaterial(); }},
      {3, [](Sequence& s) { s.Contacts(); }},
      {1, [](Sequence& s) { s.SceneMesh(); }},
      {3, [](Sequence& s) { s.ModelIds(); }},
      {3, [](Sequence& s) { s.MakeModel(); }},
      {1, [](Sequence& s) { s.DropModel(); }},
      {2, [](Sequence& s) { s.ModelProperties(); }},
      {2, [](Sequence& s) { s.ModelState(); }},
      {2, [](Sequence& s) { s.ModelSpace(); }},
      {2, [](Sequence& s) { s.ModelPaths(); }},
      {2, [](Sequence& s) { s.MakeAsset(); }},
      {1, [](Sequence& s) { s.DropAsset(); }},
      {1, [](Sequence& s) { s.AssetData(); }},
      {1, [](Sequence& s) { s.AssetNodes(); }},
  };
  int total = 0;
  for (const Weighted& w : kCalls) total += w.weight;
  int at = static_cast<int>(random_.Below(static_cast<std::uint32_t>(total)));
  for (const Weighted& w : kCalls) {
    at -= w.weight;
    if (at < 0) return w.call(*this);
  }
}

void Sequence::Say(const char* call, XrResult result, const std::string& rest) {
  lines_.push_back(std::string(call) + " -> " + std::to_string(static_cast<int>(result)) + rest);
  // The result of an exception that an entry point stopped; the runtime never returns it.
  if (result == XR_ERROR_RUNTIME_FAILURE || result == XR_ERROR_OUT_OF_MEMORY)
    Violation(std::string(call) + " failed internally: " + Name(result));
}

void Sequence::Violation(const std::string& text) {
  violations_.push_back("seed " + std::to_string(options_.seed) + ", call " + std::to_string(lines_.size()) + ": " +
                        text);
}

void Sequence::Expect(const char* call, XrResult result, std::initializer_list<XrResult> known) {
  if (result == XR_SUCCESS || std::find(known.begin(), known.end(), result) != known.end()) return;
  Violation(std::string(call) + " must not return " + Name(result));
}

XrSpace Sequence::SpaceFor(const void* handle) {
  const auto session = session_of_.find(handle);
  std::vector<XrSpace> spaces;
  for (const XrSpace space : spaces_.live)
    if (session != session_of_.end() && session_of_[space] == session->second) spaces.push_back(space);
  return spaces.empty() || random_.Percent(8) ? Pick(spaces_) : random_.Of(spaces);
}

XrStructureType Sequence::Type(XrStructureType right) { return random_.Percent(3) ? kUnknownType : right; }

// Unknown structures must be skipped.
const void* Sequence::Chain() { return random_.Percent(5) ? &unknown_ : nullptr; }

XrPath Sequence::AnyPath() {
  const std::uint32_t kind = random_.Below(20);
  if (kind == 0) return XR_NULL_PATH;
  if (kind == 1) return XrPath{987654321};
  return random_.Of(paths_);
}

XrPath Sequence::HandPath() {
  const std::uint32_t kind = random_.Below(10);
  if (kind < 4) return paths_[1];
  if (kind < 6) return paths_[0];
  return kind < 8 ? XrPath{XR_NULL_PATH} : AnyPath();
}

XrPath Sequence::Interned(const std::string& text) {
  XrPath path = XR_NULL_PATH;
  f_.StringToPath(instance_, text.c_str(), &path);
  return path;
}

std::string Sequence::Text(XrPath path) {
  char text[XR_MAX_PATH_LENGTH] = {};
  std::uint32_t length = 0;
  if (path == XR_NULL_PATH) return {};
  if (XR_FAILED(f_.PathToString(instance_, path, sizeof(text), &length, text))) Violation("an invalid path");
  return text;
}

}  // namespace omni::test
