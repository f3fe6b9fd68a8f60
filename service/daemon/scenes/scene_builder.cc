#include "service/daemon/scenes/scene_builder.h"

#include <pthread.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <filesystem>
#include <map>
#include <mutex>
#include <thread>
#include <utility>

#include "service/base/free_memory.h"
#include "service/base/threads/realtime_threads.h"
#include "service/config/paths.h"
#include "service/haptics/live/make_live.h"
#include "service/scene/cache/cache_store.h"
#include "service/scene/cache/cached_scene.h"
#include "service/scene/gltf/file_bytes.h"

namespace omni::daemon {
namespace {

constexpr std::chrono::milliseconds kEndPatience{50};
constexpr std::size_t kStackBytes = 2u << 20;  // of a thread: locked memory is taken as a whole
constexpr std::uint32_t kMostBuilders = 16;

// Searched now, not when the application's file was read: a scene may be added later. A document only has a name.
base::Result<std::string> FileOf(const SceneJob& job) {
  return job.document != nullptr ? job.file : config::FindScene(job.file, config::ScenesFolder());
}

}  // namespace

scene::LoadOptions LoadOptionsOf(const config::AppEntry& app, double hull_radius_m, double tip_radius_m) {
  return {.touch_untagged = app.touch == config::Touch::kAll,
          .z_up = app.up == config::Up::kZ,
          .fit = app.placement == config::Placement::kFit,
          .offset_base_m = app.offset_base_m,
          .scale = app.scale,
          .hull_radius_m = hull_radius_m,
          .tip_radius_m = tip_radius_m,
          .tags_by_name = app.tags};
}

std::uint32_t BuildersOfComputer() { return std::clamp(std::thread::hardware_concurrency(), 2U, kMostBuilders); }

class SceneBuilder::Work : public std::enable_shared_from_this<Work> {
 public:
  explicit Work(BuilderOptions options) : options_(std::move(options)), budget_(options_.limits) {}

  // Starts threads for what may run; a thread of its own, whose scheduling they inherit.
  void Dispatch() {
    std::unique_lock<std::mutex> lock(mutex_);
    while (!stop_) {
      const std::optional<MemoryBudget::Number> next = budget_.StartNext();
      if (!next) {
        wake_.wait(lock);
      } else if (!StartThread(*next)) {
        budget_.End(*next);
        Fail(*next, "no thread for its builder; close programs");
      }
    }
  }

  void Request(SceneJob job) {
    const Dropped dropped = DropJob(job.client);
    const std::lock_guard lock(mutex_);
    if (!options_.refused.empty()) {
      results_.push_back({.client = job.client, .file = job.file, .error = job.file + ": " + options_.refused});
      return;
    }
    auto task = std::make_shared<Task>();
    task->client = job.client;
    task->payer = job.payer == 0 ? job.client : job.payer;
    task->file = job.file;
    task->job = std::move(job);
    Add(std::move(task), {});
  }

  void Cancel(std::uint64_t client) { const Dropped dropped = DropJob(client); }

  void Stop() {
    std::unique_lock<std::mutex> lock(mutex_);
    stop_ = true;
    for (const auto& [number, task] : tasks_) task->cancel.Set();
    wake_.notify_all();
    ended_.wait_for(lock, kEndPatience, [this] { return threads_ == 0; });
    // What will not be popped any more; scenes free their memory here.
    const auto results = std::move(results_);
    std::vector<std::shared_ptr<Task>> waiting;
    for (auto entry = tasks_.begin(); entry != tasks_.end();) {
      const bool waits = budget_.IsWaiting(entry->first);
      if (waits) waiting.push_back(entry->second);
      entry = waits ? tasks_.erase(entry) : std::next(entry);
    }
    results_.clear();
    lock.unlock();
  }

  template <class T>
  std::optional<T> Pop(std::deque<T> Work::*list) {
    const std::lock_guard lock(mutex_);
    if ((this->*list).empty()) return std::nullopt;
    std::optional<T> first = std::move((this->*list).front());
    (this->*list).pop_front();
    return first;
  }

  SoftProgress Progress(std::uint64_t client) const {
    const std::lock_guard lock(mutex_);
    const auto found = progress_.find(client);
    return found == progress_.end() ? SoftProgress{} : found->second;
  }

