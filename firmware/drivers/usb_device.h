// The USB device: a ChipIdea controller (i.MX RT1062, USB1) with endpoint 0 and one bulk endpoint each way. One frame
// is one transfer; at high speed one packet [NXP IMXRT1060RM, USB: "Device Operational Model"].
//
// Each endpoint has at most one dTD at the controller; further frames wait in UsbMemory. So no dTD is ever added to a
// list that the controller is walking, and the hazard of that (ATDTW) does not arise. A finished dTD is recognised by
// its token, not by ENDPTCOMPLETE: spurious or merged interrupts are harmless.
//
// Not re-entrant: Interrupt and all others run at one priority, or with the interrupt masked. All waits are bounded; a
// wait that times out is counted (timeouts).
//
// Bus policy (the two cache calls are also barriers, for the compiler and for the memory: DSB; ranges are whole lines
// of 32 bytes):
//   std::uint32_t Read(std::uint32_t offset) noexcept;     usb_registers.h
//   void Write(std::uint32_t offset, std::uint32_t value) noexcept;
//   std::uint32_t Address(const volatile void* memory) noexcept;                        as the controller sees it
//   void CleanCache(const volatile void* memory, std::size_t size) noexcept;            writes reach memory
//   void InvalidateCache(const volatile void* memory, std::size_t size) noexcept;       reads come from memory
// Handler policy:
//   void EmergencyStop() noexcept;                                                     any number of times
//   std::size_t WriteHello(std::uint8_t* frame, std::size_t capacity) noexcept;        0: refused
//
// The board does before Start: USB PLL and PHY on, clock gate open, interrupt vector; after Stop the reverse.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "firmware/drivers/usb_control.h"
#include "firmware/drivers/usb_queue.h"
#include "firmware/drivers/usb_registers.h"

namespace omni::drivers::usb {

enum class DeviceState : std::uint8_t { kOff, kDetached, kDefault, kAddress, kConfigured };

// Wrap around.
struct UsbCounters {
  std::uint32_t setups = 0, stalls = 0;
  std::uint32_t received = 0, sent = 0;  // whole transfers
  std::uint32_t receive_errors = 0;      // transfers that the controller marked bad, discarded
  std::uint32_t send_errors = 0;         // as above
  std::uint32_t send_overwritten = 0;    // frames that the host did not fetch in time
  std::uint32_t send_refused = 0;        // no host, or not the size of a frame
  std::uint32_t lost_in_reset = 0;       // transfers that waited when the bus was reset or unplugged
  std::uint32_t resets = 0, suspends = 0, unplugs = 0, bus_errors = 0;
  std::uint32_t late_resets = 0;  // handled after the host had ended them
  std::uint32_t timeouts = 0;     // waits for a register that timed out
};

template <class Bus, class Handler>
class UsbDevice {
 public:
  // `serial`: ASCII, at most 16 characters. The driver owns all of `memory` from now on.
  UsbDevice(Bus& bus, Handler& handler, UsbMemory& memory, const char* serial) noexcept
      : bus_(bus), handler_(handler), memory_(memory) {
    for (std::size_t i = 0; i < kSerialMax && serial[i] != 0; ++i) control_.serial[i] = serial[i];
  }

  // Resets the controller and shows the device to the host. False: the controller does not come out of its reset.
  bool Start() noexcept {
    state_ = DeviceState::kOff;
    bus_.Write(kUsbCmd, kUsbCmdReset);
    if (!WaitClear(kUsbCmd, kUsbCmdReset)) return false;
    bus_.Write(kUsbMode, kUsbModeDevice | kUsbModeSetupTripwire);
    // Cache lines left dirty by start-up code must not overwrite the controller's data later.
    bus_.CleanCache(&memory_, sizeof memory_);
    ForgetHost();
    SetUpControlQueues();
    bus_.Write(kEndpointListAddr, bus_.Address(memory_.queues));
    bus_.Write(kOtgSc, kOtgScSessionInterrupt | kOtgScSessionChanged);
    bus_.Write(kUsbIntr, kUsbStsHandled);
    bus_.Write(kUsbCmd, kUsbCmdRun);
    state_ = DeviceState::kDefault;
    return true;
  }

