// Where keys come from: Linux input devices (evdev). Tests use pipes instead.
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
  // Present devices that match a rule: paths, each device once.
  virtual std::vector<std::string> Find(const config::KeyDeviceRule& rule) = 0;
  // A non-blocking descriptor with CLOCK_MONOTONIC time stamps. The error says what to do.
  virtual base::Result<int> Open(const std::string& path, bool grab) = 0;
  // Whether each of `codes` is down now; empty: it cannot be known.
  virtual std::optional<std::vector<bool>> KeysDown(int fd, const std::vector<std::uint16_t>& codes) = 0;
};

// /dev/input/event*. Names are read from /sys, so that only requested devices are opened. Needs read permission for the
// device node and nothing else.
std::unique_ptr<KeyPorts> MakeEvdevPorts();

}  // namespace omni::daemon
