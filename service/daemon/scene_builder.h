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
#include "service/scene/scene_file.h"

namespace omni::daemon {

struct BuiltScene {
  std::uint64_t client = 0;
  std::string file;
  std::shared_ptr<const haptics::Scene> scene;  // null: failed, see error
  std::string error;
  std::vector<std::string> warnings;
  haptics::BuildReport report;
};

class SceneBuilder {
 public:
  explicit SceneBuilder(double hull_radius_m);
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
  BuiltScene Build(const Job& job) const;

  const double hull_radius_m_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<Job> jobs_;
  std::deque<BuiltScene> results_;
  std::uint64_t running_client_ = 0;  // 0: none, or its result is not wanted any more
  bool stop_ = false;
  std::thread thread_;
};

}  // namespace omni::daemon
