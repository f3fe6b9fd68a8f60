// What omnid --device means: one row a kind of device.
#pragma once

#include <memory>
#include <string>

#include "service/base/result.h"
#include "service/daemon/run.h"
#include "service/device/recording/recording_transport.h"
#include "service/device/recording/replay_transport.h"
#include "service/device/transport.h"

namespace omni::daemon {

struct OpenedDevice {
  std::unique_ptr<device::Transport> transport;
  std::string serial;                               // what a calibration must have been made of
  const device::ReplayTransport* replay = nullptr;  // within `transport`, if it is one
  device::RecordingTransport* recording = nullptr;  // within `transport`, if it is recorded
};

// For --help: every kind with what it is.
std::string DeviceHelp();

// Why `device` is no word for one; empty: it is.
std::string DeviceProblem(const std::string& device);

// Precondition: DeviceProblem(options.device) is empty.
base::Result<OpenedDevice> OpenDevice(const RunOptions& options);

bool IsTwin(const std::string& device);
bool IsReplay(const std::string& device);

// What log and status say first while a simulation runs.
inline constexpr const char* kSimulationText = "there is no real base; pen, forces and all figures are simulated";

// Has `opened` written to options.record_device_path, from its next scan on. The n-th device that omnid opens (after
// the one before was lost) gets ".n" behind the path, so that no recording is overwritten by the next one. Empty, or
// why not: then nothing is recorded.
std::string RecordDevice(const RunOptions& options, double current_max_A, int n, OpenedDevice& opened);

}  // namespace omni::daemon
