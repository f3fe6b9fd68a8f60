// Requests to endpoint 0 and their answers, without any hardware: a SETUP packet and the device's state in, an answer
// out [USB 2.0, 9.4]. Requests that are not in the table stall.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

#include "firmware/drivers/usb_descriptors.h"

namespace omni::drivers::usb {

struct Setup {
  std::uint8_t type = 0;  // bmRequestType
  std::uint8_t request = 0;
  std::uint16_t value = 0, index = 0, length = 0;
};

// From the two words of a queue head.
inline Setup ParseSetup(std::uint32_t word0, std::uint32_t word1) noexcept {
  return {static_cast<std::uint8_t>(word0), static_cast<std::uint8_t>(word0 >> 8),
          static_cast<std::uint16_t>(word0 >> 16), static_cast<std::uint16_t>(word1),
          static_cast<std::uint16_t>(word1 >> 16)};
}

constexpr std::size_t kSerialMax = 16;

struct ControlState {
  char serial[kSerialMax] = {};  // ASCII, not necessarily terminated
  bool high_speed = false;
  std::uint8_t configuration = 0;
  bool out_halted = false, in_halted = false;
};

// The controller's action; all but kStall and kData end with an empty status packet.
enum class ControlAction : std::uint8_t {
  kStall,
  kData,
  kNothing,
  kSetAddress,        // argument: the address
  kSetConfiguration,  // argument: 0 or kConfigurationValue
  kHalt,              // argument: the endpoint's address
  kUnhalt,            // argument: the endpoint's address; resets the data toggle
  kRestart,           // SET_INTERFACE: resets the toggles of both endpoints
  kEstop,
  kHello,  // data: from the handler
};

struct ControlAnswer {
  ControlAction action = ControlAction::kStall;
  std::uint8_t argument = 0;
  std::size_t size = 0;  // of the data, before the host's wLength cuts it
};

namespace control {

constexpr std::uint16_t kFeatureHalt = 0;

template <class Array>
ControlAnswer Data(const Array& bytes, std::uint8_t* data) noexcept {
  std::memcpy(data, bytes.data(), bytes.size());
  return {ControlAction::kData, 0, bytes.size()};
}

inline ControlAnswer SerialString(const ControlState& state, std::uint8_t* data) noexcept {
  std::size_t size = 2;
  for (std::size_t i = 0; i < kSerialMax && state.serial[i] != 0; ++i) {
    data[size++] = static_cast<std::uint8_t>(state.serial[i]);
    data[size++] = 0;
  }
  data[0] = static_cast<std::uint8_t>(size);
  data[1] = kDescriptorString;
  return {ControlAction::kData, 0, size};
}

inline ControlAnswer GetString(std::uint8_t index, const ControlState& state, std::uint8_t* data) noexcept {
  switch (index) {
    case kStringLanguages:
      return Data(kLanguages, data);
    case kStringManufacturer:
      return Data(kManufacturer, data);
    case kStringProduct:
      return Data(kProduct, data);
    case kStringSerial:
      return SerialString(state, data);
    default:
      return {};
  }
}

inline ControlAnswer GetDescriptor(const Setup& setup, const ControlState& state, std::uint8_t* data) noexcept {
  const std::uint8_t index = LowByte(setup.value);
  const std::uint8_t type = HighByte(setup.value);
  if (type == kDescriptorString) return GetString(index, state, data);
  if (index != 0) return {};
  switch (type) {
    case kDescriptorDevice:
      return Data(kDevice, data);
    case kDescriptorConfiguration:
      return Data(state.high_speed ? kConfigurationHigh : kConfigurationFull, data);
    case kDescriptorOtherSpeed:
      return Data(state.high_speed ? kOtherSpeedOfHigh : kOtherSpeedOfFull, data);
    case kDescriptorQualifier:
      return Data(kQualifier, data);
    case kDescriptorBos:
      return Data(kBos, data);
    default:
      return {};
  }
}

inline ControlAnswer SetAddress(const Setup& setup, const ControlState&, std::uint8_t*) noexcept {
  if (setup.value > 127 || setup.length != 0) return {};
  return {ControlAction::kSetAddress, LowByte(setup.value), 0};
}

inline ControlAnswer SetConfiguration(const Setup& setup, const ControlState&, std::uint8_t*) noexcept {
  if (setup.value > kConfigurationValue || setup.length != 0) return {};
  return {ControlAction::kSetConfiguration, LowByte(setup.value), 0};
}

inline ControlAnswer GetConfiguration(const Setup&, const ControlState& state, std::uint8_t* data) noexcept {
  data[0] = state.configuration;
  return {ControlAction::kData, 0, 1};
}

inline ControlAnswer StatusWord(std::uint8_t bits, std::uint8_t* data) noexcept {
  data[0] = bits;
  data[1] = 0;
  return {ControlAction::kData, 0, 2};
}

inline ControlAnswer GetDeviceStatus(const Setup&, const ControlState&, std::uint8_t* data) noexcept {
  return StatusWord(0, data);  // powered by the bus, no remote wake-up
}

inline ControlAnswer GetInterfaceStatus(const Setup& setup, const ControlState& state, std::uint8_t* data) noexcept {
  return state.configuration != 0 && setup.index == 0 ? StatusWord(0, data) : ControlAnswer{};
}

inline bool IsControlEndpoint(std::uint16_t index) noexcept { return (index & 0xFF7F) == 0; }

// Bulk endpoints exist only once configured.
inline bool IsBulkEndpoint(std::uint16_t index, const ControlState& state) noexcept {
  return state.configuration != 0 && (index == kEndpointOut || index == kEndpointIn);
}

inline ControlAnswer GetEndpointStatus(const Setup& setup, const ControlState& state, std::uint8_t* data) noexcept {
  if (IsControlEndpoint(setup.index)) return StatusWord(0, data);
  if (!IsBulkEndpoint(setup.index, state)) return {};
  return StatusWord(setup.index == kEndpointIn ? state.in_halted : state.out_halted, data);
}

inline ControlAnswer EndpointFeature(const Setup& setup, const ControlState& state, ControlAction action) noexcept {
  if (setup.value != kFeatureHalt || setup.length != 0) return {};
  if (IsControlEndpoint(setup.index)) return {ControlAction::kNothing, 0, 0};  // never halted for long
  if (!IsBulkEndpoint(setup.index, state)) return {};
  return {action, LowByte(setup.index), 0};
}

inline ControlAnswer ClearEndpointFeature(const Setup& setup, const ControlState& state, std::uint8_t*) noexcept {
  return EndpointFeature(setup, state, ControlAction::kUnhalt);
}

inline ControlAnswer SetEndpointFeature(const Setup& setup, const ControlState& state, std::uint8_t*) noexcept {
  return EndpointFeature(setup, state, ControlAction::kHalt);
}

inline ControlAnswer GetInterface(const Setup& setup, const ControlState& state, std::uint8_t* data) noexcept {
  if (state.configuration == 0 || setup.index != 0) return {};
  data[0] = 0;
  return {ControlAction::kData, 0, 1};
}

inline ControlAnswer SetInterface(const Setup& setup, const ControlState& state, std::uint8_t*) noexcept {
  if (state.configuration == 0 || setup.index != 0 || setup.value != 0 || setup.length != 0) return {};
  return {ControlAction::kRestart, 0, 0};
}

inline ControlAnswer EmergencyStop(const Setup& setup, const ControlState&, std::uint8_t*) noexcept {
  if (setup.length != 0) return {};
  return {ControlAction::kEstop, 0, 0};
}

inline ControlAnswer Hello(const Setup&, const ControlState&, std::uint8_t*) noexcept {
  return {ControlAction::kHello, 0, 0};
}

inline ControlAnswer MsOsDescriptor(const Setup& setup, const ControlState&, std::uint8_t* data) noexcept {
  return setup.index == kMsOsDescriptorIndex ? Data(kMsOs, data) : ControlAnswer{};
}

struct Row {
  std::uint8_t type, request;
  ControlAnswer (*answer)(const Setup&, const ControlState&, std::uint8_t*) noexcept;
};

// bmRequestType: 80h to the host; 00h standard, 40h vendor; 00h device, 01h interface, 02h endpoint.
constexpr Row kRows[] = {
    {0x80, 6, GetDescriptor},      {0x00, 5, SetAddress},
    {0x00, 9, SetConfiguration},   {0x80, 8, GetConfiguration},
    {0x80, 0, GetDeviceStatus},    {0x81, 0, GetInterfaceStatus},
    {0x82, 0, GetEndpointStatus},  {0x02, 1, ClearEndpointFeature},
    {0x02, 3, SetEndpointFeature}, {0x81, 10, GetInterface},
    {0x01, 11, SetInterface},      {0x40, kRequestEstop, EmergencyStop},
    {0xC0, kRequestHello, Hello},  {0xC0, kRequestMsOs, MsOsDescriptor},
};

}  // namespace control

// `data` has room for kBufferSize bytes.
inline ControlAnswer AnswerControl(const Setup& setup, const ControlState& state, std::uint8_t* data) noexcept {
  for (const control::Row& row : control::kRows) {
    if (row.type == setup.type && row.request == setup.request) return row.answer(setup, state, data);
  }
  return {};
}

}  // namespace omni::drivers::usb
