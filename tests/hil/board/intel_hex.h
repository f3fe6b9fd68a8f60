// Intel HEX, the format in which a boot loader accepts an image [Intel, Hexadecimal Object File Format, 1988].
#pragma once

#include <cstdint>
#include <map>
#include <string>

namespace omni::hil {

// Address -> byte. Empty `error`: read whole, every checksum right, no byte twice, closed by an end record.
std::map<std::uint32_t, std::uint8_t> ReadIntelHex(const std::string& text, std::string& error);

}  // namespace omni::hil
