#include "tests/hil/time/host_process.h"

#include <signal.h>
#include <stdlib.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace omni::hil {

base::Result<HostProcess> HostProcess::Start(const std::vector<std::string>& arguments,
                                             const std::vector<std::string>& environment) {
  std::vector<char*> pointers;
  for (const std::string& argument : arguments) pointers.push_back(const_cast<char*>(argument.c_str()));
  pointers.push_back(nullptr);
  if (arguments.empty()) return base::Error{"no program to start: give one after --"};
  const pid_t pid = fork();
  if (pid < 0) return base::Error{std::string("fork: ") + std::strerror(errno)};
  if (pid == 0) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    for (const std::string& entry : environment) putenv(const_cast<char*>(entry.c_str()));
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

HostProcess::~HostProcess() {
  if (pid_ > 0) Kill();
}

void HostProcess::Ask() {
  Signal(SIGCONT);
  Signal(SIGTERM);
}

int HostProcess::Kill() {
  int status = 0;
  if (!Ended()) {
    kill(pid_, SIGKILL);
    while (waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
    }
    status_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
  return *status_;
}

}  // namespace omni::hil
