// A surface before it was deformed or sculpted: how far a place has come from it, and which paint it had there.
#pragma once

#include <cstdint>
#include <vector>

#include "scenes/generator/pictures/picture.h"

namespace omni::scenes {

struct RestPlace {
  double distance_m = 0;  // to the nearest place of the rest surface
  Vec colour{0.0};        // there, linear RGB
};

// Triangles in a grid of cells. Precondition: at least one triangle.
class RestSurface {
 public:
  explicit RestSurface(const std::vector<DrawnMesh>& meshes);
  RestPlace Nearest(const Vec& p) const;

 private:
  struct PaintedTriangle {
    Vec corner[3], colour[3];
  };
  using Cell = glm::ivec3;
  Cell CellOf(const Vec& p) const;
  std::size_t IndexOf(const Cell& cell) const;

  std::vector<PaintedTriangle> triangles_;
  std::vector<std::vector<std::uint32_t>> cells_;  // triangles that may reach into each
  Vec lower_{1e9};
  double cell_m_ = 1;
  Cell count_{1};
};

// `meshes`, of a file without colours, painted as `rest`; parts that only `rest` has, by name, are added as they are.
// With displacement_max_m > 0 places are coloured yellow to red by their distance from the rest surface.
std::vector<DrawnMesh> PaintLike(const std::vector<DrawnMesh>& rest, std::vector<DrawnMesh> meshes,
                                 double displacement_max_m);

// Of a displacement, as a share of the largest that is shown; `paint` where there is none.
Vec DisplacementColour(double share, const Vec& paint);

}  // namespace omni::scenes
