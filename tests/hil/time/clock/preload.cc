// Preloaded into an unmodified program: CLOCK_MONOTONIC becomes the time of a shared page, and timed waits
// end in that time. Without the environment variable OMNI_HIL_CLOCK nothing changes.
//
// The time stands still between two steps of its master, which advances it when all threads sleep
// (tests/hil/time/idle_watch.h): computation takes no time. Replaced are the waits of omnid, libusb, the OpenXR loader
// and test applications: sleeps, poll, epoll, sigtimedwait, condition variables, timerfd. CLOCK_REALTIME and processor
// times stay real.
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/mman.h>
#include <sys/signalfd.h>
#include <sys/syscall.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <mutex>
#include <vector>

#include <dlfcn.h>

#include "tests/hil/time/clock/timers.h"

namespace omni::hil {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;
constexpr std::size_t kKernelSigset = 8;  // bytes of a signal set in the kernel

// Null: this process keeps the real time. Never freed: threads may still wait while the process ends.
Timers* timers = nullptr;
pthread_t server;
ClockPage* clock_page = nullptr;
bool outside = false;  // a child that has not read the time yet: most call exec at once
int generation = 0;    // of children: what a thread made before the fork belongs to the parent

[[noreturn]] void Refuse(const char* path, const char* why) {
  std::fprintf(stderr, "%s=%s: %s\n", kClockVariable, path, why);
  _exit(127);
}

ClockProcess* TakePlace(ClockPage& page) {
  const pid_t pid = getpid();
  for (ClockProcess& place : page.processes) {  // exec keeps the number
    if (place.pid.load() == pid) return &place;
  }
  for (ClockProcess& place : page.processes) {
    std::int32_t nobody = 0;
    if (place.pid.compare_exchange_strong(nobody, pid)) return &place;
  }
  ++page.refused;
  return nullptr;
}

void* Serve(void*) {
  pthread_setname_np(pthread_self(), "omni-hil-clock");
  timers->Serve();
}

// This thread takes no signals: a program may wait for its own.
void StartServer() {
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  const bool started = pthread_create(&server, nullptr, &Serve, nullptr) == 0;
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  if (!started) Refuse("", "cannot start the clock's thread");
}

void Join() {
  ClockProcess* const place = TakePlace(*clock_page);
  if (place == nullptr) Refuse(std::getenv(kClockVariable), "too many programs share this clock");
  place->due_ns.store(kNever_ns);
  timers = new Timers(*clock_page, *place);
  StartServer();
}

// A fork has none of its parent's threads, hence no server.
void ForgetInChild() {
  timers = nullptr;
  outside = true;
  ++generation;
}

bool HasClock() {
  if (outside) {
    outside = false;
    Join();
  }
  return timers != nullptr;
}

__attribute__((constructor)) void Enter() {
  const char* const path = std::getenv(kClockVariable);
  if (path == nullptr || *path == '\0') return;
  const long fd = syscall(SYS_openat, AT_FDCWD, path, O_RDWR | O_CLOEXEC);
  if (fd < 0) Refuse(path, std::strerror(errno));
  void* const memory = mmap(nullptr, sizeof(ClockPage), PROT_READ | PROT_WRITE, MAP_SHARED, static_cast<int>(fd), 0);
  if (memory == MAP_FAILED) Refuse(path, std::strerror(errno));
  syscall(SYS_close, fd);
  clock_page = static_cast<ClockPage*>(memory);
  if (clock_page->magic != kClockMagic) Refuse(path, "is not a clock page of this version");
  pthread_atfork(nullptr, nullptr, &ForgetInChild);
  Join();
}

bool IsVirtual(clockid_t clock) {
  const bool monotonic = clock == CLOCK_MONOTONIC || clock == CLOCK_MONOTONIC_RAW || clock == CLOCK_MONOTONIC_COARSE ||
                         clock == CLOCK_BOOTTIME;
  return monotonic && HasClock();
}

std::int64_t Nanoseconds(const timespec& time) {
  return static_cast<std::int64_t>(time.tv_sec) * kSecond_ns + time.tv_nsec;
}
timespec Timespec(std::int64_t t_ns) { return {t_ns / kSecond_ns, t_ns % kSecond_ns}; }

bool IsValid(const timespec& time) { return time.tv_sec >= 0 && time.tv_nsec >= 0 && time.tv_nsec < kSecond_ns; }

// `after_ns` from now, or never if that is too far.
std::int64_t After(std::int64_t after_ns) {
  const std::int64_t now_ns = timers->now_ns();
  return after_ns > kNever_ns - now_ns ? kNever_ns : now_ns + after_ns;
}

// One for each thread that ever waits.
class ThreadTimer {
 public:
  ThreadTimer() = default;
  ~ThreadTimer() { syscall(SYS_close, timer_.event_fd); }
  ThreadTimer(const ThreadTimer&) = delete;
  ThreadTimer& operator=(const ThreadTimer&) = delete;
  Timer& timer() {
    if (generation_ != generation) {
      syscall(SYS_close, timer_.event_fd);
      timer_.event_fd = static_cast<int>(syscall(SYS_eventfd2, 0, EFD_CLOEXEC | EFD_NONBLOCK));
      generation_ = generation;
    }
    return timer_;
  }

