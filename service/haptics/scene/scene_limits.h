// How large a scene may be.
#pragma once

#include <cstdint>

namespace omni::haptics {

inline constexpr std::uint32_t kMaxObjects = 64;  // more: BuildScene fails, with the number
inline constexpr std::uint32_t kMaxRegions = 16;  // extrude regions; further ones stay rigid, with a report line
inline constexpr std::uint32_t kMaxSculpted = 4;  // sculpted objects; further ones stay rigid, with a report line
inline constexpr std::uint32_t kMaxTriangles = 4'000'000;  // in a whole scene
inline constexpr std::uint32_t kMaxTextures = 64;
inline constexpr std::uint32_t kMaxTexels = 64u << 20;  // of all images together
inline constexpr std::uint32_t kNoIndex = 0xFFFFFFFF;

}  // namespace omni::haptics
