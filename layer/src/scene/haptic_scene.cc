// The calls by which an application creates and changes its scene.
#include "layer/src/scene/haptic_scene.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include <glm/geometric.hpp>

#include "layer/src/entry/two_call.h"
#include "layer/src/spaces/locator.h"
#include "service/base/clock.h"
#include "service/base/sealed_memory.h"
#include "service/protocol/haptic_scene.h"

namespace omni::layer {
namespace {

constexpr double kHalfRoot = 0.70710678118654752;

glm::dvec3 Capped(const glm::dvec3& v, double most) noexcept {
  const double size = glm::length(v);
  return size > most ? (most / size) * v : v;
}

protocol::ScenePose ToScenePose(const Motion& motion) noexcept {
  const glm::dquat& q = motion.X.q;
  return {.rotation_wxyz = {q.w, q.x, q.y, q.z},
          .position_m = ToArray(motion.X.p),
          .velocity_m_s = ToArray(Capped(motion.v, protocol::kMaxSceneSpeed / 2)),
          .angular_velocity_rad_s = ToArray(Capped(motion.w, protocol::kMaxSceneSpeed / 2))};
}

bool InReach(const protocol::ScenePose& pose) noexcept {
  return std::all_of(pose.position_m.begin(), pose.position_m.end(),
                     [](double x) { return std::abs(x) <= protocol::kMaxScenePosition_m; });
}

// X_OZ = X_OG C^-1: as the service knows the scene's frame.
Motion AxesTurned(const Motion& X_OG) {
  Motion turned = X_OG;
  turned.X = Compose(X_OG.X, Inverse(DocumentAxes()));
  return turned;
}

// A node's pose and velocity in the document's frame -> how it moved from its rest, in the service's frame of the
// scene: x_Z = R x_Z,rest + t.
Motion FromRest(const Motion& X_GN, const protocol::HapticNodeRow& row, double scale) {
  const auto& q = row.rest_rotation_wxyz;
  const auto& p = row.rest_position_m;
  Pose rest{{p[0], p[1], p[2]}, glm::normalize(glm::dquat(q[0], q[1], q[2], q[3]))};
  Motion moved;
  moved.X = Compose(X_GN.X, Inverse(rest));
  moved.w = X_GN.w;
  moved.v = X_GN.v - glm::cross(X_GN.w, moved.X.q * rest.p);  // of the document's origin, carried along
  const glm::dquat C = DocumentAxes().q;
  return {
      {scale * (C * moved.X.p), glm::normalize(C * moved.X.q * glm::conjugate(C))}, scale * (C * moved.v), C * moved.w};
}

constexpr XrHapticSceneCreateFlagsOMNIX1 kKnownFlags =
    XR_HAPTIC_SCENE_CREATE_TOUCH_UNTAGGED_BIT_OMNIX1 | XR_HAPTIC_SCENE_CREATE_ALL_KINEMATIC_BIT_OMNIX1;

std::uint32_t ToFlags(XrHapticSceneCreateFlagsOMNIX1 flags) noexcept {
  return ((flags & XR_HAPTIC_SCENE_CREATE_TOUCH_UNTAGGED_BIT_OMNIX1) != 0 ? protocol::kSceneTouchUntagged : 0U) |
         ((flags & XR_HAPTIC_SCENE_CREATE_ALL_KINEMATIC_BIT_OMNIX1) != 0 ? protocol::kSceneAllKinematic : 0U);
}

bool IsThere(const Located& located) noexcept { return (located.flags & kValid) == kValid; }

// Differs by more than rounding noise, or moves.
bool Differs(const Motion& a, const Motion& b) noexcept {
  const auto far = [](const glm::dvec3& x, const glm::dvec3& y) { return glm::length(x - y) > 1e-6; };
  return far(a.X.p, b.X.p) || std::abs(glm::dot(a.X.q, b.X.q)) < 1 - 1e-12 || far(a.v, b.v) || far(a.w, b.w);
}

double ScaleOf(const HapticScene& scene) noexcept { return scene.placement ? scene.placement->scale : 1; }

// What is wrong with an update of nodes, whatever the scene is.
XrResult CheckUpdate(const XrHapticNodesUpdateInfoOMNIX1* info) {
  if (!info || info->type != XR_TYPE_HAPTIC_NODES_UPDATE_INFO_OMNIX1 || info->nodeCount == 0 || !info->nodes)
    return XR_ERROR_VALIDATION_FAILURE;
  if (info->time <= 0) return XR_ERROR_TIME_INVALID;
  for (const XrHapticNodePoseOMNIX1& node : std::span(info->nodes, info->nodeCount)) {
    if (!IsUnitPose(node.pose)) return XR_ERROR_POSE_INVALID;
    const bool known = (node.flags & ~XR_HAPTIC_NODE_POSE_TELEPORT_BIT_OMNIX1) == 0;
    if (!known || !IsFinite(node.linearVelocity) || !IsFinite(node.angularVelocity)) return XR_ERROR_VALIDATION_FAILURE;
  }
  return XR_SUCCESS;
}

// `X_OB`: the space of the pose, in the base frame; null: the document's frame.
protocol::HapticNodePose ToNodePose(const HapticScene& scene, std::uint32_t object, const XrHapticNodePoseOMNIX1& from,
                                    const Located* X_OB) {
  const double scale = ScaleOf(scene);
  Motion X_GN{FromXr(from.pose), FromXr(from.linearVelocity), FromXr(from.angularVelocity)};
  if (X_OB != nullptr) {
    X_GN = Compose(Inverse(scene.X_OG), Compose(KnownMotion(*X_OB), X_GN));
    X_GN.X.p /= scale;
    X_GN.v /= scale;
  }
  return {.object = object,
          .flags = (from.flags & XR_HAPTIC_NODE_POSE_TELEPORT_BIT_OMNIX1) != 0 ? protocol::kPoseLeaps : 0U,
          .pose = ToScenePose(FromRest(X_GN, scene.table.nodes[object], scale))};
}

}  // namespace

Pose DocumentAxes() { return {glm::dvec3(0), glm::dquat(kHalfRoot, kHalfRoot, 0, 0)}; }

bool IsUnitPose(const XrPosef& pose) noexcept {
  const XrQuaternionf& q = pose.orientation;
  const float norm = std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
  return std::abs(norm - 1) <= 0.01f && IsFinite(pose.position);
}

XrHapticNodeIdOMNIX1 NodeIdOf(const HapticScene& scene, std::uint32_t object) noexcept {
  return std::uint64_t{scene.number} << 32 | (object + 1);
}

std::optional<std::uint32_t> ObjectOf(const HapticScene& scene, XrHapticNodeIdOMNIX1 node,
                                      std::uint32_t any_of_flags) noexcept {
  const std::uint64_t object = (node & 0xFFFFFFFF) - 1;
  const bool of_this_scene = node >> 32 == scene.number;
  if (!of_this_scene || object >= scene.table.nodes.size()) return std::nullopt;
  const bool is_such = (scene.table.nodes[object].flags & any_of_flags) != 0;
  if (!is_such) return std::nullopt;
  return static_cast<std::uint32_t>(object);
}

bool HapticScenes::Contains(XrHapticSceneOMNIX1 handle) const {
  const std::lock_guard lock(mutex_);
  return XR_SUCCEEDED(Check(handle, Need::kHandle));
}

XrResult HapticScenes::Check(XrHapticSceneOMNIX1 handle, Need need) const {
  const HapticScene* scene = scene_.get();
  if (scene == nullptr || scene->handle != handle) return XR_ERROR_HANDLE_INVALID;
  const bool failed = scene->status == XR_HAPTIC_SCENE_STATUS_FAILED_OMNIX1;
  if (failed && need != Need::kHandle) return XR_ERROR_HAPTIC_SCENE_INVALID_OMNIX1;
  const bool ready = scene->ever_ready;
  return ready || need != Need::kReady ? XR_SUCCESS : XR_ERROR_HAPTIC_SCENE_NOT_READY_OMNIX1;
}

XrResult HapticScenes::Locate(XrHapticSceneOMNIX1 handle, Need need, XrSpace space, XrTime time, Located& X_OS) {
  std::shared_ptr<Session> session;
  const XrResult result = WithScene(handle, need, [&](const HapticScene& scene) {
    session = sessions_.Find(scene.session);
    return session != nullptr ? XR_SUCCESS : XR_ERROR_HANDLE_INVALID;
  });
  return XR_SUCCEEDED(result) ? locator_.LocateInBase(*session, space, time, X_OS) : result;
}

XrResult HapticScenes::Create(XrSession session, const XrHapticSceneCreateInfoOMNIX1* info,
                              XrHapticSceneOMNIX1* handle) {
  if (!info || info->type != XR_TYPE_HAPTIC_SCENE_CREATE_INFO_OMNIX1 || !handle || !info->buffer ||
      (info->createFlags & ~kKnownFlags) != 0 || info->bufferByteCount == 0 ||
      info->bufferByteCount > XR_MAX_HAPTIC_SCENE_BYTES_OMNIX1) {
    return XR_ERROR_VALIDATION_FAILURE;
  }
  if (!sessions_.Contains(session)) return XR_ERROR_HANDLE_INVALID;
  auto scene = std::make_unique<HapticScene>();
  auto document = base::SealedCopy("omni-scene", {reinterpret_cast<const char*>(info->buffer), info->bufferByteCount});
  if (!document.ok()) return XR_ERROR_OUT_OF_MEMORY;
  scene->document = std::move(*document);
  scene->handle = reinterpret_cast<XrHapticSceneOMNIX1>(scene.get());
  scene->session = session;
  scene->bytes = info->bufferByteCount;
  scene->flags = ToFlags(info->createFlags);
  scene->X_OG.X = DocumentAxes();
  const std::lock_guard lock(mutex_);
  if (scene_ != nullptr) return XR_ERROR_LIMIT_REACHED;
  scene->number = ++scenes_made_;
  *handle = scene->handle;
  scene_ = std::move(scene);
  NotifyAll();
  return XR_SUCCESS;
}

XrResult HapticScenes::Destroy(XrHapticSceneOMNIX1 handle) {
  return WithScene(handle, Need::kHandle, [&](const HapticScene&) {
    End();
    return XR_SUCCESS;
  });
}

void HapticScenes::EndOf(XrSession session) {
  const std::lock_guard lock(mutex_);
  if (scene_ != nullptr && scene_->session == session) End();
}

void HapticScenes::End() {
  protocol::HapticSceneEnd end;
  end.number = scene_->number;
  const bool surfaces = scene_->surfaces_asked;
  link_.WithConnection([&](client::Connection& connection) {
    connection.Send(end);
    if (surfaces) connection.RequestSurfaces(false);
  });
  scene_ = nullptr;
}

XrResult HapticScenes::GetState(XrHapticSceneOMNIX1 handle, XrHapticSceneStateOMNIX1* state) {
  if (!state || state->type != XR_TYPE_HAPTIC_SCENE_STATE_OMNIX1) return XR_ERROR_VALIDATION_FAILURE;
  Poll();
  return WithScene(handle, Need::kHandle, [&](const HapticScene& scene) {
    const bool ready = scene.status == XR_HAPTIC_SCENE_STATUS_READY_OMNIX1;
    state->status = scene.status;
    state->isFelt = ready && scene.state.generation != 0;
    state->nodeCount = ready ? static_cast<uint32_t>(scene.table.nodes.size()) : 0;
    state->materialCount = ready ? static_cast<uint32_t>(scene.table.materials.size()) : 0;
    state->triangleCount = ready ? scene.state.triangle_count : 0;
    state->loadTime = scene.status == XR_HAPTIC_SCENE_STATUS_LOADING_OMNIX1 ? 0 : scene.state.load_ns;
    return XR_SUCCESS;
  });
}

XrResult HapticScenes::GetDiagnostics(XrHapticSceneOMNIX1 handle, uint32_t capacity, uint32_t* count, char* text) {
  if (!count || (capacity > 0 && !text)) return XR_ERROR_VALIDATION_FAILURE;
  Poll();
  return WithScene(handle, Need::kHandle, [&](const HapticScene& scene) {
    const std::string waiting = link_.WithConnection([](client::Connection& connection) {
      return connection.connected() ? std::string("being built\n")
                                    : "waiting for omnid: " + connection.last_error() + "\n";
    });
    const std::string& said = scene.status == XR_HAPTIC_SCENE_STATUS_LOADING_OMNIX1 ? waiting : scene.text;
    return Fill(said.c_str(), said.size() + 1, capacity, count, text);
  });
}

XrResult HapticScenes::SetPlacement(XrHapticSceneOMNIX1 handle, const XrHapticScenePlacementOMNIX1* placement) {
  if (!placement || placement->type != XR_TYPE_HAPTIC_SCENE_PLACEMENT_OMNIX1 || !std::isfinite(placement->scale)) {
    return XR_ERROR_VALIDATION_FAILURE;
  }
  if (!IsUnitPose(placement->pose)) return XR_ERROR_POSE_INVALID;
  const std::int64_t now_ns = base::MonotonicNow_ns();
  Located X_OS;
  const XrResult found = Locate(handle, Need::kUsable, placement->baseSpace, clock_.ToXr(now_ns), X_OS);
  if (XR_FAILED(found)) return found;
  const double scale = std::clamp(double{placement->scale}, protocol::kLeastSceneScale, protocol::kMostSceneScale);
  return WithScene(handle, Need::kUsable, [&](HapticScene& scene) {
    Motion X_SG, X_OG = scene.X_OG;
    X_SG.X = FromXr(placement->pose);
    if (IsThere(X_OS)) X_OG = Compose(KnownMotion(X_OS), X_SG);
    const protocol::ScenePose pose = ToScenePose(AxesTurned(X_OG));
    if (!InReach(pose)) return XR_ERROR_POSE_INVALID;
    const bool reload = scale != ScaleOf(scene);
    if (reload) SetStatus(XR_HAPTIC_SCENE_STATUS_LOADING_OMNIX1);
    scene.placement = {placement->baseSpace, X_SG.X, scale};
    scene.X_OG = X_OG;
    scene.place.number = scene.number;
    scene.place.t_ns = now_ns;
    scene.place.scale = scale;
    scene.place.pose = pose;
    Send(scene.place);
    return XR_SUCCESS;
  });
}

void HapticScenes::FollowSpace(XrSession session_handle, XrTime time) {
  ScenePlacement placement;
  {
    const std::lock_guard lock(mutex_);
    if (scene_ == nullptr || scene_->session != session_handle || !scene_->placement) return;
    if (scene_->placement->base == XR_NULL_HANDLE) return;
    placement = *scene_->placement;
  }
  const std::shared_ptr<Session> session = sessions_.Find(session_handle);
  Located X_OS;
  if (session == nullptr || XR_FAILED(locator_.LocateInBase(*session, placement.base, time, X_OS))) return;
  if (!IsThere(X_OS)) return;  // it stays where it was
  Motion X_SG;
  X_SG.X = placement.X_SG;
  const Motion X_OG = Compose(KnownMotion(X_OS), X_SG);
  const std::lock_guard lock(mutex_);
  if (scene_ == nullptr || !scene_->placement || scene_->placement->base != placement.base) return;
  if (!Differs(X_OG, scene_->X_OG) && glm::length(X_OG.v) + glm::length(X_OG.w) < 1e-9) return;
  const protocol::ScenePose pose = ToScenePose(AxesTurned(X_OG));
  if (!InReach(pose)) return;
  scene_->X_OG = X_OG;
  scene_->place.t_ns = std::max<std::int64_t>(0, clock_.ToMonotonic(time));
  scene_->place.pose = pose;
  Send(scene_->place);
}

// Its handle may be reused for another space: the scene stays where it is.
void HapticScenes::ForgetSpace(XrSpace space) {
  const std::lock_guard lock(mutex_);
  if (scene_ != nullptr && scene_->placement && scene_->placement->base == space)
    scene_->placement->base = XR_NULL_HANDLE;
}

XrResult HapticScenes::SetEnabled(XrHapticSceneOMNIX1 handle, XrBool32 enabled) {
  return WithScene(handle, Need::kUsable, [&](HapticScene& scene) {
    scene.enabled = enabled != XR_FALSE;
    protocol::HapticSceneEnable message;
    message.number = scene.number;
    message.enabled = scene.enabled ? 1 : 0;
    Send(message);
    return XR_SUCCESS;
  });
}

XrResult HapticScenes::SetMaterial(XrHapticSceneOMNIX1 handle, uint32_t index, const XrHapticMaterialOMNIX1* material) {
  if (!material || material->type != XR_TYPE_HAPTIC_MATERIAL_OMNIX1 || !IsMaterial(*material))
    return XR_ERROR_VALIDATION_FAILURE;
  return WithScene(handle, Need::kReady, [&](HapticScene& scene) {
    if (index >= scene.table.materials.size()) return XR_ERROR_INDEX_OUT_OF_RANGE;
    const bool full = scene.changed.size() >= XR_MAX_HAPTIC_MATERIALS_SET_OMNIX1;
    if (full && scene.changed.count(index) == 0) return XR_ERROR_LIMIT_REACHED;
    protocol::HapticMaterial message;
    message.number = scene.number;
    message.material = index;
    message.parameters = scene.changed[index] = ToParameters(*material);
    Send(message);
    return XR_SUCCESS;
  });
}

XrResult HapticScenes::MoveNodes(XrHapticSceneOMNIX1 handle, const XrHapticNodesUpdateInfoOMNIX1* info) {
  if (const XrResult result = CheckUpdate(info); XR_FAILED(result)) return result;
  Located X_OB;
  const bool in_document = info->baseSpace == XR_NULL_HANDLE;
  if (!in_document) {
    const XrResult found = Locate(handle, Need::kReady, info->baseSpace, info->time, X_OB);
    if (XR_FAILED(found)) return found;
  }
  return WithScene(handle, Need::kReady, [&](HapticScene& scene) {
    const bool is_there = in_document || IsThere(X_OB);
    std::map<std::uint32_t, protocol::HapticNodePose> nodes = scene.nodes;
    std::vector<std::uint32_t> moved;
    for (const XrHapticNodePoseOMNIX1& from : std::span(info->nodes, info->nodeCount)) {
      const std::optional<std::uint32_t> object = ObjectOf(scene, from.node, protocol::kNodeKinematic);
      if (!object) return XR_ERROR_HAPTIC_NODE_INVALID_OMNIX1;
      if (!is_there) continue;
      const protocol::HapticNodePose to = ToNodePose(scene, *object, from, in_document ? nullptr : &X_OB);
      if (!InReach(to.pose)) return XR_ERROR_POSE_INVALID;
      nodes[*object] = to;
      if (std::find(moved.begin(), moved.end(), *object) == moved.end()) moved.push_back(*object);
    }
    if (!is_there) return XR_SUCCESS;  // not locatable: the nodes stay where they were
    if (nodes.size() > protocol::kMaxHapticNodesMoved) return XR_ERROR_LIMIT_REACHED;
    scene.nodes = std::move(nodes);
    scene.nodes_t_ns = std::max<std::int64_t>(0, clock_.ToMonotonic(info->time));
    protocol::HapticNodes message;
    message.number = scene.number;
    message.t_ns = scene.nodes_t_ns;
    for (const std::uint32_t object : moved) message.nodes[message.count++] = scene.nodes[object];
    Send(message);
    return XR_SUCCESS;
  });
}

}  // namespace omni::layer
