// Target of the digital twin's pen, from a person or a program: one packet to the twin's process, on a socket of its
// own beside omnid's. The newest counts; there is no answer. docs/protocol/ipc.md.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace omni::protocol {

inline constexpr std::uint32_t kHandMagic = 0x41484D4F;  // "OMHA"
inline constexpr std::uint32_t kHandVersion = 1;
inline constexpr double kHandReach_m = 1;  // |x| of the tip at most

struct HandAim {
  std::uint32_t magic = kHandMagic;
  std::uint32_t version = kHandVersion;
  std::uint32_t present = 1;  // 0: the pen is taken away; 1: it is there
  std::uint32_t reserved = 0;
  std::array<double, 3> tip_base_m{};         // device point
  std::array<double, 3> axis_base{0, 0, -1};  // out of the tip; a unit vector, |u|^2 within kUnitTolerance of 1
};
static_assert(std::is_trivially_copyable_v<HandAim> && sizeof(HandAim) == 64);

// Checks received bytes. False: wrong size, magic or version, or a number out of range or NaN; `aim` is unchanged.
bool ReadHandAim(const void* bytes, std::size_t size, HandAim& aim) noexcept;

}  // namespace omni::protocol
