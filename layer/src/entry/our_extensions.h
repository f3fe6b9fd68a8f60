// The extensions that this layer answers; the list is layer/extensions.json, which the manifests are made from too.
#pragma once

#include <cstdint>
#include <span>

namespace omni::layer {

struct OurExtension {
  const char* name;
  std::uint32_t version;
  bool may_be_below;  // asked for there first; else only we know it, and what lies below never hears of it
};

std::span<const OurExtension> OurExtensions();

}  // namespace omni::layer
