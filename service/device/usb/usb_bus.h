// The USB functions that this module needs: list bases, open one as a pipe of frames, and send vendor requests to
// endpoint 0. MakeUsbBus() uses libusb; tests have a bus of their own.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "firmware/wire/usb_ids.h"
#include "service/base/result.h"

namespace omni::device {

// Events of an opened base. Every call comes from the link's own thread, one after another.
class UsbHandler {
 public:
  virtual ~UsbHandler() = default;
  // One IN transfer as received. `data` is valid during the call.
  virtual void OnFrame(const std::uint8_t* data, std::size_t size, std::int64_t t_ns) noexcept = 0;
  // The next frame to send, its size; 0: nothing now. Called while there is a free OUT transfer: after every IN
  // transfer, every Wake and at least every 50 ms.
  virtual std::size_t NextFrame(std::int64_t t_ns, std::uint8_t* frame, std::size_t capacity) noexcept = 0;
  // The frame of an earlier NextFrame did not reach the device completely.
  virtual void OnSendFailed() noexcept = 0;
  // A call was interrupted, or a transfer failed and was restarted.
  virtual void OnInterrupted() noexcept = 0;
  // The device is gone, or fails persistently. The last call.
  virtual void OnGone() noexcept = 0;
};

class UsbLink {
 public:
  // No call of the handler after this.
  virtual ~UsbLink() = default;
  // Once. `handler` outlives the link.
  virtual base::Status Start(UsbHandler& handler) = 0;
  // Any thread: makes the link call NextFrame soon. Never waits, allocates nothing, takes no lock.
  virtual void Wake() noexcept = 0;
};

// One base on the bus.
struct UsbBase {
  std::string serial;   // empty: it has none, or none that we may read
  std::string node;     // "/dev/bus/usb/001/005"
  std::string speed;    // "480 Mbit/s"
  std::string port;     // "1-2.3", as in /sys/bus/usb/devices
  std::string problem;  // why it cannot be opened, with the remedy; empty: it can
};

class UsbBus {
 public:
  virtual ~UsbBus() = default;
  // By VID:PID, in the order of their ports.
  virtual base::Result<std::vector<UsbBase>> ListBases() = 0;
  // Claims the vendor interface. An error names the process that holds it.
  virtual base::Result<std::unique_ptr<UsbLink>> Open(const UsbBase& base) = 0;
  // Vendor request without data; works while another program holds the interface.
  virtual base::Status ControlOut(const UsbBase& base, wire::UsbRequest request, std::uint16_t value) = 0;
  // Vendor request that answers with at most wire::kFrameSizeMax bytes; as above.
  virtual base::Result<std::vector<std::uint8_t>> ControlIn(const UsbBase& base, wire::UsbRequest request) = 0;
};

// libusb-1.0 with a context of its own. `realtime`: the thread of an opened link requests SCHED_FIFO; refusal is fine.
base::Result<std::unique_ptr<UsbBus>> MakeUsbBus(bool realtime);

// The base with this serial, or the only one if `serial` is empty. Errors: none, several, none with that serial.
base::Result<UsbBase> ChooseUsbBase(const std::vector<UsbBase>& bases, const std::string& serial);

// "usb base A17" for messages; the port when it has no serial.
std::string UsbBaseName(const UsbBase& base);

// What to do when permission to open a node is missing: names the udev rule and udevadm.
std::string UsbPermissionHelp(const std::string& node);

// Which processes have a device node open, for messages.
struct Holder {
  int pid = 0;
  std::string name;
};

// Except this process. Other users' processes are visible to root only. `proc`: where /proc is.
std::vector<Holder> HoldersOf(const std::string& node, const std::string& proc = "/proc");

// "omnid (pid 12), omni (pid 15)"; empty: none visible.
std::string HoldersText(const std::vector<Holder>& holders);

}  // namespace omni::device
