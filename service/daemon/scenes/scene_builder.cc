#include "service/daemon/scenes/scene_builder.h"

#include <algorithm>
#include <exception>
#include <utility>

#include "service/config/paths.h"
#include "service/haptics/live/make_live.h"
#include "service/scene/load_scene.h"

namespace omni::daemon {
namespace {

// Searched now, not when the application's file was read: a scene may be added later. A document only has a name.
base::Result<std::string> FileOf(const SceneJob& job) {
  return job.document != nullptr ? job.file : config::FindScene(job.file, config::ScenesFolder());
}

}  // namespace

scene::LoadOptions LoadOptionsOf(const config::AppEntry& app, double hull_radius_m) {
  return {.touch_untagged = app.touch == config::Touch::kAll,
          .fit = app.placement == config::Placement::kFit,
          .offset_base_m = app.offset_base_m,
          .scale = app.scale,
          .hull_radius_m = hull_radius_m};
}

SceneBuilder::SceneBuilder(double hull_radius_m, std::string cache_folder, std::uint32_t soft_tets)
    : hull_radius_m_(hull_radius_m),
      cache_folder_(std::move(cache_folder)),
      soft_tets_(soft_tets),
      thread_([this] { Run(); }) {}

SceneBuilder::~SceneBuilder() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void SceneBuilder::Request(std::uint64_t client, const config::AppEntry& app) {
  Request({.client = client, .file = app.scene, .options = LoadOptionsOf(app, hull_radius_m_), .document = nullptr});
}

void SceneBuilder::Request(SceneJob job) {
  if (job.document != nullptr) job.options.memory = job.document->get();
  const std::uint64_t client = job.client;
  {
    const std::lock_guard lock(mutex_);
    std::erase_if(jobs_, [&](const SceneJob& waiting) { return waiting.client == client; });
    if (running_client_ == client) running_client_ = 0;
    DropSoft(client);
    jobs_.push_back(std::move(job));
  }
  wake_.notify_one();
}

void SceneBuilder::Cancel(std::uint64_t client) {
  const std::lock_guard lock(mutex_);
  std::erase_if(jobs_, [&](const SceneJob& job) { return job.client == client; });
  std::erase_if(results_, [&](const BuiltScene& result) { return result.client == client; });
  if (running_client_ == client) running_client_ = 0;
  DropSoft(client);
}

void SceneBuilder::DropSoft(std::uint64_t client) {
  std::erase_if(soft_jobs_, [&](const SoftJob& job) { return job.client == client; });
  std::erase_if(outcomes_, [&](const SoftOutcome& outcome) { return outcome.client == client; });
  progress_.erase(client);
  if (soft_client_ == client) soft_client_ = 0;
}

std::optional<BuiltScene> SceneBuilder::PopResult() {
  const std::lock_guard lock(mutex_);
  if (results_.empty()) return std::nullopt;
  BuiltScene result = std::move(results_.front());
  results_.pop_front();
  return result;
}

std::optional<SoftOutcome> SceneBuilder::PopSoftOutcome() {
  const std::lock_guard lock(mutex_);
  if (outcomes_.empty()) return std::nullopt;
  SoftOutcome outcome = std::move(outcomes_.front());
  outcomes_.pop_front();
  return outcome;
}

SoftProgress SceneBuilder::Progress(std::uint64_t client) const {
  const std::lock_guard lock(mutex_);
  const auto found = progress_.find(client);
  return found == progress_.end() ? SoftProgress{} : found->second;
}

void SceneBuilder::Run() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    wake_.wait(lock, [this] { return stop_ || !jobs_.empty() || !soft_jobs_.empty(); });
    if (stop_) return;
    jobs_.empty() ? RunSoftJob(lock) : RunJob(lock);
  }
}

void SceneBuilder::RunJob(std::unique_lock<std::mutex>& lock) {
  const SceneJob job = std::move(jobs_.front());
  jobs_.pop_front();
  running_client_ = job.client;
  lock.unlock();
  std::deque<std::uint32_t> soft_objects;
  BuiltScene built = Build(job, soft_objects);
  lock.lock();
  if (running_client_ != job.client) return;  // cancelled or requested again
  running_client_ = 0;
  built.build = ++builds_;
  if (!soft_objects.empty()) {
    progress_[job.client] = {.objects = static_cast<std::uint32_t>(soft_objects.size())};
    soft_jobs_.push_back({job.client, built.file, built.scene, std::move(soft_objects)});
  }
  results_.push_back(std::move(built));
}

