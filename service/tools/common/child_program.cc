#include "service/tools/common/child_program.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <thread>
#include <utility>

#include "service/base/unique_fd.h"
#include "service/config/paths.h"

namespace omni::tools {
namespace {

constexpr auto kWaitPause = std::chrono::milliseconds(10);
constexpr int kEndPauses = 300;  // then it is killed; an omnid's base is at zero 50 ms after the last command
constexpr int kCannotStart = 127;

// In the child, after fork(): only async-signal-safe calls. Writes errno to `report` if the program cannot be started.
[[noreturn]] void Become(const char* program, char* const* words, const char* log, pid_t parent, int report) {
  ::prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (::getppid() != parent) ::_exit(kCannotStart);  // which has ended in between
  if (*log != 0) {
    ::setpgid(0, 0);
    const int in = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
    const int out = ::open(log, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
    ::dup2(in, STDIN_FILENO);
    ::dup2(out, STDOUT_FILENO);
    ::dup2(out, STDERR_FILENO);
  }
  ::execv(program, words);
  const int code = errno;
  [[maybe_unused]] const ssize_t written = ::write(report, &code, sizeof(code));
  ::_exit(kCannotStart);
}

}  // namespace

base::Result<ChildProgram> ChildProgram::Start(const std::string& name, const std::vector<std::string>& words,
                                               const std::string& log) {
  std::vector<std::string> all = words;
  all.insert(all.begin(), config::ProgramFolder() + "/" + name);
  std::vector<char*> arguments;
  for (std::string& word : all) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const auto failed = [&](int code) {
    return base::Error{all.front() + ": cannot be started (" + std::strerror(code) + "); install Omni again"};
  };
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) return failed(errno);
  const base::UniqueFd reader(ends[0]);
  base::UniqueFd writer(ends[1]);
  const pid_t parent = ::getpid();
  const pid_t pid = ::fork();
  if (pid < 0) return failed(errno);
  if (pid == 0) Become(all.front().c_str(), arguments.data(), log.c_str(), parent, ends[1]);
  writer.Reset();
  ChildProgram child(pid);
  int code = 0;
  if (::read(reader.get(), &code, sizeof(code)) == static_cast<ssize_t>(sizeof(code))) return failed(code);
  return child;
}

ChildProgram::ChildProgram(ChildProgram&& other) noexcept
    : pid_(std::exchange(other.pid_, -1)), status_(std::exchange(other.status_, std::nullopt)) {}

ChildProgram& ChildProgram::operator=(ChildProgram&& other) noexcept {
  End();
  pid_ = std::exchange(other.pid_, -1);
  status_ = std::exchange(other.status_, std::nullopt);
  return *this;
}

ChildProgram::~ChildProgram() { End(); }

void ChildProgram::End() noexcept {
  if (pid_ <= 0 || Poll()) return;
  ::kill(pid_, SIGTERM);
  for (int i = 0; i < kEndPauses && !Poll(); ++i) std::this_thread::sleep_for(kWaitPause);
  if (Poll()) return;
  ::kill(pid_, SIGKILL);
  ::waitpid(pid_, nullptr, 0);
}

std::optional<int> ChildProgram::Poll() {
  int status = 0;
  if (!status_ && ::waitpid(pid_, &status, WNOHANG) == pid_) {
    status_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
  return status_;
}

int ChildProgram::Wait() {
  while (!Poll()) std::this_thread::sleep_for(kWaitPause);
  return *status_;
}

base::Result<PrivateFolder> PrivateFolder::Make(const std::string& name) {
  const char* run = std::getenv("XDG_RUNTIME_DIR");
  for (const std::string& parent : {std::string(run == nullptr ? "" : run), std::string("/tmp")}) {
    if (parent.empty()) continue;
    std::string folder = parent + "/" + name + "-XXXXXX";
    if (::mkdtemp(folder.data()) != nullptr) return PrivateFolder(std::move(folder));
  }
  return base::Error{std::string("no folder can be made in /tmp (") + std::strerror(errno) + ")"};
}

PrivateFolder::PrivateFolder(PrivateFolder&& other) noexcept : path_(std::exchange(other.path_, {})) {}

PrivateFolder::~PrivateFolder() {
  if (path_.empty()) return;
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace omni::tools
