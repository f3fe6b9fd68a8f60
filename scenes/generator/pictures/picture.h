// A small software renderer: z-buffer, supersampled; light from many directions, each with its own shadow map, so that
// folds and undersides darken as they do under a sky.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "scenes/generator/pictures/drawn_mesh.h"

namespace omni::scenes {

struct View {
  std::string name;
  double azimuth_deg;  // of the camera about z, 0 = in front of +x
  double elevation_deg;
};

struct PictureOptions {
  View view;
  int width = 960, height = 720;
  int supersampling = 3;
  double zoom = 1;
  std::optional<Vec> look_at_m;  // in the middle of the picture, in place of the middle of everything ...
  double span_m = 0.1;           // ... which then shows so much of its shorter side
};

// RGB, 8 bits each, rows from the top.
std::vector<std::uint8_t> Render(const std::vector<DrawnMesh>& meshes, const PictureOptions& options);

}  // namespace omni::scenes
