// Where keys come from: Linux input devices (evdev). Tests put pipes in their place.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "service/base/result.h"
#include "service/config/inputs/input_settings.h"

namespace omni::daemon {

class KeyPorts {
 public:
  virtual ~KeyPorts() = default;
  // Devices that a rule means and that are there now: paths, each device once.
  virtual std::vector<std::string> Find(const config::KeyDeviceRule& rule) = 0;
  // A descriptor that is read without blocking, stamped by CLOCK_MONOTONIC. The error says what to do.
  virtual base::Result<int> Open(const std::string& path, bool grab) = 0;
  // Whether each of `codes` is down now; empty: it cannot be known.
  virtual std::optional<std::vector<bool>> KeysDown(int fd, const std::vector<std::uint16_t>& codes) = 0;
};

// /dev/input/event*. Names are read from /sys, so that a device that nobody asked for is never opened. Reading needs
// the right to the device node and nothing else.
std::unique_ptr<KeyPorts> MakeEvdevPorts();

}  // namespace omni::daemon
