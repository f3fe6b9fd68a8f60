// Bases on the bus by libusb-1.0: listing, opening, requests of endpoint 0.
#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <utility>

#include "firmware/wire/frame.h"
#include "service/device/base_notes.h"
#include "service/device/usb/libusb_handle.h"
#include "service/device/usb/usb_bus.h"

namespace omni::device {
namespace {

constexpr unsigned kControlTimeout_ms = 500;
constexpr int kControlAttempts = 3;
constexpr std::size_t kPortsMax = 7;  // [USB 3.0, 8.9]
constexpr int kTextMax = 64;

struct Found {
  libusb_device* device = nullptr;
  UsbBase base;
};

// The devices of a listing stay referenced as long as this lives.
class DeviceList {
 public:
  explicit DeviceList(libusb_context* context) : count_(libusb_get_device_list(context, &devices_)) {}
  ~DeviceList() {
    if (count_ >= 0) libusb_free_device_list(devices_, 1);
  }
  DeviceList(const DeviceList&) = delete;
  DeviceList& operator=(const DeviceList&) = delete;
  ssize_t count() const { return count_; }
  libusb_device* at(ssize_t i) const { return devices_[i]; }

 private:
  libusb_device** devices_ = nullptr;
  ssize_t count_;
};

// "1-2.3", the name of the device's folder in /sys/bus/usb/devices.
std::string PortOf(libusb_device* device) {
  std::array<std::uint8_t, kPortsMax> ports{};
  const int depth = libusb_get_port_numbers(device, ports.data(), static_cast<int>(ports.size()));
  std::string text = std::to_string(libusb_get_bus_number(device));
  for (int i = 0; i < depth; ++i) {
    text += (i == 0 ? "-" : ".") + std::to_string(ports[static_cast<std::size_t>(i)]);
  }
  return text;
}

std::string NodeOf(libusb_device* device) {
  char node[40];
  std::snprintf(node, sizeof node, "/dev/bus/usb/%03d/%03d", libusb_get_bus_number(device),
                libusb_get_device_address(device));
  return node;
}

const char* SpeedOf(libusb_device* device) {
  switch (libusb_get_device_speed(device)) {
    case LIBUSB_SPEED_LOW:
      return "1.5 Mbit/s";
    case LIBUSB_SPEED_FULL:
      return "12 Mbit/s";
    case LIBUSB_SPEED_HIGH:
      return "480 Mbit/s";
    case LIBUSB_SPEED_SUPER:
      return "5 Gbit/s";
    default:
      return "unknown speed";
  }
}

// A string that the kernel has read, in sysfs: "serial", "product".
std::string TextInSysfs(const std::string& port, const char* name) {
  std::ifstream file("/sys/bus/usb/devices/" + port + "/" + name);
  std::string text;
  std::getline(file, text);
  return PrintableText(text.data(), std::min<std::size_t>(text.size(), kTextMax));
}

std::string TextOf(libusb_device_handle* handle, std::uint8_t index) {
  std::array<unsigned char, kTextMax> text{};
  const int size = index == 0 ? 0 : libusb_get_string_descriptor_ascii(handle, index, text.data(), kTextMax);
  return PrintableText(reinterpret_cast<const char*>(text.data()), static_cast<std::size_t>(std::max(0, size)));
}

// Vendor specific, with one bulk IN and one bulk OUT.
bool IsOurInterface(const libusb_interface_descriptor& interface) {
  if (interface.bInterfaceClass != wire::kUsbInterfaceClass ||
      interface.bInterfaceSubClass != wire::kUsbInterfaceSubclass ||
      interface.bInterfaceProtocol != wire::kUsbInterfaceProtocol || interface.bNumEndpoints != 2) {
    return false;
  }
  int in = 0, out = 0;
  for (const libusb_endpoint_descriptor* end = interface.endpoint; end != interface.endpoint + 2; ++end) {
    const bool bulk = (end->bmAttributes & LIBUSB_TRANSFER_TYPE_MASK) == LIBUSB_TRANSFER_TYPE_BULK;
    ++((end->bEndpointAddress & LIBUSB_ENDPOINT_DIR_MASK) == LIBUSB_ENDPOINT_IN ? in : out);
    if (!bulk) return false;
  }
  return in == 1 && out == 1;
}

bool HasOurInterface(libusb_device* device) {
  libusb_config_descriptor* config = nullptr;
  if (libusb_get_active_config_descriptor(device, &config) != LIBUSB_SUCCESS &&
      libusb_get_config_descriptor(device, 0, &config) != LIBUSB_SUCCESS) {
    return false;
  }
  bool ours = false;
  for (const libusb_interface* one = config->interface; one != config->interface + config->bNumInterfaces; ++one) {
    for (int k = 0; k < one->num_altsetting; ++k) ours = ours || IsOurInterface(one->altsetting[k]);
  }
  libusb_free_config_descriptor(config);
  return ours;
}

class LibusbBus final : public UsbBus {
 public:
  LibusbBus(LibusbContext context, bool realtime) : context_(std::move(context)), realtime_(realtime) {}

  base::Result<std::vector<UsbBase>> ListBases() override {
    const DeviceList devices(context_.get());
    if (devices.count() < 0) {
      return base::Error{LibusbProblem(static_cast<int>(devices.count()), "list devices", "/dev/bus/usb")};
    }
    std::vector<UsbBase> bases;
    for (ssize_t i = 0; i < devices.count(); ++i) {
      UsbBase base;
      if (Look(devices.at(i), base)) bases.push_back(std::move(base));
    }
    std::sort(bases.begin(), bases.end(), [](const UsbBase& a, const UsbBase& b) { return a.port < b.port; });
    return bases;
  }

