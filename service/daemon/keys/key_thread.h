// Reads keyboards and foot pedals that the user has named (config::InputSettings): one thread, waiting for events,
// which searches once a second for devices that are missing or have come back. Only mapped keys are passed on.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "service/base/result.h"
#include "service/base/threads/realtime_threads.h"
#include "service/config/inputs/input_settings.h"
#include "service/daemon/keys/key_book.h"

namespace omni::daemon {

// Where keys come from: Linux input devices (evdev). Tests use pipes instead.
class KeyPorts {
 public:
  virtual ~KeyPorts() = default;
  // Present devices that match a rule: paths, each device once.
  virtual std::vector<std::string> FindDevices(const config::KeyDeviceRule& rule) = 0;
  // A non-blocking descriptor with CLOCK_MONOTONIC time stamps. The error says what to do.
  virtual base::Result<int> Open(const std::string& path, bool grab) = 0;
  // Whether each of `codes` is down now; empty: it cannot be known.
  virtual std::optional<std::vector<bool>> KeysDown(int fd, const std::vector<std::uint16_t>& codes) = 0;
};

// /dev/input/event*. Names are read from /sys, so that only requested devices are opened. Needs read permission for the
// device node and nothing else.
std::unique_ptr<KeyPorts> MakeEvdevPorts();

struct KeyThreadOptions {
  std::vector<config::KeyDeviceRule> devices;
  std::vector<std::uint16_t> codes;  // of key source i
  int search_ms = 1000;
};

class KeyThread {
 public:
  // Called on the thread when a key of ours has changed. Must be short.
  using Changed = std::function<void(const base::KeyStates&)>;

  KeyThread(KeyThreadOptions options, std::unique_ptr<KeyPorts> ports, Changed changed);
  ~KeyThread();  // stops; closes all
  KeyThread(const KeyThread&) = delete;
  KeyThread& operator=(const KeyThread&) = delete;

  struct DeviceStatus {
    std::string rule;     // path or name as written
    std::string paths;    // of what is being read, separated by spaces; empty: nothing
    std::string problem;  // why not; empty: the device is not there
  };
  std::vector<DeviceStatus> Status() const;  // any thread

 private:
  struct Port {
    int fd = -1;
    std::size_t rule = 0;
    std::string path;
    KeyDecoder decoder;
  };
  void Run();
  void Search();
  void OpenPort(std::size_t rule, const std::string& path);
  void ReadPort(int index);
  void RequestAllKeys(int index, std::int64_t now_ns, bool& changed);
  void ClosePort(int index);
  void Report(std::size_t rule, const std::string& problem);
  void UpdateStatus();

  const KeyThreadOptions options_;
  const std::unique_ptr<KeyPorts> ports_;
  const Changed changed_;
  KeyBook book_;
  std::array<Port, kMaxKeyDevicesOpen> open_;
  std::vector<std::string> problems_;  // one per rule, of the thread
  int wake_ = -1;                      // eventfd: the end
  mutable base::PriorityMutex status_mutex_;
  std::vector<DeviceStatus> status_;
  std::thread thread_;
};

}  // namespace omni::daemon