  // The host sees the device leave.
  void Stop() noexcept {
    bus_.Write(kUsbIntr, 0);
    bus_.Write(kUsbCmd, 0);
    Flush(kAllEndpoints);
    ForgetHost();
    state_ = DeviceState::kOff;
  }

  // From the controller's interrupt; spurious calls are harmless.
  void HandleInterrupt() noexcept {
    if (state_ == DeviceState::kOff) return;
    const std::uint32_t status = bus_.Read(kUsbSts) & kUsbStsHandled;
    bus_.Write(kUsbSts, status);
    HandleSetups();
    HandleTransfers();
    if ((status & kUsbStsReset) != 0) HandleReset();
    if ((status & kUsbStsPortChange) != 0) HandlePortChange();
    if ((status & kUsbStsSuspend) != 0) HandleSuspend();
    if ((status & kUsbStsError) != 0) ++counters_.bus_errors;
    HandleSession();
  }

  // Queues a frame of 1 to 512 bytes for the host. If the host does not fetch them, the oldest waiting frame is
  // dropped. False: no host, or an invalid size.
  bool Send(const std::uint8_t* frame, std::size_t size) noexcept {
    if (!configured() || suspended_ || size == 0 || size > kBufferSize) {
      ++counters_.send_refused;
      return false;
    }
    if (send_.full()) {
      ++counters_.send_overwritten;
      send_.Remove(1);  // the first one may be on its way
    }
    std::uint8_t* buffer = memory_.send[send_.next()];
    std::memcpy(buffer, frame, size);
    bus_.CleanCache(buffer, kBufferSize);
    send_.Push(size);
    if (!sending_) ArmSend();
    return true;
  }

  // The oldest received transfer; 0: none. One longer than `capacity` is discarded and 0 is returned.
  std::size_t Receive(std::uint8_t* frame, std::size_t capacity) noexcept {
    if (receive_.count() == 0) return 0;
    const int slot = receive_.front();
    const std::size_t size = receive_.size(slot);
    if (size <= capacity) std::memcpy(frame, memory_.receive[slot], size);
    receive_.Remove(0);
    if (!receiving_) ArmReceive();
    return size <= capacity ? size : 0;
  }

  DeviceState state() const noexcept { return state_; }
  bool configured() const noexcept { return state_ == DeviceState::kConfigured; }
  bool suspended() const noexcept { return suspended_; }
  bool high_speed() const noexcept { return control_.high_speed; }
  const UsbCounters& counters() const noexcept { return counters_; }

 private:
  static constexpr int kSpinMax = 20'000;  // register reads, about 2 ms; the waits normally take microseconds
  static constexpr int kTripwireTries = 16;
  static constexpr int kSetupsPerInterrupt = 16;
  static constexpr std::uint32_t kAllEndpoints = 0xFFFFFFFF;

  static constexpr std::uint32_t EndpointBit(int queue) noexcept { return 1U << (queue / 2 + (queue % 2) * 16); }

  bool WaitClear(std::uint32_t offset, std::uint32_t mask) noexcept {
    for (int i = 0; i < kSpinMax; ++i) {
      if ((bus_.Read(offset) & mask) == 0) return true;
    }
    ++counters_.timeouts;
    return false;
  }

  // A packet that is on the wire while flushing keeps its endpoint primed: check, and flush again ["Flushing
  // Endpoints"].
  void Flush(std::uint32_t endpoints) noexcept {
    for (int i = 0; i < 4; ++i) {
      bus_.Write(kEndpointFlush, endpoints);
      if (!WaitClear(kEndpointFlush, endpoints)) return;
      if ((bus_.Read(kEndpointStat) & endpoints) == 0) return;
    }
    ++counters_.timeouts;
  }

  void SetUpQueue(int queue, std::uint32_t capabilities) noexcept {
    QueueHead& head = memory_.queues[queue];
    head.capabilities = capabilities;
    head.current = 0;
    head.next = kTerminate;
    head.token = 0;
    bus_.CleanCache(&head, kCacheLine);
  }

  void SetUpControlQueues() noexcept {
    constexpr std::uint32_t kControl = (kControlPacket << kPacketSizeShift) | kNoZeroLengthEnd;
    SetUpQueue(kControlOut, kControl | kInterruptOnSetup);
    SetUpQueue(kControlIn, kControl);
  }

