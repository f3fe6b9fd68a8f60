// The USB device driver on its controller's model, with a host on the other end of the cable.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <numeric>
#include <vector>

#include "firmware/drivers/usb_device.h"
#include "tests/support/chips/chipidea_model.h"
#include "tests/support/chips/usb_host.h"

namespace omni::support {

struct UsbHandler {
  void EmergencyStop() noexcept { ++stops; }
  std::size_t WriteHello(std::uint8_t* frame, std::size_t capacity) noexcept {
    for (std::size_t i = 0; i < hello_size && i < capacity; ++i) frame[i] = static_cast<std::uint8_t>(0x40 + i);
    return hello_size;
  }

  int stops = 0;
  std::size_t hello_size = 72;
};

struct UsbBench {
  using Device = drivers::usb::UsbDevice<ChipideaModel, UsbHandler>;
  using Bytes = UsbHost::Bytes;

  explicit UsbBench(unsigned seed = 1) : controller(memory.get(), sizeof *memory, seed) {}

  Bytes Receive() {
    Bytes frame(drivers::usb::kBufferSize);
    frame.resize(device.Receive(frame.data(), frame.size()));
    return frame;
  }
  bool Send(const Bytes& frame) { return device.Send(frame.data(), frame.size()); }

  static Bytes Frame(std::size_t size, int first) {
    Bytes frame(size);
    std::iota(frame.begin(), frame.end(), static_cast<std::uint8_t>(first));
    return frame;
  }

  std::unique_ptr<drivers::usb::UsbMemory> memory = std::make_unique<drivers::usb::UsbMemory>();
  ChipideaModel controller;
  UsbHandler handler;
  Device device{controller, handler, *memory, "0123456789abcdef"};
  UsbHost host{controller, [this] { device.HandleInterrupt(); }};
};

}  // namespace omni::support
