// The emulated base's answers to GET_DESCRIPTOR [USB 2.0, 9.4.3]: the firmware's own descriptors, at high speed.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace omni::hil {

// Device and configuration, one after the other: what sysfs shows as `descriptors`.
std::vector<std::uint8_t> SysfsDescriptors();

// For wValue of GET_DESCRIPTOR (type, index); empty: there is none, stall.
std::vector<std::uint8_t> Descriptor(std::uint16_t value, const std::string& serial);

// The descriptor set of Microsoft OS 2.0, for its vendor request.
std::vector<std::uint8_t> MsOsDescriptors();

}  // namespace omni::hil
