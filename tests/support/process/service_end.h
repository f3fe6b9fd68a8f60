// Time until a service ends after a signal.
#pragma once

#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <fstream>
#include <string>
#include <utility>

#include "service/tools/common/service_link.h"
#include "tests/support/process/service_process.h"

namespace omni::test {

inline constexpr double kEndsWithin_ms = 1000;

struct ServiceEnd {
  double ms = 0;
  int status = -1;  // as ChildProcess::Wait
};

// Waits for its end, at most as long as a test can wait; then kills it, and `ms` is large.
inline ServiceEnd WaitForEnd(ServiceProcess& service, std::int64_t asked_ns, const char* what) {
  constexpr int kPatience_ms = 10'000;
  siginfo_t info{};
  for (int ms = 0; ms < kPatience_ms && info.si_pid == 0; ++ms) {
    SleepMs(1);
    waitid(P_PID, static_cast<id_t>(service.pid()), &info, WEXITED | WNOHANG | WNOWAIT);
  }
  const double ms = static_cast<double>(base::MonotonicNow_ns() - asked_ns) * 1e-6;
  if (info.si_pid == 0) service.Signal(SIGKILL);
  std::printf("[ figure   ] ended %s%.0f ms after the signal: %s\n", info.si_pid == 0 ? "by force " : "", ms, what);
  return {ms, service.Wait()};
}

inline ServiceEnd EndAndWait(ServiceProcess& service, const char* what) {
  const std::int64_t asked_ns = base::MonotonicNow_ns();
  service.Signal(SIGTERM);
  return WaitForEnd(service, asked_ns, what);
}

// A named pipe that is open for reading during its lifetime but never read; or that no process has opened.
class UnreadPipe {
 public:
  enum class Reader { kSleeps, kNone };
  UnreadPipe(std::string path, Reader reader) : path_(std::move(path)) {
    EXPECT_EQ(mkfifo(path_.c_str(), 0600), 0);
    if (reader == Reader::kSleeps) fd_ = open(path_.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  }
  ~UnreadPipe() {
    if (fd_ >= 0) close(fd_);
  }
  UnreadPipe(const UnreadPipe&) = delete;
  UnreadPipe& operator=(const UnreadPipe&) = delete;

  // Writes until the pipe is full. Returns the number of bytes.
  std::size_t Fill() const {
    const std::string text(4096, '.');
    std::size_t bytes = 0;
    for (std::size_t piece = text.size(); piece > 0;) {
      const ssize_t size = write(fd_, text.data(), piece);
      if (size > 0) bytes += static_cast<std::size_t>(size);
      if (size <= 0) piece /= 2;
    }
    return bytes;
  }
  // All bytes in it now or arriving within `ms`.
  std::string Read(int ms) const {
    std::string text;
    char bytes[65536];
    for (int i = 0; i < ms; ++i) {
      for (ssize_t size = 0; (size = read(fd_, bytes, sizeof bytes)) > 0;)
        text.append(bytes, static_cast<std::size_t>(size));
      SleepMs(1);
    }
    return text;
  }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
  int fd_ = -1;
};

inline bool WaitUntilServing(const ServiceProcess& service) {
  const std::int64_t end_ns = base::MonotonicNow_ns() + 10'000'000'000;
  while (base::MonotonicNow_ns() < end_ns) {
    if (tools::FetchStatus(service.socket_path()).ok()) return true;
    SleepMs(100);
  }
  return false;
}

// The first child of a process; 0: it has none.
inline pid_t ChildOf(pid_t parent) {
  const std::string pid = std::to_string(parent);
  std::ifstream file("/proc/" + pid + "/task/" + pid + "/children");
  pid_t child = 0;
  file >> child;
  return child;
}

}  // namespace omni::test
