// One opened base: its interface claimed, IN transfers always in flight, OUT transfers when there is something to send,
// all on a thread of its own.
//
// The thread waits in its own poll(), not in libusb's, so that Wake() is one write to an eventfd;
// libusb_interrupt_event_handler() would take libusb's locks in the tick.
#include <poll.h>
#include <pthread.h>
#include <sched.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <thread>
#include <utility>
#include <vector>

#include "firmware/wire/frame.h"
#include "service/base/clock.h"
#include "service/base/threads/realtime_threads.h"
#include "service/device/usb/libusb_handle.h"
#include "service/device/usb/ready_event.h"

namespace omni::device {
namespace {

constexpr std::size_t kInTransfers = 8;   // 8 ms of telemetry may wait in the kernel while this thread does not run
constexpr std::size_t kOutTransfers = 2;  // one on the bus, one behind it; newer commands replace each other meanwhile
constexpr std::size_t kBufferSize = 512;  // a multiple of every packet size: no babble; a frame is shorter
constexpr int kFailuresMax = 16;          // in a row
constexpr int kPoll_ms = 50;
constexpr std::int64_t kLastWords_ns = 20'000'000;  // for set-points in flight when the link closes
constexpr std::int64_t kCancel_ns = 1'000'000'000;  // for the kernel to return transfers
constexpr int kPriority = 81;                       // above the tick, which waits for its scans

struct Endpoints {
  int interface = -1;
  std::uint8_t in = 0, out = 0;
  std::uint16_t out_packet = 0;
};

bool IsBulk(const libusb_endpoint_descriptor& endpoint) {
  return (endpoint.bmAttributes & LIBUSB_TRANSFER_TYPE_MASK) == LIBUSB_TRANSFER_TYPE_BULK;
}

// The endpoints of one interface's descriptor; false: not an Omni interface.
bool Match(const libusb_interface_descriptor& descriptor, Endpoints& found) {
  if (descriptor.bInterfaceClass != wire::kUsbInterfaceClass ||
      descriptor.bInterfaceSubClass != wire::kUsbInterfaceSubclass ||
      descriptor.bInterfaceProtocol != wire::kUsbInterfaceProtocol) {
    return false;
  }
  found = {.interface = descriptor.bInterfaceNumber};
  for (int i = 0; i < descriptor.bNumEndpoints; ++i) {
    const libusb_endpoint_descriptor& endpoint = descriptor.endpoint[i];
    if (!IsBulk(endpoint)) continue;
    if ((endpoint.bEndpointAddress & LIBUSB_ENDPOINT_IN) != 0) {
      found.in = endpoint.bEndpointAddress;
    } else {
      found.out = endpoint.bEndpointAddress;
      found.out_packet = endpoint.wMaxPacketSize;
    }
  }
  return found.in != 0 && found.out != 0 && found.out_packet != 0;
}

base::Result<Endpoints> FindEndpoints(libusb_device* device, const std::string& node) {
  libusb_config_descriptor* config = nullptr;
  const int got = libusb_get_active_config_descriptor(device, &config);
  if (got != LIBUSB_SUCCESS) return base::Error{LibusbProblem(got, "read its descriptors", node)};
  Endpoints found;
  bool matched = false;
  for (int i = 0; i < config->bNumInterfaces && !matched; ++i) {
    const libusb_interface& interface = config->interface[i];
    matched = interface.num_altsetting > 0 && Match(interface.altsetting[0], found);
  }
  libusb_free_config_descriptor(config);
  if (matched) return found;
  return base::Error{node +
                     " has Omni's USB ID but not its interface (vendor specific, bulk in and out): another "
                     "device, or the wrong firmware (omni device flash-help)"};
}

class LibusbLink;

struct Transfer {
  LibusbLink* link = nullptr;
  libusb_transfer* transfer = nullptr;
  bool in_flight = false;
  std::array<unsigned char, kBufferSize> buffer{};

  Transfer() = default;
  Transfer(const Transfer&) = delete;
  Transfer& operator=(const Transfer&) = delete;
  ~Transfer() { libusb_free_transfer(transfer); }
};

struct Transfers {
  std::array<Transfer, kInTransfers> in;
  std::array<Transfer, kOutTransfers> out;
};

class LibusbLink final : public UsbLink {
 public:
  LibusbLink(LibusbContext context, LibusbHandle handle, const Endpoints& endpoints, bool realtime)
      : context_(std::move(context)), handle_(std::move(handle)), endpoints_(endpoints), realtime_(realtime) {}

  ~LibusbLink() override {
    stop_.store(true, std::memory_order_release);
    wake_.Signal();
    if (thread_.joinable()) thread_.join();
    if (watching_) libusb_hotplug_deregister_callback(context_.get(), hotplug_);
    // A transfer that the kernel does not return may still be written to: better leaked than freed.
    if (AnyInFlight()) [[maybe_unused]]
      auto* const leaked = transfers_.release();
    libusb_release_interface(handle_.get(), endpoints_.interface);
  }

