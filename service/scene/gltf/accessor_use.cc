#include "service/scene/gltf/accessor_use.h"

#include <algorithm>
#include <iterator>
#include <optional>

#include "service/scene/gltf/load_error.h"

namespace omni::scene {
namespace {

constexpr unsigned kColour = kColour3 | kColour4;

constexpr UseRow kUses[] = {
    {kIndex, "SCALAR", 1, "5121, 5123 or 5125 for indices"},
    {kPosition, "VEC3", 3, "5126 (or 5120 to 5123, quantised) for positions"},
    {kUv, "VEC2", 2, "5126 (or 5120 to 5123, quantised) for texture coordinates"},
    {kVector, "VEC3", 3, "5126 for translations and scales"},
    {kRotation, "VEC4", 4, "5126, 5120 or 5122 for rotations"},
    {kNormal, "VEC3", 3, "5126 (or 5120 or 5122, quantised) for normals"},
    {kColour3, "VEC3", 3, "5126, 5121 or 5123 for colours"},
    {kColour4, "VEC4", 4, "5126, 5121 or 5123 for colours"},
};

constexpr ComponentRow kComponents[] = {{5120, 1, kPosition | kUv | kRotation | kNormal},
                                        {5121, 1, kIndex | kPosition | kUv | kColour},
                                        {5122, 2, kPosition | kUv | kRotation | kNormal},
                                        {5123, 2, kIndex | kPosition | kUv | kColour},
                                        {5125, 4, kIndex},
                                        {5126, 4, kPosition | kUv | kVector | kRotation | kNormal | kColour}};

}  // namespace

const UseRow& RowOf(Use use) {
  return *std::find_if(std::begin(kUses), std::end(kUses), [use](const UseRow& row) { return row.use == use; });
}

const ComponentRow& ComponentOf(const Json& parent, const std::string& pointer, Use use) {
  const std::uint64_t type = Whole(parent, pointer, "componentType", 1 << 16, std::nullopt);
  for (const ComponentRow& row : kComponents) {
    if (row.type == type && (row.uses & use) != 0) return row;
  }
  throw LoadError(Join(pointer, "componentType"), "is " + std::to_string(type) + ", must be " + RowOf(use).allowed);
}

std::size_t ComponentBytes(std::uint64_t type) {
  return std::find_if(std::begin(kComponents), std::end(kComponents),
                      [type](const ComponentRow& row) { return row.type == type; })
      ->bytes;
}

}  // namespace omni::scene
