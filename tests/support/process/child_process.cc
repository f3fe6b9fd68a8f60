#include "tests/support/process/child_process.h"

#include <fcntl.h>
#include <sys/ptrace.h>
#include <sys/syscall.h>
#include <sys/user.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <thread>

namespace omni::test {
namespace {

// Child side, after fork: never returns.
[[noreturn]] void Execute(std::vector<char*>& arguments, const Environment& environment) {
  for (const std::string& entry : environment) {
    const std::size_t equals = entry.find('=');
    const std::string name = entry.substr(0, equals);
    const std::string value = entry.substr(equals + 1);
    if (value.empty()) {
      unsetenv(name.c_str());
    } else {
      setenv(name.c_str(), value.c_str(), 1);
    }
  }
  execv(arguments[0], arguments.data());
  _exit(127);
}

std::vector<char*> Pointers(const std::vector<std::string>& arguments) {
  std::vector<char*> pointers;
  pointers.reserve(arguments.size() + 1);
  for (const std::string& argument : arguments) pointers.push_back(const_cast<char*>(argument.c_str()));
  pointers.push_back(nullptr);
  return pointers;
}

base::Status Check(const std::vector<std::string>& arguments) {
  if (arguments.empty() || access(arguments[0].c_str(), X_OK) != 0) {
    return base::Error{(arguments.empty() ? std::string("(nothing)") : arguments[0]) + ": not there or not executable"};
  }
  return base::Ok{};
}

int Decode(int status) { return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status); }

}  // namespace

base::Result<ChildProcess> ChildProcess::Start(const std::vector<std::string>& arguments,
                                               const Environment& environment, const std::string& output_path) {
  const base::Status there = Check(arguments);
  if (!there.ok()) return base::Error{there.error()};
  std::vector<char*> pointers = Pointers(arguments);
  const pid_t pid = fork();
  if (pid < 0) return base::Error{std::string("fork: ") + std::strerror(errno)};
  if (pid == 0) {
    if (!output_path.empty()) {
      const int fd = open(output_path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
      if (fd >= 0) dup2(fd, STDOUT_FILENO);
    }
    Execute(pointers, environment);
  }
  return ChildProcess(pid);
}

ChildProcess::ChildProcess(ChildProcess&& other) noexcept : pid_(other.pid_) { other.pid_ = -1; }

ChildProcess::~ChildProcess() {
  if (pid_ <= 0) return;
  kill(pid_, SIGTERM);
  for (int i = 0; i < 200; ++i) {
    int status = 0;
    if (waitpid(pid_, &status, WNOHANG) == pid_) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  kill(pid_, SIGKILL);
  Wait();
}

int ChildProcess::Wait() {
  int status = 0;
  const pid_t pid = pid_;
  pid_ = -1;
  while (waitpid(pid, &status, 0) < 0) {
    if (errno != EINTR) return 127;
  }
  return Decode(status);
}

base::Result<std::vector<std::uint64_t>> CountSystemCalls(const std::vector<std::string>& arguments,
                                                          const Environment& environment) {
  const base::Status there = Check(arguments);
  if (!there.ok()) return base::Error{there.error()};
  std::vector<char*> pointers = Pointers(arguments);
  const pid_t pid = fork();
  if (pid < 0) return base::Error{std::string("fork: ") + std::strerror(errno)};
  if (pid == 0) {
    ptrace(PTRACE_TRACEME, 0, nullptr, nullptr);
    raise(SIGSTOP);
    Execute(pointers, environment);
  }
  int status = 0;
  waitpid(pid, &status, 0);
  if (!WIFSTOPPED(status)) return base::Error{"ptrace is not permitted here"};
  ptrace(PTRACE_SETOPTIONS, pid, nullptr, PTRACE_O_TRACESYSGOOD | PTRACE_O_EXITKILL);

  std::vector<std::uint64_t> counts;
  std::uint64_t since_marker = 0;
  bool marked = false;
  bool entering = true;
  long deliver = 0;
  while (ptrace(PTRACE_SYSCALL, pid, nullptr, deliver) == 0 && waitpid(pid, &status, 0) == pid && WIFSTOPPED(status)) {
    deliver = 0;
    if (WSTOPSIG(status) != (SIGTRAP | 0x80)) {
      if (WSTOPSIG(status) != SIGTRAP) deliver = WSTOPSIG(status);
      continue;
    }
    if (entering) {
      user_regs_struct registers{};
      ptrace(PTRACE_GETREGS, pid, nullptr, &registers);
      if (registers.orig_rax == SYS_getppid) {
        if (marked) counts.push_back(since_marker);
        marked = true;
        since_marker = 0;
      } else {
        ++since_marker;
      }
    }
    entering = !entering;
  }
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    return base::Error{arguments[0] + " failed under ptrace (status " + std::to_string(Decode(status)) + ")"};
  }
  return counts;
}

}  // namespace omni::test
