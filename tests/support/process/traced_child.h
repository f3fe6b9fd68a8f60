// A function in a forked child that is stopped before each of its system calls, which may be made to fail or be the
// last.
#pragma once

#include <signal.h>
#include <sys/ptrace.h>
#include <sys/user.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <functional>

namespace omni::test {

struct SystemCall {
  std::uint64_t number = 0;  // SYS_write, ...
  std::array<std::uint64_t, 3> arguments{};
};

// Fate of a system call of the child.
struct Fate {
  bool dies = false;  // the child is killed before the call
  int error = 0;      // the call is skipped and fails with this
};

// How the child ended: what `body` returned; kKilled; kNoTrace: ptrace is not permitted here.
inline constexpr int kKilled = -1, kNoTrace = -2;

// Runs `body` (which returns 0 to 255) and calls `decide` before each of its system calls, in order.
inline int RunTraced(const std::function<int()>& body, const std::function<Fate(const SystemCall&)>& decide) {
  const pid_t pid = fork();
  if (pid == 0) {
    if (ptrace(PTRACE_TRACEME, 0, nullptr, nullptr) != 0) _exit(255);
    raise(SIGSTOP);
    _exit(body());
  }
  int status = 0;
  waitpid(pid, &status, 0);
  if (!WIFSTOPPED(status)) return kNoTrace;
  ptrace(PTRACE_SETOPTIONS, pid, nullptr, PTRACE_O_TRACESYSGOOD | PTRACE_O_EXITKILL);
  bool entering = true;
  int failing = 0;
  while (ptrace(PTRACE_SYSCALL, pid, nullptr, nullptr) == 0 && waitpid(pid, &status, 0) == pid && WIFSTOPPED(status)) {
    if (WSTOPSIG(status) != (SIGTRAP | 0x80)) continue;
    user_regs_struct registers{};
    ptrace(PTRACE_GETREGS, pid, nullptr, &registers);
    if (entering) {
      const Fate fate = decide({registers.orig_rax, {registers.rdi, registers.rsi, registers.rdx}});
      if (fate.dies) {
        kill(pid, SIGKILL);
        waitpid(pid, &status, 0);
        return kKilled;
      }
      failing = fate.error;
      if (failing != 0) registers.orig_rax = ~0ULL;  // no such call
    } else if (failing != 0) {
      registers.rax = static_cast<unsigned long long>(-static_cast<long long>(failing));
    }
    if (failing != 0) ptrace(PTRACE_SETREGS, pid, nullptr, &registers);
    entering = !entering;
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : kKilled;
}

}  // namespace omni::test
