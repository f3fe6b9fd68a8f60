// The devices of omnid --device: one row per kind of device.
#pragma once

#include <memory>
#include <string>

#include "service/base/device_geometry.h"
#include "service/base/result.h"
#include "service/daemon/run.h"
#include "service/device/recording/device_recorder.h"
#include "service/device/recording/replay_transport.h"
#include "service/device/transport.h"

namespace omni::daemon {

struct OpenedDevice {
  std::unique_ptr<device::Transport> transport;
  std::string serial;                               // that a calibration must have
  const device::ReplayTransport* replay = nullptr;  // within `transport`, if it is one
  device::RecordingTransport* recording = nullptr;  // within `transport`, if it is recorded
};

// For --help: every kind with its description.
std::string DeviceHelp();

// Why `device` is not a known device; empty: it is.
std::string DeviceProblem(const std::string& device);

// Precondition: DeviceProblem(options.device) is empty.
base::Result<OpenedDevice> OpenDevice(const RunOptions& options);

// Why the sensors of an opened base are not those of the device file; empty: they are, or it does not say.
std::string SensorProblem(const device::TransportInfo& opened, const base::DeviceGeometry& device);

bool IsTwin(const std::string& device);
bool IsReplay(const std::string& device);

// Shown first in log and status while a simulation runs.
inline constexpr const char* kSimulationText = "there is no real base; pen, forces and all figures are simulated";

// Records `opened` to options.record_device_path, a new file, from its next scan on. Returns the problem, if any: then
// nothing is recorded.
std::string RecordDevice(const RunOptions& options, double current_max_A, OpenedDevice& opened);

}  // namespace omni::daemon
