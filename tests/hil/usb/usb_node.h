// The device node of an emulated USB device. usbfs signals by POLLOUT that a transfer can be reaped; a plain file would
// always do so, and libusb would spin. Hence a FIFO: full: not writable; drained: writable.
#pragma once

#include <string>

#include "service/base/result.h"
#include "service/base/unique_fd.h"

namespace omni::hil {

class UsbNode {
 public:
  // Makes the FIFO `path` and its folders.
  static base::Result<UsbNode> Make(const std::string& path);

  // True: something can be reaped.
  void SetReady(bool ready);

 private:
  explicit UsbNode(base::UniqueFd fd) : fd_(std::move(fd)) {}

  base::UniqueFd fd_;
  bool ready_ = true;
};

}  // namespace omni::hil
