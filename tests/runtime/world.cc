#include "tests/runtime/world.h"

#include "tests/runtime/newer_openxr.h"
#include "tests/runtime/spaces/clock.h"

namespace omni::runtime {
namespace {

constexpr float kEyeHeight_m = 1.6f;
// Origins that are remembered; queries about the past need few.
constexpr size_t kMaxOrigins = 64;

Motion RestPose(int hand, bool aim) {
  Motion motion;
  motion.pose.position = {hand == 0 ? -0.2f : 0.2f, 1.3f, aim ? -0.45f : -0.4f};
  return motion;
}

float Seconds(XrTime from, XrTime to) { return static_cast<float>(static_cast<double>(to - from) * 1e-9); }

}  // namespace

World::World() { Reset(); }

void World::Reset() {
  const XrTime now = Now();
  focus = true;
  head = {};
  head.pose.position = {0, kEyeHeight_m, 0};
  head_time = now;
  local_origins.assign(1, {0, {{0, 0, 0, 1}, {0, kEyeHeight_m, 0}}});
  stage_origins.assign(1, {0, kIdentity});
  has_stage = has_timespec = has_velocities = true;
  has_shapes = holds_images = false;
  has_models = user_present = true;
  first_model = 1;
  creation = XR_SUCCESS;
  for (int hand = 0; hand < kHands; ++hand) {
    devices[hand] = {};
    devices[hand].present = hand == 0;
    hands[hand] = {};
    Motion palm;
    palm.pose.position = {hand == 0 ? -0.25f : 0.25f, 1.2f, -0.3f};
    SetHand(hand, hand == 0, palm);
    ApplyProfile(hand, FindProfile("/interaction_profiles/oculus/touch_controller"));
  }
}

void World::ApplyProfile(int hand, int profile) {
  Device& device = devices[hand];
  device.profile = profile;
  device.epoch = next_epoch++;
  const auto components = Profiles()[profile].components;
  Value rest;
  rest.change_time = Now();
  device.values.assign(components.size(), rest);
  for (size_t i = 0; i < components.size(); ++i) {
    if (components[i].type == ComponentType::kPose) {
      device.values[i].motion = RestPose(hand, components[i].path == "input/aim/pose");
    }
  }
}

bool World::SetDevice(int hand, bool present, std::string_view profile) {
  if (!profile.empty()) {
    const int index = FindProfile(profile);
    if (index < 0) return false;
    if (index != devices[hand].profile) ApplyProfile(hand, index);
  }
  devices[hand].present = present;
  return true;
}

bool World::RenewDevice(int hand, bool present, std::string_view profile) {
  if (!SetDevice(hand, present, profile)) return false;
  for (Value& value : devices[hand].values) value.x = value.y = 0;
  return true;
}

Value* World::Find(std::string_view path, ComponentType type) {
  const HandPath split = SplitHandPath(path);
  if (split.hand < 0) return nullptr;
  Device& device = devices[split.hand];
  const Profile& profile = Profiles()[device.profile];
  const int component = FindComponent(profile, split.hand, split.rest);
  if (component < 0 || profile.components[component].type != type) return nullptr;
  return &device.values[component];
}

bool World::SetBool(std::string_view path, bool value) {
  Value* const slot = Find(path, ComponentType::kBool);
  if (slot == nullptr) return false;
  const float wanted = value ? 1.0f : 0.0f;
  if (slot->x != wanted) slot->change_time = Now();
  slot->x = wanted;
  return true;
}

bool World::SetFloat(std::string_view path, float value) {
  Value* const slot = Find(path, ComponentType::kFloat);
  if (slot == nullptr || !(value >= 0 && value <= 1)) return false;
  if (slot->x != value) slot->change_time = Now();
  slot->x = value;
  return true;
}

bool World::SetVector2(std::string_view path, float x, float y) {
  Value* const slot = Find(path, ComponentType::kVector2);
  if (slot == nullptr || !(x >= -1 && x <= 1 && y >= -1 && y <= 1)) return false;
  if (slot->x != x || slot->y != y) slot->change_time = Now();
  slot->x = x;
  slot->y = y;
  return true;
}

bool World::SetPose(std::string_view path, const Motion& motion) {
  Value* const slot = Find(path, ComponentType::kPose);
  if (slot == nullptr || !IsValid(motion.pose)) return false;
  slot->motion = motion;
  slot->motion.pose = Normalized(motion.pose);
  slot->change_time = Now();
  return true;
}

void World::SetHead(const Motion& motion) {
  head = motion;
  head.pose = Normalized(motion.pose);
  head_time = Now();
}

void World::SetHand(int hand, bool active, const Motion& palm) {
  hands[hand] = {active, palm, Now()};
  hands[hand].palm.pose = Normalized(palm.pose);
}

Motion World::PalmAt(int hand, XrTime time) const {
  return Extrapolate(hands[hand].palm, Seconds(hands[hand].change_time, time));
}

void World::Recenter(XrReferenceSpaceType space, const XrPosef& pose, XrTime when) {
  Origins& origins = space == XR_REFERENCE_SPACE_TYPE_STAGE ? stage_origins : local_origins;
  if (origins.size() == kMaxOrigins) origins.erase(origins.begin());
  origins.push_back({when, Normalized(Compose(origins.back().pose, pose))});
}

// LOCAL_FLOOR is LOCAL on the floor.
XrPosef World::OriginAt(XrReferenceSpaceType space, XrTime time) const {
  const Origins& origins = space == XR_REFERENCE_SPACE_TYPE_STAGE ? stage_origins : local_origins;
  size_t i = origins.size() - 1;
  while (i > 0 && time < origins[i].since) --i;
  XrPosef origin = origins[i].pose;
  if (space == kLocalFloor) origin.position.y = 0;
  return origin;
}

Motion World::HeadAt(XrTime time) const { return Extrapolate(head, Seconds(head_time, time)); }

bool World::IsLive(const Source& source) const {
  return source.hand >= 0 && devices[source.hand].present && devices[source.hand].epoch == source.epoch;
}

const Component& World::ComponentOf(const Source& source) const {
  return Profiles()[devices[source.hand].profile].components[source.component];
}

Value World::Read(const Source& source) const {
  const Device& device = devices[source.hand];
  const Component& component = ComponentOf(source);
  const bool is_x = component.type == ComponentType::kVectorX;
  if (!is_x && component.type != ComponentType::kVectorY) return device.values[source.component];
  const std::string_view parent = component.path.substr(0, component.path.rfind('/'));
  const Profile& profile = Profiles()[device.profile];
  const Value& vector = device.values[FindComponent(profile, source.hand, parent)];
  Value half = vector;
  half.x = is_x ? vector.x : vector.y;
  half.y = 0;
  return half;
}

Motion World::PoseAt(const Source& source, XrTime time) const {
  const Value& value = devices[source.hand].values[source.component];
  return Extrapolate(value.motion, Seconds(value.change_time, time));
}

}  // namespace omni::runtime
