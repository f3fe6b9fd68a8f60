// Composition layers that an application placed in a space of the pen, converted to a space that the runtime knows.
#pragma once

#include <cstddef>
#include <list>
#include <vector>

#include "layer/src/spaces/pose_math.h"

namespace omni::layer {

// Copies of layers, alive as long as this object. The application's own structures are never written.
class FrameLayers {
 public:
  // Projection, quad, cube, cylinder, equirect, equirect2. Of other types we do not know where their poses are.
  static bool Knows(XrStructureType type) noexcept;

  // The same layer in the space `anchor`, L. `next` chains are kept. Precondition: Knows(layer.type).
  const XrCompositionLayerBaseHeader* Move(const XrCompositionLayerBaseHeader& layer, XrSpace anchor, const Pose& X_LS);

 private:
  struct Copy {
    alignas(std::max_align_t) std::byte layer[256];
    std::vector<XrCompositionLayerProjectionView> views;
  };
  std::list<Copy> copies_;
};

}  // namespace omni::layer
