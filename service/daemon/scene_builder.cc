#include "service/daemon/scene_builder.h"

#include <algorithm>
#include <exception>
#include <utility>

#include "service/scene/load_scene.h"

namespace omni::daemon {

scene::LoadOptions LoadOptionsOf(const config::AppEntry& app, double hull_radius_m) {
  return {.touch_untagged = app.touch == config::Touch::kAll,
          .fit = app.placement == config::Placement::kFit,
          .offset_base_m = app.offset_base_m,
          .scale = app.scale,
          .hull_radius_m = hull_radius_m};
}

SceneBuilder::SceneBuilder(double hull_radius_m, std::string cache_folder)
    : hull_radius_m_(hull_radius_m), cache_folder_(std::move(cache_folder)), thread_([this] { Run(); }) {}

SceneBuilder::~SceneBuilder() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void SceneBuilder::Request(std::uint64_t client, const config::AppEntry& app) {
  {
    const std::lock_guard lock(mutex_);
    std::erase_if(jobs_, [&](const Job& job) { return job.client == client; });
    if (running_client_ == client) running_client_ = 0;
    jobs_.push_back({client, app});
  }
  wake_.notify_one();
}

void SceneBuilder::Cancel(std::uint64_t client) {
  const std::lock_guard lock(mutex_);
  std::erase_if(jobs_, [&](const Job& job) { return job.client == client; });
  std::erase_if(results_, [&](const BuiltScene& result) { return result.client == client; });
  if (running_client_ == client) running_client_ = 0;
}

std::optional<BuiltScene> SceneBuilder::TakeResult() {
  const std::lock_guard lock(mutex_);
  if (results_.empty()) return std::nullopt;
  BuiltScene result = std::move(results_.front());
  results_.pop_front();
  return result;
}

void SceneBuilder::Run() {
  std::unique_lock lock(mutex_);
  while (true) {
    wake_.wait(lock, [this] { return stop_ || !jobs_.empty(); });
    if (stop_) return;
    const Job job = std::move(jobs_.front());
    jobs_.pop_front();
    running_client_ = job.client;
    lock.unlock();
    BuiltScene built = Build(job);
    lock.lock();
    if (running_client_ != job.client) continue;  // cancelled or asked for again
    running_client_ = 0;
    results_.push_back(std::move(built));
  }
}

BuiltScene SceneBuilder::Build(const Job& job) {
  BuiltScene built{.client = job.client, .file = job.app.scene};
  try {
    if (!cache_ && !cache_folder_.empty()) cache_.emplace(cache_folder_);
    base::Result<haptics::Scene> scene = scene::LoadScene(job.app.scene, LoadOptionsOf(job.app, hull_radius_m_),
                                                          cache_ ? &*cache_ : nullptr, built.load, built.report);
    built.warnings = built.load.warnings;
    if (cache_ && !cache_->problem().empty() && !std::exchange(told_of_cache_, true)) {
      built.warnings.push_back("scene cache: " + cache_->problem());
    }
    if (scene.ok()) {
      built.scene = std::make_shared<const haptics::Scene>(std::move(*scene));
    } else {
      built.error = scene.error();
    }
  } catch (const std::exception& caught) {  // out of memory on a hostile file must not take the service down
    built.error = job.app.scene + ": " + caught.what();
  }
  return built;
}

}  // namespace omni::daemon
