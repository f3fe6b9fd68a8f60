// Bases on the bus by libusb-1.0: listing, opening, requests of endpoint 0.
#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <utility>

#include "firmware/wire/frame.h"
#include "service/device/base_notes.h"
#include "service/device/usb/libusb_handle.h"
#include "service/device/usb/usb_holders.h"

namespace omni::device {
namespace {

constexpr unsigned kControlTimeout_ms = 500;
constexpr int kControlAttempts = 3;
constexpr std::size_t kPortsMax = 7;  // [USB 3.0, 8.9]
constexpr int kSerialMax = 64;

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

// The serial number that the kernel has read, in sysfs.
std::string SerialInSysfs(const std::string& port) {
  std::ifstream file("/sys/bus/usb/devices/" + port + "/serial");
  std::string serial;
  std::getline(file, serial);
  return PrintableText(serial.data(), std::min<std::size_t>(serial.size(), kSerialMax));
}

std::string SerialOf(libusb_device_handle* handle, std::uint8_t index) {
  std::array<unsigned char, kSerialMax> text{};
  const int size = index == 0 ? 0 : libusb_get_string_descriptor_ascii(handle, index, text.data(), kSerialMax);
  return PrintableText(reinterpret_cast<const char*>(text.data()), static_cast<std::size_t>(std::max(0, size)));
}

class LibusbBus final : public UsbBus {
 public:
  LibusbBus(LibusbContext context, bool realtime) : context_(std::move(context)), realtime_(realtime) {}

  base::Result<std::vector<UsbBase>> List() override {
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
  // Fills `base` if `device` is one.
  static bool Look(libusb_device* device, UsbBase& base) {
    libusb_device_descriptor descriptor{};
    if (libusb_get_device_descriptor(device, &descriptor) != LIBUSB_SUCCESS) return false;
    if (descriptor.idVendor != wire::kUsbVendorId || descriptor.idProduct != wire::kUsbProductId) return false;
    base = {.serial = "", .node = NodeOf(device), .speed = SpeedOf(device), .port = PortOf(device), .problem = ""};
    libusb_device_handle* raw = nullptr;
    const int opened = libusb_open(device, &raw);
    const LibusbHandle handle(raw);
    if (opened == LIBUSB_SUCCESS) {
      base.serial = SerialOf(raw, descriptor.iSerialNumber);
    } else {
      base.problem = LibusbProblem(opened, "open", base.node);
    }
    if (base.serial.empty()) base.serial = SerialInSysfs(base.port);
    return true;
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
