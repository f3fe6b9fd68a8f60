#include "tests/hil/usb/usb_emulator.h"

#include <errno.h>
#include <linux/usbdevice_fs.h>
#include <sys/ioctl.h>
#include <umockdev.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <utility>

#include "firmware/drivers/usb_descriptors.h"
#include "firmware/wire/frame.h"
#include "firmware/wire/usb_ids.h"
#include "tests/hil/usb/usb_descriptors.h"

namespace omni::hil {
namespace {

namespace usb = drivers::usb;

constexpr const char* kPreload = "libumockdev-preload.so";
constexpr const char* kSysPath = "/sys/devices/omni/usb1/1-1";
constexpr int kDeviceNumberMax = 127;
constexpr std::size_t kSetupSize = 8;
constexpr std::size_t kAnswerMax = 512;  // of endpoint 0: any descriptor, any frame

struct ObjectRelease {
  void operator()(gpointer object) const { g_object_unref(object); }
};
template <class T>
using Held = std::unique_ptr<T, ObjectRelease>;

std::string Hex(const std::vector<std::uint8_t>& bytes) {
  constexpr char kDigits[] = "0123456789ABCDEF";
  std::string text;
  for (const std::uint8_t byte : bytes) {
    text += kDigits[byte >> 4];
    text += kDigits[byte & 15];
  }
  return text;
}

std::string ThreeDigits(int number) {
  std::string text = std::to_string(number);
  return std::string(3 - text.size(), '0') + text;
}

// The device's entry in udev and sysfs. umockdev's own device nodes are plain files, so none is requested (N:).
std::string Describe(int device_number, const std::string& node, const std::string& serial) {
  const std::string number = std::to_string(device_number);
  return std::string("P: ") + (kSysPath + 4) + "\n" +  // without /sys
         "E: SUBSYSTEM=usb\nE: DEVTYPE=usb_device\nE: DRIVER=usb\nE: BUSNUM=001\nE: DEVNUM=" +
         ThreeDigits(device_number) + "\nE: DEVNAME=" + node + "\n" + "A: busnum=1\\n\nA: devnum=" + number +
         "\\n\nA: bConfigurationValue=1\\n\nA: speed=480\\n\n" +
         "A: idVendor=1209\\n\nA: idProduct=0001\\n\nA: product=" + wire::kUsbProductName + "\\n\nA: serial=" + serial +
         "\\n\n" + "H: descriptors=" + Hex(SysfsDescriptors()) + "\n";
}

}  // namespace

struct UsbEmulator::Request {
  std::uint8_t type = 0, request = 0;
  std::uint16_t value = 0, index = 0, length = 0;
};

base::Status EnterMockEnvironment(char** argv) {
  const char* preload = getenv("LD_PRELOAD");
  if (preload != nullptr && std::strstr(preload, kPreload) != nullptr) return base::Ok{};
  std::vector<char*> arguments{const_cast<char*>("umockdev-wrapper")};
  arguments.push_back(const_cast<char*>("/proc/self/exe"));
  const std::string self = std::filesystem::read_symlink("/proc/self/exe").string();
  arguments.back() = const_cast<char*>(self.c_str());
  for (char** argument = argv + 1; *argument != nullptr; ++argument) arguments.push_back(*argument);
  arguments.push_back(nullptr);
  execvp(arguments[0], arguments.data());
  return base::Error{std::string("umockdev-wrapper: ") + std::strerror(errno) +
                     ": install it with scripts/setup all (Debian package umockdev)"};
}

UsbEmulator::Urb::Urb(Data* data, const Client* owner, std::size_t node)
    : data_(umockdev_ioctl_data_ref(data)), owner_(owner), node_(node) {}
UsbEmulator::Urb::Urb(Urb&& other) noexcept
    : data_(std::exchange(other.data_, nullptr)), owner_(other.owner_), node_(other.node_) {}
UsbEmulator::Urb::~Urb() {
  if (data_ != nullptr) umockdev_ioctl_data_unref(data_);
}
usbdevfs_urb& UsbEmulator::Urb::operator*() const { return *reinterpret_cast<usbdevfs_urb*>(data_->data); }
std::uint8_t* UsbEmulator::Urb::buffer() const { return static_cast<std::uint8_t*>((**this).buffer); }
unsigned long UsbEmulator::Urb::client_address() const { return data_->client_addr; }

UsbEmulator::UsbEmulator(UsbFunction& function, std::string serial) : function_(function), serial_(std::move(serial)) {}

base::Result<std::unique_ptr<UsbEmulator>> UsbEmulator::Create(UsbFunction& function, const std::string& serial) {
  std::unique_ptr<UsbEmulator> emulator(new UsbEmulator(function, serial));
  emulator->testbed_ = umockdev_testbed_new();
  if (emulator->testbed_ == nullptr || umockdev_in_mock_environment() == FALSE) {
    return base::Error{"no emulated bus: this program must run under umockdev-wrapper"};
  }
  gchar* const root = umockdev_testbed_get_root_dir(emulator->testbed_);
  emulator->root_ = root;
  g_free(root);
  emulator->handler_ = umockdev_ioctl_base_new();
  g_signal_connect_after(emulator->handler_, "handle-ioctl", G_CALLBACK(&UsbEmulator::OnIoctl), emulator.get());
  g_signal_connect_after(emulator->handler_, "client-vanished", G_CALLBACK(&UsbEmulator::OnVanished), emulator.get());
  return emulator;
}

UsbEmulator::~UsbEmulator() {
  Unplug();
  if (handler_ != nullptr) g_object_unref(handler_);
  if (testbed_ != nullptr) g_object_unref(testbed_);
}

// The node exists before the bus announces it, because the client opens it at once.
base::Status UsbEmulator::Plug() {
  std::string node;
  int number = 0;
  {
    const std::lock_guard lock(mutex_);
    if (plugged_) return base::Ok{};
    if (device_number_ == kDeviceNumberMax) return base::Error{"the emulated bus has no device number left"};
    number = ++device_number_;
    node = device_node_ = "/dev/bus/usb/001/" + ThreeDigits(number);
    base::Result<UsbNode> made = UsbNode::Make(root_ + node);
    if (!made) return base::Error{made.error()};
    nodes_.push_back(std::move(*made));
    plugged_ = true;
    ++counts_.plugged;
  }
  GError* error = nullptr;
  if (umockdev_testbed_attach_ioctl(testbed_, node.c_str(), handler_, &error) == FALSE ||
      umockdev_testbed_add_from_string(testbed_, Describe(number, node, serial_).c_str(), &error) == FALSE) {
    const std::string message = error != nullptr ? error->message : "umockdev gives no reason";
    g_clear_error(&error);
    return base::Error{node + ": " + message};
  }
  return base::Ok{};
}

void UsbEmulator::Unplug() {
  {
    const std::lock_guard lock(mutex_);
    if (!plugged_) return;
    plugged_ = false;
    counts_.aborted += waiting_.size();
    while (!waiting_.empty()) {
      Urb urb = std::move(waiting_.front());
      waiting_.pop_front();
      Finish(std::move(urb), -ESHUTDOWN, 0);
    }
    overtaken_.clear();
    std::filesystem::remove(root_ + device_node_);
  }
  function_.Unplugged();
  umockdev_testbed_uevent(testbed_, kSysPath, "remove");
  umockdev_testbed_remove_device(testbed_, kSysPath);
}

bool UsbEmulator::plugged() const {
  const std::lock_guard lock(mutex_);
  return plugged_;
}

void UsbEmulator::SetFaults(const LinkFaults& to_host, const LinkFaults& to_base) {
  const std::lock_guard lock(mutex_);
  to_host_.SetFaults(to_host);
  to_base_.SetFaults(to_base);
}

UsbCounts UsbEmulator::counts() const {
  const std::lock_guard lock(mutex_);
  return counts_;
}
LinkCounts UsbEmulator::to_host_counts() const {
  const std::lock_guard lock(mutex_);
  return to_host_.counts();
}
LinkCounts UsbEmulator::to_base_counts() const {
  const std::lock_guard lock(mutex_);
  return to_base_.counts();
}

int UsbEmulator::OnIoctl(UMockdevIoctlBase*, UMockdevIoctlClient* client, void* self) {
  return static_cast<UsbEmulator*>(self)->Handle(client) ? TRUE : FALSE;
}

void UsbEmulator::OnVanished(UMockdevIoctlBase*, UMockdevIoctlClient* client, void* self) {
  auto& emulator = *static_cast<UsbEmulator*>(self);
  const std::lock_guard lock(emulator.mutex_);
  const auto its = [client](const Urb& urb) { return urb.owner() == client; };
  emulator.waiting_.remove_if(its);
  emulator.reapable_.remove_if(its);
  emulator.UpdateReady();
}

bool UsbEmulator::IsPresent(Client* client) const {
  const std::lock_guard lock(mutex_);
  return IsPresentLocked(client);
}

// A client of an unplugged device stays disconnected when the device returns, which has another node.
bool UsbEmulator::IsPresentLocked(Client* client) const {
  const gchar* const node = umockdev_ioctl_client_get_devnode(client);
  return plugged_ && node != nullptr && device_node_ == node;
}

// The requests of libusb's Linux back end.
bool UsbEmulator::Handle(Client* client) {
  const unsigned long request = umockdev_ioctl_client_get_request(client);
  Data* const argument = umockdev_ioctl_client_get_arg(client);
  if (request == USBDEVFS_REAPURB || request == USBDEVFS_REAPURBNDELAY) return Reap(client, argument);
  if (!IsPresent(client)) {
    umockdev_ioctl_client_complete(client, -1, ENODEV);
    return true;
  }
  switch (request) {
    case USBDEVFS_GET_CAPABILITIES: {
      const Held<Data> capabilities(umockdev_ioctl_data_resolve(argument, 0, sizeof(std::uint32_t), nullptr));
      if (capabilities == nullptr) return false;
      const std::uint32_t value =
          USBDEVFS_CAP_ZERO_PACKET | USBDEVFS_CAP_NO_PACKET_SIZE_LIM | USBDEVFS_CAP_REAP_AFTER_DISCONNECT;
      std::memcpy(capabilities->data, &value, sizeof value);
      umockdev_ioctl_client_complete(client, 0, 0);
      return true;
    }
    case USBDEVFS_CLAIMINTERFACE:
    case USBDEVFS_RELEASEINTERFACE:
    case USBDEVFS_DISCONNECT_CLAIM:
    case USBDEVFS_SETINTERFACE:
    case USBDEVFS_SETCONFIGURATION:
    case USBDEVFS_CLEAR_HALT:
    case USBDEVFS_RESETEP:
    case USBDEVFS_RESET:
      umockdev_ioctl_client_complete(client, 0, 0);
      return true;
    case USBDEVFS_GETDRIVER:
      umockdev_ioctl_client_complete(client, -1, ENODATA);
      return true;
    case USBDEVFS_SUBMITURB:
      return Submit(client, argument);
    case USBDEVFS_DISCARDURB:
      return Discard(client, argument);
    default:
      umockdev_ioctl_client_complete(client, -1, ENOTTY);
      return true;
  }
}

bool UsbEmulator::Submit(Client* client, Data* argument) {
  const Held<Data> data(umockdev_ioctl_data_resolve(argument, 0, sizeof(usbdevfs_urb), nullptr));
  if (data == nullptr) return false;
  const auto& urb = *reinterpret_cast<const usbdevfs_urb*>(data->data);
  const bool control = urb.type == USBDEVFS_URB_TYPE_CONTROL && urb.buffer_length >= static_cast<int>(kSetupSize);
  const bool out = urb.type == USBDEVFS_URB_TYPE_BULK && urb.endpoint == usb::kEndpointOut && urb.buffer_length >= 0;
  const bool in = urb.type == USBDEVFS_URB_TYPE_BULK && urb.endpoint == usb::kEndpointIn && urb.buffer_length > 0;
  if (!control && !out && !in) {
    umockdev_ioctl_client_complete(client, -1, ENOENT);  // no such endpoint
    return true;
  }
  if (urb.buffer_length > 0) {
    const Held<Data> buffer(umockdev_ioctl_data_resolve(data.get(), offsetof(usbdevfs_urb, buffer),
                                                        static_cast<gsize>(urb.buffer_length), nullptr));
    if (buffer == nullptr) return false;
  }
  bool present = false;
  {
    const std::lock_guard lock(mutex_);
    present = IsPresentLocked(client);
    if (present) Start(Urb(data.get(), client, nodes_.size() - 1));
  }
  umockdev_ioctl_client_complete(client, present ? 0 : -1, present ? 0 : ENODEV);
  return true;
}

void UsbEmulator::Start(Urb urb) {
  if (urb->type == USBDEVFS_URB_TYPE_CONTROL) {
    Control(std::move(urb));
  } else if (urb->endpoint == usb::kEndpointOut) {
    ++counts_.frames_out;
    const auto size = static_cast<std::size_t>(urb->buffer_length);
    to_base_.Pass(Frame(urb.buffer(), urb.buffer() + size),
                  [this](const Frame& frame) { function_.HostFrame(frame.data(), frame.size()); });
    Finish(std::move(urb), 0, size);
  } else {
    waiting_.push_back(std::move(urb));
    PumpLocked();
  }
}

void UsbEmulator::Finish(Urb urb, int status, std::size_t size) {
  urb->status = status;
  urb->actual_length = static_cast<int>(size);
  reapable_.push_back(std::move(urb));
  UpdateReady();
}

// Endpoint 0: setup packet, then data [USB 2.0, 9.3].
void UsbEmulator::Control(Urb urb) {
  const std::uint8_t* setup = urb.buffer();
  const auto word = [setup](std::size_t at) { return static_cast<std::uint16_t>(setup[at] | (setup[at + 1] << 8)); };
  const Request request{setup[0], setup[1], word(2), word(4), word(6)};
  std::uint8_t answer[kAnswerMax];
  const int size = Answer(request, answer);
  if (size < 0) {
    ++counts_.stalls;
    Finish(std::move(urb), -EPIPE, 0);
    return;
  }
  const std::size_t room =
      std::min<std::size_t>(request.length, static_cast<std::size_t>(urb->buffer_length) - kSetupSize);
  const std::size_t given = std::min(room, static_cast<std::size_t>(size));
  std::memcpy(urb.buffer() + kSetupSize, answer, given);
  Finish(std::move(urb), 0, given);
}

// < 0: stall.
int UsbEmulator::Answer(const Request& request, std::uint8_t* answer) {
  constexpr std::uint8_t kTypeMask = 0x60, kVendor = 0x40, kStandard = 0x00;
  constexpr std::uint8_t kGetStatus = 0, kGetDescriptor = 6, kGetConfiguration = 8;
  const auto give = [answer](const std::vector<std::uint8_t>& bytes) {
    std::copy(bytes.begin(), bytes.end(), answer);
    return bytes.empty() ? -1 : static_cast<int>(bytes.size());
  };
  if ((request.type & kTypeMask) == kVendor) {
    ++counts_.vendor_requests;
    if (request.request == usb::kRequestMsOs && request.index == usb::kMsOsDescriptorIndex) {
      return give(MsOsDescriptors());
    }
    return function_.VendorRequest(request.request, request.value, request.index, answer, kAnswerMax);
  }
  if ((request.type & kTypeMask) != kStandard) return -1;
  switch (request.request) {
    case kGetDescriptor:
      return give(Descriptor(request.value, serial_));
    case kGetStatus:
      return give({0, 0});
    case kGetConfiguration:
      return give({usb::kConfigurationValue});
    default:
      return -1;
  }
}

bool UsbEmulator::Reap(Client* client, Data* argument) {
  std::list<Urb> reaped;
  bool gone = false;
  {
    const std::lock_guard lock(mutex_);
    gone = !IsPresentLocked(client);
    const auto its = std::find_if(reapable_.begin(), reapable_.end(),
                                  [client](const Urb& candidate) { return candidate.owner() == client; });
    if (its != reapable_.end()) reaped.splice(reaped.begin(), reapable_, its);
    UpdateReady();
  }
  if (reaped.empty()) {
    umockdev_ioctl_client_complete(client, -1, gone ? ENODEV : EAGAIN);
    return true;
  }
  const Held<Data> pointer(umockdev_ioctl_data_resolve(argument, 0, sizeof(void*), nullptr));
  if (pointer == nullptr) return false;
  umockdev_ioctl_data_set_ptr(pointer.get(), 0, reaped.front().data());
  umockdev_ioctl_client_complete(client, 0, 0);
  return true;
}

bool UsbEmulator::Discard(Client* client, Data* argument) {
  unsigned long address = 0;
  std::memcpy(&address, argument->data, sizeof address);
  bool found = false;
  {
    const std::lock_guard lock(mutex_);
    const auto urb = std::find_if(waiting_.begin(), waiting_.end(), [address, client](const Urb& candidate) {
      return candidate.owner() == client && candidate.client_address() == address;
    });
    if (urb != waiting_.end()) {
      Urb discarded = std::move(*urb);
      waiting_.erase(urb);
      Finish(std::move(discarded), -ENOENT, 0);
      found = true;
    }
  }
  umockdev_ioctl_client_complete(client, found ? 0 : -1, found ? 0 : EINVAL);
  return true;
}

bool UsbEmulator::Pump() {
  const std::lock_guard lock(mutex_);
  return PumpLocked();
}

bool UsbEmulator::PumpLocked() {
  const std::uint64_t before = counts_.frames_in;
  std::uint8_t bytes[wire::kFrameSizeMax];
  while (plugged_ && !waiting_.empty()) {
    if (!overtaken_.empty()) {
      Frame frame = std::move(overtaken_.front());
      overtaken_.pop_front();
      GiveToHost(std::move(frame));
      continue;
    }
    const std::size_t size = function_.NextFrame(bytes, sizeof bytes);
    if (size == 0) break;
    to_host_.Pass(Frame(bytes, bytes + size), [this](Frame frame) { overtaken_.push_back(std::move(frame)); });
  }
  return counts_.frames_in != before;
}

// Precondition: a transfer waits. One that is too small for the frame is a babble.
void UsbEmulator::GiveToHost(Frame frame) {
  Urb urb = std::move(waiting_.front());
  waiting_.pop_front();
  ++counts_.frames_in;
  const bool fits = frame.size() <= static_cast<std::size_t>(urb->buffer_length);
  if (fits) std::memcpy(urb.buffer(), frame.data(), frame.size());
  const std::size_t size = fits ? frame.size() : 0;
  Finish(std::move(urb), fits ? 0 : -EOVERFLOW, size);
}

void UsbEmulator::UpdateReady() {
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    nodes_[i].SetReady(
        std::any_of(reapable_.begin(), reapable_.end(), [i](const Urb& urb) { return urb.node() == i; }));
  }
}

}  // namespace omni::hil
