// A base on a port of an emulated computer: QEMU's usb-redir device is the port, its xHCI and the guest's kernel are
// the host, and this end is the cable with the base on it [usbredir protocol 0.7, "usb-host" side]. Endpoint 0 is
// answered by the firmware's own table (firmware/drivers/usb_control.h), bulk transfers go to the UsbFunction.
//
// Nothing here has a thread: Serve() is called every millisecond, as frames of the bus come.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "firmware/drivers/usb_control.h"
#include "service/base/unique_fd.h"
#include "tests/hil/usb/usb_function.h"

// usbredirparser.h stays in redir_port.cc.
struct usbredirparser;
struct usb_redir_bulk_packet_header;
struct usb_redir_control_packet_header;

namespace omni::hil {

struct RedirCounts {
  std::uint64_t frames_in = 0;   // to the host
  std::uint64_t frames_out = 0;  // from the host
  std::uint64_t requests = 0;    // of endpoint 0
  std::uint64_t stalls = 0;
  std::uint64_t cancelled = 0;  // IN transfers that the host cancelled
  std::uint64_t aborted = 0;    // IN transfers in flight when the cable was pulled
  std::uint64_t plugged = 0;
  std::uint64_t refused = 0;  // messages for endpoints that this base does not have
};

class RedirPort {
 public:
  // `socket` leads to QEMU and is not blocking. `function` outlives the port. Nothing is plugged yet. `serial`: at most
  // drivers::usb::kSerialMax characters count.
  RedirPort(base::UniqueFd socket, UsbFunction& function, const std::string& serial);
  ~RedirPort();
  RedirPort(const RedirPort&) = delete;
  RedirPort& operator=(const RedirPort&) = delete;

  // The cable. Plugging waits for the other side's HELLO.
  void Plug();
  void Unplug();

  // Reads the host's messages, and gives waiting frames to waiting IN transfers. No-op once the other side is gone.
  void Serve();

  // True: a host that was fetching frames recently has no IN transfer waiting.
  bool HostIsBehind() const;

  const RedirCounts& counts() const { return counts_; }

 private:
  struct Callbacks;  // usbredirparser's, all of them
  struct Waiting {
    std::uint64_t id = 0;
    std::uint32_t length = 0;
    std::uint32_t stream = 0;
  };

  void Appear();
  void ReportEndpoints();
  void Control(std::uint64_t id, usb_redir_control_packet_header header);
  int Ask(const drivers::usb::Setup& setup, std::uint8_t* data);
  void SetConfiguration(std::uint64_t id, std::uint8_t configuration);
  void SetInterface(std::uint64_t id, std::uint8_t interface, std::uint8_t alternate);
  void Bulk(std::uint64_t id, usb_redir_bulk_packet_header header, const std::uint8_t* data, int size);
  void Cancel(std::uint64_t id);
  void Reset();
  void Pump();
  void FinishIn(const Waiting& waiting, std::uint8_t status, const std::uint8_t* data, std::size_t size);

  base::UniqueFd socket_;
  UsbFunction& function_;
  usbredirparser* parser_;
  drivers::usb::ControlState state_;
  std::deque<Waiting> waiting_;  // IN transfers
  std::int64_t fetched_ns_ = 0;  // the newest of them came
  bool wanted_ = false;          // the cable is plugged in
  bool plugged_ = false;         // and the other side has been notified
  bool greeted_ = false;
  bool closed_ = false;
  RedirCounts counts_;
};

}  // namespace omni::hil
