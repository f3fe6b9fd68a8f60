// The builder thread: loads and builds one scene at a time, off the tick and off the control thread.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "service/config/app_file.h"
#include "service/haptics/scene.h"
#include "service/scene/cache_store.h"
#include "service/scene/scene_file.h"

namespace omni::daemon {

struct BuiltScene {
  std::uint64_t client = 0;
  std::string file;
  std::shared_ptr<const haptics::Scene> scene;  // null: failed, see error
  std::string error;
  std::vector<std::string> warnings;
  scene::LoadReport load;
  haptics::BuildReport report;
};

// What an application file asks of its scene.
scene::LoadOptions LoadOptionsOf(const config::AppEntry& app, double hull_radius_m);

class SceneBuilder {
 public:
  // `cache_folder`: built scenes are kept there (scene/cache_store.h); empty: nowhere.
  explicit SceneBuilder(double hull_radius_m, std::string cache_folder = {});
  ~SceneBuilder();
  SceneBuilder(const SceneBuilder&) = delete;
  SceneBuilder& operator=(const SceneBuilder&) = delete;

  // Queues a job; a job of the same client that has not begun is replaced.
  void Request(std::uint64_t client, const config::AppEntry& app);
  // Forgets the client's waiting job; the result of a running one is dropped.
  void Cancel(std::uint64_t client);
  // A finished job, oldest first.
  std::optional<BuiltScene> TakeResult();

 private:
  struct Job {
    std::uint64_t client;
    config::AppEntry app;
  };
  void Run();
  BuiltScene Build(const Job& job);

  const double hull_radius_m_;
  const std::string cache_folder_;
  std::optional<scene::CacheStore> cache_;  // of the thread
  bool told_of_cache_ = false;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<Job> jobs_;
  std::deque<BuiltScene> results_;
  std::uint64_t running_client_ = 0;  // 0: none, or its result is not wanted any more
  bool stop_ = false;
  std::thread thread_;
};

}  // namespace omni::daemon
