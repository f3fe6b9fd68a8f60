#include "tests/hil/board/qemu_process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>

#include "tests/hil/board/tools.h"

namespace omni::hil {
namespace {

using base::Error;
using base::Result;

std::string Reason() { return std::strerror(errno); }

std::vector<std::string> CommandLine(const std::string& qemu, const QemuProcess::Options& options) {
  std::string semihosting = "enable=on,target=native,arg=" + options.image;
  for (const std::string& argument : options.arguments) semihosting += ",arg=" + argument;
  std::vector<std::string> line = {qemu,
                                   "-M",
                                   "mps2-an500",
                                   "-display",
                                   "none",
                                   "-monitor",
                                   "none",
                                   "-serial",
                                   "none",
                                   "-net",
                                   "none",
                                   "-kernel",
                                   ImagePath(options.image)};
  line.insert(line.end(), {"-semihosting-config", semihosting});
  // At shift 10 an instruction takes 25.6 ticks of SysTick: fine enough to count single ones.
  if (options.count_instructions) line.insert(line.end(), {"-icount", "shift=10,sleep=off"});
  return line;
}

// Our environment, without libraries preloaded to emulate a program's devices: the board has none.
std::vector<std::string> EnvironmentWithoutPreload() {
  std::vector<std::string> kept;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    if (std::strncmp(*entry, "LD_PRELOAD=", 11) != 0) kept.emplace_back(*entry);
  }
  return kept;
}

std::vector<char*> Pointers(std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  pointers.reserve(texts.size() + 1);
  for (std::string& text : texts) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  return pointers;
}

// In the child, between fork and exec: only calls that are safe there.
[[noreturn]] void BecomeQemu(char** arguments, char** environment, const char* folder, int output, pid_t parent) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(125);  // the parent died before we could be notified
  const int nothing = ::open("/dev/null", O_RDONLY);
  ::dup2(nothing, STDIN_FILENO);
  ::dup2(output, STDOUT_FILENO);
  ::dup2(output, STDERR_FILENO);
  if (::chdir(folder) != 0) ::_exit(126);
  ::execve(arguments[0], arguments, environment);
  ::_exit(127);
}

}  // namespace

Result<std::unique_ptr<QemuProcess>> QemuProcess::Start(const Options& options, const std::string& folder) {
  const std::string qemu = FindProgram("qemu-system-arm");
  if (qemu.empty()) return Error{"there is no qemu-system-arm: run scripts/setup all"};
  if (!std::filesystem::exists(ImagePath(options.image))) {
    return Error{ImagePath(options.image) + " is missing: build target omni_images"};
  }
  const std::string output_path = folder + "/output";
  const int output = ::open(output_path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
  if (output < 0) return Error{output_path + ": " + Reason()};
  std::vector<std::string> line = CommandLine(qemu, options);
  std::vector<std::string> environment = EnvironmentWithoutPreload();
  const std::vector<char*> line_pointers = Pointers(line), environment_pointers = Pointers(environment);
  const pid_t parent = ::getpid();
  const pid_t pid = ::fork();
  if (pid == 0)
    BecomeQemu(const_cast<char**>(line_pointers.data()), const_cast<char**>(environment_pointers.data()),
               folder.c_str(), output, parent);
  ::close(output);
  if (pid < 0) return Error{"cannot start " + qemu + ": " + Reason()};
  const int pidfd = static_cast<int>(::syscall(SYS_pidfd_open, pid, 0));
  if (pidfd < 0) {
    const std::string reason = Reason();
    ::kill(pid, SIGKILL);
    ::waitpid(pid, nullptr, 0);
    return Error{"cannot watch " + qemu + ": " + reason};
  }
  return std::unique_ptr<QemuProcess>(new QemuProcess(pid, pidfd, output_path));
}

QemuProcess::~QemuProcess() {
  Kill();
  ::close(pidfd_);
}

std::optional<int> QemuProcess::Wait(int timeout_ms) {
  if (status_) return status_;
  pollfd ended{pidfd_, POLLIN, 0};
  int ready = 0;
  do {
    ready = ::poll(&ended, 1, timeout_ms);
  } while (ready < 0 && errno == EINTR);
  int status = 0;
  if (ready <= 0 || ::waitpid(pid_, &status, WNOHANG) != pid_) return std::nullopt;
  status_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return status_;
}

void QemuProcess::Kill() {
  if (status_) return;
  ::kill(pid_, SIGKILL);
  Wait(-1);
}

std::string QemuProcess::output() const {
  std::ifstream file(output_path_);
  std::string text, line;
  while (std::getline(file, line)) {
    // The board always has its Ethernet chip.
    if (line.find("warning: nic lan9118.0 has no peer") == std::string::npos) text += line + "\n";
  }
  return text;
}

Result<QemuRun> RunImage(const QemuProcess::Options& options, int timeout_ms) {
  const test::TempFolder folder;
  auto started = QemuProcess::Start(options, folder.Path());
  if (!started) return Error{started.error()};
  QemuProcess& process = **started;
  const std::optional<int> status = process.Wait(timeout_ms);
  if (!status) {
    return Error{options.image + " still runs after " + std::to_string(timeout_ms) + " ms\n" + process.output()};
  }
  return QemuRun{*status, process.output()};
}

}  // namespace omni::hil
