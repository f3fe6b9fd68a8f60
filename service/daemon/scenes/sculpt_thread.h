// The thread that edits sculpted surfaces: handles the tick's messages every 2 ms, and requests of users (undo, redo,
// save). It exists while there is a scene with a sculpt session, and polls only while the tick may read one.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "service/base/threads/realtime_threads.h"
#include "service/base/unique_fd.h"
#include "service/daemon/scenes/journal_writer.h"
#include "service/haptics/live/live_parts.h"
#include "service/haptics/scene/scene.h"

namespace omni::daemon {

enum class SculptAction : std::uint8_t { kEdits, kUndo, kRedo, kSave, kRelease };

struct SculptRequest {
  std::uint64_t asker = 0;   // client that gets the answer
  std::uint32_t number = 0;  // comes back in it
  std::uint64_t client = 0;  // whose scene; 0: the owner's if it is sculpted, else the only one that is
  SculptAction action = SculptAction::kEdits;
  std::string object;  // name, or index in the scene; empty: undo and redo apply to the one that was edited last
};

struct SculptAnswer {
  std::uint64_t asker = 0;
  std::uint32_t number = 0;
  bool ok = false;
  std::string text;              // kEdits: JSON; else a line for people, including the reason of a refusal
  base::UniqueFd file;           // kSave: sealed memory that holds a .glb
  std::uint64_t file_bytes = 0;  // its size
  // What it holds: once the asker has the file, MarkSaved with the number.
  std::vector<std::pair<JournalWriter::Journal, std::uint64_t>> saved;
};

// For people: a rejected stroke, or what becomes of a journal.
struct SculptProblem {
  std::uint64_t client = 0;
  std::string text;
  int level = 1;  // as JournalNote's
};

class SculptThread {
 public:
  static constexpr std::chrono::milliseconds kPeriod{2};
  static constexpr std::size_t kMaxWaiting = 16;                // requests; further ones are refused at once
  static constexpr std::chrono::seconds kSameProblemAfter{10};  // the same problem is not reported again before
  static constexpr std::chrono::seconds kKeepOpenEvery{1};      // a stroke that goes on is written to the journal

  SculptThread() = default;
  ~SculptThread();
  SculptThread(const SculptThread&) = delete;
  SculptThread& operator=(const SculptThread&) = delete;

  // All below: control thread only. A scene without a sculpt session is ignored by all of them.

  // Adds a client's scene, loaded from `file`. Held until Remove. `journals`: one per sculpt session, or none at all;
  // from here on they are this one's.
  void Add(std::uint64_t client, const std::string& file, const std::shared_ptr<const haptics::Scene>& scene,
           const std::vector<JournalWriter::Journal>& journals = {});
  // Call each time before the scene is handed to the tick: from here on nothing that the tick may read is reused.
  void EnterScene(const haptics::Scene& scene);
  // The tick no longer uses the scene: it has acknowledged a newer hand-over, or its thread has ended. Ends open
  // strokes.
  void LeaveScene(const haptics::Scene& scene);
  // The scene is no longer used. Precondition: never entered, or left since.
  void Remove(const haptics::Scene& scene);

  // The answer comes by PopAnswer, also if it is a refusal. `owner`: client that owns the force; 0: none.
  void Request(const SculptRequest& request, std::uint64_t owner);
  // Neither of the two waits for an edit that is in progress: a later call returns its result.
  std::optional<SculptAnswer> PopAnswer();
  std::optional<SculptProblem> PopProblem();
  // Of a journal; its present problem is in its state.
  std::optional<SculptProblem> PopJournalNote();
  // The asker has got the file.
  void ConfirmSaved(const SculptAnswer& answer);
  // Whether the thread exists, for tests and status.
  bool running() const;

 private:
  using Clock = std::chrono::steady_clock;
  // One sculpt session.
  struct Bench {
    std::uint64_t edited = 0;        // when it was edited last, counted; 0: never
    std::string problem;             // the newest one reported ...
    Clock::time_point reported;      // ... and when
    JournalWriter::Journal journal;  // null: none
    Clock::time_point kept;          // its open stroke, or when that began ...
    bool moved = false;              // ... and whether it has changed since
  };
  struct Sculpted {
    std::uint64_t client = 0;
    std::string file;
    std::shared_ptr<const haptics::Scene> scene;
    std::vector<Bench> benches;  // as the scene's sculpt sessions
    bool read = false;           // by the tick
    bool broken = false;         // an edit ran out of memory: it is not edited any more

    haptics::sculpt::SculptSession& sculpt_session(std::size_t n) const {
      return scene->live()->sculpt_session_at(static_cast<std::uint32_t>(n));
    }
    std::uint32_t object(std::size_t n) const { return scene->live()->object_at(static_cast<std::uint32_t>(n)); }
    const char* name(std::size_t n) const { return scene->objects()[object(n)].name; }
  };
  struct Work {
    SculptRequest request;
    std::shared_ptr<const haptics::Scene> scene;
  };
  void Run();
  void Poll(Sculpted& sculpted);
  void KeepOpenStroke(Sculpted& sculpted, std::size_t n, const haptics::sculpt::ServeReport& served);
  void CloseJournals(Sculpted& sculpted);
  void Report(Sculpted& sculpted, std::size_t n, const std::string& problem);
  void Execute(const Work& work, std::unique_lock<std::mutex>& lock);
  void Save(const Sculpted& sculpted, std::unique_lock<std::mutex>& lock, SculptAnswer& answer);
  void Step(Sculpted& sculpted, const SculptRequest& request, SculptAnswer& answer);
  static void Release(const Sculpted& sculpted, SculptAnswer& answer);
  static std::string Edits(const Sculpted& sculpted);
  // The sculpt session that a request refers to; none: see `why`.
  static std::optional<std::size_t> Named(const Sculpted& sculpted, const std::string& object, std::string& why);
  Sculpted* Find(const haptics::Scene& scene);
  Sculpted* Choose(std::uint64_t client, std::uint64_t owner, std::string& why);

  JournalWriter writer_;
  mutable base::PriorityMutex mutex_;
  std::condition_variable wake_;
  std::vector<Sculpted> scenes_;
  std::deque<Work> work_;
  std::deque<SculptAnswer> answers_;
  std::deque<SculptProblem> problems_;
  std::uint64_t edits_ = 0;  // counts
  bool ended_ = false;       // the thread has left Run, or is about to
  std::thread thread_;
};

}  // namespace omni::daemon