  BuilderStatus Status() const {
    const std::lock_guard lock(mutex_);
    BuilderStatus status{
        .rows = {}, .kept_bytes = budget_.kept_bytes(), .peak_bytes = budget_.peak_bytes(), .limits = budget_.limits()};
    for (const auto& [number, task] : tasks_) {
      const std::string why = budget_.WhyItWaits(number);
      status.rows.push_back(
          {task->payer, task->file, why.empty() ? "runs" : why, task->soft(), budget_.NeedOf(number)});
    }
    return status;
  }

  std::uint64_t KeptBytes(std::uint64_t payer) const {
    const std::lock_guard lock(mutex_);
    return budget_.kept_bytes(payer);
  }

  void Free(MemoryBudget::Number kept) {
    const std::lock_guard lock(mutex_);
    budget_.FreeKept(kept);
    wake_.notify_all();
  }

  std::deque<BuiltScene> results_;
  std::deque<SoftOutcome> outcomes_;
  std::deque<BuilderNote> notes_;

 private:
  // A scene that is to be built, or the next soft body of one that has been.
  struct Task {
    std::uint64_t client = 0, payer = 0;
    std::string file;
    CancelEvent cancel;
    bool wanted = true;
    bool noted = false;  // its client knows that it waits
    SceneJob job;
    std::shared_ptr<const haptics::Scene> scene;  // null: it is to be built
    MemoryBudget::Number kept = 0;                // of the scene
    std::deque<std::uint32_t> objects;            // that get soft bodies
    bool soft() const { return scene != nullptr; }
  };
  // What must not be destroyed with the lock held: a scene frees its memory with it.
  struct Dropped {
    std::vector<std::shared_ptr<Task>> tasks;
    std::vector<BuiltScene> results;
  };
  // A scene, and its memory until its last holder gives it up.
  struct KeptScene {
    KeptScene(std::shared_ptr<Work> owner, haptics::Scene made) : work(std::move(owner)), scene(std::move(made)) {}
    ~KeptScene() {
      scene = {};
      if (kept != 0) work->Free(kept);
    }
    KeptScene(const KeptScene&) = delete;
    KeptScene& operator=(const KeptScene&) = delete;
    const std::shared_ptr<Work> work;
    haptics::Scene scene;
    MemoryBudget::Number kept = 0;
  };
  struct Started {
    std::shared_ptr<Work> work;
    MemoryBudget::Number number;
  };
  enum class End { kDone, kWaits };

  // With the lock held.
  void Add(std::shared_ptr<Task> task, const scene::BuildNeed& need) {
    const BuildRequest request{task->client, task->payer, task->soft(), need};
    tasks_.emplace(budget_.Wait(request), std::move(task));
    wake_.notify_all();
  }

  Dropped DropJob(std::uint64_t client) {
    Dropped dropped;
    const std::lock_guard lock(mutex_);
    for (auto entry = tasks_.begin(); entry != tasks_.end();) {
      if (entry->second->client != client) {
        ++entry;
        continue;
      }
      entry->second->wanted = false;
      entry->second->cancel.Set();
      dropped.tasks.push_back(entry->second);
      // A running one is given up by its thread, with its memory.
      const bool waits = budget_.IsWaiting(entry->first);
      if (waits) budget_.End(entry->first);
      entry = waits ? tasks_.erase(entry) : std::next(entry);
    }
    for (BuiltScene& result : results_) {
      if (result.client == client) dropped.results.push_back(std::move(result));
    }
    std::erase_if(results_, [&](const BuiltScene& result) { return result.client == client; });
    std::erase_if(outcomes_, [&](const SoftOutcome& outcome) { return outcome.client == client; });
    std::erase_if(notes_, [&](const BuilderNote& note) { return note.client == client; });
    progress_.erase(client);
    wake_.notify_all();
    return dropped;
  }

  static void* RunThread(void* started) {
    const std::unique_ptr<Started> own(static_cast<Started*>(started));
    own->work->RunTask(own->number);
    return nullptr;
  }

