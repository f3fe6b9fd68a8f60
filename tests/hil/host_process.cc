#include "tests/hil/host_process.h"

#include <sched.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>
#include <utility>

namespace omni::hil {

base::Result<HostProcess> HostProcess::Start(const std::vector<std::string>& arguments) {
  std::vector<char*> pointers;
  for (const std::string& argument : arguments) pointers.push_back(const_cast<char*>(argument.c_str()));
  pointers.push_back(nullptr);
  if (arguments.empty()) return base::Error{"no program to start: give one after --"};
  const pid_t pid = fork();
  if (pid < 0) return base::Error{std::string("fork: ") + std::strerror(errno)};
  if (pid == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    const sched_param ordinary{};  // as a service manager starts it
    sched_setscheduler(0, SCHED_OTHER, &ordinary);
    sigset_t none;
    sigemptyset(&none);
    sigprocmask(SIG_SETMASK, &none, nullptr);
    execvp(pointers[0], pointers.data());
    _exit(127);
  }
  return HostProcess(pid);
}

HostProcess::HostProcess(HostProcess&& other) noexcept : pid_(std::exchange(other.pid_, -1)), status_(other.status_) {}

void HostProcess::Signal(int signal) {
  if (pid_ > 0 && !Ended()) kill(pid_, signal);
}

std::optional<int> HostProcess::Ended() {
  int status = 0;
  if (!status_ && pid_ > 0 && waitpid(pid_, &status, WNOHANG) == pid_) {
    status_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
  return status_;
}

int HostProcess::Stop() {
  if (pid_ <= 0) return 0;
  Signal(SIGCONT);
  Signal(SIGTERM);
  for (int i = 0; i < 300 && !Ended(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  Signal(SIGKILL);
  while (!Ended()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  return *status_;
}

}  // namespace omni::hil
