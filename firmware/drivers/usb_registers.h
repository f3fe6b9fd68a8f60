// The ChipIdea USB controller of the i.MX RT1062 in device mode [NXP IMXRT1060RM, chapter "Universal Serial Bus
// Controller (USB)": "USB Core Memory Map"]. Offsets from the base of USB1, 0x402E0000.
#pragma once

#include <cstdint>

namespace omni::drivers::usb {

constexpr std::uint32_t kUsbCmd = 0x140;
constexpr std::uint32_t kUsbCmdRun = 1U << 0;             // RS: the pull-up, the host sees the device
constexpr std::uint32_t kUsbCmdReset = 1U << 1;           // RST: clears itself
constexpr std::uint32_t kUsbCmdSetupTripwire = 1U << 13;  // SUTW: the controller clears it when a SETUP arrives
// ITC (bits 23:16) is 8 after reset, a millisecond between interrupts; 0 is at once.

constexpr std::uint32_t kUsbSts = 0x144;              // written ones clear
constexpr std::uint32_t kUsbIntr = 0x148;             // same bits: enables
constexpr std::uint32_t kUsbStsTransfer = 1U << 0;    // UI: a dTD with IOC, or a SETUP
constexpr std::uint32_t kUsbStsError = 1U << 1;       // UEI
constexpr std::uint32_t kUsbStsPortChange = 1U << 2;  // PCI: full or high speed is running, also after a suspend
constexpr std::uint32_t kUsbStsReset = 1U << 6;       // URI
constexpr std::uint32_t kUsbStsSuspend = 1U << 8;     // SLI
constexpr std::uint32_t kUsbStsHandled =
    kUsbStsTransfer | kUsbStsError | kUsbStsPortChange | kUsbStsReset | kUsbStsSuspend;

constexpr std::uint32_t kDeviceAddr = 0x154;
constexpr int kDeviceAddrShift = 25;
constexpr std::uint32_t kDeviceAddrAdvance = 1U << 24;  // USBADRA: takes effect once the status stage is acknowledged

constexpr std::uint32_t kEndpointListAddr = 0x158;  // of the queue heads, a multiple of 2048

constexpr std::uint32_t kPortSc1 = 0x184;
constexpr std::uint32_t kPortSc1Suspended = 1U << 7;  // SUSP
constexpr std::uint32_t kPortSc1Reset = 1U << 8;      // PR: the host is resetting the device
constexpr std::uint32_t kPortSc1HighSpeed = 1U << 9;  // HSP

constexpr std::uint32_t kOtgSc = 0x1A4;
constexpr std::uint32_t kOtgScSessionValid = 1U << 11;      // BSV: there is a host's voltage on the cable
constexpr std::uint32_t kOtgScSessionChanged = 1U << 19;    // BSVIS, a written one clears
constexpr std::uint32_t kOtgScSessionInterrupt = 1U << 27;  // BSVIE
constexpr std::uint32_t kOtgScWriteOneClears = 0x7FU << 16;

constexpr std::uint32_t kUsbMode = 0x1A8;
constexpr std::uint32_t kUsbModeDevice = 2U << 0;         // CM
constexpr std::uint32_t kUsbModeSetupTripwire = 1U << 3;  // SLOM: no lock-out of SETUPs, the tripwire is used

// Endpoint bits: n receives (OUT), 16 + n transmits (IN).
constexpr std::uint32_t kEndpointSetupStat = 0x1AC;  // a written one clears
constexpr std::uint32_t kEndpointPrime = 0x1B0;      // clears itself
constexpr std::uint32_t kEndpointFlush = 0x1B4;      // clears itself
constexpr std::uint32_t kEndpointStat = 0x1B8;       // primed, a packet can go
constexpr std::uint32_t kEndpointComplete = 0x1BC;   // a written one clears

constexpr std::uint32_t EndpointCtrl(int endpoint) noexcept { return 0x1C0 + 4 * static_cast<std::uint32_t>(endpoint); }
constexpr int kEndpointCtrlTx = 16;  // the bits below for IN
constexpr std::uint32_t kEndpointCtrlStall = 1U << 0;
constexpr std::uint32_t kEndpointCtrlBulk = 2U << 2;
constexpr std::uint32_t kEndpointCtrlToggleReset = 1U << 6;
constexpr std::uint32_t kEndpointCtrlEnable = 1U << 7;

}  // namespace omni::drivers::usb
