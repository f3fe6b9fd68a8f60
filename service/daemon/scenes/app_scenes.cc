#include "service/daemon/scenes/app_scenes.h"

#include <algorithm>
#include <utility>

#include "service/base/clock.h"
#include "service/haptics/scene/scene.h"

namespace omni::daemon {
namespace {

constexpr std::size_t kMaxTextBytes = 60'000;

loop::PoseSample SampleOf(const protocol::ScenePose& pose, std::int64_t t_ns, std::uint32_t flags,
                          std::uint64_t number) {
  const auto& q = pose.rotation_wxyz;
  return {.t_ns = t_ns,
          .number = number,
          .leaps = (flags & protocol::kPoseLeaps) != 0,
          .rotation = {q[0], q[1], q[2], q[3]},
          .position_m = base::VecOf(pose.position_m),
          .velocity_m_s = base::VecOf(pose.velocity_m_s),
          .angular_velocity_rad_s = base::VecOf(pose.angular_velocity_rad_s)};
}

// The entry of a fixed-size list for which `is` holds, else a new one; full: null.
template <class List, class Is>
auto* SlotIn(List& list, std::uint32_t& count, Is is) {
  for (std::uint32_t i = 0; i < count; ++i) {
    if (is(list[i])) return &list[i];
  }
  return count < list.size() ? &list[count++] : nullptr;
}

std::string Cut(std::string text) {
  if (text.size() > kMaxTextBytes) text.resize(kMaxTextBytes);
  return text;
}

std::string WarningsOf(const BuiltScene& built) {
  std::string text;
  if (built.load.skipped) {
    text =
        "nothing to touch: the document has no haptic tag; tag the objects to touch (docs/scenes.md), or create the "
        "scene "
        "with XR_HAPTIC_SCENE_CREATE_TOUCH_UNTAGGED_BIT_OMNIX1\n";
  }
  for (const std::string& line : built.warnings) text += line + "\n";
  return Cut(std::move(text));
}

}  // namespace

AppScenes::AppScene* AppScenes::Find(ipc::ClientId id, std::uint32_t number) {
  const auto found = scenes_.find(id);
  return found == scenes_.end() || found->second.number != number ? nullptr : &found->second;
}

void AppScenes::Load(ipc::ClientId id, const std::string& application, const protocol::HapticSceneLoad& load,
                     base::UniqueFd document) {
  AppScene& scene = scenes_[id];
  Drop(scene);
  scene = {};
  scene.number = load.number;
  scene.flags = load.flags;
  scene.name = "document of " + application;
  scene.document = std::make_shared<const base::UniqueFd>(std::move(document));
  scene.scale = load.scale;
  scene.asked_ns = base::MonotonicNow_ns();
  Request(id, scene);
}

void AppScenes::Request(ipc::ClientId id, AppScene& scene) {
  scene.loading = true;
  scene.built_scale = scene.scale;
  builder_.Request({.client = JobOf(id),
                    .file = scene.name,
                    .options = {.all_kinematic = (scene.flags & protocol::kSceneAllKinematic) != 0,
                                .touch_untagged = (scene.flags & protocol::kSceneTouchUntagged) != 0,
                                .scale = scene.scale,
                                .hull_radius_m = hull_radius_m_,
                                .tip_radius_m = tip_radius_m_,
                                .max_file_bytes = protocol::kMaxHapticSceneBytes},
                    .document = scene.document,
                    .payer = id});
}

void AppScenes::Drop(AppScene& scene) { handed_.Retire(std::exchange(scene.built, nullptr)); }

bool AppScenes::End(ipc::ClientId id, std::uint32_t number) {
  if (Find(id, number) == nullptr) return false;
  Remove(id);
  return true;
}

void AppScenes::Remove(ipc::ClientId id) {
  const auto found = scenes_.find(id);
  if (found == scenes_.end()) return;
  builder_.Cancel(JobOf(id));
  Drop(found->second);
  scenes_.erase(found);
}

bool AppScenes::Place(ipc::ClientId id, const protocol::HapticScenePlace& place) {
  AppScene* scene = Find(id, place.number);
  if (scene == nullptr || scene->failed) return false;
  scene->control.placement = SampleOf(place.pose, place.t_ns, place.flags, ++samples_);
  if (place.scale == scene->scale) return true;
  scene->scale = place.scale;
  scene->asked_ns = base::MonotonicNow_ns();
  if (!scene->loading) Request(id, *scene);  // else when the present build is finished
  return true;
}

bool AppScenes::Enable(ipc::ClientId id, const protocol::HapticSceneEnable& enable) {
  AppScene* scene = Find(id, enable.number);
  if (scene == nullptr) return false;
  scene->enabled = enable.enabled != 0;
  return true;
}

bool AppScenes::MoveNodes(ipc::ClientId id, const protocol::HapticNodes& nodes) {
  AppScene* scene = Find(id, nodes.number);
  if (scene == nullptr) return false;
  for (std::uint32_t i = 0; i < nodes.count; ++i) {
    const protocol::HapticNodePose& node = nodes.nodes[i];
    loop::ObjectSample* slot = SlotIn(scene->control.objects, scene->control.object_count,
                                      [&](const loop::ObjectSample& sample) { return sample.object == node.object; });
    if (slot == nullptr) continue;
    slot->object = node.object;
    slot->pose = SampleOf(node.pose, nodes.t_ns, node.flags, ++samples_);
  }
  return true;
}

bool AppScenes::SetMaterial(ipc::ClientId id, const protocol::HapticMaterial& material) {
  AppScene* scene = Find(id, material.number);
  if (scene == nullptr) return false;
  haptics::MaterialChange* slot =
      SlotIn(scene->control.materials, scene->control.material_count,
             [&](const haptics::MaterialChange& change) { return change.material == material.material; });
  if (slot == nullptr) return false;
  *slot = {material.material, material.parameters};
  return true;
}

std::shared_ptr<const BuiltScene> AppScenes::Accept(BuiltScene built) {
  const auto found = scenes_.find(ClientOf(built.client));
  if (found == scenes_.end()) return nullptr;
  AppScene& scene = found->second;
  scene.loading = false;
  scene.load_ns = base::MonotonicNow_ns() - scene.asked_ns;
  if (built.scene == nullptr) {
    scene.failed = true;
    scene.text = Cut(built.error);
    Drop(scene);
    return nullptr;
  }
  Drop(scene);
  scene.text = WarningsOf(built);
  scene.felt_scale = scene.built_scale;
  scene.built = std::make_shared<const BuiltScene>(std::move(built));
  scene.table_due = true;
  if (scene.scale != scene.built_scale) Request(found->first, scene);
  return scene.built;
}

bool AppScenes::HasBeenReady(ipc::ClientId id) const {
  const auto found = scenes_.find(id);
  return found != scenes_.end() && found->second.built != nullptr;
}

std::shared_ptr<const BuiltScene> AppScenes::ActiveScene(ipc::ClientId id) const {
  const auto found = scenes_.find(id);
  return found == scenes_.end() || !found->second.enabled ? nullptr : found->second.built;
}

bool AppScenes::Contains(const std::shared_ptr<const BuiltScene>& scene) const {
  return std::any_of(scenes_.begin(), scenes_.end(), [&](const auto& entry) { return entry.second.built == scene; });
}

// Poses of nodes arrive at the requested scale; until the scene is rebuilt they are rendered at its present one.
void AppScenes::FillControl(ipc::ClientId id, std::uint64_t generation, loop::SceneControl& control) const {
  const AppScene& scene = scenes_.at(id);
  control = scene.control;
  control.generation = generation;
  if (scene.felt_scale == scene.scale) return;
  const double factor = scene.felt_scale / scene.scale;
  for (std::uint32_t i = 0; i < control.object_count; ++i) {
    loop::PoseSample& pose = control.objects[i].pose;
    for (base::Vec3* v : {&pose.position_m, &pose.velocity_m_s}) *v = factor * *v;
  }
}

protocol::HapticSceneState AppScenes::StateOf(const AppScene& scene, std::uint64_t generation) const {
  using Status = protocol::HapticSceneStatus;
  protocol::HapticSceneState state;
  state.number = scene.number;
  state.status = scene.failed ? Status::kFailed : scene.loading ? Status::kLoading : Status::kReady;
  state.generation = generation;
  state.scale = scene.felt_scale;
  state.load_ns = std::max<std::int64_t>(0, scene.load_ns);
  if (scene.built != nullptr && !scene.built->scene->empty()) {
    state.triangle_count = scene.built->scene->header().triangle_count;
    state.material_count = scene.built->scene->header().material_count;
  }
  return state;
}

void AppScenes::Notify(ipc::ClientId felt, std::uint64_t generation) {
  for (auto& [id, scene] : scenes_) {
    if (scene.table_due) {
      if (!send_(id, HapticTableMessage(scene.number, *scene.built))) continue;
      scene.table_due = false;
    }
    protocol::HapticSceneState state =
        StateOf(scene, id == felt && scene.enabled && scene.built != nullptr ? generation : 0);
    const bool known = scene.reported && scene.reported->status == state.status &&
                       scene.reported->generation == state.generation && scene.reported->scale == state.scale &&
                       scene.reported->load_ns == state.load_ns &&
                       scene.reported->triangle_count == state.triangle_count;
    if (known) continue;
    state.header.size = static_cast<std::uint32_t>(sizeof(state) + scene.text.size());
    std::string message(reinterpret_cast<const char*>(&state), sizeof(state));
    message += scene.text;
    if (send_(id, message)) scene.reported = state;
  }
}

}  // namespace omni::daemon