  bool StartThread(MemoryBudget::Number number) {
    auto started = std::make_unique<Started>(Started{shared_from_this(), number});
    pthread_attr_t attributes;
    pthread_attr_init(&attributes);
    pthread_attr_setstacksize(&attributes, kStackBytes);
    pthread_attr_setdetachstate(&attributes, PTHREAD_CREATE_DETACHED);
    pthread_t thread{};
    const bool made = pthread_create(&thread, &attributes, RunThread, started.get()) == 0;
    pthread_attr_destroy(&attributes);
    if (!made) return false;
    static_cast<void>(started.release());
    ++threads_;
    return true;
  }

  // With the lock held.
  void Fail(MemoryBudget::Number number, const std::string& why) {
    const auto found = tasks_.find(number);
    const std::shared_ptr<Task> task = found->second;
    tasks_.erase(found);
    if (!task->soft())
      results_.push_back({.client = task->client, .file = task->file, .error = task->file + ": " + why});
  }

  void RunTask(MemoryBudget::Number number) {
    std::shared_ptr<Task> task;
    {
      const std::lock_guard lock(mutex_);
      task = tasks_.at(number);
    }
    const End end = task->soft() ? RunSoft(number, *task) : RunScene(number, *task);
    const std::lock_guard lock(mutex_);
    // One that waits may have been dropped, or started again, by now.
    if (end == End::kDone) {
      budget_.End(number);
      tasks_.erase(number);
    }
    --threads_;
    wake_.notify_all();
    ended_.notify_all();
  }

  End RunScene(MemoryBudget::Number number, Task& task) {
    BuiltScene built{.client = task.client, .file = task.file};
    auto made = std::make_shared<KeptScene>(shared_from_this(), haptics::Scene());
    haptics::LivePlan plan;
    bool waits = false;
    try {
      waits = !Build(number, task, built, made->scene, plan);
    } catch (const std::exception& caught) {  // out of memory must not take the service down
      built.error = task.file + ": " + caught.what();
    }
    if (waits) return End::kWaits;
    const std::lock_guard lock(mutex_);
    if (!task.wanted || stop_) return End::kDone;
    if (built.error.empty()) {
      made->kept = budget_.Finish(number, made->scene.bytes() + haptics::SculptSessionBytes(made->scene, plan));
      built.scene = std::shared_ptr<const haptics::Scene>(made, &made->scene);
      built.build = ++builds_;
      if (!plan.soft.empty()) {
        progress_[task.client] = {.objects = static_cast<std::uint32_t>(plan.soft.size())};
        AddSoft(task, built.file, built.scene, made->kept, {plan.soft.begin(), plan.soft.end()});
      }
    }
    results_.push_back(std::move(built));
    return End::kDone;
  }

  // False: it waits for memory, and begins again when there is some.
  bool Build(MemoryBudget::Number number, Task& task, BuiltScene& built, haptics::Scene& made,
             haptics::LivePlan& plan) {
    const base::Result<std::string> file = FileOf(task.job);
    if (!file.ok()) {
      built.error = file.error();
      return true;
    }
    built.file = *file;
    std::optional<scene::CacheStore> cache;
    if (!options_.cache_folder.empty()) cache.emplace(options_.cache_folder);
    scene::LoadOptions load = task.job.options;
    base::UniqueFd opened;
    scene::FilesInFolder folder(std::filesystem::path(*file).parent_path().string());
    if (task.job.document == nullptr) {
      try {
        opened.Reset(scene::OpenForReading(*file));
      } catch (const std::exception& problem) {
        built.error = *file + ": " + problem.what();
        return true;
      }
      load.beside = &folder;
    }
    load.memory = opened ? opened.get() : task.job.document->get();
    MemoryBudget::Answer answer =
        Ask(number, task, scene::NeedToRead(scene::JsonBytesOf(load.memory), scene::FileBytesOf(load.memory)), built);
    std::optional<scene::CachedPlace> place;
    std::optional<haptics::Scene> cached;
    const scene::LoadSteps steps{.admit =
                                     [&](const scene::BuildNeed& need) {
                                       answer = Ask(number, task, need, built);
                                       return answer == MemoryBudget::Answer::kGranted;
                                     },
                                 .build =
                                     [&](const scene::Digest& bytes) {
                                       place.emplace(cache ? &*cache : nullptr, *file, load, bytes);
                                       cached = place->Take(built.load, built.report);
                                       return !cached;
                                     }};
    base::Result<haptics::Scene> scene = base::Error{};
    if (answer == MemoryBudget::Answer::kGranted) {
      scene = options_.way->BuildScene(*file, load, steps, task.cancel, built.load, built.report);
    }
    if (answer == MemoryBudget::Answer::kWaits) return false;
    if (cached) scene = std::move(*cached);
    built.warnings = built.load.warnings;
    if (answer == MemoryBudget::Answer::kRefused) return true;  // built.error says why
    if (!scene.ok()) {
      built.error = scene.error().empty() ? *file + ": cancelled" : scene.error();
      return true;
    }
    made = std::move(*scene);
    if (!cached && cache && place && !made.empty() && !task.cancel.is_set() &&
        made.header().triangle_count >= scene::kCachedFromTriangles) {
      place->Keep(made.header().triangle_count, scene::Pack(made, built.load, built.report), built.load);
    }
    if (cache && !cache->problem().empty() && !cache_reported_.exchange(true)) {
      built.warnings.push_back("scene cache: " + cache->problem());
    }
    base::FreeMemory(built.load.rows);  // for people; up to a hundred thousand of them
    plan = haptics::MakeLive(made, RoomFor(number));
    for (const std::string& line : plan.lines) built.warnings.push_back(built.file + ": " + line);
    if (!task.job.application.empty() && !task.cancel.is_set()) {
      built.journals = scene::RestoreJournals(
          made, {.folder = options_.journal_folder, .application = task.job.application, .file = built.file},
          built.notes);
    }
    return true;
  }

