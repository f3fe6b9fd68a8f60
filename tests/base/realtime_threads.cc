// Threads in real time: listed, and put back when they take too much of it.
#include "service/base/threads/realtime_threads.h"

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <thread>

#include "service/base/clock.h"

namespace omni::base {
namespace test_base_realtime_threads {

TEST(RealtimeThreads, AreListedWhileTheyLive) {
  const std::size_t before = RealtimeThreads().size();
  std::thread([&] {
    const RealtimeThread named("omni-test");
    const auto listed = RealtimeThreads();
    ASSERT_EQ(listed.size(), before + 1);
    EXPECT_EQ(listed.back().name, "omni-test");
    EXPECT_EQ(listed.back().id, ::gettid());
    EXPECT_FALSE(listed.back().realtime);
  }).join();
  EXPECT_EQ(RealtimeThreads().size(), before);
}

// In a process of its own, which the second limit would kill. Exit status: 0 it left real time, 2 it may not have it.
[[noreturn]] void ComputeInRealtime() {
  const RealtimeThread named("omni-test");
  LeaveRealtimeAtLimit();
  const rlimit limit{.rlim_cur = 50'000, .rlim_max = 400'000};  // us
  const sched_param priority{1};
  if (::setrlimit(RLIMIT_RTTIME, &limit) != 0 || ::sched_setscheduler(0, SCHED_FIFO, &priority) != 0) ::_exit(2);
  const std::int64_t end_ns = MonotonicNow_ns() + 2'000'000'000;
  while (::sched_getscheduler(0) == SCHED_FIFO && MonotonicNow_ns() < end_ns) continue;
  ::_exit(::sched_getscheduler(0) == SCHED_OTHER && !RealtimeThreads().back().realtime ? 0 : 1);
}

TEST(RealtimeThreads, LeaveRealTimeAtItsLimit) {
  const pid_t child = ::fork();
  if (child == 0) ComputeInRealtime();
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status)) << "ended by signal " << WTERMSIG(status);
  if (WEXITSTATUS(status) == 2) GTEST_SKIP() << "real-time scheduling is refused here";
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

}  // namespace test_base_realtime_threads
}  // namespace omni::base
