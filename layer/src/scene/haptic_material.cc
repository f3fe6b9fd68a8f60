#include "layer/src/scene/haptic_material.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>

#include "service/base/aggregate.h"
#include "service/base/material.h"

namespace omni::layer {
namespace {

// The structure is its type, its chain, and a float for each live field, in their order (a test compares the names).
using Floats = std::array<float, base::kLiveMaterialFields>;
static_assert(base::FieldCount<XrHapticMaterialOMNIX1>() == 2 + base::kLiveMaterialFields,
              "XrHapticMaterialOMNIX1 has a float for each live field of service/base/material.h");
constexpr std::size_t kFloatsAt = offsetof(XrHapticMaterialOMNIX1, stiffness);

Floats FloatsOf(const XrHapticMaterialOMNIX1& material) noexcept {
  Floats floats;
  std::memcpy(floats.data(), reinterpret_cast<const std::byte*>(&material) + kFloatsAt, sizeof(floats));
  return floats;
}

}  // namespace

bool IsMaterial(const XrHapticMaterialOMNIX1& material) noexcept {
  const Floats floats = FloatsOf(material);
  return std::all_of(floats.begin(), floats.end(), [](float x) { return std::isfinite(x); });
}

base::MaterialParameters ToParameters(const XrHapticMaterialOMNIX1& material) noexcept {
  const Floats floats = FloatsOf(material);
  base::MaterialParameters given;
  for (std::size_t i = 0; i < floats.size(); ++i) given.*base::kLiveFields[i]->live = double{floats[i]};
  base::MaterialParameters parameters = base::Clamped(given);
  parameters.dynamic_friction = std::min(parameters.dynamic_friction, parameters.static_friction);
  return parameters;
}

void Put(const base::MaterialParameters& parameters, XrHapticMaterialOMNIX1& material) noexcept {
  Floats floats;
  for (std::size_t i = 0; i < floats.size(); ++i)
    floats[i] = static_cast<float>(parameters.*base::kLiveFields[i]->live);
  std::memcpy(reinterpret_cast<std::byte*>(&material) + kFloatsAt, floats.data(), sizeof(floats));
}

}  // namespace omni::layer
