// Builds clients' scenes, off the tick and off the control thread: several at once, as many as there are processors and
// as there is memory for (memory_budget.h), each by a BuildWay. A scene with soft bodies is delivered without them;
// they are computed afterwards, one by one.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "service/base/unique_fd.h"
#include "service/config/files/app_file.h"
#include "service/daemon/scenes/build_way.h"
#include "service/daemon/scenes/memory_budget.h"
#include "service/haptics/scene/scene.h"
#include "service/scene/journal/sculpt_journal.h"
#include "service/scene/load_scene.h"
#include "service/scene/scene_file.h"

namespace omni::daemon {

struct BuiltScene {
  std::uint64_t client = 0;
  std::uint64_t build = 0;  // a number that is never reused
  std::string file;
  // Null: failed, see error. Includes its live parts, if any: sculpt sessions at once, soft bodies as they get ready.
  // Its memory counts for its client until its last holder gives it up.
  std::shared_ptr<const haptics::Scene> scene;
  std::string error;
  std::vector<std::string> warnings;
  std::vector<std::shared_ptr<scene::SculptJournal>> journals;  // per sculpt session; empty: none are kept
  std::vector<scene::JournalNote> notes;                        // what they have restored, or why not
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
scene::LoadOptions LoadOptionsOf(const config::AppEntry& app, double hull_radius_m, double tip_radius_m);

// A scene to be built, and for which client.
struct SceneJob {
  std::uint64_t client = 0;                        // of the job: a client may have several
  std::string file;                                // path, or the document's name
  scene::LoadOptions options;                      // `memory` and `beside` are set by the builder
  std::shared_ptr<const base::UniqueFd> document;  // instead of a file; null: none
  std::uint64_t payer = 0;                         // whose memory its scene is; 0: `client`
  std::string application;                         // whose strokes are kept; empty: they are not
};

// What waits for memory, for its client.
struct BuilderNote {
  std::uint64_t client = 0;
  std::string text;
};

// For people.
struct BuilderStatus {
  struct Row {
    std::uint64_t client = 0;
    std::string file, state;  // "runs", or why it waits
    bool soft = false;
    scene::BuildNeed need;
  };
  std::vector<Row> rows;  // oldest first
  std::uint64_t kept_bytes = 0, peak_bytes = 0;
  MemoryLimits limits;
};

struct BuilderOptions {
  double hull_radius_m = 0.0375;
  double tip_radius_m = scene::LoadOptions{}.tip_radius_m;  // of the pen
  std::string cache_folder;    // of built scenes (scene/cache/cache_store.h); empty: no cache
  std::string journal_folder;  // of strokes (scene/journal); empty: they are not kept
  // Of a soft body, at most [100, 400000]; more take longer to compute.
  std::uint32_t soft_tets = scene::kSoftTets;
  std::shared_ptr<const BuildWay> way = std::make_shared<const BuildHere>();
  std::string refused;  // why no scene is built at all; empty: they are
  MemoryLimits limits;
};

// As many builders as processors, for limits.
std::uint32_t BuildersOfComputer();

class SceneBuilder {
 public:
  explicit SceneBuilder(BuilderOptions options);
  explicit SceneBuilder(double hull_radius_m, std::string cache_folder = {}, std::uint32_t soft_tets = scene::kSoftTets)
      : SceneBuilder(BuilderOptions{
            .hull_radius_m = hull_radius_m, .cache_folder = std::move(cache_folder), .soft_tets = soft_tets}) {}
  ~SceneBuilder();  // ends what runs, and waits for that no longer than a moment
  SceneBuilder(const SceneBuilder&) = delete;
  SceneBuilder& operator=(const SceneBuilder&) = delete;

  // Queues a job; ends the same client's one before, and its soft bodies.
  void Request(std::uint64_t client, const config::AppEntry& app, const std::string& application = {});
  void Request(SceneJob job);
  // Ends the client's job; there will be no result of it.
  void Cancel(std::uint64_t client);
  // A finished job, oldest first.
  std::optional<BuiltScene> PopResult();
  // A soft body that was finished or has failed, oldest first. Never before its scene's result.
  std::optional<SoftOutcome> PopSoftOutcome();
  std::optional<BuilderNote> PopNote();
  SoftProgress Progress(std::uint64_t client) const;
  BuilderStatus Status() const;
  std::uint64_t KeptBytes(std::uint64_t payer) const;

 private:
  class Work;  // shared with the threads, of which one may outlive this when a disk hangs
  const double hull_radius_m_, tip_radius_m_;
  const std::shared_ptr<Work> work_;
  std::thread dispatcher_;
};

}  // namespace omni::daemon
