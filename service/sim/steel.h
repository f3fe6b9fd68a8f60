// What steel near the base answers to everything that stands there. Each piece answers the base alone, not the other
// pieces. docs/theory/truth.md (16), (17)
#pragma once

#include <array>
#include <cstddef>

#include "service/base/room_parameters.h"
#include "service/sim/vec3.h"

namespace omni::sim {

// B = mu0 / 4 pi (3 (m.n) n - m) / r^3 of a dipole at the origin [Jackson 3e, 5.56].
Vec3 DipoleField(const Vec3& moment_Am2, const Vec3& point_m) noexcept;

class SteelPiece {
 public:
  explicit SteelPiece(const base::Steel& steel) noexcept;

  // Where the field of the base is needed to know the answer at `point`: `field_T` is called there. Linear in it.
  //   Vec3 field_T(const Vec3& point_base_m): of what stands at the base, as if there were no steel.
  template <class Field>
  Vec3 AnswerAt(const Vec3& point_base_m, const Field& field_T) const noexcept {
    if (steel_.shape == base::SteelShape::kPlane) {
      return -steel_.strength * MirroredDirection(field_T(MirroredPoint(point_base_m)));
    }
    Vec3 along_T;  // mean field, weighed by the cross-section
    for (std::size_t i = 0; i < node_count_; ++i) along_T += share_[i] * field_T(node_base_m_[i]);
    return AnswerTo(along_T, point_base_m);
  }

  Vec3 MirroredPoint(const Vec3& point_base_m) const noexcept;

 private:
  static constexpr std::size_t kNodes = 9;
  Vec3 MirroredDirection(const Vec3& v) const noexcept;
  // Of a ball or bar in the mean field.
  Vec3 AnswerTo(const Vec3& mean_T, const Vec3& point_base_m) const noexcept;

  base::Steel steel_;
  double along_Am2_T_ = 0, across_Am2_T_ = 0;  // moment per field, along the bar's axis and across
  std::size_t node_count_ = 0;
  std::array<Vec3, kNodes> node_base_m_;
  std::array<double, kNodes> share_{};  // of the moment
};

}  // namespace omni::sim
