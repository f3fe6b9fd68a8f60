#include "service/daemon/scenes/journal_writer.h"

#include <condition_variable>
#include <exception>
#include <map>
#include <mutex>
#include <thread>

#include <spdlog/spdlog.h>

#include "service/base/threads/realtime_threads.h"

namespace omni::daemon {

struct JournalWriter::Shared {
  using Clock = std::chrono::steady_clock;
  struct Job {
    Clock::time_point due;
    bool close = false;
  };

  explicit Shared(std::chrono::milliseconds after) : try_again(after) {}

  // The first job that is due; end: none. When the service ends, all are.
  auto Due() {
    auto at = jobs.begin();
    const Clock::time_point now = Clock::now();
    while (at != jobs.end() && at->second.due > now && !ending) ++at;
    return at;
  }

  void Run() {
    std::unique_lock<std::mutex> lock(mutex);
    while (true) {
      const auto at = Due();
      if (at == jobs.end()) {
        if (ending) break;
        Sleep(lock);
        continue;
      }
      const auto [journal, job] = *at;
      jobs.erase(at);
      lock.unlock();
      const bool kept = Flush(*journal);
      if (kept && job.close) journal->Close();
      while (job.close) {  // its scene is gone, and with it whoever reads these
        const std::optional<scene::JournalNote> note = journal->PopNote();
        if (!note) break;
        spdlog::warn("{}", note->text);
      }
      lock.lock();
      if (kept || ending) continue;
      Job& again = jobs[journal];  // it may have been asked for again meanwhile
      again.due = Clock::now() + try_again;
      again.close |= job.close;
    }
    ended = true;
    wake.notify_all();
  }

  void Sleep(std::unique_lock<std::mutex>& lock) {
    if (jobs.empty()) return wake.wait(lock);
    Clock::time_point next = Clock::time_point::max();
    for (const auto& [journal, job] : jobs) next = std::min(next, job.due);
    wake.wait_until(lock, next);
  }

  static bool Flush(scene::SculptJournal& journal) {
    try {
      return journal.Flush();
    } catch (const std::exception& caught) {  // out of memory
      spdlog::error("a sculpt journal cannot be written: {}", caught.what());
      return false;
    }
  }

  void Add(const Journal& journal, bool close) {
    const std::lock_guard lock(mutex);
    Job& job = jobs[journal];
    if (job.due == Clock::time_point() || close) job.due = Clock::now();
    job.close |= close;
    if (!started) std::thread([shared = self.lock()] { shared->Run(); }).detach();
    started = true;
    wake.notify_all();
  }

  const std::chrono::milliseconds try_again;
  std::weak_ptr<Shared> self;
  base::PriorityMutex mutex;
  std::condition_variable wake;
  std::map<Journal, Job> jobs;
  bool started = false, ending = false, ended = false;
};

JournalWriter::JournalWriter(std::chrono::milliseconds try_again) : shared_(std::make_shared<Shared>(try_again)) {
  shared_->self = shared_;
}

JournalWriter::~JournalWriter() {
  std::unique_lock<std::mutex> lock(shared_->mutex);
  shared_->ending = true;
  shared_->wake.notify_all();
  const bool done = !shared_->started || shared_->wake.wait_for(lock, kPatience, [this] { return shared_->ended; });
  if (!done) spdlog::error("the disk does not respond: the last strokes are not kept");
}

void JournalWriter::Write(const Journal& journal) { shared_->Add(journal, false); }

void JournalWriter::Close(const Journal& journal) { shared_->Add(journal, true); }

}  // namespace omni::daemon
