#include "service/daemon/devices/open_device.h"

#include <cmath>
#include <utility>
#include <vector>

#include "service/base/files/nearest_word.h"
#include "service/config/paths.h"
#include "service/device/usb/usb_transport.h"
#include "service/sim/twin/twin.h"

namespace omni::daemon {
namespace {

constexpr const char* kReplay = "replay";

base::Result<OpenedDevice> OpenTwin(const RunOptions& options, const std::string& /*argument*/) {
  const std::string program = config::ProgramFolder() + "/omni-twin";
  std::vector<std::string> arguments{"--seed", std::to_string(options.twin_seed)};
  const auto add = [&](const char* name, const std::string& value) {
    if (!value.empty()) arguments.insert(arguments.end(), {name, value});
  };
  add("--twin", options.twin);
  add("--script", options.twin_script);
  add("--hand", options.twin_hand);
  add("--record", options.twin_record);
  add("--device", options.device_file);
  base::Result<std::unique_ptr<device::Transport>> twin = sim::SpawnTwin(program, arguments);
  if (!twin.ok()) return base::Error{twin.error()};
  // The twin's imperfections follow from its seed: it is another base with every seed.
  return OpenedDevice{.transport = std::move(*twin), .serial = "twin-" + std::to_string(options.twin_seed)};
}

base::Result<OpenedDevice> OpenUsb(const RunOptions& options, const std::string& serial) {
  base::Result<std::unique_ptr<device::UsbBus>> bus = device::MakeUsbBus(options.realtime);
  if (!bus.ok()) return base::Error{bus.error()};
  base::Result<std::unique_ptr<device::Transport>> base = device::MakeUsbTransport(**bus, serial);
  if (!base.ok()) return base::Error{base.error()};
  const std::string reported = (*base)->info().serial;
  return OpenedDevice{.transport = std::move(*base), .serial = reported};
}

base::Result<OpenedDevice> OpenRecording(const RunOptions& options, const std::string& path) {
  auto replay =
      device::OpenReplay(path, options.replay_fast ? device::ReplayPace::kFast : device::ReplayPace::kRecorded);
  if (!replay.ok()) return base::Error{replay.error()};
  OpenedDevice opened{.serial = (*replay)->info().serial, .replay = replay->get()};
  opened.transport = std::move(*replay);
  return opened;
}

struct DeviceEntry {
  const char* name;
  const char* argument;  // what may follow after a colon; empty: nothing
  bool needs_argument;
  const char* about;
  base::Result<OpenedDevice> (*open)(const RunOptions& options, const std::string& argument);
};

constexpr DeviceEntry kDevices[] = {
    {"usb", "SERIAL", false, "a base on USB (waits until it is connected); SERIAL if there are several", OpenUsb},
    {"twin", "", false, "the digital twin (a simulation)", OpenTwin},
    {kReplay, "FILE", true, "a recording of --record-device", OpenRecording},
};

struct Wanted {
  const DeviceEntry* entry = nullptr;  // null: there is no such device
  std::string argument;
};

Wanted Parse(const std::string& device) {
  const std::size_t colon = device.find(':');
  const std::string name = device.substr(0, colon);
  const std::string argument = colon == std::string::npos ? "" : device.substr(colon + 1);
  for (const DeviceEntry& entry : kDevices) {
    const bool fits =
        colon == std::string::npos ? !entry.needs_argument : entry.argument[0] != '\0' && !argument.empty();
    if (name == entry.name && fits) return {&entry, argument};
  }
  return {};
}

std::string Words(const DeviceEntry& entry) {
  const std::string argument = ":" + std::string(entry.argument);
  if (entry.argument[0] == '\0') return entry.name;
  return entry.name + (entry.needs_argument ? argument : "[" + argument + "]");
}

}  // namespace

std::string DeviceHelp() {
  std::string text;
  for (const DeviceEntry& entry : kDevices) text += (text.empty() ? "" : "; ") + Words(entry) + ": " + entry.about;
  return text;
}

std::string DeviceProblem(const std::string& device) {
  if (Parse(device).entry != nullptr) return {};
  std::string known;
  std::vector<std::string> names;
  for (const DeviceEntry& entry : kDevices) {
    known += (known.empty() ? "" : ", ") + Words(entry);
    names.emplace_back(entry.name);
  }
  std::string meant = base::NearestWord(device.substr(0, device.find(':')), names);
  for (const DeviceEntry& entry : kDevices) {
    if (meant == entry.name && entry.needs_argument) meant = Words(entry);
  }
  return "\"" + device + "\" is not a device; known are " + known +
         (meant.empty() ? std::string() : "; did you mean '" + meant + "'?");
}

base::Result<OpenedDevice> OpenDevice(const RunOptions& options) {
  const Wanted wanted = Parse(options.device);
  if (wanted.entry == nullptr) return base::Error{DeviceProblem(options.device)};
  return wanted.entry->open(options, wanted.argument);
}

std::string SensorProblem(const device::TransportInfo& opened, const base::DeviceGeometry& device) {
  if (!(opened.field_range_T > 0) || std::abs(opened.field_range_T - device.sensor_range_T) <= device.sensor_lsb_T)
    return {};
  const auto milliteslas = [](double T) { return std::to_string(1e3 * T) + " mT"; };
  return "the base reports sensors of +-" + milliteslas(opened.field_range_T) + ", the device file has those of +-" +
         milliteslas(device.sensor_range_T) +
         " (sensor.sensor_range_T): poses will be wrong; start omnid with the --device-file of this base";
}

bool IsTwin(const std::string& device) {
  const DeviceEntry* entry = Parse(device).entry;
  return entry != nullptr && entry->open == OpenTwin;
}

bool IsReplay(const std::string& device) {
  const DeviceEntry* entry = Parse(device).entry;
  return entry != nullptr && entry->open == OpenRecording;
}

std::string RecordDevice(const RunOptions& options, double current_max_A, OpenedDevice& opened) {
  device::RecordingInfo info = device::DescribeForRecording(opened.transport->info(), current_max_A);
  info.serial = opened.serial;
  auto recorder = device::DeviceRecorder::Open(options.record_device_path, info);
  if (!recorder.ok()) return recorder.error();
  auto recording = std::make_unique<device::RecordingTransport>(std::move(opened.transport), std::move(*recorder));
  opened.recording = recording.get();
  opened.transport = std::move(recording);
  return "";
}

}  // namespace omni::daemon
