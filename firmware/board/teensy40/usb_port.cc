#include "firmware/board/teensy40/usb_port.h"

namespace omni::board {
namespace {

// RM USB PHY.
constexpr std::uint32_t kSoftReset = 1U << 31, kClockGate = 1U << 30;
constexpr std::uint32_t kControllerReset = 1U << 1, kModeMask = 3U;
constexpr std::uint32_t kBursts = 0x0404;
constexpr std::uint32_t kLeave_us = 25'000;

// Shared by the controller and the processor, hence not in cached memory. Start-up code clears it.
#ifdef TEENSYDUINO  // its on-chip RAM is cached, its ordinary variables are not
drivers::usb::UsbMemory g_usb_memory;
#else
__attribute__((section(".shared"))) drivers::usb::UsbMemory g_usb_memory;
#endif

void LeaveTheBootLoadersSession() noexcept {
  if ((RegisterAt(kUsb1Mode) & kModeMask) == 0) return;
  usbphy1().CTRL.set = kSoftReset;
  RegisterAt(kUsb1Command) |= kControllerReset;
  BusyWait(kLeave_us);
  usbphy1().CTRL.clear = kSoftReset;
}

}  // namespace

std::size_t UsbPort::Handler::WriteHello(std::uint8_t* frame, std::size_t capacity) noexcept {
  wire::Hello hello;
  hello.firmware_version = settings.firmware_version;
  hello.capabilities = settings.capabilities;
  for (std::size_t i = 0; i < sizeof hello.serial; ++i) hello.serial[i] = settings.serial[i];
  hello.field_lsb_T = settings.field_lsb_T;
  hello.field_full_scale = settings.field_full_scale;
  hello.current_max_A = settings.current_max_A;
  return wire::Encode(hello, 0, 0, frame, capacity).size;
}

UsbPort::UsbPort(const firmware::Settings& settings) noexcept
    : handler_{settings}, device_(bus_, handler_, g_usb_memory, settings.serial) {}

void UsbPort::Start() noexcept {
  analog().PMU_REG_3P0.value = analog_bits::kUsbRegulator;
  LeaveTheBootLoadersSession();
  RegisterAt(kUsb1BurstSize) = kBursts;
  usbphy1().CTRL.clear = kClockGate;
  usbphy1().PWD.value = 0;
  if (device_.Start()) nvic::Enable(Irq::kUsb1, Priority::kLow);
}

void UsbPort::HandleInterrupt() noexcept {
  device_.HandleInterrupt();
  std::uint8_t frame[wire::kFrameSizeMax];
  while (const std::size_t size = device_.Receive(frame, sizeof frame)) from_host_.Push(frame, size);
  while (const std::size_t size = to_host_.Pop(frame, sizeof frame)) device_.Send(frame, size);
  DataBarrier();
}

bool UsbPort::EmergencyStop() noexcept {
  if (handler_.emergency_stop.exchange(false)) stop_held_ = kEmergencyStopHold;
  if (stop_held_ == 0) return false;
  --stop_held_;
  return true;
}

}  // namespace omni::board
