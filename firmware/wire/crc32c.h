// CRC-32C (Castagnoli): polynomial 0x1EDC6F41 reflected, start and final value 0xFFFFFFFF [RFC 3720, B.4].
#pragma once

#include <cstddef>
#include <cstdint>

namespace omni::wire {

std::uint32_t Crc32c(const std::uint8_t* data, std::size_t size) noexcept;

}  // namespace omni::wire
