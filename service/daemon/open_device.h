// The devices that omnid can open: one row each, found by what --device says.
#pragma once

#include <memory>
#include <string>

#include "service/base/result.h"
#include "service/daemon/run.h"
#include "service/device/recording_transport.h"
#include "service/device/replay_transport.h"
#include "service/device/transport.h"

namespace omni::daemon {

struct OpenedDevice {
  std::unique_ptr<device::Transport> transport;
  const device::ReplayTransport* replay = nullptr;  // within `transport`, if it is one
  device::RecordingTransport* recording = nullptr;  // within `transport`, if it is recorded
};

// Empty, or which devices there are: for the command line.
std::string CheckDeviceName(const std::string& device);

bool IsReplay(const std::string& device);

// Which base it will be, before it is opened: calibrations belong to a serial.
base::Result<std::string> DeviceSerial(const RunOptions& options);

base::Result<OpenedDevice> OpenDevice(const RunOptions& options);

// Has `opened` written to options.record_device_path, from its next scan on. The n-th device that omnid opens (after
// the one before was lost) gets ".n" behind the path, so that no recording is overwritten by the next one. Empty, or
// why not: then nothing is recorded.
std::string RecordDevice(const RunOptions& options, double current_max_A, int n, OpenedDevice& opened);

}  // namespace omni::daemon
