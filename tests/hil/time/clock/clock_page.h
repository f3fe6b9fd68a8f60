// Shared by the master of a virtual clock and the programs under it: one page of memory, a mapped file.
//
// The master writes the time, and wakes a process when the first of its timers is due. A process registers itself when
// it starts, and keeps the instant of its first timer up to date; the master removes those that have ended.
#pragma once

#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <climits>
#include <cstddef>
#include <cstdint>
#include <ctime>
#include <limits>

namespace omni::hil {

constexpr std::uint64_t kClockMagic = 0x31306B636F6C436FULL;  // "oClock01"
constexpr std::size_t kClockProcessesMax = 64;
constexpr std::int64_t kNever_ns = std::numeric_limits<std::int64_t>::max();
constexpr const char* kClockVariable = "OMNI_HIL_CLOCK";  // environment: path of the page

struct ClockProcess {
  std::atomic<std::int32_t> pid;    // 0: free
  std::atomic<std::uint32_t> wake;  // futex: grows when a timer is due
  std::atomic<std::int64_t> due_ns;
};

struct ClockPage {
  std::uint64_t magic;
  std::atomic<std::int64_t> now_ns;  // what CLOCK_MONOTONIC shows
  std::atomic<std::int32_t> master_pid;
  std::atomic<std::int32_t> refused;  // processes that found no free place
  ClockProcess processes[kClockProcessesMax];
};

static_assert(std::atomic<std::int64_t>::is_always_lock_free && std::atomic<std::int32_t>::is_always_lock_free);
static_assert(sizeof(ClockPage) <= 4096);

// Between processes, hence not the private kind [futex(2)]. Returns after `timeout` of real time at the latest.
inline void FutexWait(std::atomic<std::uint32_t>& word, std::uint32_t seen, const timespec& timeout) noexcept {
  syscall(SYS_futex, &word, FUTEX_WAIT, seen, &timeout, nullptr, 0);
}
inline void FutexWake(std::atomic<std::uint32_t>& word) noexcept {
  syscall(SYS_futex, &word, FUTEX_WAKE, INT_MAX, nullptr, nullptr, 0);
}

}  // namespace omni::hil
