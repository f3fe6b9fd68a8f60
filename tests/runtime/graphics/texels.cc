#include "tests/runtime/graphics/texels.h"

#include <cmath>

namespace omni::runtime {
namespace {

float ToLinear(int value, bool srgb) {
  const float part = static_cast<float>(value) / 255.0F;
  if (!srgb) return part;
  return part <= 0.04045F ? part / 12.92F : std::pow((part + 0.055F) / 1.055F, 2.4F);
}

}  // namespace

Picture FromTexels(const uint8_t* bytes, uint32_t width, uint32_t height, bool srgb, bool blue_first) {
  float linear[256];
  for (int i = 0; i < 256; ++i) linear[i] = ToLinear(i, srgb);
  Picture picture{width, height, std::vector<float>(size_t{width} * height * 4)};
  for (size_t i = 0; i < picture.rgba.size(); i += 4) {
    picture.rgba[i] = linear[bytes[i + (blue_first ? 2 : 0)]];
    picture.rgba[i + 1] = linear[bytes[i + 1]];
    picture.rgba[i + 2] = linear[bytes[i + (blue_first ? 0 : 2)]];
    picture.rgba[i + 3] = ToLinear(bytes[i + 3], false);
  }
  return picture;
}

}  // namespace omni::runtime
