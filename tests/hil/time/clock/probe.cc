// hil_clock_probe WHAT FILE: waits by one kind of system call, and writes to FILE how many milliseconds of
// CLOCK_MONOTONIC it took and the call's result. Independent of virtual clocks.
#include <poll.h>
#include <signal.h>
#include <sys/epoll.h>
#include <sys/timerfd.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <thread>

#include "service/base/clock.h"

namespace {

using std::chrono::milliseconds;

int Sleep() {
  std::this_thread::sleep_for(milliseconds(10'000));
  return 0;
}

int SleepUntil() {
  const std::int64_t wake_ns = omni::base::MonotonicNow_ns() + 10'000'000'000;
  const timespec wake{wake_ns / 1'000'000'000, wake_ns % 1'000'000'000};
  return clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &wake, nullptr);
}

int Poll() { return poll(nullptr, 0, 10'000); }

// A descriptor that is ready before the time is over.
int PollData() {
  int ends[2];
  if (pipe(ends) != 0) return -1;
  std::thread writer([&] {
    std::this_thread::sleep_for(milliseconds(10'000));
    if (write(ends[1], "x", 1) != 1) std::abort();
  });
  pollfd wait{ends[0], POLLIN, 0};
  const int ready = poll(&wait, 1, 60'000);
  writer.join();
  return ready;
}

int Epoll() {
  const int epoll = epoll_create1(0);
  epoll_event event{};
  return epoll_wait(epoll, &event, 1, 10'000);
}

int Signal() {
  sigset_t usr1;
  sigemptyset(&usr1);
  sigaddset(&usr1, SIGUSR1);
  sigprocmask(SIG_BLOCK, &usr1, nullptr);
  const timespec ten_s{10, 0};
  return sigtimedwait(&usr1, nullptr, &ten_s);
}

int Condition() {
  std::mutex mutex;
  std::condition_variable never;
  std::unique_lock lock(mutex);
  return never.wait_for(lock, milliseconds(10'000), [] { return false; }) ? 1 : 0;
}

// First after 2 s, then every second: nine times.
int TimerDescriptor() {
  const int fd = timerfd_create(CLOCK_MONOTONIC, 0);
  const itimerspec schedule{.it_interval = {1, 0}, .it_value = {2, 0}};
  timerfd_settime(fd, 0, &schedule, nullptr);
  std::uint64_t expired = 0;
  while (expired < 9) {
    std::uint64_t times = 0;
    if (read(fd, &times, sizeof times) != static_cast<ssize_t>(sizeof times)) return -1;
    expired += times;
  }
  itimerspec left{};
  timerfd_gettime(fd, &left);
  return left.it_interval.tv_sec == 1 ? static_cast<int>(expired) : -2;
}

// Busy for half a second of processor time.
int Work() {
  timespec used{};
  do {
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &used);
  } while (used.tv_sec == 0 && used.tv_nsec < 500'000'000);
  return 0;
}

// A child that never calls exec sleeps.
int Fork() {
  const pid_t child = fork();
  if (child == 0) {
    const std::int64_t begin_ns = omni::base::MonotonicNow_ns();
    const int result = Sleep();
    _exit(result == 0 && omni::base::MonotonicNow_ns() - begin_ns == 10'000'000'000 ? 7 : 1);
  }
  int status = 0;
  if (waitpid(child, &status, 0) != child) return -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : -2;
}

constexpr struct {
  const char* name;
  int (*run)();
} kWays[] = {{"sleep", &Sleep},         {"sleep_until", &SleepUntil},
             {"poll", &Poll},           {"poll_data", &PollData},
             {"epoll", &Epoll},         {"signal", &Signal},
             {"condition", &Condition}, {"timerfd", &TimerDescriptor},
             {"work", &Work},           {"fork", &Fork}};

}  // namespace

int main(int argc, char** argv) {
  for (const auto& way : kWays) {
    if (argc != 3 || std::strcmp(argv[1], way.name) != 0) continue;
    const std::int64_t begin_ns = omni::base::MonotonicNow_ns();
    const int result = way.run();
    const std::int64_t took_ns = omni::base::MonotonicNow_ns() - begin_ns;
    std::FILE* const file = std::fopen(argv[2], "w");
    std::fprintf(file, "%.6f %d\n", static_cast<double>(took_ns) * 1e-6, result);
    return std::fclose(file);
  }
  return 2;
}
