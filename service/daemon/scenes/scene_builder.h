// The builder thread: loads and builds one scene at a time, off the tick and off the control thread. A scene with soft
// bodies is delivered without them; they are computed afterwards, one by one, while no scene is requested.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "service/base/threads/realtime_threads.h"
#include "service/base/unique_fd.h"
#include "service/config/files/app_file.h"
#include "service/haptics/scene/scene.h"
#include "service/scene/cache/cache_store.h"
#include "service/scene/load_scene.h"
#include "service/scene/scene_file.h"

namespace omni::daemon {

struct BuiltScene {
  std::uint64_t client = 0;
  std::uint64_t build = 0;  // a number that is never reused
  std::string file;
  // Null: failed, see error. Includes its live parts, if any: sculpt sessions at once, soft bodies as they get ready.
  std::shared_ptr<const haptics::Scene> scene;
  std::string error;
  std::vector<std::string> warnings;
  scene::LoadReport load;
  haptics::BuildReport report;
};

// Of one client's scene.
struct SoftProgress {
  std::uint32_t objects = 0;  // that get a soft body; 0: none does
  std::uint32_t ready = 0, failed = 0;
  double done = 0;  // of all objects, 0 ... 1
};

// A soft body was finished, or has failed.
struct SoftOutcome {
  std::uint64_t client = 0;
  std::string file, object;
  std::string error;  // empty: the soft body is in use
  scene::SoftLoadReport report;
};

// Options from an application's file for its scene.
scene::LoadOptions LoadOptionsOf(const config::AppEntry& app, double hull_radius_m);

// A scene to be built, and for which client.
struct SceneJob {
  std::uint64_t client = 0;
  std::string file;                                // path, or the document's name
  scene::LoadOptions options;                      // `memory` is set from the next one
  std::shared_ptr<const base::UniqueFd> document;  // instead of a file; null: none
};

class SceneBuilder {
 public:
  // `cache_folder`: stores built scenes (scene/cache/cache_store.h); empty: no cache. `soft_tets`: of a soft body, at
  // most [100, 400000]; more take longer to compute.
  explicit SceneBuilder(double hull_radius_m, std::string cache_folder = {},
                        std::uint32_t soft_tets = scene::kSoftTets);
  ~SceneBuilder();
  SceneBuilder(const SceneBuilder&) = delete;
  SceneBuilder& operator=(const SceneBuilder&) = delete;

  // Queues a job; replaces a job of the same client that has not begun, and cancels its soft bodies.
  void Request(std::uint64_t client, const config::AppEntry& app);
  void Request(SceneJob job);
  // Forgets the client's waiting jobs; the result of a running one is dropped.
  void Cancel(std::uint64_t client);
  // A finished job, oldest first.
  std::optional<BuiltScene> PopResult();
  // A soft body that was finished or has failed, oldest first. Never before its scene's result.
  std::optional<SoftOutcome> PopSoftOutcome();
  SoftProgress Progress(std::uint64_t client) const;

 private:
  // The soft bodies that a scene still has to get.
  struct SoftJob {
    std::uint64_t client = 0;
    std::string file;
    std::shared_ptr<const haptics::Scene> scene;
    std::deque<std::uint32_t> objects;
  };
  void Run();
  // Both need the lock held, and release it while they work.
  void RunJob(std::unique_lock<std::mutex>& lock);
  void RunSoftJob(std::unique_lock<std::mutex>& lock);
  std::unique_ptr<const haptics::SoftBody> MakeSoftBody(const haptics::Scene& scene, std::uint32_t index,
                                                        SoftOutcome& outcome);
  // Called by the precompute: whether to continue. Builds requested scenes meanwhile.
  bool GoOn(std::uint64_t client, double done);
  void DropSoft(std::uint64_t client);  // with the lock held
  BuiltScene Build(const SceneJob& job, std::deque<std::uint32_t>& soft_objects);

  const double hull_radius_m_;
  const std::string cache_folder_;
  const std::uint32_t soft_tets_;
  std::optional<scene::CacheStore> cache_;  // of the thread
  bool cache_reported_ = false;
  mutable base::PriorityMutex mutex_;
  std::condition_variable wake_;
  std::deque<SceneJob> jobs_;
  std::deque<BuiltScene> results_;
  std::uint64_t builds_ = 0;
  std::uint64_t running_client_ = 0;  // 0: none, or its result is no longer wanted
  std::deque<SoftJob> soft_jobs_;     // the first one is in progress
  std::uint64_t soft_client_ = 0;     // as running_client_
  std::deque<SoftOutcome> outcomes_;
  std::map<std::uint64_t, SoftProgress> progress_;
  bool stop_ = false;
  std::thread thread_;
};

}  // namespace omni::daemon
