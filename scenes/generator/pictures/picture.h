// A small software renderer: z-buffer, supersampled; light from many directions, each with its own shadow map, so that
// folds and undersides darken as they do under a sky.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "scenes/generator/mesh/mesh.h"

namespace omni::scenes {

// What pictures are made of.
struct DrawnMesh {
  std::string name;
  Mesh mesh;  // base frame, colours per vertex
  std::vector<Vec> normals;
  double roughness = 0.7;
  bool overlay = false;  // seen through everything, casts and takes no shadow
};

// What a scene looks like, one mesh per primitive of each node, by the service's own reader
// (service/scene/drawn_scene.h). What is not drawn is reported on stderr. Throws std::runtime_error.
std::vector<DrawnMesh> ReadMeshes(const std::string& path);

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

// For words and a colour scale on a picture as Render makes it.
struct Pixels {
  std::vector<std::uint8_t>& rgb;
  int width, height;
};

// Along the lower edge; ASCII.
void DrawCaption(const std::string& text, Pixels pixels);

// Bar on the right: from no displacement to the largest that is shown, in mm.
void DrawDisplacementScale(double displacement_max_m, Pixels pixels);

}  // namespace omni::scenes
