#include "tests/hil/time/idle_watch.h"

#include <fcntl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <string_view>
#include <thread>
#include <utility>

#include "service/base/clock.h"
#include "service/base/unique_fd.h"

namespace omni::hil {
namespace {

using base::UniqueFd;

// Every check takes time from the busy threads: none much before the usual time, then at growing intervals.
constexpr double kFirstLook = 0.8, kForget = 0.1;
constexpr double kNapMin_us = 30, kNapMax_us = 500, kNapGrowth = 1.3;
constexpr std::size_t kStatMax = 512, kCountsMax = 96;
constexpr int kThreadsField = 17;  // after the state: num_threads [proc(5), stat (20)]

std::string_view ReadNew(int fd, char* text, std::size_t capacity) {
  const ssize_t size = pread(fd, text, capacity, 0);
  return {text, size > 0 ? static_cast<std::size_t>(size) : 0};
}

}  // namespace

class IdleWatch::Thread {
 public:
  Thread(pid_t process, pid_t thread) {
    const std::string folder = "/proc/" + std::to_string(process) + "/task/" + std::to_string(thread);
    stat_ = UniqueFd(open((folder + "/stat").c_str(), O_RDONLY | O_CLOEXEC));
    counts_ = UniqueFd(open((folder + "/schedstat").c_str(), O_RDONLY | O_CLOEXEC));
  }

  bool HasCounts() const { return !count_.empty(); }
  void Count() { count_ = ReadCounts(); }
  bool HasRun() { return ReadCounts() != count_; }

  // 0: it is gone.
  char State(int& threads) {
    char text[kStatMax];
    const std::string_view stat = ReadNew(stat_.get(), text, sizeof text);
    const std::size_t name_end = stat.rfind(')');
    if (name_end == std::string_view::npos || name_end + 2 >= stat.size()) return 0;
    std::size_t at = name_end + 2;
    for (int field = 0; field < kThreadsField && at != std::string_view::npos; ++field) at = stat.find(' ', at + 1);
    threads = at != std::string_view::npos ? std::atoi(text + at) : 0;
    return stat[name_end + 2];
  }

  std::string Name() {
    char text[kStatMax];
    const std::string_view stat = ReadNew(stat_.get(), text, sizeof text);
    return std::string(stat.substr(0, stat.rfind(')') + 1));
  }

 private:
  std::string ReadCounts() {
    char text[kCountsMax];
    return std::string(ReadNew(counts_.get(), text, sizeof text));
  }

  UniqueFd stat_, counts_;
  std::string count_;
};

struct IdleWatch::Process {
  pid_t pid = 0;
  bool listed = false;
  std::vector<Thread> threads;
  int unwatched = 0;  // our own thread
};

base::Status IdleWatch::Possible() {
  Thread self(getpid(), getpid());
  int threads = 0;
  self.Count();
  if (self.HasCounts() && self.State(threads) != 0 && threads > 0) return base::Ok{};
  return base::Error{"virtual time needs /proc/PID/task/*/stat and schedstat (CONFIG_SCHED_INFO of the kernel)"};
}

IdleWatch::IdleWatch() : own_thread_(static_cast<pid_t>(syscall(SYS_gettid))) {}
IdleWatch::~IdleWatch() = default;

void IdleWatch::Follow(const std::vector<pid_t>& processes) {
  const auto wanted = [&](pid_t pid) {
    return pid == getpid() || std::find(processes.begin(), processes.end(), pid) != processes.end();
  };
  processes_.erase(std::remove_if(processes_.begin(), processes_.end(),
                                  [&](const Process& process) { return !wanted(process.pid); }),
                   processes_.end());
  const auto follow = [&](pid_t pid) {
    const bool known =
        std::any_of(processes_.begin(), processes_.end(), [&](const Process& process) { return process.pid == pid; });
    if (known) return;
    processes_.emplace_back();
    processes_.back().pid = pid;
  };
  for (const pid_t pid : processes) follow(pid);
  follow(getpid());
}

void IdleWatch::List(Process& process) {
  process.threads.clear();
  process.unwatched = 0;
  process.listed = true;
  std::error_code gone;
  for (const auto& entry :
       std::filesystem::directory_iterator("/proc/" + std::to_string(process.pid) + "/task", gone)) {
    const pid_t thread = static_cast<pid_t>(std::atoi(entry.path().filename().c_str()));
    if (thread == own_thread_) {
      ++process.unwatched;
    } else {
      process.threads.emplace_back(process.pid, thread);
    }
  }
}

// One pass. A thread that was busy is checked first in the next pass: it probably still is.
bool IdleWatch::AllSleep() {
  for (Process& process : processes_) {
    for (auto thread = process.threads.begin(); thread != process.threads.end(); ++thread) {
      int count = 0;
      const char state = thread->State(count);
      const bool same = count == static_cast<int>(process.threads.size()) + process.unwatched;
      if (state == 0 || !same) {
        busy_ = "process " + std::to_string(process.pid) + ", whose threads come and go";
        process.listed = false;
        return false;
      }
      if (state == 'R' || state == 'D') {
        busy_ = thread->Name();
        std::rotate(process.threads.begin(), thread, thread + 1);
        return false;
      }
    }
  }
  return true;
}

bool IdleWatch::IsIdle() {
  for (Process& process : processes_) {
    if (!process.listed || process.threads.empty()) List(process);
    for (Thread& thread : process.threads) thread.Count();
  }
  if (!AllSleep() || !AllSleep()) return false;
  for (Process& process : processes_) {
    for (auto thread = process.threads.begin(); thread != process.threads.end(); ++thread) {
      if (!thread->HasRun()) continue;
      busy_ = thread->Name();
      return false;
    }
  }
  return true;
}

bool IdleWatch::Wait(const std::vector<pid_t>& processes, std::int64_t patience_us) {
  Follow(processes);
  const std::int64_t begin_ns = base::MonotonicNow_ns();
  double nap_us = std::max(kNapMin_us, kFirstLook * usual_us_);
  for (double next_us = kNapMin_us;; next_us = std::min(kNapMax_us, kNapGrowth * next_us)) {
    std::this_thread::sleep_for(std::chrono::duration<double, std::micro>(nap_us));
    const bool quiet = IsIdle();
    const std::int64_t took_ns = base::MonotonicNow_ns() - begin_ns;
    if (!quiet && took_ns > patience_us * 1000) return false;
    if (quiet) {
      usual_us_ += kForget * (std::min(1e-3 * static_cast<double>(took_ns), 2 * kNapMax_us) - usual_us_);
      return true;
    }
    nap_us = next_us;
  }
}

}  // namespace omni::hil
