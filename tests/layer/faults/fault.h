// Whether a seeded fault (seeds.json) is the one that the environment names. Included before every source of the
// mutated copy of the layer (target XrApiLayer_omni_faulty), never by the shipped layer.
#pragma once

#include <unistd.h>

#include <cstdlib>
#include <cstring>

namespace omni::layer {

inline bool FaultIs(const char* name) noexcept {
  static const char* const seeded = ::secure_getenv("OMNI_LAYER_FAULT");
  return seeded && std::strcmp(seeded, name) == 0;
}

}  // namespace omni::layer