  base::Status Start(UsbHandler& handler) override {
    handler_ = &handler;
    if (!wake_.valid()) return base::Error{"no file descriptor left for an eventfd: raise the limit of open files"};
    if (!Allocate()) return base::Error{"no memory for USB transfers"};
    WatchHotplug();
    if (const base::Status watched = CollectDescriptors(); !watched.ok()) return watched;
    thread_ = std::thread([this] { Run(); });
    return base::Ok{};
  }

  void Wake() noexcept override { wake_.Signal(); }

 private:
  bool Allocate() {
    transfers_ = std::make_unique<Transfers>();
    const auto allocate = [this](Transfer& one) {
      one.link = this;
      one.transfer = libusb_alloc_transfer(0);
      return one.transfer != nullptr;
    };
    for (Transfer& one : transfers_->in) {
      if (!allocate(one)) return false;
    }
    for (Transfer& one : transfers_->out) {
      if (!allocate(one)) return false;
    }
    return true;
  }

  void WatchHotplug() {
    if (libusb_has_capability(LIBUSB_CAP_HAS_HOTPLUG) == 0) return;  // an unplugged base then fails its transfers
    watching_ = libusb_hotplug_register_callback(context_.get(), LIBUSB_HOTPLUG_EVENT_DEVICE_LEFT, 0,
                                                 wire::kUsbVendorId, wire::kUsbProductId, LIBUSB_HOTPLUG_MATCH_ANY,
                                                 &LibusbLink::OnLeft, this, &hotplug_) == LIBUSB_SUCCESS;
  }

  base::Status CollectDescriptors() {
    const libusb_pollfd** fds = libusb_get_pollfds(context_.get());
    if (fds == nullptr) return base::Error{"libusb provides no file descriptors to poll"};
    polled_ = {pollfd{wake_.fd(), POLLIN, 0}};
    for (const libusb_pollfd** fd = fds; *fd != nullptr; ++fd) polled_.push_back({(*fd)->fd, (*fd)->events, 0});
    libusb_free_pollfds(fds);
    return base::Ok{};
  }

  void Run() noexcept {
    const base::RealtimeThread named("omni-usb");
    const sched_param parameters{kPriority};
    if (realtime_) pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters);  // the tick reports a refusal
    while (!stop_.load(std::memory_order_acquire) && !gone_) {
      SubmitIn();
      SubmitOut();
      if (!gone_) Await(kPoll_ms);
    }
    if (gone_) {
      handler_->OnGone();
    } else {
      SubmitOut();
    }
    Finish();
  }

  // Waits for libusb's descriptors or Wake, then lets libusb call back.
  void Await(int timeout_ms) noexcept {
    if (poll(polled_.data(), polled_.size(), timeout_ms) < 0 && errno == EINTR) Interrupted();
    wake_.Clear();
    timeval now{0, 0};
    if (libusb_handle_events_timeout_completed(context_.get(), &now, nullptr) == LIBUSB_ERROR_INTERRUPTED) {
      Interrupted();
    }
  }

  void Finish() noexcept {
    const std::int64_t words_ns = base::MonotonicNow_ns() + kLastWords_ns;
    finishing_ = true;
    while (!gone_ && AnyInFlight(transfers_->out) && base::MonotonicNow_ns() < words_ns) Await(1);
    for (Transfer& one : transfers_->in) Cancel(one);
    for (Transfer& one : transfers_->out) Cancel(one);
    const std::int64_t cancel_ns = base::MonotonicNow_ns() + kCancel_ns;
    while (AnyInFlight() && base::MonotonicNow_ns() < cancel_ns) Await(1);
  }

  static void Cancel(Transfer& one) noexcept {
    if (one.in_flight) libusb_cancel_transfer(one.transfer);  // a finished one returns anyway
  }

  template <class Array>
  static bool AnyInFlight(const Array& transfers) noexcept {
    for (const Transfer& one : transfers) {
      if (one.in_flight) return true;
    }
    return false;
  }
  bool AnyInFlight() const noexcept {
    return transfers_ != nullptr && (AnyInFlight(transfers_->in) || AnyInFlight(transfers_->out));
  }

  void SubmitIn() noexcept {
    if (halted_) {
      libusb_clear_halt(handle_.get(), endpoints_.in);  // waits, but there is nothing to miss
      libusb_clear_halt(handle_.get(), endpoints_.out);
      halted_ = false;
    }
    for (Transfer& one : transfers_->in) {
      if (one.in_flight || gone_) continue;
      libusb_fill_bulk_transfer(one.transfer, handle_.get(), endpoints_.in, one.buffer.data(), kBufferSize,
                                &LibusbLink::OnIn, &one, 0);
      Submit(one);
    }
  }