  void Fill(TransferDescriptor& transfer, const std::uint8_t* data, std::size_t size, std::uint32_t next,
            bool interrupt) noexcept {
    const std::uint32_t address = bus_.Address(data);
    transfer.next = next;
    transfer.page[0] = address;
    for (std::uint32_t i = 1; i < 5; ++i) transfer.page[i] = (address & ~0xFFFU) + 0x1000 * i;
    transfer.token =
        (static_cast<std::uint32_t>(size) << kTokenBytesShift) | kTokenActive | (interrupt ? kTokenInterrupt : 0U);
    bus_.CleanCache(&transfer, sizeof transfer);
  }

  // ["Executing a Transfer Descriptor", list empty.]
  void Prime(int queue, const TransferDescriptor& transfer) noexcept {
    QueueHead& head = memory_.queues[queue];
    head.next = bus_.Address(&transfer);
    head.token = 0;
    bus_.CleanCache(&head, kCacheLine);
    bus_.Write(kEndpointPrime, EndpointBit(queue));
    WaitClear(kEndpointPrime, EndpointBit(queue));
  }

  // The token of a dTD as the controller left it.
  std::uint32_t Token(const TransferDescriptor& transfer) noexcept {
    bus_.InvalidateCache(&transfer, sizeof transfer);
    return transfer.token;
  }

  // ---- endpoint 0

  // If another SETUP has arrived meanwhile, the host has abandoned the current one: only the newest is answered.
  void HandleSetups() noexcept {
    for (int i = 0; i < kSetupsPerInterrupt; ++i) {
      if ((bus_.Read(kEndpointSetupStat) & 1U) == 0) return;
      const Setup setup = PopSetup();
      if ((bus_.Read(kEndpointSetupStat) & 1U) != 0) continue;
      ++counters_.setups;
      suspended_ = false;
      Flush(EndpointBit(kControlOut) | EndpointBit(kControlIn));
      Answer(setup);
    }
  }

  // ["Setup Phase", with the tripwire]: a SETUP that arrives while the eight bytes are copied clears SUTW.
  Setup PopSetup() noexcept {
    Setup setup;
    bus_.Write(kEndpointSetupStat, 1);
    const std::uint32_t command = bus_.Read(kUsbCmd) & ~kUsbCmdSetupTripwire;
    for (int i = 0; i < kTripwireTries; ++i) {
      bus_.Write(kUsbCmd, command | kUsbCmdSetupTripwire);
      QueueHead& head = memory_.queues[kControlOut];
      bus_.InvalidateCache(&head.page4, kCacheLine);
      setup = ParseSetup(head.setup[0], head.setup[1]);
      if ((bus_.Read(kUsbCmd) & kUsbCmdSetupTripwire) != 0) break;
    }
    bus_.Write(kUsbCmd, command);
    return setup;
  }

  void Answer(const Setup& setup) noexcept {
    ControlAnswer answer = AnswerControl(setup, control_, memory_.control);
    switch (answer.action) {
      case ControlAction::kStall:
        break;
      case ControlAction::kHello:
        answer.size = handler_.WriteHello(memory_.control, kBufferSize);
        if (answer.size != 0 && answer.size <= kBufferSize) return SendControl(answer.size, setup.length);
        break;
      case ControlAction::kData:
        return SendControl(answer.size, setup.length);
      default:
        Execute(answer);
        return SendControl(0, 0);
    }
    ++counters_.stalls;
    // Both directions; the next SETUP ends it.
    bus_.Write(EndpointCtrl(0),
               bus_.Read(EndpointCtrl(0)) | kEndpointCtrlStall | (kEndpointCtrlStall << kEndpointCtrlTx));
  }

  void Execute(const ControlAnswer& answer) noexcept {
    switch (answer.action) {
      case ControlAction::kSetAddress:
        bus_.Write(kDeviceAddr, (static_cast<std::uint32_t>(answer.argument) << kDeviceAddrShift) | kDeviceAddrAdvance);
        if (state_ == DeviceState::kDefault || state_ == DeviceState::kAddress) {
          state_ = answer.argument != 0 ? DeviceState::kAddress : DeviceState::kDefault;
        }
        return;
      case ControlAction::kSetConfiguration:
        return SetConfiguration(answer.argument);
      case ControlAction::kHalt:
        return SetHalt(answer.argument, true);
      case ControlAction::kUnhalt:
        return SetHalt(answer.argument, false);
      case ControlAction::kRestart:
        SetHalt(kEndpointOut, false);
        return SetHalt(kEndpointIn, false);
      case ControlAction::kEstop:
        return handler_.EmergencyStop();
      default:
        return;
    }
  }