  MemoryBudget::Answer Ask(MemoryBudget::Number number, Task& task, const scene::BuildNeed& need, BuiltScene& built) {
    const std::lock_guard lock(mutex_);
    std::string why;
    if (!task.wanted || stop_) {
      built.error = built.file + ": cancelled";
      return MemoryBudget::Answer::kRefused;
    }
    const MemoryBudget::Answer answer = budget_.Grow(number, need, why);
    if (answer == MemoryBudget::Answer::kRefused) built.error = built.file + ": " + why;
    if (answer == MemoryBudget::Answer::kWaits && !std::exchange(task.noted, true)) {
      notes_.push_back({task.client, built.file + ": " + why});
    }
    wake_.notify_all();  // what it no longer takes
    return answer;
  }

  std::uint64_t RoomFor(MemoryBudget::Number number) const {
    const std::lock_guard lock(mutex_);
    return budget_.RoomFor(number);
  }

  // The next soft body of a scene. With the lock held.
  void AddSoft(const Task& of, const std::string& file, std::shared_ptr<const haptics::Scene> scene,
               MemoryBudget::Number kept, std::deque<std::uint32_t> objects) {
    auto task = std::make_shared<Task>();
    task->client = of.client;
    task->payer = of.payer;
    task->file = file;
    task->scene = std::move(scene);
    task->kept = kept;
    task->objects = std::move(objects);
    Add(std::move(task), {});
  }

  End RunSoft(MemoryBudget::Number number, Task& task) {
    const std::uint32_t index = task.objects.front();
    SoftOutcome outcome{.client = task.client, .file = task.file, .object = task.scene->objects()[index].name};
    std::unique_ptr<const haptics::SoftBody> body;
    try {
      MemoryBudget::Answer answer = MemoryBudget::Answer::kGranted;
      body = MakeSoftBody(number, task, index, outcome, answer);
      if (answer == MemoryBudget::Answer::kWaits) return End::kWaits;
    } catch (const std::exception& caught) {  // out of memory
      outcome.error = std::string("soft body: ") + caught.what();
    }
    const std::lock_guard lock(mutex_);
    if (!task.wanted || stop_) return End::kDone;
    SoftProgress& progress = progress_[task.client];
    ++(body != nullptr ? progress.ready : progress.failed);
    progress.done = static_cast<double>(progress.ready + progress.failed) / progress.objects;
    if (body != nullptr) {
      budget_.FinishInto(number, task.kept, body->bytes().size());
      task.scene->live()->SetSoftBody(index, std::move(body));
    }
    outcomes_.push_back(std::move(outcome));
    task.objects.pop_front();
    if (!task.objects.empty()) AddSoft(task, task.file, task.scene, task.kept, std::move(task.objects));
    return End::kDone;
  }