void SceneBuilder::RunSoftJob(std::unique_lock<std::mutex>& lock) {
  const std::shared_ptr<const haptics::Scene> scene = soft_jobs_.front().scene;  // outlives the client
  const std::uint32_t index = soft_jobs_.front().objects.front();
  const std::uint64_t client = soft_client_ = soft_jobs_.front().client;
  SoftOutcome outcome{.client = client, .file = soft_jobs_.front().file};
  lock.unlock();
  std::unique_ptr<const haptics::SoftBody> body = MakeSoftBody(*scene, index, outcome);
  lock.lock();
  if (stop_ || soft_client_ != client) return;  // cancelled: its job is gone already
  soft_client_ = 0;
  SoftProgress& progress = progress_[client];
  ++(body != nullptr ? progress.ready : progress.failed);
  progress.done = static_cast<double>(progress.ready + progress.failed) / progress.objects;
  if (body != nullptr) scene->live()->SetSoftBody(index, std::move(body));
  outcomes_.push_back(std::move(outcome));
  soft_jobs_.front().objects.pop_front();
  if (soft_jobs_.front().objects.empty()) soft_jobs_.pop_front();
}

// Null: failed or cancelled, see outcome.error.
std::unique_ptr<const haptics::SoftBody> SceneBuilder::MakeSoftBody(const haptics::Scene& scene, std::uint32_t index,
                                                                    SoftOutcome& outcome) {
  const haptics::Object& object = scene.objects()[index];
  outcome.object = object.name;
  try {
    haptics::SoftBodyOptions options = haptics::SoftOptionsOf(scene.materials()[MainMaterial(scene, object)]);
    options.lattice.max_tets = soft_tets_;
    options.progress = [this, client = outcome.client](double done) { return GoOn(client, done); };
    base::Result<haptics::SoftBody> body =
        scene::LoadSoftBody(haptics::MeshOf(scene, index), options, cache_ ? &*cache_ : nullptr, outcome.report);
    if (body.ok()) return std::make_unique<const haptics::SoftBody>(std::move(*body));
    outcome.error = body.error();
  } catch (const std::exception& caught) {  // out of memory
    outcome.error = std::string("soft body: ") + caught.what();
  }
  return nullptr;
}

bool SceneBuilder::GoOn(std::uint64_t client, double done) {
  std::unique_lock<std::mutex> lock(mutex_);
  while (!stop_ && !jobs_.empty()) RunJob(lock);
  if (stop_ || soft_client_ != client) return false;
  SoftProgress& progress = progress_[client];
  progress.done = (progress.ready + progress.failed + done) / progress.objects;
  return true;
}

BuiltScene SceneBuilder::Build(const SceneJob& job, std::deque<std::uint32_t>& soft_objects) {
  BuiltScene built{.client = job.client, .file = job.file};
  try {
    if (!cache_ && !cache_folder_.empty()) cache_.emplace(cache_folder_);
    const base::Result<std::string> file = FileOf(job);
    if (!file.ok()) {
      built.error = file.error();
      return built;
    }
    built.file = *file;
    base::Result<haptics::Scene> scene =
        scene::LoadScene(built.file, job.options, cache_ ? &*cache_ : nullptr, built.load, built.report);
    built.warnings = built.load.warnings;
    if (cache_ && !cache_->problem().empty() && !std::exchange(cache_reported_, true)) {
      built.warnings.push_back("scene cache: " + cache_->problem());
    }
    if (scene.ok()) {
      const haptics::LivePlan plan = haptics::MakeLive(*scene);
      for (const std::string& line : plan.lines) built.warnings.push_back(built.file + ": " + line);
      soft_objects.assign(plan.soft.begin(), plan.soft.end());
      built.scene = std::make_shared<const haptics::Scene>(std::move(*scene));
    } else {
      built.error = scene.error();
    }
  } catch (const std::exception& caught) {  // out of memory on a hostile file must not take the service down
    built.error = job.file + ": " + caught.what();
  }
  return built;
}

}  // namespace omni::daemon
