// SHA-256 (FIPS 180-4): names cached scenes by their content.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace omni::scene {

using Digest = std::array<std::uint8_t, 32>;

class Sha256 {
 public:
  void Add(std::span<const std::byte> bytes);
  // With its length, so that ("ab", "c") and ("a", "bc") differ.
  void Add(std::string_view text);
  void Add(double number);
  Digest Finish();  // once

 private:
  void Block(const std::uint8_t* block);

  std::array<std::uint32_t, 8> state_{0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                                      0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
  std::array<std::uint8_t, 64> pending_{};
  std::size_t pending_count_ = 0;
  std::uint64_t length_ = 0;  // bytes
};

// 64 hexadecimal digits.
std::string ToHex(const Digest& digest);

}  // namespace omni::scene