  // The data stage, cut to what the host asked for, and the status stage; `length` 0: an empty packet to the host is
  // the status stage. Data that are shorter than requested and fill their last packet need an empty one after them
  // [USB 2.0, 5.5.3]. Both stages are primed at once, because the host may end the first early.
  void SendControl(std::size_t size, std::size_t length) noexcept {
    const std::size_t count = size < length ? size : length;
    const bool say_end = count != 0 && count < length && count % kControlPacket == 0;
    bus_.CleanCache(memory_.control, kBufferSize);
    std::uint32_t next = kTerminate;
    if (say_end) {
      Fill(memory_.control_in[1], memory_.control, 0, kTerminate, false);
      next = bus_.Address(&memory_.control_in[1]);
    }
    Fill(memory_.control_in[0], memory_.control, count, next, false);
    Prime(kControlIn, memory_.control_in[0]);
    if (length == 0) return;
    Fill(memory_.control_out, memory_.control, 0, kTerminate, false);
    Prime(kControlOut, memory_.control_out);
  }

  // ---- bulk endpoints

  void SetConfiguration(std::uint8_t value) noexcept {
    CloseBulk();
    control_.configuration = value;
    state_ = value != 0 ? DeviceState::kConfigured : DeviceState::kAddress;
    if (value == 0) return;
    const std::uint32_t packet = static_cast<std::uint32_t>(control_.high_speed ? kBulkPacketHigh : kBulkPacketFull)
                                 << kPacketSizeShift;
    // From the host: 512 bytes are a whole buffer and end a transfer by themselves. To the host: a frame that fills its
    // last packet is followed by an empty one, so that the host knows its end.
    SetUpQueue(kBulkOut, packet | kNoZeroLengthEnd);
    SetUpQueue(kBulkIn, packet);
    constexpr std::uint32_t kOpen = kEndpointCtrlBulk | kEndpointCtrlToggleReset | kEndpointCtrlEnable;
    bus_.Write(EndpointCtrl(1), kOpen | (kOpen << kEndpointCtrlTx));
    ArmReceive();
  }

  // Both directions keep the type bulk: an unused one left as control upsets the other's data toggle ["Endpoint
  // Initialization"].
  void CloseBulk() noexcept {
    Flush(EndpointBit(kBulkOut) | EndpointBit(kBulkIn));
    bus_.Write(EndpointCtrl(1), kEndpointCtrlBulk | (kEndpointCtrlBulk << kEndpointCtrlTx));
    counters_.lost_in_reset += static_cast<std::uint32_t>(receive_.count() + send_.count());
    receive_.Clear();
    send_.Clear();
    receiving_ = sending_ = false;
    control_.out_halted = control_.in_halted = false;
    control_.configuration = 0;
  }

  void SetHalt(std::uint8_t endpoint, bool halt) noexcept {
    const bool in = endpoint == kEndpointIn;
    const int shift = in ? kEndpointCtrlTx : 0;
    std::uint32_t value = bus_.Read(EndpointCtrl(1)) & ~(kEndpointCtrlStall << shift);
    value |= (halt ? kEndpointCtrlStall : kEndpointCtrlToggleReset) << shift;
    bus_.Write(EndpointCtrl(1), value);
    (in ? control_.in_halted : control_.out_halted) = halt;
    if (!halt) Restart(in);
  }

  // Resets the toggle and restarts a transfer in progress, so that no partial transfer is joined to the next.
  void Restart(bool in) noexcept {
    if (!(in ? sending_ : receiving_)) return;
    Flush(EndpointBit(in ? kBulkIn : kBulkOut));
    if ((Token(in ? memory_.bulk_in : memory_.bulk_out) & kTokenActive) == 0) return;  // already ended
    in ? ArmSend() : ArmReceive();
  }

  void ArmReceive() noexcept {
    if (!configured() || receive_.full()) return;
    std::uint8_t* buffer = memory_.receive[receive_.next()];
    // No dirty cache line may be written back over the controller's data.
    bus_.InvalidateCache(buffer, kBufferSize);
    Fill(memory_.bulk_out, buffer, kBufferSize, kTerminate, true);
    receiving_ = true;
    Prime(kBulkOut, memory_.bulk_out);
  }