  void SubmitOut() noexcept {
    for (Transfer& one : transfers_->out) {
      if (one.in_flight || gone_) continue;
      const std::size_t size = handler_->NextFrame(base::MonotonicNow_ns(), one.buffer.data(), wire::kFrameSizeMax);
      if (size == 0) return;
      libusb_fill_bulk_transfer(one.transfer, handle_.get(), endpoints_.out, one.buffer.data(), static_cast<int>(size),
                                &LibusbLink::OnOut, &one, 0);
      // A frame that fills its last packet needs a zero-length packet, or the base would wait for more.
      const bool full = size % endpoints_.out_packet == 0;
      one.transfer->flags = full ? std::uint8_t{LIBUSB_TRANSFER_ADD_ZERO_PACKET} : std::uint8_t{0};
      if (!Submit(one)) handler_->OnSendFailed();
    }
  }

  bool Submit(Transfer& one) noexcept {
    const int submitted = libusb_submit_transfer(one.transfer);
    one.in_flight = submitted == LIBUSB_SUCCESS;
    if (submitted == LIBUSB_ERROR_NO_DEVICE) gone_ = true;
    if (!one.in_flight && !gone_) Failed();
    return one.in_flight;
  }

  void Interrupted() noexcept {
    if (!finishing_) handler_->OnInterrupted();
  }

  void Failed() noexcept {
    Interrupted();
    if (++failures_ >= kFailuresMax) gone_ = true;
  }

  // Handles the end of a transfer; true: it succeeded.
  bool Completed(Transfer& one) noexcept {
    one.in_flight = false;
    switch (one.transfer->status) {
      case LIBUSB_TRANSFER_COMPLETED:
        failures_ = 0;
        return true;
      case LIBUSB_TRANSFER_CANCELLED:
        return false;
      case LIBUSB_TRANSFER_NO_DEVICE:
        gone_ = true;
        return false;
      case LIBUSB_TRANSFER_STALL:
        halted_ = true;
        break;
      case LIBUSB_TRANSFER_ERROR:
      case LIBUSB_TRANSFER_TIMED_OUT:
      case LIBUSB_TRANSFER_OVERFLOW:
        break;
    }
    Failed();
    return false;
  }

  static void LIBUSB_CALL OnIn(libusb_transfer* transfer) noexcept {
    Transfer& one = *static_cast<Transfer*>(transfer->user_data);
    LibusbLink& link = *one.link;
    if (!link.Completed(one) || link.finishing_ || link.gone_) return;
    link.handler_->OnFrame(one.buffer.data(), static_cast<std::size_t>(transfer->actual_length),
                           base::MonotonicNow_ns());
    link.Submit(one);
  }

  static void LIBUSB_CALL OnOut(libusb_transfer* transfer) noexcept {
    Transfer& one = *static_cast<Transfer*>(transfer->user_data);
    LibusbLink& link = *one.link;
    const bool whole = link.Completed(one) && transfer->actual_length == transfer->length;
    if (!whole && !link.finishing_ && !link.gone_) link.handler_->OnSendFailed();
  }

  static int LIBUSB_CALL OnLeft(libusb_context* /*context*/, libusb_device* device, libusb_hotplug_event /*event*/,
                                void* user_data) noexcept {
    auto& link = *static_cast<LibusbLink*>(user_data);
    if (device == libusb_get_device(link.handle_.get())) link.gone_ = true;
    return 0;
  }

  // In reverse order of destruction.
  LibusbContext context_;
  LibusbHandle handle_;
  Endpoints endpoints_;
  bool realtime_;
  UsbHandler* handler_ = nullptr;
  ReadyEvent wake_;
  std::vector<pollfd> polled_;  // wake_ first
  std::unique_ptr<Transfers> transfers_;
  libusb_hotplug_callback_handle hotplug_ = 0;
  bool watching_ = false;
  std::atomic<bool> stop_{false};
  std::thread thread_;

  // The thread's.
  bool gone_ = false;
  bool halted_ = false;
  bool finishing_ = false;  // the handler is not called any more
  int failures_ = 0;        // in a row
};

}  // namespace

base::Result<std::unique_ptr<UsbLink>> MakeLibusbLink(LibusbContext context, LibusbHandle handle,
                                                      const std::string& node, bool realtime) {
  base::Result<Endpoints> endpoints = FindEndpoints(libusb_get_device(handle.get()), node);
  if (!endpoints.ok()) return base::Error{endpoints.error()};
  libusb_set_auto_detach_kernel_driver(handle.get(), 1);  // in case a test driver is bound to the vendor interface
  const int claimed = libusb_claim_interface(handle.get(), endpoints->interface);
  if (claimed != LIBUSB_SUCCESS) return base::Error{LibusbProblem(claimed, "claim its interface", node)};
  return std::unique_ptr<UsbLink>(
      std::make_unique<LibusbLink>(std::move(context), std::move(handle), *endpoints, realtime));
}

}  // namespace omni::device
