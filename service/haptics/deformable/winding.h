// Inside or outside of a triangle soup. The winding number is 1 inside and 0 outside of a closed mesh, and between them
// it falls smoothly over holes, so that "more than a half" is a sound inside test on open, unwelded, self-intersecting
// and duplicated surfaces, where counting the crossings of a ray is not [Jacobson et al. 2013]. Far triangles count as
// one dipole per cluster [Barill et al. 2018]. Set-up only.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "service/haptics/geometry/vec_math.h"

namespace omni::haptics {

class WindingField {
 public:
  // Precondition: indices in range, vertices finite. Keeps copies.
  WindingField(std::span<const Vec3> vertices, std::span<const std::array<std::uint32_t, 3>> triangles);

  double At(const Vec3& p) const;
  bool Inside(const Vec3& p) const { return At(p) > 0.5; }

 private:
  struct Cluster {
    Vec3 centre;          // area-weighted
    Vec3 area;            // sum of area vectors / 2
    double radius_m = 0;  // farthest corner from the centre
    std::uint32_t first = 0, count = 0;
    std::uint32_t right = 0;  // left child is the next cluster; 0: leaf
  };
  std::uint32_t Build(std::uint32_t first, std::uint32_t count, std::vector<std::uint32_t>& order,
                      const std::vector<std::array<Vec3, 3>>& soup);

  std::vector<std::array<Vec3, 3>> corners_;
  std::vector<Cluster> clusters_;
};

}  // namespace omni::haptics
