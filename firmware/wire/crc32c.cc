#include "firmware/wire/crc32c.h"

namespace omni::wire {
namespace {

constexpr std::uint32_t kPolynomialReflected = 0x82F63B78U;

struct Table {
  std::uint32_t entry[256];
};

constexpr Table MakeTable() {
  Table table{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t crc = byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1U) != 0 ? kPolynomialReflected : 0U);
    table.entry[byte] = crc;
  }
  return table;
}

constexpr Table kTable = MakeTable();

}  // namespace

std::uint32_t Crc32c(const std::uint8_t* data, std::size_t size) noexcept {
  std::uint32_t crc = 0xFFFFFFFFU;
  for (std::size_t i = 0; i < size; ++i) crc = (crc >> 8) ^ kTable.entry[(crc ^ data[i]) & 0xFFU];
  return ~crc;
}

}  // namespace omni::wire