 private:
  Timer timer_;
  int generation_ = -1;
};

// During its lifetime the calling thread has a deadline, and a descriptor that becomes readable then.
class Deadline {
 public:
  explicit Deadline(std::int64_t due_ns, pthread_cond_t* condition = nullptr) : due_ns_(due_ns) {
    thread_local ThreadTimer own;
    timer_ = &own.timer();
    timer_->condition = condition;
    timers->Start(*timer_, due_ns, 0);
  }
  ~Deadline() {
    timers->Remove(*timer_);
    std::uint64_t count = 0;
    syscall(SYS_read, timer_->event_fd, &count, sizeof count);
  }
  Deadline(const Deadline&) = delete;
  Deadline& operator=(const Deadline&) = delete;

  pollfd wait() const { return {timer_->event_fd, POLLIN, 0}; }
  bool passed() const { return timers->now_ns() >= due_ns_; }

 private:
  std::int64_t due_ns_;
  Timer* timer_ = nullptr;
};

int RealPoll(pollfd* fds, nfds_t count, const timespec* timeout, const sigset_t* mask) {
  return static_cast<int>(syscall(SYS_ppoll, fds, count, timeout, mask, kKernelSigset));
}

// The program's descriptors and the deadline's together.
int PollUntil(std::int64_t due_ns, pollfd* fds, nfds_t count, const sigset_t* mask) {
  const Deadline deadline(due_ns);
  std::vector<pollfd> all(fds, fds + count);
  all.push_back(deadline.wait());
  const int ready = RealPoll(all.data(), all.size(), nullptr, mask);
  if (ready < 0) return -1;
  std::copy_n(all.begin(), count, fds);
  return ready - (all.back().revents != 0 ? 1 : 0);
}

// 0, or EINTR.
int SleepUntil(std::int64_t due_ns) {
  const Deadline deadline(due_ns);
  while (!deadline.passed()) {
    pollfd wait = deadline.wait();
    if (RealPoll(&wait, 1, nullptr, nullptr) < 0) return errno;
  }
  return 0;
}

int SleepFor(const timespec& time, timespec* left) {
  const std::int64_t due_ns = After(Nanoseconds(time));
  const int error = SleepUntil(due_ns);
  if (error != 0 && left != nullptr) *left = Timespec(std::max<std::int64_t>(0, due_ns - timers->now_ns()));
  return error;
}

// A condition variable is signalled when its time is over, a spurious wake-up for other waiters. A thread that is not
// waiting yet misses that: hence the short waits in real time.
constexpr std::int64_t kConditionPiece_ns = 2'000'000;
using ClockWait = int (*)(pthread_cond_t*, pthread_mutex_t*, clockid_t, const timespec*);

template <class Wait>
int WaitInPieces(pthread_cond_t* condition, std::int64_t due_ns, Wait wait_until) {
  const Deadline deadline(due_ns, condition);
  while (!deadline.passed()) {
    timespec real{};
    syscall(SYS_clock_gettime, CLOCK_MONOTONIC, &real);
    const timespec piece = Timespec(Nanoseconds(real) + kConditionPiece_ns);
    const int result = wait_until(piece);
    if (result != ETIMEDOUT) return result;
  }
  return ETIMEDOUT;
}

// timerfd: an eventfd is read in the same way. We keep a duplicate descriptor, so that a number that was closed and
// reused is never written to.
struct DescriptorTimer {
  int fd = -1;
  Timer timer;
};

std::mutex descriptors_mutex;
std::vector<std::unique_ptr<DescriptorTimer>>& Descriptors() {
  static auto* const all = new std::vector<std::unique_ptr<DescriptorTimer>>;
  return *all;
}

DescriptorTimer* FindDescriptor(int fd) {
  for (const auto& one : Descriptors()) {
    if (one->fd == fd) return one.get();
  }
  return nullptr;
}

void Forget(int fd) {
  auto& all = Descriptors();
  for (auto one = all.begin(); one != all.end(); ++one) {
    if ((*one)->fd != fd) continue;
    timers->Remove((*one)->timer);
    syscall(SYS_close, (*one)->timer.event_fd);
    all.erase(one);
    return;
  }
}

int MakeDescriptor(int flags) {
  int event_flags = 0;
  if ((flags & TFD_CLOEXEC) != 0) event_flags |= EFD_CLOEXEC;
  if ((flags & TFD_NONBLOCK) != 0) event_flags |= EFD_NONBLOCK;
  const int fd = static_cast<int>(syscall(SYS_eventfd2, 0, event_flags));
  if (fd < 0) return -1;
  const int ours = static_cast<int>(syscall(SYS_fcntl, fd, F_DUPFD_CLOEXEC, 0));
  if (ours < 0) {
    syscall(SYS_close, fd);
    return -1;
  }
  auto made = std::make_unique<DescriptorTimer>();
  made->fd = fd;
  made->timer.event_fd = ours;
  const std::lock_guard lock(descriptors_mutex);
  Forget(fd);
  Descriptors().push_back(std::move(made));
  return fd;
}

itimerspec Schedule(const Timer& timer) {
  if (timer.due_ns == kNever_ns) return {};
  const std::int64_t left_ns = std::max<std::int64_t>(1, timer.due_ns - timers->now_ns());
  return {.it_interval = Timespec(timer.period_ns), .it_value = Timespec(left_ns)};
}

// Setting a timer discards earlier expirations [timerfd_create(2)].
void Arm(DescriptorTimer& one, int flags, const itimerspec& wanted) {
  timers->Remove(one.timer);
  pollfd raised{one.timer.event_fd, POLLIN, 0};
  const timespec at_once{};
  std::uint64_t count = 0;
  if (RealPoll(&raised, 1, &at_once, nullptr) > 0) syscall(SYS_read, one.timer.event_fd, &count, sizeof count);
  const std::int64_t value_ns = Nanoseconds(wanted.it_value);
  const std::int64_t due_ns = (flags & TFD_TIMER_ABSTIME) != 0 ? value_ns : After(value_ns);
  timers->Start(one.timer, value_ns == 0 ? kNever_ns : due_ns, Nanoseconds(wanted.it_interval));
}

template <class Function>
Function Next(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

}  // namespace
}  // namespace omni::hil

