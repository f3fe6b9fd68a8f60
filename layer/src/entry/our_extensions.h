// The extensions that this layer supports, from layer/extensions.json, which the manifests are made from too.
#pragma once

#include <cstdint>
#include <span>

namespace omni::layer {

struct OurExtension {
  const char* name;
  std::uint32_t version;
  bool may_be_below;  // requested from the runtime first; otherwise only we know it, and it is never passed down
  const char* needs;  // another one of ours that must be enabled too; null: none
};

std::span<const OurExtension> OurExtensions();

}  // namespace omni::layer
