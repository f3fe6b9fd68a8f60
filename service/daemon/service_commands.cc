// What the control thread hands to the tick, and when it takes it back.
#include <algorithm>
#include <memory>
#include <mutex>
#include <utility>

#include "service/daemon/service.h"
#include "service/haptics/scene/scene.h"

namespace omni::daemon {

// What the tick has, without force: before anything that takes longer.
void Service::CloseGate() {
  commands_.gate = loop::ForceGate::kClosed;
  commands_.applied.open = false;
  const std::lock_guard lock(loop_mutex_);
  if (loop_ != nullptr) loop_->commands().Write(commands_);
}

void Service::HandOverLife(ipc::ClientId owner) {
  std::shared_ptr<const protocol::LifePage> life = owner == 0 || server_ == nullptr ? nullptr : server_->Life(owner);
  if (life == life_) return;
  if (life_ != nullptr) retired_lives_.push_back(std::move(life_));
  life_ = std::move(life);
  ++life_number_;
}

void Service::WriteCommands(std::int64_t now_ns) {
  const std::uint64_t owner = owners_.owner();
  const auto found = clients_.find(owner);
  const Client* client = found == clients_.end() ? nullptr : &found->second;
  const std::shared_ptr<const BuiltScene> scene = SceneOf(owner);
  if (wanted_ != scene) {
    if (wanted_ != nullptr) retired_.push_back(wanted_);
    wanted_ = scene;
    if (wanted_ != nullptr) sculpt_.Enter(*wanted_->scene);
    ++generation_;
  }
  force_.SetOwner(owner);
  HandOverLife(owner);
  const bool open = owner != 0 && !stop_.on() && (life_ != nullptr || server_ == nullptr);
  commands_ = {.t_ns = now_ns,
               .gate = open ? loop::ForceGate::kOpen : loop::ForceGate::kClosed,
               .owner = {.page = life_.get(), .number = life_number_},
               .idle = owners_.empty(),
               .scene_generation = generation_,
               .force_scale = client == nullptr || client->app == nullptr ? 1.0 : client->app->force_scale,
               .haptic = vibration_.waveform(),
               .inputs = MappingOf(client),
               .applied = force_.Command(now_ns),
               .scene = {}};
  if (scene != nullptr && app_scenes_.Stands(owner)) app_scenes_.FillControl(owner, generation_, commands_.scene);
  const std::lock_guard lock(loop_mutex_);
  if (loop_ == nullptr) return;
  loop_->scenes().Write({.scene = scene == nullptr ? nullptr : scene->scene.get(),
                         .generation = generation_,
                         .build = scene == nullptr ? 0 : scene->build});
  if (vibration_.PopFresh()) loop_->vibration().Write(vibration_.samples());  // before the command that names them
  loop_->commands().Write(commands_);
}

// Frees retired scenes once the tick is known to hold the newest hand-over. Until then it may hold, or be about to
// take, any earlier one. A hand-over's number is never reused, so an old acknowledgement cannot be taken for a new
// one.
void Service::ReleaseScenes() {
  const std::lock_guard lock(loop_mutex_);
  const bool newest =
      loop_ == nullptr || loop_->statistics().scene_generation.load(std::memory_order_acquire) == generation_;
  if (!newest) return;
  for (const std::shared_ptr<const BuiltScene>& scene : retired_) {
    if (scene == wanted_) continue;  // it came back
    sculpt_.Leave(*scene->scene);
    const bool kept =
        app_scenes_.Holds(scene) ||
        std::any_of(clients_.begin(), clients_.end(), [&](const auto& client) { return client.second.scene == scene; });
    if (!kept) sculpt_.Remove(*scene->scene);
  }
  retired_.clear();
}

// Unmaps pages of earlier owners once the tick is known to read the newest one. As with scenes.
void Service::ReleaseLives() {
  if (retired_lives_.empty()) return;
  const std::lock_guard lock(loop_mutex_);
  const bool newest =
      loop_ == nullptr || loop_->statistics().owner_number.load(std::memory_order_acquire) == life_number_;
  if (newest) retired_lives_.clear();
}

}  // namespace omni::daemon
