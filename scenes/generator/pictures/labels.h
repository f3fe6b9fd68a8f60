// Words and a colour scale on a picture.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scenes/generator/mesh/mesh.h"

namespace omni::scenes {

// RGB, 8 bits each, rows from the top; as Render makes it.
struct Pixels {
  std::vector<std::uint8_t>& rgb;
  int width, height;
};

// Along the lower edge; ASCII.
void DrawCaption(const std::string& text, Pixels pixels);

// Bar on the right: from no displacement to the largest that is shown, in mm.
void DrawDisplacementScale(double displacement_max_m, Pixels pixels);

}  // namespace omni::scenes
