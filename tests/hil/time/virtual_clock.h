// The master of a virtual clock: programs started with its Environment() see CLOCK_MONOTONIC as it is set here. It
// begins at the real one, so that stamps of programs beside it are close.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>
#include <vector>

#include "service/base/result.h"
#include "tests/hil/time/clock/clock_page.h"

namespace omni::hil {

class VirtualClock {
 public:
  // `path`: a file, recreated, for programs started elsewhere; empty: only our children find it.
  static base::Result<VirtualClock> Create(const std::string& path);
  VirtualClock(VirtualClock&& other) noexcept;
  VirtualClock& operator=(VirtualClock&&) = delete;
  ~VirtualClock();

  // The variables that put a program under the clock: "NAME=value". Preloads our library after those preloaded here.
  std::vector<std::string> Environment() const;

  std::int64_t zero_ns() const { return zero_ns_; }  // at its start
  std::int64_t now_ns() const { return page_->now_ns.load(); }

  // Never back. True: a process's timer became due, and it is being woken.
  bool AdvanceTo(std::int64_t t_ns);
  // To the first timer that is not due yet. False: there is none.
  bool AdvanceToNext();

  // The programs under the clock now.
  std::vector<pid_t> Processes() const;
  // Waits, in real time, until process `pid` is one of them. False: it ended, or had not come after `timeout_ms`.
  bool WaitForProcess(pid_t pid, int timeout_ms) const;

 private:
  VirtualClock(ClockPage* page, std::string path, int fd);

  ClockPage* page_;
  std::string path_;
  int fd_;
  bool unlink_ = false;
  std::int64_t zero_ns_;
};

}  // namespace omni::hil
