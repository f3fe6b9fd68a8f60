// A base on an emulated USB bus: unmodified programs with libusb, started as our children, find, open and talk to it.
// umockdev's preloaded library redirects their system calls here; this class is usbfs and the bus [Linux,
// Documentation/driver-api/usb/usb.rst: "usbfs"]. This process must run under umockdev-wrapper (EnterMockEnvironment).
//
// Requests of the client come on umockdev's own thread, everything else on the caller's; all state has one mutex, which
// is never held while the client's memory is read: a stopped client would block us too.
#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "service/base/result.h"
#include "tests/hil/faulty_link.h"
#include "tests/hil/usb/usb_function.h"
#include "tests/hil/usb/usb_node.h"

// umockdev's header stays in usb_emulator.cc.
// NOLINTBEGIN(bugprone-reserved-identifier): its names
struct _UMockdevTestbed;
struct _UMockdevIoctlBase;
struct _UMockdevIoctlClient;
struct _UMockdevIoctlData;
// NOLINTEND(bugprone-reserved-identifier)
struct usbdevfs_urb;

namespace omni::hil {

// Starts this program again under umockdev-wrapper unless it already runs there. Returns only when that is not needed,
// or with an error.
base::Status EnterMockEnvironment(char** argv);

struct UsbCounts {
  std::uint64_t frames_in = 0;   // to the host
  std::uint64_t frames_out = 0;  // from the host
  std::uint64_t vendor_requests = 0;
  std::uint64_t stalls = 0;
  std::uint64_t plugged = 0;
  std::uint64_t aborted = 0;  // transfers in flight when the cable was pulled
};

class UsbEmulator {
 public:
  // `function` outlives the emulator. Nothing is plugged yet. One emulator in a process.
  static base::Result<std::unique_ptr<UsbEmulator>> Create(UsbFunction& function, const std::string& serial);
  ~UsbEmulator();  // after the client has ended
  UsbEmulator(const UsbEmulator&) = delete;
  UsbEmulator& operator=(const UsbEmulator&) = delete;

  // Appears on the bus, with a device number of its own every time (at most 127). No-op when it is there.
  base::Status Plug();
  // Pulls the cable, with any transfers in flight.
  void Unplug();
  bool plugged() const;

  // Completes waiting IN transfers with waiting frames of the function. Call whenever it may have some. True: the host
  // received one.
  bool Pump();

  // Damage to frames in transit.
  void SetFaults(const LinkFaults& to_host, const LinkFaults& to_base);

  UsbCounts counts() const;
  LinkCounts to_host_counts() const;
  LinkCounts to_base_counts() const;

 private:
  using Client = _UMockdevIoctlClient;
  using Data = _UMockdevIoctlData;
  struct Request;

  // One URB of a client: a reference to umockdev's copy of it.
  class Urb {
   public:
    Urb(Data* data, const Client* owner, std::size_t node);
    Urb(Urb&& other) noexcept;
    Urb& operator=(Urb&&) = delete;
    ~Urb();
    usbdevfs_urb& operator*() const;
    usbdevfs_urb* operator->() const { return &**this; }
    std::uint8_t* buffer() const;
    Data* data() const { return data_; }
    unsigned long client_address() const;
    const Client* owner() const { return owner_; }
    std::size_t node() const { return node_; }

   private:
    Data* data_;
    const Client* owner_;
    std::size_t node_;
  };

  UsbEmulator(UsbFunction& function, std::string serial);

  static int OnIoctl(_UMockdevIoctlBase* handler, Client* client, void* self);
  static void OnVanished(_UMockdevIoctlBase* handler, Client* client, void* self);
  bool Handle(Client* client);
  bool Submit(Client* client, Data* argument);
  bool Reap(Client* client, Data* argument);
  bool Discard(Client* client, Data* argument);
  bool IsPresent(Client* client) const;

  // With the mutex held.
  bool IsPresentLocked(Client* client) const;
  void Start(Urb urb);
  void Finish(Urb urb, int status, std::size_t size);
  void Control(Urb urb);
  int Answer(const Request& request, std::uint8_t* answer);
  bool PumpLocked();
  void GiveToHost(Frame frame);
  void UpdateReady();

  UsbFunction& function_;
  std::string serial_;
  _UMockdevTestbed* testbed_ = nullptr;
  _UMockdevIoctlBase* handler_ = nullptr;
  std::string root_;

  mutable std::mutex mutex_;
  std::vector<UsbNode> nodes_;  // one per plug; the clients of former ones may still hold theirs
  int device_number_ = 0;
  std::string device_node_;
  bool plugged_ = false;
  std::list<Urb> waiting_;      // IN transfers
  std::list<Urb> reapable_;     // finished
  std::list<Frame> overtaken_;  // came out of the cable while no transfer waited
  FaultyLink to_host_{0xFA11}, to_base_{0xFA17};
  UsbCounts counts_;
};

}  // namespace omni::hil