using namespace omni::hil;

// Their declarations, and which of them may throw (they are cancellation points), are the C library's.
extern "C" {

int clock_gettime(clockid_t clock, timespec* time) noexcept {
  if (!IsVirtual(clock)) return static_cast<int>(syscall(SYS_clock_gettime, clock, time));
  *time = Timespec(timers->now_ns());
  return 0;
}

int clock_nanosleep(clockid_t clock, int flags, const timespec* time, timespec* left) {
  if (!IsVirtual(clock)) {
    return syscall(SYS_clock_nanosleep, clock, flags, time, left) == 0 ? 0 : errno;
  }
  if (!IsValid(*time)) return EINVAL;
  return (flags & TIMER_ABSTIME) != 0 ? SleepUntil(Nanoseconds(*time)) : SleepFor(*time, left);
}

int nanosleep(const timespec* time, timespec* left) {
  const int error = clock_nanosleep(CLOCK_MONOTONIC, 0, time, left);
  if (error == 0) return 0;
  errno = error;
  return -1;
}

// umockdev's preloaded library sleeps for 0 us in every emulated system call: a thread that really slept would look as
// if it had nothing to do.
int usleep(useconds_t time_us) {
  const timespec time = Timespec(static_cast<std::int64_t>(time_us) * 1000);
  return time_us == 0 ? 0 : nanosleep(&time, nullptr);
}

unsigned sleep(unsigned seconds) {
  const timespec time{static_cast<time_t>(seconds), 0};
  timespec left{};
  return nanosleep(&time, &left) == 0 ? 0 : static_cast<unsigned>(left.tv_sec);
}

int ppoll(pollfd* fds, nfds_t count, const timespec* timeout, const sigset_t* mask) {
  if (timeout == nullptr || Nanoseconds(*timeout) <= 0 || !HasClock()) {
    timespec rest = timeout != nullptr ? *timeout : timespec{};  // the kernel writes into it
    return RealPoll(fds, count, timeout != nullptr ? &rest : nullptr, mask);
  }
  return PollUntil(After(Nanoseconds(*timeout)), fds, count, mask);
}

int poll(pollfd* fds, nfds_t count, int timeout_ms) {
  const timespec timeout = Timespec(static_cast<std::int64_t>(timeout_ms) * 1'000'000);
  return ppoll(fds, count, timeout_ms < 0 ? nullptr : &timeout, nullptr);
}

// What _FORTIFY_SOURCE makes of the two where it knows how many descriptors there is room for.
// NOLINTBEGIN(bugprone-reserved-identifier): the C library's names
int __ppoll_chk(pollfd* fds, nfds_t count, const timespec* timeout, const sigset_t* mask, std::size_t room) {
  if (room / sizeof(pollfd) < count) std::abort();
  return ppoll(fds, count, timeout, mask);
}

int __poll_chk(pollfd* fds, nfds_t count, int timeout_ms, std::size_t room) {
  if (room / sizeof(pollfd) < count) std::abort();
  return poll(fds, count, timeout_ms);
}
// NOLINTEND(bugprone-reserved-identifier)

int epoll_pwait(int epoll, epoll_event* events, int capacity, int timeout_ms, const sigset_t* mask) {
  const auto real = [&](int real_ms) {
    return static_cast<int>(syscall(SYS_epoll_pwait, epoll, events, capacity, real_ms, mask, kKernelSigset));
  };
  if (timeout_ms <= 0 || !HasClock()) return real(timeout_ms);
  pollfd ready{epoll, POLLIN, 0};
  if (PollUntil(After(static_cast<std::int64_t>(timeout_ms) * 1'000'000), &ready, 1, mask) < 0) return -1;
  return real(0);
}

int epoll_wait(int epoll, epoll_event* events, int capacity, int timeout_ms) {
  return epoll_pwait(epoll, events, capacity, timeout_ms, nullptr);
}

int sigtimedwait(const sigset_t* signals, siginfo_t* info, const timespec* timeout) {
  const auto real = [&](const timespec* real_timeout) {
    return static_cast<int>(syscall(SYS_rt_sigtimedwait, signals, info, real_timeout, kKernelSigset));
  };
  if (timeout == nullptr || Nanoseconds(*timeout) <= 0 || !HasClock()) return real(timeout);
  pollfd pending{signalfd(-1, signals, SFD_CLOEXEC), POLLIN, 0};
  if (pending.fd < 0) return -1;
  const int ready = PollUntil(After(Nanoseconds(*timeout)), &pending, 1, nullptr);
  const int error = errno;
  syscall(SYS_close, pending.fd);
  errno = error;
  const timespec at_once{};
  return ready < 0 ? -1 : real(&at_once);
}

int pthread_cond_clockwait(pthread_cond_t* condition, pthread_mutex_t* mutex, clockid_t clock, const timespec* until) {
  static const auto next = Next<ClockWait>("pthread_cond_clockwait");
  if (!IsVirtual(clock)) return next(condition, mutex, clock, until);
  return WaitInPieces(condition, Nanoseconds(*until),
                      [&](const timespec& piece) { return next(condition, mutex, clock, &piece); });
}

// The clock is a secret of the condition variable; an instant before 2001 can only be of the monotonic one.
int pthread_cond_timedwait(pthread_cond_t* condition, pthread_mutex_t* mutex, const timespec* until) {
  static const auto next = Next<int (*)(pthread_cond_t*, pthread_mutex_t*, const timespec*)>("pthread_cond_timedwait");
  const bool monotonic = until->tv_sec < kSecond_ns;
  if (!monotonic || !HasClock()) return next(condition, mutex, until);
  return WaitInPieces(condition, Nanoseconds(*until),
                      [&](const timespec& piece) { return next(condition, mutex, &piece); });
}

int timerfd_create(clockid_t clock, int flags) noexcept {
  return IsVirtual(clock) ? MakeDescriptor(flags) : static_cast<int>(syscall(SYS_timerfd_create, clock, flags));
}

int timerfd_settime(int fd, int flags, const itimerspec* wanted, itimerspec* before) noexcept {
  const std::lock_guard lock(descriptors_mutex);
  DescriptorTimer* const one = HasClock() ? FindDescriptor(fd) : nullptr;
  if (one == nullptr) return static_cast<int>(syscall(SYS_timerfd_settime, fd, flags, wanted, before));
  if (!IsValid(wanted->it_value) || !IsValid(wanted->it_interval)) {
    errno = EINVAL;
    return -1;
  }
  if (before != nullptr) *before = Schedule(timers->Look(one->timer));
  Arm(*one, flags, *wanted);
  return 0;
}

int timerfd_gettime(int fd, itimerspec* schedule) noexcept {
  const std::lock_guard lock(descriptors_mutex);
  const DescriptorTimer* const one = HasClock() ? FindDescriptor(fd) : nullptr;
  if (one == nullptr) return static_cast<int>(syscall(SYS_timerfd_gettime, fd, schedule));
  *schedule = Schedule(timers->Look(one->timer));
  return 0;
}

}  // extern "C"
