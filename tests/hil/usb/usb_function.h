// The function behind an emulated USB plug: a base, or a test's own.
#pragma once

#include <cstddef>
#include <cstdint>

namespace omni::hil {

class UsbFunction {
 public:
  virtual ~UsbFunction() = default;

  // One OUT transfer of the host, as received. Called on the emulator's own thread.
  virtual void HostFrame(const std::uint8_t* data, std::size_t size) = 0;

  // The next frame to the host, its size; 0: none. Called only while the host waits for one. Any thread, one at a time.
  virtual std::size_t NextFrame(std::uint8_t* frame, std::size_t capacity) = 0;

  // A vendor request of endpoint 0. Returns the bytes of the answer; < 0: unknown (stall). The emulator's own thread.
  virtual int VendorRequest(std::uint8_t request, std::uint16_t value, std::uint16_t index, std::uint8_t* answer,
                            std::size_t capacity) = 0;

  // The cable was pulled: frames waiting for the host are lost.
  virtual void Unplugged() = 0;
};

}  // namespace omni::hil
