#include "service/haptics/contact/contact_scene.h"

#include "service/haptics/deformable/soft_contact.h"

namespace omni::haptics {
namespace {

constexpr double kFarthestPose_m = 100;
constexpr double kUnitTolerance = 1e-3;  // of a quaternion's norm
constexpr double kPoseLeap_m = 0.01;     // of the tip in the object's frame, in one tick: a jump, not a motion

bool IsPose(const ObjectPose& pose) noexcept {
  const base::Quat& q = pose.rotation;
  const double norm2 = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
  return std::abs(norm2 - 1) < kUnitTolerance && IsWithin(pose.translation_m, kFarthestPose_m);
}

base::Quat Unit(const base::Quat& q) noexcept {
  const double scale = 1 / std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  return {scale * q.w, scale * q.x, scale * q.y, scale * q.z};
}

bool IsTouched(const State& state, std::uint32_t object) noexcept {
  return std::any_of(state.contacts.begin(), state.contacts.end(),
                     [&](const ContactState& c) { return c.active && c.object == object; });
}

// The slot of an object, a free one for a new object, or none.
MovedObject* SlotFor(std::uint32_t object, State& state) noexcept {
  MovedObject* free = nullptr;
  for (MovedObject& moved : state.moved) {
    if (moved.object == object) return &moved;
    if (moved.object == kNoIndex && free == nullptr) free = &moved;
  }
  return free;
}

}  // namespace

ContactScene::ContactScene(const Scene& scene, const Input& input, State& state) noexcept
    : scene_(scene),
      state_(state),
      surface_(scene, state.regions),
      tip_base_m_(input.device_point_base_m),
      per_dt_(input.dt_s > 0 ? 1 / input.dt_s : 0) {
  if (scene.live() != nullptr) {
    TakeSculpted(state);
    TakeSoft(state);
  }
  while (live_materials_ < kMaxLiveMaterials && state.materials[live_materials_].material != kNoIndex)
    ++live_materials_;
  TakePoses(input, state);
  FindMovedFaces();
  if (input.scene_motion == SceneMotion::kLeaps) changed_ = ~std::uint64_t{0};
  if (!input.tracked) state.ball_restarts |= changed_ | moved_ | face_moved_;  // no tip to sweep
}

void ContactScene::TakeSculpted(State& state) noexcept {
  const LiveParts& live = *scene_.live();
  for (std::uint32_t n = 0; n < live.sculpt_session_count() && n < kMaxSculpted; ++n) {
    const std::uint32_t object = live.object_at(n);
    const sculpt::SculptTable* table = live.sculpt_session_at(n).Acquire();
    if (table == nullptr) continue;
    sculpted_[sculpted_count_++] = {object, table};
    std::uint64_t& known = state.sculpted[n].generation;
    if (known != 0 && known != table->generation) changed_ |= std::uint64_t{1} << object;
    known = table->generation;
  }
}

// Only while the tip touches nothing of it: a body that becomes ready must not change the force.
void ContactScene::TakeSoft(State& state) noexcept {
  for (std::uint32_t object = 0; object < scene_.objects().size(); ++object) {
    if (state.is_soft[object] != 0 || scene_.live()->soft_body(object) == nullptr) continue;
    if (!IsTouched(state, object)) state.is_soft[object] = 1;
  }
}

void ContactScene::TakePoses(const Input& input, State& state) noexcept {
  for (MovedObject& moved : state.moved) {
    moved.last_rotation = moved.rotation;
    moved.last_translation_m = moved.translation_m;
  }
  for (const ObjectPose& pose : input.poses) {
    const bool known = pose.object < scene_.objects().size() && (scene_.objects()[pose.object].flags & kKinematic) != 0;
    if (!known || !IsPose(pose)) continue;
    MovedObject* moved = SlotFor(pose.object, state);
    if (moved == nullptr) continue;
    moved->object = pose.object;
    moved->rotation = Unit(pose.rotation);
    moved->translation_m = pose.translation_m;
    if (moved->rotation == moved->last_rotation && moved->translation_m == moved->last_translation_m) continue;
    moved_ |= std::uint64_t{1} << pose.object;
    const Target target = TargetOf(pose.object);
    const Frame frame = FrameOf(pose.object);
    const Vec3 step = frame.ToRest(state.last_device_point_base_m) - target.from;
    if (pose.leaps || !(Norm(step) < kPoseLeap_m)) changed_ |= std::uint64_t{1} << pose.object;
  }
}

void ContactScene::FindMovedFaces() noexcept {
  const auto regions = scene_.regions();
  for (std::size_t r = 0; r < regions.size(); ++r) {
    const RegionState& face = state_.regions[r];
    has_faces_ |= std::uint64_t{1} << regions[r].object;
    if (face.offset_m != face.last_offset_m) face_moved_ |= std::uint64_t{1} << regions[r].object;
  }
}

const MovedObject* ContactScene::MovedOf(std::uint32_t object) const noexcept {
  if ((scene_.objects()[object].flags & kKinematic) == 0) return nullptr;
  for (const MovedObject& moved : state_.moved) {
    if (moved.object == object) return &moved;
  }
  return nullptr;
}

Frame ContactScene::FrameOf(std::uint32_t object) const noexcept {
  const MovedObject* moved = MovedOf(object);
  return moved == nullptr ? Frame{} : Frame{false, moved->rotation, moved->translation_m};
}

Target ContactScene::TargetOf(std::uint32_t object) const noexcept {
  const Object& o = scene_.objects()[object];
  const bool sculpted = TableOf(object) != nullptr;
  Target target{o, object, sculpted ? 0 : o.root, !sculpted, state_.last_device_point_base_m, tip_base_m_};
  const MovedObject* moved = MovedOf(object);
  if (moved == nullptr) return target;
  target.tip = Frame{false, moved->rotation, moved->translation_m}.ToRest(target.tip);
  target.from = Frame{false, moved->last_rotation, moved->last_translation_m}.ToRest(target.from);
  return target;
}

Vec3 ContactScene::VelocityOf(std::uint32_t object, const Vec3& point) const noexcept {
  const MovedObject* moved = MovedOf(object);
  if (moved == nullptr || ChangedUnderTip(object)) return {};
  const Frame now{false, moved->rotation, moved->translation_m};
  const Frame before{false, moved->last_rotation, moved->last_translation_m};
  return per_dt_ * (now.ToBase(point) - before.ToBase(point));
}

Vec3 ContactScene::TipOver(const Target& target, const ContactState& contact) const noexcept {
  const SoftBody* body = SoftOf(target.index);
  if (body == nullptr) return target.tip;
  for (const SoftTouch& soft : state_.soft) {
    if (soft.object != target.index) continue;
    const auto slot = static_cast<std::size_t>(&contact - state_.contacts.data());
    const bool known = slot < kMaxContacts && soft.body.slots[slot].active;
    const std::uint32_t hint = known ? soft.body.slots[slot].place.triangle : kNoSoftTriangle;
    return target.tip - CarriedDisplacement(body->view(), soft.body, contact.proxy_m, hint);
  }
  return target.tip;
}

void ForgetUntouched(State& state) noexcept {
  for (SoftTouch& soft : state.soft) {
    if (soft.object != kNoIndex && !IsTouched(state, soft.object)) soft = {};
  }
}

}  // namespace omni::haptics
