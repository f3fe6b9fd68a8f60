#include "service/tools/monitor/monitor.h"

#include <fcntl.h>
#include <spawn.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <vector>

#include "service/config/files/twin_file.h"
#include "service/config/paths.h"

namespace omni::tools {
namespace {

std::string LastLine(const std::string& path) {
  std::ifstream in(path);
  std::string last;
  for (std::string line; std::getline(in, line);) {
    if (!line.empty()) last = line;
  }
  return last;
}

std::string LogOf(const std::string& folder) { return folder + "/omnid.log"; }

}  // namespace

base::Result<std::unique_ptr<TrialService>> TrialService::Start(const std::string& twin_record) {
  base::Result<PrivateFolder> folder = PrivateFolder::Make("omni-try");
  if (!folder.ok()) return base::Error{folder.error()};
  const std::string& in = folder->path();
  std::vector<std::string> words = {"--device",    "twin",         "--socket",     in + kSocketName,
                                    "--twin-hand", in + kHandName, "--alignments", in + "/alignments.toml",
                                    "--log-level", "warn",         "--stop-file",  in + "/emergency_stop.toml"};
  if (const std::string calibration = config::ShippedCalibration({}, config::kShippedSeed); !calibration.empty()) {
    words.insert(words.end(), {"--calibration", calibration});
  }
  if (!twin_record.empty()) words.insert(words.end(), {"--twin-record", twin_record});
  base::Result<ChildProgram> omnid = ChildProgram::Start("omnid", words, LogOf(in));
  if (!omnid.ok()) return base::Error{omnid.error()};
  return std::unique_ptr<TrialService>(new TrialService(std::move(*folder), std::move(*omnid)));
}

std::string TrialService::EndReason() {
  const std::optional<int> status = omnid_.Poll();
  if (!status) return {};
  const std::string last = LastLine(LogOf(folder()));
  return "omnid " +
         (*status > 128 ? "was ended by signal " + std::to_string(*status - 128)
                        : "ended with status " + std::to_string(*status)) +
         (last.empty() ? "" : ": " + last);
}

base::Result<std::string> FindPage() {
  const std::string folder = config::DataFolder() + "/page";
  std::error_code error;
  if (std::filesystem::exists(folder + "/page.js", error)) return folder;
  return base::Error{"the page is not in " + folder +
                     ": Omni was built without npm; install npm (Debian: npm) and build again. `omni watch` shows the "
                     "pen in the terminal"};
}

bool OpenBrowser(const std::string& address) {
  const char* display = std::getenv("DISPLAY");
  const char* wayland = std::getenv("WAYLAND_DISPLAY");
  if ((display == nullptr || *display == 0) && (wayland == nullptr || *wayland == 0)) return false;
  std::string program = "xdg-open";
  std::string word = address;
  std::array<char*, 3> words{program.data(), word.data(), nullptr};
  posix_spawn_file_actions_t files;
  ::posix_spawn_file_actions_init(&files);
  for (const int fd : {STDOUT_FILENO, STDERR_FILENO}) {
    ::posix_spawn_file_actions_addopen(&files, fd, "/dev/null", O_WRONLY, 0);
  }
  pid_t pid = 0;
  const bool started = ::posix_spawnp(&pid, program.c_str(), &files, nullptr, words.data(), environ) == 0;
  ::posix_spawn_file_actions_destroy(&files);
  return started;
}

}  // namespace omni::tools
