#include "service/daemon/check_options.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>

#include "service/config/files/alignment_file.h"
#include "service/config/files/calibration_file.h"
#include "service/config/files/device_file.h"
#include "service/config/files/twin_file.h"
#include "service/daemon/devices/open_device.h"
#include "service/magnetics/nominal.h"
#include "service/sim/hand/hand.h"

namespace omni::daemon {
namespace {

namespace fs = std::filesystem;

template <class T>
std::string ErrorOf(const base::Result<T>& result) {
  return result.ok() ? std::string() : result.error();
}

std::string ScriptProblem(const std::string& path) { return ErrorOf(sim::LoadHandScript(path)); }
std::string TwinProblem(const std::string& name_or_file) { return ErrorOf(config::FindTwin(name_or_file)); }
std::string AlignmentsProblem(const std::string& path) { return ErrorOf(config::LoadAlignmentFile(path)); }
std::string DeviceFileProblem(const std::string& path) { return ErrorOf(config::LoadDeviceFile(path)); }

// A recording replaces an existing file.
std::string WriteProblem(const std::string& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) return path + ": is a folder; give a file's name";
  if (fs::exists(path, error)) {
    return ::access(path.c_str(), W_OK) == 0
               ? std::string()
               : path + ": cannot be written (" + std::strerror(errno) + "); name another file";
  }
  const fs::path parent = fs::path(path).parent_path();
  const std::string folder = parent.empty() ? "." : parent.string();
  if (!fs::is_directory(folder, error))
    return path + ": there is no folder " + folder + "; make it or name another one";
  if (::access(folder.c_str(), W_OK | X_OK) == 0) return {};
  return path + ": cannot be made in " + folder + " (" + std::strerror(errno) + "); name another folder";
}

struct FileOption {
  const char* name;
  std::string RunOptions::*path;
  std::string (*problem)(const std::string& path);
};
constexpr FileOption kFileOptions[] = {
    {"--device-file", &RunOptions::device_file, DeviceFileProblem},
    {"--alignments", &RunOptions::alignment_path, AlignmentsProblem},
    {"--twin", &RunOptions::twin, TwinProblem},
    {"--twin-script", &RunOptions::twin_script, ScriptProblem},
    {"--record", &RunOptions::record_path, WriteProblem},
    {"--record-device", &RunOptions::record_device_path, WriteProblem},
    {"--twin-record", &RunOptions::twin_record, WriteProblem},
};

// Precondition: the device's file can be read, if one is given.
std::string CalibrationProblem(const RunOptions& options) {
  if (options.calibration_path.empty()) return {};
  const base::DeviceGeometry device =
      options.device_file.empty() ? config::DefaultDevice() : *config::LoadDeviceFile(options.device_file);
  const config::ExpectedBase expected{.device = device, .drawing = magnetics::NominalCalibration(device), .serial = {}};
  const std::string problem = ErrorOf(config::LoadCalibrationFile(options.calibration_path, expected));
  return problem.empty() ? problem : "--calibration: " + problem;
}

}  // namespace

std::string TwinChoiceProblem(const RunOptions& options) {
  if (options.twin.empty() || IsTwin(options.device)) return {};
  return "--twin, --ideal: need --device twin";
}

std::string OptionsProblem(const RunOptions& options) {
  const bool twin = IsTwin(options.device);
  if (const std::string problem = TwinChoiceProblem(options); !problem.empty()) return problem;
  if (!twin && !options.twin_script.empty()) return "--twin-script: needs --device twin";
  if (!twin && !options.twin_hand.empty()) return "--twin-hand: needs --device twin";
  if (!twin && !options.twin_record.empty()) return "--twin-record: needs --device twin";
  for (const FileOption& option : kFileOptions) {
    const std::string& path = options.*option.path;
    const std::string problem = path.empty() ? std::string() : option.problem(path);
    if (!problem.empty()) return option.name + (": " + problem);
  }
  return CalibrationProblem(options);
}

}  // namespace omni::daemon
