// Third repair step: each component's front faces out of the body. docs/theory/haptics.md (R.6). Set-up only.
#pragma once

#include "service/haptics/geometry/mesh.h"

namespace omni::haptics {

struct OrientReport {
  std::uint32_t flipped = 0;   // components that were inside-out
  std::uint32_t cavities = 0;  // closed, inwards, inside another component: left so
};

// Precondition: mesh.component is filled with numbers below `components`, each component is oriented in itself.
OrientReport OrientOutwards(Mesh& mesh, std::uint32_t components);

}  // namespace omni::haptics
