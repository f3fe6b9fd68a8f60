// Opens the device, runs the loop on it, and opens it again when it was lost.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "service/base/device_geometry.h"
#include "service/daemon/devices/attached_device.h"
#include "service/daemon/devices/magnet_book.h"
#include "service/daemon/devices/open_device.h"
#include "service/daemon/end_watch.h"
#include "service/daemon/run.h"
#include "service/loop/tick_config.h"
#include "service/loop/tick_thread.h"

namespace omni::daemon {

// Main thread. Everything handed over outlives it.
class DeviceKeeper {
 public:
  DeviceKeeper(const RunOptions& options, const base::DeviceGeometry& device, loop::TickSink& sink,
               AttachedDevice& attached, EndWatch& end);
  ~DeviceKeeper();
  DeviceKeeper(const DeviceKeeper&) = delete;
  DeviceKeeper& operator=(const DeviceKeeper&) = delete;

  // False: it cannot be opened now. A lost device may come back; a rejected replay never will.
  bool Open();
  // Ten times a second; opens a lost device again. False: a replay has ended.
  bool Poll();

 private:
  struct Session;
  loop::TickConfig Calibrated(const std::string& serial);
  void WatchRoom();
  void SetRoom();
  void WatchFit();
  void WatchHost();
  void Record(const RunOptions& options, OpenedDevice& opened);
  void WatchRecording();
  void LogFaults();
  void Close(const std::string& why);

  const RunOptions& options_;
  const base::DeviceGeometry& device_;
  loop::TickSink& sink_;
  AttachedDevice& attached_;
  EndWatch& end_;
  MagnetBook magnets_;
  std::unique_ptr<Session> session_;
  std::string calibration_path_;                  // in use; empty: nominal geometry
  std::optional<base::Calibration> calibration_;  // in use
  bool never_calibrated_ = false;                 // there is no file, nor was one refused
  std::string reported_;                          // the last error logged, not repeated every second
  int polls_ = 0;                                 // since it was lost
};

}  // namespace omni::daemon
