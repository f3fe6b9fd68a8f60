#include "layer/src/models/pen_model.h"

#include <algorithm>

namespace omni::layer {

XrRenderModelNodeStateEXT StateOf(const PenPart& part, const protocol::InputSnapshot& inputs) noexcept {
  float pressed = 0;
  for (const protocol::InputIndex input : part.inputs)
    pressed = std::max(pressed, inputs.components[static_cast<std::size_t>(input)].value);
  // A NaN leaves `pressed` as it is.
  pressed = std::min(pressed, 1.0f);
  const XrVector3f& t = part.travel_m;
  return {{{0, 0, 0, 1}, {pressed * t.x, pressed * t.y, pressed * t.z}}, XR_TRUE};
}

}  // namespace omni::layer
