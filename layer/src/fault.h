// Seeded faults, for tests only: OMNI_FAULT("name") marks a place where the layer can be made to break one rule. The
// library that ships is built without OMNI_LAYER_FAULTS: there the macro is the constant false, and neither code nor
// text of a fault is left (Faults.TheShippedLayerHasNone). With it (target XrApiLayer_omni_faulty) the environment
// variable OMNI_LAYER_FAULT names the one fault of this process. tests/layer/rules.json says which rule each breaks.
// Only in .cc files: a header would be compiled with and without it into one library.
#pragma once

#ifdef OMNI_LAYER_FAULTS

#include <cstdlib>
#include <cstring>

namespace omni::layer {

inline bool FaultIs(const char* name) noexcept {
  static const char* const seeded = ::secure_getenv("OMNI_LAYER_FAULT");
  return seeded && std::strcmp(seeded, name) == 0;
}

}  // namespace omni::layer

#define OMNI_FAULT(name) (::omni::layer::FaultIs(name))

#else

#define OMNI_FAULT(name) false

#endif
