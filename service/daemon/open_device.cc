#include "service/daemon/open_device.h"

#include <filesystem>
#include <utility>
#include <vector>

#include "service/sim/twin.h"

namespace omni::daemon {
namespace {

constexpr const char* kReplay = "replay:";

base::Result<OpenedDevice> OpenTwin(const RunOptions& options) {
  std::error_code error;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", error);
  const std::string program = (self.parent_path() / "omni").string();
  std::vector<std::string> arguments{"--seed", std::to_string(options.twin_seed)};
  const auto add = [&](const char* name, const std::string& value) {
    if (!value.empty()) arguments.insert(arguments.end(), {name, value});
  };
  add("--script", options.twin_script);
  add("--record", options.twin_record);
  add("--device", options.device_file);
  auto twin = sim::SpawnTwin(program, arguments);
  if (!twin.ok()) return base::Error{twin.error()};
  return OpenedDevice{.transport = std::move(*twin)};
}

// The twin's imperfections follow from its seed: it is another base with every seed.
base::Result<std::string> TwinSerial(const RunOptions& options) { return "twin-" + std::to_string(options.twin_seed); }

std::string ReplayPath(const RunOptions& options) { return options.device.substr(std::string(kReplay).size()); }

base::Result<OpenedDevice> OpenRecording(const RunOptions& options) {
  auto replay = device::OpenReplay(ReplayPath(options),
                                   options.replay_fast ? device::ReplayPace::kFast : device::ReplayPace::kRecorded);
  if (!replay.ok()) return base::Error{replay.error()};
  OpenedDevice opened{.replay = replay->get()};
  opened.transport = std::move(*replay);
  return opened;
}

base::Result<std::string> RecordedSerial(const RunOptions& options) {
  const auto reader = device::RecordingReader::Open(ReplayPath(options));
  if (!reader.ok()) return base::Error{reader.error()};
  return (*reader)->info().serial;
}

struct DeviceRow {
  const char* word;  // of --device; with a colon at its end: what follows is a file
  const char* meaning;
  base::Result<OpenedDevice> (*open)(const RunOptions&);
  base::Result<std::string> (*serial)(const RunOptions&);
};
constexpr DeviceRow kDevices[] = {
    {"twin", "twin (the simulation)", OpenTwin, TwinSerial},
    {kReplay, "replay:FILE (a recording of --record-device)", OpenRecording, RecordedSerial},
};

const DeviceRow* FindDevice(const std::string& device) {
  for (const DeviceRow& row : kDevices) {
    const std::string word = row.word;
    const bool with_file = word.back() == ':';
    if (with_file ? device.size() > word.size() && device.starts_with(word) : device == word) return &row;
  }
  return nullptr;
}

}  // namespace

std::string CheckDeviceName(const std::string& device) {
  if (FindDevice(device) != nullptr) return "";
  std::string known;
  for (const DeviceRow& row : kDevices) known += (known.empty() ? "" : ", ") + std::string(row.meaning);
  return "no device " + device + "; there are: " + known;
}

bool IsReplay(const std::string& device) { return device.starts_with(kReplay); }

base::Result<std::string> DeviceSerial(const RunOptions& options) {
  const DeviceRow* row = FindDevice(options.device);
  if (row == nullptr) return base::Error{CheckDeviceName(options.device)};
  return row->serial(options);
}

base::Result<OpenedDevice> OpenDevice(const RunOptions& options) {
  const DeviceRow* row = FindDevice(options.device);
  if (row == nullptr) return base::Error{CheckDeviceName(options.device)};
  return row->open(options);
}

std::string RecordDevice(const RunOptions& options, double current_max_A, int n, OpenedDevice& opened) {
  const std::string path = options.record_device_path + (n > 1 ? "." + std::to_string(n) : "");
  device::RecordingInfo info = device::DescribeForRecording(opened.transport->info(), current_max_A);
  if (const auto serial = DeviceSerial(options); serial.ok()) info.serial = *serial;
  auto recorder = device::DeviceRecorder::Open(path, info);
  if (!recorder.ok()) return recorder.error();
  auto recording = std::make_unique<device::RecordingTransport>(std::move(opened.transport), std::move(*recorder));
  opened.recording = recording.get();
  opened.transport = std::move(recording);
  return "";
}

}  // namespace omni::daemon
