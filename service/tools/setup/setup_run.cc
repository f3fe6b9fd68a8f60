#include "service/tools/setup/setup_run.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <thread>
#include <utility>

#include <nlohmann/json.hpp>

#include "service/base/clock.h"
#include "service/client/connection.h"
#include "service/config/paths.h"
#include "service/protocol/socket_path.h"
#include "service/tools/common/json_text.h"
#include "service/tools/common/service_link.h"

extern char** environ;

namespace omni::tools {
namespace {

constexpr auto kServicePause = std::chrono::milliseconds(50);
constexpr int kServicePauses = 200;  // until omnid has its device

std::string Trimmed(std::string text) {
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back())) != 0) text.pop_back();
  return text;
}

// systemd starts omnid for an application; it stays for a minute after this.
void Wake(const std::string& socket_path) {
  client::Connection application({.application = "omni setup", .engine = "", .socket_path = socket_path});
  for (int i = 0; i < kServicePauses && !application.connected(); ++i) {
    application.Poll(base::MonotonicNow_ns());
    std::this_thread::sleep_for(kServicePause);
  }
}

}  // namespace

base::Result<SetupChild> SetupChild::Start(const std::string& program, const std::vector<std::string>& words,
                                           const std::string& log) {
  const std::string path = config::ProgramFolder() + "/" + program;
  std::vector<std::string> all = words;
  all.insert(all.begin(), path);
  std::vector<char*> arguments;
  for (std::string& word : all) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  if (!log.empty()) {
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, log.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600);
    posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
  }
  pid_t pid = -1;
  const int code = ::posix_spawn(&pid, path.c_str(), &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (code != 0) return base::Error{path + ": cannot be started (" + std::strerror(code) + "); install Omni again"};
  return SetupChild(pid);
}

SetupChild::SetupChild(SetupChild&& other) noexcept
    : pid_(std::exchange(other.pid_, -1)), status_(std::exchange(other.status_, std::nullopt)) {}

SetupChild& SetupChild::operator=(SetupChild&& other) noexcept {
  End();
  pid_ = std::exchange(other.pid_, -1);
  status_ = std::exchange(other.status_, std::nullopt);
  return *this;
}

SetupChild::~SetupChild() { End(); }

void SetupChild::End() noexcept {
  if (pid_ <= 0 || status_) return;
  ::kill(pid_, SIGTERM);
  ::waitpid(pid_, nullptr, 0);
  pid_ = -1;
}

std::optional<int> SetupChild::Poll() {
  int status = 0;
  if (!status_ && ::waitpid(pid_, &status, WNOHANG) == pid_) {
    status_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
  return status_;
}

int SetupChild::Wait() {
  while (!Poll()) std::this_thread::sleep_for(kServicePause);
  return *status_;
}

base::Result<std::unique_ptr<SetupRun>> SetupRun::Start(bool rehearsal, bool yes) {
  std::string folder = std::filesystem::temp_directory_path().string() + "/omni-setup-XXXXXX";
  if (::mkdtemp(folder.data()) == nullptr) {
    return base::Error{folder + ": cannot be made (" + std::strerror(errno) + "); set TMPDIR to a folder of your own"};
  }
  if (rehearsal) {
    ::setenv("XDG_CONFIG_HOME", (folder + "/config").c_str(), 1);
    ::setenv("XDG_DATA_HOME", (folder + "/data").c_str(), 1);
    ::setenv("OMNI_SOCKET", (folder + "/omnid.sock").c_str(), 1);
  }
  return std::unique_ptr<SetupRun>(new SetupRun(rehearsal, yes, folder));
}

SetupRun::~SetupRun() {
  EndService();
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

bool SetupRun::Ask(const std::string& question) const { return Choose(question, {"y", "n"}) == "y"; }

std::string SetupRun::Choose(const std::string& question, const std::vector<std::string>& answers) const {
  std::string listed;
  for (const std::string& answer : answers) listed += (listed.empty() ? "" : "/") + answer;
  for (;;) {
    std::cout << question << " [" << listed << "] " << std::flush;
    if (yes_) {
      std::cout << answers.front() << "\n";
      return answers.front();
    }
    std::string line;
    if (!std::getline(std::cin, line)) return answers.size() == 2 && answers[1] == "n" ? "n" : answers.front();
    line = Trimmed(line);
    if (line.empty()) return answers.front();
    for (const std::string& answer : answers) {
      if (line == answer) return answer;
    }
  }
}

int SetupRun::Omni(const std::vector<std::string>& words) const {
  std::cout << "$ omni";
  for (const std::string& word : words) std::cout << " " << word;
  std::cout << std::endl;
  base::Result<SetupChild> child = SetupChild::Start("omni", words, "");
  if (child.ok()) return child->Wait();
  std::cerr << child.error() << "\n";
  return 1;
}

base::Result<SetupChild> SetupRun::OmniBehind(const std::vector<std::string>& words) const {
  return SetupChild::Start("omni", words, folder_ + "/omni.log");
}

base::Status SetupRun::NeedService() {
  if (protocol::FindService(client::DefaultSocketPath()) == protocol::ServiceState::kOnDemand) {
    Wake(client::DefaultSocketPath());
  }
  base::Result<nlohmann::json> status = FetchStatus("");
  if (!status.ok() && (!service_ || service_->Poll())) {
    std::vector<std::string> words{"--device", device(), "--log-level", "warn"};
    if (rehearsal_) words.insert(words.end(), {"--twin-hand", hand_socket()});
    base::Result<SetupChild> child = SetupChild::Start("omnid", words, folder_ + "/omnid.log");
    if (!child.ok()) return base::Error{child.error()};
    service_ = std::move(*child);
  }
  std::string why = "omnid does not answer";
  for (int i = 0; i < kServicePauses; ++i) {
    status = FetchStatus("");
    if (status.ok()) {
      const nlohmann::json* name = base::ValueAt(*status, "/device/name");
      if (name != nullptr && name->is_string()) return base::Ok{};
      why = "omnid has no device: " + base::StringAt(*status, "/device/absent");
    }
    if (service_ && service_->Poll()) return base::Error{"omnid has ended; run it in a terminal to see why"};
    std::this_thread::sleep_for(kServicePause);
  }
  return base::Error{why + "; connect the base and switch its supply on, or see `omni doctor`"};
}

}  // namespace omni::tools
