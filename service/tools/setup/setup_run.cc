#include "service/tools/setup/setup.h"

#include <chrono>
#include <cstdlib>
#include <iostream>
#include <thread>
#include <utility>

#include <nlohmann/json.hpp>

#include "service/base/clock.h"
#include "service/client/connection.h"
#include "service/console/wrap.h"
#include "service/protocol/socket_path.h"
#include "service/tools/common/output.h"
#include "service/tools/common/service_link.h"

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

base::Result<std::unique_ptr<SetupRun>> SetupRun::Start(bool rehearsal, bool yes) {
  base::Result<PrivateFolder> made = PrivateFolder::Make("omni-setup");
  if (!made.ok()) return base::Error{made.error()};
  const std::string& folder = made->path();
  if (rehearsal) {
    ::setenv("XDG_CONFIG_HOME", (folder + "/config").c_str(), 1);
    ::setenv("XDG_DATA_HOME", (folder + "/data").c_str(), 1);
    ::setenv("HOME", (folder + "/home").c_str(), 1);
    ::setenv("XDG_STATE_HOME", (folder + "/state").c_str(), 1);
    ::setenv("OMNI_SOCKET", (folder + "/omnid.sock").c_str(), 1);
  }
  return std::unique_ptr<SetupRun>(new SetupRun(rehearsal, yes, std::move(*made)));
}

bool SetupRun::Ask(const std::string& question) const { return Choose(question, {"y", "n"}, "n") == "y"; }

std::string SetupRun::Choose(const std::string& question, const std::vector<std::string>& answers,
                             const std::string& at_end) const {
  const std::string listed = console::Joined(answers, "/");
  for (;;) {
    std::cout << question << " [" << listed << "] " << std::flush;
    if (yes_) {
      std::cout << answers.front() << "\n";
      return answers.front();
    }
    std::string line;
    if (!std::getline(std::cin, line)) return at_end;
    line = Trimmed(line);
    if (line.empty()) return answers.front();
    for (const std::string& answer : answers) {
      if (line == answer) return answer;
    }
  }
}

int SetupRun::Omni(const std::vector<std::string>& words) const {
  std::cout << "$ omni " << console::Joined(words, " ") << std::endl;
  base::Result<ChildProgram> child = ChildProgram::Start("omni", words, "");
  if (child.ok()) return child->Wait();
  std::cerr << child.error() << "\n";
  return 1;
}

base::Result<ChildProgram> SetupRun::OmniBehind(const std::vector<std::string>& words) const {
  return ChildProgram::Start("omni", words, folder() + "/omni.log");
}

base::Status SetupRun::NeedService() {
  if (protocol::FindService(client::DefaultSocketPath()) == protocol::ServiceState::kOnDemand) {
    Wake(client::DefaultSocketPath());
  }
  base::Result<nlohmann::json> status = FetchStatus("");
  if (!status.ok() && (!service_ || service_->Poll())) {
    std::vector<std::string> words{"--device", device(), "--log-level", "warn"};
    if (rehearsal_) words.insert(words.end(), {"--twin-hand", hand_socket()});
    base::Result<ChildProgram> child = ChildProgram::Start("omnid", words, folder() + "/omnid.log");
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
