#include "service/tools/monitor/trial_service.h"

#include <fstream>
#include <optional>
#include <vector>

#include "service/config/files/twin_file.h"

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

}  // namespace omni::tools
