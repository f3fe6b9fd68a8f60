// XR_OMNIX1_haptic_scene: the record of an application's scene, and its messages to the service. At most one per
// instance, since the service keeps one per client. One mutex orders all messages about it; no runtime function is
// called under it.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "layer/include/openxr/omni_haptic_scene.h"
#include "layer/src/instance/clock.h"
#include "layer/src/instance/event_queue.h"
#include "layer/src/instance/records.h"
#include "layer/src/service/service_link.h"
#include "layer/src/spaces/locate.h"
#include "service/base/material.h"
#include "service/base/unique_fd.h"

namespace omni::layer {

class Locator;

// The scene's own frame at the service (z up, scaled) against the document's (y up): x_Z = scale * C x_G.
Pose DocumentAxes();  // C as a pose without translation

// Where an application has put its scene.
struct ScenePlacement {
  XrSpace base = XR_NULL_HANDLE;
  Pose X_SG;  // document's frame in the space, lengths in metres
  double scale = 1;
};

struct HapticScene {
  XrHapticSceneOMNIX1 handle = XR_NULL_HANDLE;  // its own address
  XrSession session = XR_NULL_HANDLE;
  std::uint32_t number = 0;
  base::UniqueFd document;
  std::uint64_t bytes = 0;
  std::uint32_t flags = 0;

  // As sent to the service, and sent again after a reconnection.
  std::optional<ScenePlacement> placement;
  protocol::HapticScenePlace place;                         // in the base frame
  Motion X_OG;                                              // document's frame in the base frame, lengths in metres
  std::map<std::uint32_t, protocol::HapticNodePose> nodes;  // by object
  std::int64_t nodes_t_ns = 0;
  std::map<std::uint32_t, base::MaterialParameters> changed;  // by material
  bool enabled = true;
  std::uint64_t sent = 0;  // the connection over which it was sent; 0: none

  // As reported by the service.
  XrHapticSceneStatusOMNIX1 status = XR_HAPTIC_SCENE_STATUS_LOADING_OMNIX1;
  protocol::HapticSceneState state;
  std::string text;
  client::HapticSceneTable table;
  bool ever_ready = false;

  bool surfaces_asked = false;
  std::map<std::uint32_t, client::SurfaceCopy> surfaces;  // by object
};

class HapticScenes {
 public:
  HapticScenes(const HandleMap<XrSession, Session>& sessions, ServiceLink& link, const RuntimeClock& clock,
               EventQueue& events, Locator& locator)
      : sessions_(sessions), link_(link), clock_(clock), events_(events), locator_(locator) {}

  bool Contains(XrHapticSceneOMNIX1 handle) const;

  // haptic_scene.cc
  XrResult Create(XrSession session, const XrHapticSceneCreateInfoOMNIX1* info, XrHapticSceneOMNIX1* scene);
  XrResult Destroy(XrHapticSceneOMNIX1 scene);
  XrResult GetState(XrHapticSceneOMNIX1 scene, XrHapticSceneStateOMNIX1* state);
  XrResult GetDiagnostics(XrHapticSceneOMNIX1 scene, uint32_t capacity, uint32_t* count, char* text);
  XrResult SetPlacement(XrHapticSceneOMNIX1 scene, const XrHapticScenePlacementOMNIX1* placement);
  XrResult SetEnabled(XrHapticSceneOMNIX1 scene, XrBool32 enabled);
  XrResult SetMaterial(XrHapticSceneOMNIX1 scene, uint32_t material, const XrHapticMaterialOMNIX1* wanted);
  XrResult MoveNodes(XrHapticSceneOMNIX1 scene, const XrHapticNodesUpdateInfoOMNIX1* info);

  // haptic_scene_queries.cc
  XrResult EnumerateNodes(XrHapticSceneOMNIX1 scene, uint32_t capacity, uint32_t* count,
                          XrHapticSceneNodeOMNIX1* nodes);
  XrResult GetMaterial(XrHapticSceneOMNIX1 scene, uint32_t material, XrHapticMaterialOMNIX1* out);
  XrResult EnumerateContacts(XrHapticSceneOMNIX1 scene, const XrHapticContactsGetInfoOMNIX1* info, uint32_t capacity,
                             uint32_t* count, XrHapticContactOMNIX1* contacts);
  XrResult GetNodeMesh(XrHapticSceneOMNIX1 scene, const XrHapticNodeMeshGetInfoOMNIX1* info,
                       XrHapticNodeMeshOMNIX1* mesh);

  // Handles the service's messages and sends what it does not have yet; events go to the instance's queue.
  void Poll();
  // The placement of a scene follows its space: once a frame.
  void FollowSpace(XrSession session, XrTime time);
  void ForgetSpace(XrSpace space);
  void EndOf(XrSession session);
  // A status event of a destroyed scene.
  bool IsOfDestroyed(const XrEventDataBuffer& event) const;

 private:
  enum class Need {
    kHandle,  // state, diagnostics, destruction
    kUsable,  // has not failed
    kReady    // has nodes and materials
  };
  // Calls body(scene) with the mutex held; an error if there is no such scene, or it does not meet the need.
  template <class Body>
  XrResult WithScene(XrHapticSceneOMNIX1 handle, Need need, Body body) {
    const std::lock_guard lock(mutex_);
    const XrResult result = Check(handle, need);
    return XR_SUCCEEDED(result) ? body(*scene_) : result;
  }
  // Where a space is in the base frame. Without the mutex: it calls the runtime.
  XrResult Locate(XrHapticSceneOMNIX1 handle, Need need, XrSpace space, XrTime time, Located& X_OS);
  template <class Message>
  void Send(const Message& message) {
    link_.WithConnection([&](client::Connection& connection) { connection.Send(message); });
  }

  // All with the mutex held.
  XrResult Check(XrHapticSceneOMNIX1 handle, Need need) const;
  void End();
  void HandleUpdates();
  void NotifyAll();
  void SetStatus(XrHapticSceneStatusOMNIX1 status);

  const HandleMap<XrSession, Session>& sessions_;
  ServiceLink& link_;
  const RuntimeClock& clock_;
  EventQueue& events_;
  Locator& locator_;
  mutable std::mutex mutex_;
  std::unique_ptr<HapticScene> scene_;
  std::uint32_t scenes_made_ = 0;
};

XrHapticNodeIdOMNIX1 NodeIdOf(const HapticScene& scene, std::uint32_t object) noexcept;
// The object of a node of this scene that has one of these flags; none: nothing.
std::optional<std::uint32_t> ObjectOf(const HapticScene& scene, XrHapticNodeIdOMNIX1 node,
                                      std::uint32_t any_of_flags) noexcept;

bool IsUnitPose(const XrPosef& pose) noexcept;

// All values are finite.
bool IsMaterial(const XrHapticMaterialOMNIX1& material) noexcept;

// In the ranges of service/base/material.h; dynamic friction is at most static friction.
base::MaterialParameters ToParameters(const XrHapticMaterialOMNIX1& material) noexcept;

void Put(const base::MaterialParameters& parameters, XrHapticMaterialOMNIX1& material) noexcept;

}  // namespace omni::layer