  base::Result<std::unique_ptr<UsbLink>> Open(const UsbBase& base) override {
    base::Result<LibusbHandle> handle = OpenNode(base.node);
    if (!handle.ok()) return base::Error{handle.error()};
    return MakeLibusbLink(context_, std::move(*handle), base.node, realtime_);
  }

  base::Status ControlOut(const UsbBase& base, wire::UsbRequest request, std::uint16_t value) override {
    const auto answer = Control(base, wire::kUsbRequestTypeOut, request, value, 0);
    if (!answer.ok()) return base::Error{answer.error()};
    return base::Ok{};
  }

  base::Result<std::vector<std::uint8_t>> ControlIn(const UsbBase& base, wire::UsbRequest request) override {
    return Control(base, wire::kUsbRequestTypeIn, request, 0, wire::kFrameSizeMax);
  }

 private:
  // Fills `base` if `device` is one: by number, interface and product string, as far as they can be read. Nothing is
  // written to a device that is not.
  static bool Look(libusb_device* device, UsbBase& base) {
    libusb_device_descriptor descriptor{};
    if (libusb_get_device_descriptor(device, &descriptor) != LIBUSB_SUCCESS) return false;
    if (descriptor.idVendor != wire::kUsbVendorId || descriptor.idProduct != wire::kUsbProductId) return false;
    if (!HasOurInterface(device)) return false;
    base = {.serial = "", .node = NodeOf(device), .speed = SpeedOf(device), .port = PortOf(device), .problem = ""};
    std::string product;
    libusb_device_handle* raw = nullptr;
    const int opened = libusb_open(device, &raw);
    const LibusbHandle handle(raw);
    if (opened == LIBUSB_SUCCESS) {
      base.serial = TextOf(raw, descriptor.iSerialNumber);
      product = TextOf(raw, descriptor.iProduct);
    } else {
      base.problem = LibusbProblem(opened, "open", base.node);
    }
    if (base.serial.empty()) base.serial = TextInSysfs(base.port, "serial");
    if (product.empty()) product = TextInSysfs(base.port, "product");
    return product.empty() || product == wire::kUsbProductName;
  }

  base::Result<LibusbHandle> OpenNode(const std::string& node) const {
    const DeviceList devices(context_.get());
    for (ssize_t i = 0; i < devices.count(); ++i) {
      if (NodeOf(devices.at(i)) != node) continue;
      libusb_device_handle* raw = nullptr;
      const int opened = libusb_open(devices.at(i), &raw);
      if (opened != LIBUSB_SUCCESS) return base::Error{LibusbProblem(opened, "open", node)};
      return LibusbHandle(raw);
    }
    return base::Error{node + " is gone: was it unplugged?"};
  }

  base::Result<std::vector<std::uint8_t>> Control(const UsbBase& base, std::uint8_t type, wire::UsbRequest request,
                                                  std::uint16_t value, std::size_t size) const {
    const base::Result<LibusbHandle> handle = OpenNode(base.node);
    if (!handle.ok()) return base::Error{handle.error()};
    std::vector<std::uint8_t> answer(size);
    int got = LIBUSB_ERROR_INTERRUPTED;
    for (int i = 0; i < kControlAttempts && got == LIBUSB_ERROR_INTERRUPTED; ++i) {
      got = libusb_control_transfer(handle->get(), type, static_cast<std::uint8_t>(request), value, 0, answer.data(),
                                    static_cast<std::uint16_t>(size), kControlTimeout_ms);
    }
    if (got < 0) {
      return base::Error{
          LibusbProblem(got, "answer vendor request " + std::to_string(static_cast<int>(request)), base.node)};
    }
    answer.resize(static_cast<std::size_t>(got));
    return answer;
  }

  LibusbContext context_;
  bool realtime_;
};

}  // namespace

std::string LibusbProblem(int error, const std::string& what, const std::string& node) {
  switch (error) {
    case LIBUSB_ERROR_ACCESS:
      return UsbPermissionHelp(node);
    case LIBUSB_ERROR_BUSY: {
      const std::string holders = HoldersText(HoldersOf(node));
      return "another program holds " + node + ": " +
             (holders.empty() ? "a process of another user (find it with `sudo fuser -v " + node + "`)" : holders) +
             "; stop it first";
    }
    case LIBUSB_ERROR_NO_DEVICE:
    case LIBUSB_ERROR_NOT_FOUND:
      return node + " is gone: was it unplugged?";
    case LIBUSB_ERROR_PIPE:
      return node + ": refuses to " + what + "; its firmware is older than this program (omni device flash-help)";
    default:
      break;
  }
  return node + ": cannot " + what + " (" + libusb_error_name(error) + "); reconnect it, preferably without a hub";
}

base::Result<std::unique_ptr<UsbBus>> MakeUsbBus(bool realtime) {
  libusb_context* raw = nullptr;
  const int made = libusb_init(&raw);
  if (made != LIBUSB_SUCCESS) {
    return base::Error{std::string("USB is not available (libusb_init: ") + libusb_error_name(made) +
                       "): check that /dev/bus/usb exists"};
  }
  return std::unique_ptr<UsbBus>(
      std::make_unique<LibusbBus>(LibusbContext(raw, [](libusb_context* context) { libusb_exit(context); }), realtime));
}

}  // namespace omni::device