  void ArmSend() noexcept {
    const int slot = send_.front();
    Fill(memory_.bulk_in, memory_.send[slot], send_.size(slot), kTerminate, true);
    sending_ = true;
    Prime(kBulkIn, memory_.bulk_in);
  }

  void HandleTransfers() noexcept {
    bus_.Write(kEndpointComplete, bus_.Read(kEndpointComplete));
    if (receiving_) FinishReceive(Token(memory_.bulk_out));
    if (sending_) FinishSend(Token(memory_.bulk_in));
  }

  void FinishReceive(std::uint32_t token) noexcept {
    if ((token & kTokenActive) != 0) return;
    receiving_ = false;
    suspended_ = false;
    const std::size_t left = (token >> kTokenBytesShift) & kTokenBytesMask;
    if ((token & kTokenErrors) != 0 || left > kBufferSize) {
      ++counters_.receive_errors;
    } else if (left < kBufferSize) {  // empty transfers are ignored
      bus_.InvalidateCache(memory_.receive[receive_.next()], kBufferSize);
      receive_.Push(kBufferSize - left);
      ++counters_.received;
    }
    ArmReceive();
  }

  void FinishSend(std::uint32_t token) noexcept {
    if ((token & kTokenActive) != 0) return;
    sending_ = false;
    suspended_ = false;
    ++((token & kTokenErrors) != 0 ? counters_.send_errors : counters_.sent);
    send_.Remove(0);
    if (send_.count() != 0) ArmSend();
  }

  // ---- the bus

  // Discards the state of a host that is gone or restarts. Waiting transfers are dropped.
  void ForgetHost() noexcept {
    CloseBulk();
    suspended_ = false;
  }

  // ["Bus Reset"]. An address that was to take effect with a status stage does not.
  void HandleReset() noexcept {
    ++counters_.resets;
    bus_.Write(kEndpointSetupStat, bus_.Read(kEndpointSetupStat));
    bus_.Write(kEndpointComplete, bus_.Read(kEndpointComplete));
    WaitClear(kEndpointPrime, kAllEndpoints);
    Flush(kAllEndpoints);
    // All is cleaned up either way; for a host this fast the manual requires a controller reset, which would force it
    // to enumerate again.
    if ((bus_.Read(kPortSc1) & kPortSc1Reset) == 0) ++counters_.late_resets;
    bus_.Write(kDeviceAddr, 0);
    ForgetHost();
    SetUpControlQueues();
    state_ = DeviceState::kDefault;
  }

  void HandlePortChange() noexcept {
    const std::uint32_t port = bus_.Read(kPortSc1);
    control_.high_speed = (port & kPortSc1HighSpeed) != 0;
    suspended_ = (port & kPortSc1Suspended) != 0;
  }

  void HandleSuspend() noexcept {
    ++counters_.suspends;
    suspended_ = (bus_.Read(kPortSc1) & kPortSc1Suspended) != 0;
  }

  // The cable's voltage may appear and vanish; without it the pull-up must be off [USB 2.0, 7.1.5].
  void HandleSession() noexcept {
    const std::uint32_t otg = bus_.Read(kOtgSc);
    if ((otg & kOtgScSessionChanged) == 0) return;
    bus_.Write(kOtgSc, (otg & ~kOtgScWriteOneClears) | kOtgScSessionChanged);
    if ((otg & kOtgScSessionValid) != 0) {
      bus_.Write(kUsbCmd, kUsbCmdRun);
      if (state_ == DeviceState::kDetached) state_ = DeviceState::kDefault;
      return;
    }
    ++counters_.unplugs;
    bus_.Write(kUsbCmd, 0);
    Flush(kAllEndpoints);
    ForgetHost();
    state_ = DeviceState::kDetached;
  }

  Bus& bus_;
  Handler& handler_;
  UsbMemory& memory_;
  ControlState control_;
  DeviceState state_ = DeviceState::kOff;
  bool suspended_ = false;
  bool receiving_ = false, sending_ = false;
  SlotQueue<kReceiveDepth> receive_;
  SlotQueue<kSendDepth> send_;
  UsbCounters counters_;
};

}  // namespace omni::drivers::usb
