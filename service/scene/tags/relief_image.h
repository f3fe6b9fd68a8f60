// Heights from the normals that a glTF material has for its looks: what a person sees as relief can be felt.
// docs/theory/haptics.md, (T.3).
#pragma once

#include <cstdint>
#include <span>

#include "service/base/work_watch.h"
#include "service/haptics/scene/scene_input.h"

namespace omni::scene {

// Pixels as decoded: rows from the top, red, green and blue the normal's x (to the right), y (up) and z, [0, 255] for
// [-1, 1].
struct NormalPixels {
  std::span<const std::uint8_t> pixels;  // width x height x channels
  std::uint32_t width = 0, height = 0;
  std::uint32_t channels = 0;  // >= 3
};

// All but how it is sampled; the image holds its bands. Heights are relative to their mean.
struct MadeRelief {
  haptics::InputRelief relief;
  haptics::InputImage bands;
};
MadeRelief ReliefOf(const NormalPixels& normals, const base::WorkWatch& watch);

// Memory while it is made, beside the pixels: of an image of any size at most this.
inline constexpr std::uint64_t kReliefWorkBytes = 16ull << 20;

}  // namespace omni::scene
