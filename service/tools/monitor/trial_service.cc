#include "service/tools/monitor/trial_service.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <thread>
#include <utility>
#include <vector>

#include "service/config/paths.h"

namespace omni::tools {
namespace {

constexpr auto kEndPause = std::chrono::milliseconds(10);
constexpr int kEndPauses = 300;  // then omnid is killed; its base is at zero 50 ms after the last command

// In the user's run-time folder, else in /tmp; with mode 0700.
base::Result<std::string> MakeFolder() {
  const char* run = std::getenv("XDG_RUNTIME_DIR");
  for (const std::string& parent : {std::string(run == nullptr ? "" : run), std::string("/tmp")}) {
    if (parent.empty()) continue;
    std::string folder = parent + "/omni-try-XXXXXX";
    if (::mkdtemp(folder.data()) != nullptr) return folder;
  }
  return base::Error{std::string("no folder can be made in /tmp (") + std::strerror(errno) + ")"};
}

std::string LastLine(const std::string& path) {
  std::ifstream in(path);
  std::string last;
  for (std::string line; std::getline(in, line);) {
    if (!line.empty()) last = line;
  }
  return last;
}

}  // namespace

std::string TwinCalibration() {
  const std::string path = config::DataFolder() + "/device/twin_calibration.toml";
  std::error_code error;
  return std::filesystem::exists(path, error) ? path : std::string();
}

base::Result<std::unique_ptr<TrialService>> TrialService::Start() {
  base::Result<std::string> folder = MakeFolder();
  if (!folder.ok()) return base::Error{folder.error()};
  std::unique_ptr<TrialService> service(new TrialService(*folder));
  const base::Status spawned = service->Spawn();
  if (!spawned.ok()) return base::Error{spawned.error()};
  return service;
}

base::Status TrialService::Spawn() {
  const std::string program = config::ProgramFolder() + "/omnid";
  std::vector<std::string> words = {program,       "--device",     "twin",
                                    "--socket",    socket(),       "--twin-hand",
                                    hand(),        "--alignments", folder_ + "/alignments.toml",
                                    "--log-level", "warn"};
  if (const std::string calibration = TwinCalibration(); !calibration.empty()) {
    words.insert(words.end(), {"--calibration", calibration});
  }
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const std::string log = folder_ + "/omnid.log";
  const pid_t parent = ::getpid();
  pid_ = ::fork();
  if (pid_ < 0) return base::Error{std::string("omnid cannot be started: ") + std::strerror(errno)};
  if (pid_ == 0) {  // only async-signal-safe calls
    ::prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (::getppid() != parent) ::_exit(1);
    ::setpgid(0, 0);  // Ctrl-C is for omni, which ends omnid
    const int fd = ::open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    ::dup2(fd, STDOUT_FILENO);
    ::dup2(fd, STDERR_FILENO);
    ::execv(program.c_str(), arguments.data());
    ::_exit(127);
  }
  return base::Ok{};
}

std::string TrialService::EndReason() {
  if (!ended_.empty()) return ended_;
  int status = 0;
  if (::waitpid(pid_, &status, WNOHANG) != pid_) return {};
  const std::string how = WIFSIGNALED(status) ? "was ended by signal " + std::to_string(WTERMSIG(status))
                                              : "ended with status " + std::to_string(WEXITSTATUS(status));
  const std::string last = LastLine(folder_ + "/omnid.log");
  pid_ = -1;
  return ended_ = "omnid " + how + (last.empty() ? "" : ": " + last);
}

TrialService::~TrialService() {
  if (pid_ > 0) ::kill(pid_, SIGTERM);
  for (int i = 0; pid_ > 0 && i < kEndPauses && ::waitpid(pid_, nullptr, WNOHANG) != pid_; ++i) {
    std::this_thread::sleep_for(kEndPause);
    if (i + 1 < kEndPauses) continue;
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
  }
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

}  // namespace omni::tools
