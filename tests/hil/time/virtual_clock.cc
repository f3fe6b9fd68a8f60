#include "tests/hil/time/virtual_clock.h"

#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <new>
#include <thread>
#include <utility>

#include "service/base/clock.h"

namespace omni::hil {
namespace {

base::Error Problem(const std::string& path) {
  return base::Error{"virtual clock " + path + ": " + std::strerror(errno)};
}

// It has ended, or is a zombie.
bool IsGone(pid_t pid) {
  siginfo_t info{};
  if (waitid(P_PID, static_cast<id_t>(pid), &info, WEXITED | WNOHANG | WNOWAIT) == 0) return info.si_pid == pid;
  return kill(pid, 0) != 0 && errno == ESRCH;
}

}  // namespace

base::Result<VirtualClock> VirtualClock::Create(const std::string& path) {
  const int fd = path.empty() ? memfd_create("omni_hil_clock", MFD_CLOEXEC)
                              : open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (fd < 0) return Problem(path);
  void* memory = MAP_FAILED;
  if (ftruncate(fd, sizeof(ClockPage)) == 0) {
    memory = mmap(nullptr, sizeof(ClockPage), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
  }
  if (memory == MAP_FAILED) {
    const base::Error problem = Problem(path);
    close(fd);
    return problem;
  }
  const std::string name = path.empty() ? "/proc/" + std::to_string(getpid()) + "/fd/" + std::to_string(fd) : path;
  VirtualClock clock(new (memory) ClockPage{}, name, fd);
  clock.unlink_ = !path.empty();
  return clock;
}

VirtualClock::VirtualClock(ClockPage* page, std::string path, int fd)
    : page_(page), path_(std::move(path)), fd_(fd), zero_ns_(base::MonotonicNow_ns()) {
  for (ClockProcess& process : page_->processes) process.due_ns.store(kNever_ns);
  page_->now_ns.store(zero_ns_);
  page_->master_pid.store(getpid());
  page_->magic = kClockMagic;
}

VirtualClock::VirtualClock(VirtualClock&& other) noexcept
    : page_(std::exchange(other.page_, nullptr)),
      path_(std::move(other.path_)),
      fd_(other.fd_),
      unlink_(other.unlink_),
      zero_ns_(other.zero_ns_) {}

VirtualClock::~VirtualClock() {
  if (page_ == nullptr) return;
  munmap(page_, sizeof(ClockPage));
  close(fd_);
  if (unlink_) unlink(path_.c_str());
}

std::vector<std::string> VirtualClock::Environment() const {
  const char* const preload = getenv("LD_PRELOAD");
  const std::string before = preload != nullptr && *preload != '\0' ? std::string(preload) + ":" : "";
  return {std::string(kClockVariable) + "=" + path_, "LD_PRELOAD=" + before + OMNI_HIL_CLOCK_LIBRARY};
}

bool VirtualClock::AdvanceTo(std::int64_t t_ns) {
  if (t_ns > page_->now_ns.load()) page_->now_ns.store(t_ns);
  bool due = false;
  for (ClockProcess& process : page_->processes) {
    if (process.pid.load() == 0 || process.due_ns.load() > t_ns) continue;
    due = true;
    ++process.wake;
    FutexWake(process.wake);
  }
  return due;
}

bool VirtualClock::AdvanceToNext() {
  std::int64_t next_ns = kNever_ns;
  for (const ClockProcess& process : page_->processes) {
    const std::int64_t due_ns = process.due_ns.load();
    if (process.pid.load() != 0 && due_ns > now_ns()) next_ns = std::min(next_ns, due_ns);
  }
  return next_ns != kNever_ns && AdvanceTo(next_ns);
}

std::vector<pid_t> VirtualClock::Processes() const {
  std::vector<pid_t> all;
  for (ClockProcess& process : page_->processes) {
    const pid_t pid = process.pid.load();
    if (pid == 0) continue;
    if (!IsGone(pid)) {
      all.push_back(pid);
      continue;
    }
    process.due_ns.store(kNever_ns);
    process.pid.store(0);
  }
  return all;
}

bool VirtualClock::WaitForProcess(pid_t pid, int timeout_ms) const {
  for (int i = 0; i < timeout_ms; ++i) {
    if (IsGone(pid)) return false;
    for (const ClockProcess& process : page_->processes) {
      if (process.pid.load() == pid) return true;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}

}  // namespace omni::hil