  // Null: failed or cancelled, see outcome.error; or it waits.
  std::unique_ptr<const haptics::SoftBody> MakeSoftBody(MemoryBudget::Number number, Task& task, std::uint32_t index,
                                                        SoftOutcome& outcome, MemoryBudget::Answer& answer) {
    const haptics::Object& object = task.scene->objects()[index];
    const haptics::Mesh mesh = haptics::MeshOf(*task.scene, index);
    haptics::SoftBodyOptions soft =
        haptics::SoftOptionsOf(task.scene->materials()[haptics::MainMaterial(*task.scene, object)]);
    soft.lattice.max_tets = options_.soft_tets;
    soft.progress = [&](double done) { return GoOn(task, done); };
    {
      const std::lock_guard lock(mutex_);
      answer =
          task.wanted ? budget_.Grow(number, scene::NeedOf(mesh, soft), outcome.error) : MemoryBudget::Answer::kRefused;
      wake_.notify_all();
    }
    if (answer != MemoryBudget::Answer::kGranted) return nullptr;
    std::optional<scene::CacheStore> cache;
    if (!options_.cache_folder.empty()) cache.emplace(options_.cache_folder);
    base::Result<haptics::SoftBody> body = scene::LoadSoftBody(
        mesh, soft, cache ? &*cache : nullptr, outcome.report,
        [&](const haptics::Mesh& of, const haptics::SoftBodyOptions& with, haptics::SoftBuildReport& report) {
          return options_.way->BuildSoftBody(of, with, task.cancel, report);
        });
    if (body.ok()) return std::make_unique<const haptics::SoftBody>(std::move(*body));
    outcome.error = body.error();
    return nullptr;
  }

  bool GoOn(const Task& task, double done) {
    const std::lock_guard lock(mutex_);
    if (stop_ || !task.wanted) return false;
    SoftProgress& progress = progress_[task.client];
    progress.done = (progress.ready + progress.failed + done) / progress.objects;
    return true;
  }

  const BuilderOptions options_;
  mutable base::PriorityMutex mutex_;
  std::condition_variable wake_;   // of the dispatcher
  std::condition_variable ended_;  // a thread has
  MemoryBudget budget_;
  std::map<MemoryBudget::Number, std::shared_ptr<Task>> tasks_;  // those that wait or run
  std::map<std::uint64_t, SoftProgress> progress_;
  std::atomic<bool> cache_reported_{false};
  std::uint64_t builds_ = 0;
  int threads_ = 0;
  bool stop_ = false;
};

SceneBuilder::SceneBuilder(BuilderOptions options)
    : hull_radius_m_(options.hull_radius_m),
      tip_radius_m_(options.tip_radius_m),
      work_(std::make_shared<Work>(std::move(options))) {
  dispatcher_ = std::thread([work = work_] { work->Dispatch(); });
}

SceneBuilder::~SceneBuilder() {
  work_->Stop();
  dispatcher_.join();
}

void SceneBuilder::Request(std::uint64_t client, const config::AppEntry& app, const std::string& application) {
  Request({.client = client,
           .file = app.scene,
           .options = LoadOptionsOf(app, hull_radius_m_, tip_radius_m_),
           .document = nullptr,
           .application = application});
}
void SceneBuilder::Request(SceneJob job) { work_->Request(std::move(job)); }
void SceneBuilder::Cancel(std::uint64_t client) { work_->Cancel(client); }
std::optional<BuiltScene> SceneBuilder::PopResult() { return work_->Pop(&Work::results_); }
std::optional<SoftOutcome> SceneBuilder::PopSoftOutcome() { return work_->Pop(&Work::outcomes_); }
std::optional<BuilderNote> SceneBuilder::PopNote() { return work_->Pop(&Work::notes_); }
SoftProgress SceneBuilder::Progress(std::uint64_t client) const { return work_->Progress(client); }
BuilderStatus SceneBuilder::Status() const { return work_->Status(); }
std::uint64_t SceneBuilder::KeptBytes(std::uint64_t payer) const { return work_->KeptBytes(payer); }

}  // namespace omni::daemon
