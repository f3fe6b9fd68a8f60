// The base's USB descriptors, as bytes. One vendor interface (FF/00/00) with one bulk endpoint each way; MS OS
// 2.0 descriptors make Windows load WinUSB without an .inf file, the WebUSB capability lets a browser request it.
//
// [USB 2.0] 9.6; [USB 3.2] 9.6.2 (BOS); [MS OS 2.0 Descriptors Specification]; [WebUSB] "WebUSB Platform Capability
// Descriptor".
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace omni::drivers::usb {

constexpr std::uint16_t kVendorId = 0x1209;   // pid.codes
constexpr std::uint16_t kProductId = 0x0001;  // its number for tests
constexpr std::uint8_t kEndpointOut = 0x01;
constexpr std::uint8_t kEndpointIn = 0x81;
constexpr std::uint16_t kControlPacket = 64;
constexpr std::uint16_t kBulkPacketHigh = 512;
constexpr std::uint16_t kBulkPacketFull = 64;
constexpr std::uint8_t kConfigurationValue = 1;

// Vendor requests, bmRequestType 40h or C0h (to the device: no claimed interface is needed).
constexpr std::uint8_t kRequestEstop = 1;      // 40h, no data
constexpr std::uint8_t kRequestHello = 2;      // C0h: a HELLO frame
constexpr std::uint8_t kRequestMsOs = 0x20;    // C0h, wIndex 7
constexpr std::uint8_t kRequestWebUsb = 0x21;  // C0h; no landing page, so every request is refused
constexpr std::uint16_t kMsOsDescriptorIndex = 7;

enum DescriptorType : std::uint8_t {
  kDescriptorDevice = 1,
  kDescriptorConfiguration = 2,
  kDescriptorString = 3,
  kDescriptorInterface = 4,
  kDescriptorEndpoint = 5,
  kDescriptorQualifier = 6,
  kDescriptorOtherSpeed = 7,
  kDescriptorBos = 15,
  kDescriptorCapability = 16,
};
enum StringIndex : std::uint8_t {
  kStringLanguages = 0,
  kStringManufacturer = 1,
  kStringProduct = 2,
  kStringSerial = 3
};

constexpr std::uint8_t LowByte(std::uint32_t value) noexcept { return static_cast<std::uint8_t>(value & 0xFF); }
constexpr std::uint8_t HighByte(std::uint32_t value) noexcept { return static_cast<std::uint8_t>((value >> 8) & 0xFF); }

template <std::size_t A, std::size_t B>
constexpr std::array<std::uint8_t, A + B> Concatenate(const std::array<std::uint8_t, A>& a,
                                                      const std::array<std::uint8_t, B>& b) noexcept {
  std::array<std::uint8_t, A + B> bytes{};
  for (std::size_t i = 0; i < A; ++i) bytes[i] = a[i];
  for (std::size_t i = 0; i < B; ++i) bytes[A + i] = b[i];
  return bytes;
}

// UTF-16 of an ASCII literal, with its closing zero.
template <std::size_t N>
constexpr std::array<std::uint8_t, 2 * N> Utf16(const char (&text)[N]) noexcept {
  std::array<std::uint8_t, 2 * N> bytes{};
  for (std::size_t i = 0; i < N; ++i) bytes[2 * i] = static_cast<std::uint8_t>(text[i]);
  return bytes;
}

// A string descriptor has no closing zero: its header takes that place [USB 2.0, 9.6.7].
template <std::size_t N>
constexpr std::array<std::uint8_t, 2 * N> StringDescriptor(const char (&text)[N]) noexcept {
  std::array<std::uint8_t, 2 * N> bytes{};
  bytes[0] = static_cast<std::uint8_t>(2 * N);
  bytes[1] = kDescriptorString;
  for (std::size_t i = 0; i + 1 < N; ++i) bytes[2 + 2 * i] = static_cast<std::uint8_t>(text[i]);
  return bytes;
}

// [USB 2.0, 9.6.1]. bcdUSB 2.1: the host asks for the BOS.
constexpr std::array<std::uint8_t, 18> kDevice = {18,
                                                  kDescriptorDevice,
                                                  0x10,
                                                  0x02,  // bLength, type, bcdUSB
                                                  0x00,
                                                  0x00,
                                                  0x00,  // class, subclass, protocol: defined by the interface
                                                  static_cast<std::uint8_t>(kControlPacket),
                                                  LowByte(kVendorId),
                                                  HighByte(kVendorId),
                                                  LowByte(kProductId),
                                                  HighByte(kProductId),
                                                  0x01,
                                                  0x00,  // bcdDevice
                                                  kStringManufacturer,
                                                  kStringProduct,
                                                  kStringSerial,
                                                  1};  // configurations
static_assert(kDevice[0] == kDevice.size(), "bLength");

// [USB 2.0, 9.6.2]: the device at the other speed.
constexpr std::array<std::uint8_t, 10> kQualifier = {
    10, kDescriptorQualifier, 0x10, 0x02, 0x00, 0x00, 0x00, static_cast<std::uint8_t>(kControlPacket), 1, 0};
static_assert(kQualifier[0] == kQualifier.size(), "bLength");

// [USB 2.0, 9.6.3 to 9.6.6] for either speed; `type` is kDescriptorConfiguration or kDescriptorOtherSpeed.
constexpr std::array<std::uint8_t, 32> Configuration(std::uint8_t type, std::uint16_t packet) noexcept {
  return {9,
          type,
          32,
          0,
          1,
          kConfigurationValue,
          0,
          0x80,  // powered by the bus, no remote wake-up
          125,   // 250 mA
          9,
          kDescriptorInterface,
          0,
          0,
          2,
          0xFF,
          0x00,
          0x00,
          0,
          7,
          kDescriptorEndpoint,
          kEndpointOut,
          0x02,
          LowByte(packet),
          HighByte(packet),
          0,
          7,
          kDescriptorEndpoint,
          kEndpointIn,
          0x02,
          LowByte(packet),
          HighByte(packet),
          0};
}
constexpr auto kConfigurationHigh = Configuration(kDescriptorConfiguration, kBulkPacketHigh);
constexpr auto kConfigurationFull = Configuration(kDescriptorConfiguration, kBulkPacketFull);
constexpr auto kOtherSpeedOfHigh = Configuration(kDescriptorOtherSpeed, kBulkPacketFull);
constexpr auto kOtherSpeedOfFull = Configuration(kDescriptorOtherSpeed, kBulkPacketHigh);
static_assert(kConfigurationHigh.size() == 9 + 9 + 7 + 7 && kConfigurationHigh[2] == kConfigurationHigh.size(),
              "wTotalLength");

constexpr std::array<std::uint8_t, 4> kLanguages = {4, kDescriptorString, 0x09, 0x04};  // English (United States)
constexpr auto kManufacturer = StringDescriptor("Omni");
constexpr auto kProduct = StringDescriptor("Omni haptic base");
static_assert(kManufacturer[0] == kManufacturer.size() && kProduct[0] == kProduct.size(), "bLength");

// MS OS 2.0 descriptor set: header (10), compatible ID (20), registry property. One function, so no subsets.
constexpr auto kMsOsPropertyName = Utf16("DeviceInterfaceGUIDs");
// A list of strings (REG_MULTI_SZ) ends with an empty one: two zeros in all.
constexpr auto kMsOsPropertyData =
    Concatenate(Utf16("{655E2F77-EED6-4D58-B59F-4C9BA12D7C30}"), std::array<std::uint8_t, 2>{0, 0});
constexpr std::size_t kMsOsPropertySize = 10 + kMsOsPropertyName.size() + kMsOsPropertyData.size();
constexpr std::size_t kMsOsSize = 10 + 20 + kMsOsPropertySize;
constexpr std::array<std::uint8_t, 4> kWindows81 = {0x00, 0x00, 0x03, 0x06};

constexpr std::array<std::uint8_t, 10> kMsOsHeader = {10,
                                                      0,
                                                      0x00,
                                                      0x00,
                                                      kWindows81[0],
                                                      kWindows81[1],
                                                      kWindows81[2],
                                                      kWindows81[3],
                                                      LowByte(kMsOsSize),
                                                      HighByte(kMsOsSize)};
constexpr std::array<std::uint8_t, 20> kMsOsCompatibleId = {20, 0, 0x03, 0x00, 'W', 'I', 'N', 'U', 'S', 'B',
                                                            0,  0, 0,    0,    0,   0,   0,   0,   0,   0};
constexpr std::array<std::uint8_t, 8> kMsOsPropertyHeader = {
    LowByte(kMsOsPropertySize),        HighByte(kMsOsPropertySize),       0x04, 0x00, 0x07, 0x00,  // REG_MULTI_SZ
    LowByte(kMsOsPropertyName.size()), HighByte(kMsOsPropertyName.size())};
constexpr std::array<std::uint8_t, 2> kMsOsPropertyDataSize = {LowByte(kMsOsPropertyData.size()),
                                                               HighByte(kMsOsPropertyData.size())};
constexpr auto kMsOs = Concatenate(
    Concatenate(Concatenate(kMsOsHeader, kMsOsCompatibleId), Concatenate(kMsOsPropertyHeader, kMsOsPropertyName)),
    Concatenate(kMsOsPropertyDataSize, kMsOsPropertyData));
static_assert(kMsOs.size() == kMsOsSize && kMsOsSize == 162, "wTotalLength");

// BOS: header (5), MS OS 2.0 capability (28), WebUSB capability (24). A platform capability names itself by a UUID.
constexpr std::size_t kBosSize = 5 + 28 + 24;
constexpr std::array<std::uint8_t, 5> kBosHeader = {5, kDescriptorBos, LowByte(kBosSize), HighByte(kBosSize), 2};
// {D8DD60DF-4589-4CC7-9CD2-659D9E648A9F}
constexpr std::array<std::uint8_t, 28> kBosMsOs = {28,
                                                   kDescriptorCapability,
                                                   0x05,
                                                   0x00,
                                                   0xDF,
                                                   0x60,
                                                   0xDD,
                                                   0xD8,
                                                   0x89,
                                                   0x45,
                                                   0xC7,
                                                   0x4C,
                                                   0x9C,
                                                   0xD2,
                                                   0x65,
                                                   0x9D,
                                                   0x9E,
                                                   0x64,
                                                   0x8A,
                                                   0x9F,
                                                   kWindows81[0],
                                                   kWindows81[1],
                                                   kWindows81[2],
                                                   kWindows81[3],
                                                   LowByte(kMsOsSize),
                                                   HighByte(kMsOsSize),
                                                   kRequestMsOs,
                                                   0};  // no other enumeration
// {3408B638-09A9-47A0-8BFD-A0768815B665}, version 1.0, no landing page
constexpr std::array<std::uint8_t, 24> kBosWebUsb = {24,
                                                     kDescriptorCapability,
                                                     0x05,
                                                     0x00,
                                                     0x38,
                                                     0xB6,
                                                     0x08,
                                                     0x34,
                                                     0xA9,
                                                     0x09,
                                                     0xA0,
                                                     0x47,
                                                     0x8B,
                                                     0xFD,
                                                     0xA0,
                                                     0x76,
                                                     0x88,
                                                     0x15,
                                                     0xB6,
                                                     0x65,
                                                     0x00,
                                                     0x01,
                                                     kRequestWebUsb,
                                                     0};
constexpr auto kBos = Concatenate(kBosHeader, Concatenate(kBosMsOs, kBosWebUsb));
static_assert(kBos.size() == kBosSize && kBosMsOs[0] == kBosMsOs.size() && kBosWebUsb[0] == kBosWebUsb.size(),
              "wTotalLength and bLength");

}  // namespace omni::drivers::usb
