// The response of steel near the base to all field sources there. Each piece responds to the base alone, not to the
// other pieces. docs/theory/truth.md (16), (17)
#pragma once

#include <array>
#include <cstddef>

#include "service/base/room_parameters.h"
#include "service/sim/fields/vec3.h"

namespace omni::sim {

// B = mu0 / 4 pi (3 (m.n) n - m) / r^3 of a dipole at the origin [Jackson 3e, 5.56].
Vec3 DipoleField(const Vec3& moment_Am2, const Vec3& point_m) noexcept;

class SteelPiece {
 public:
  explicit SteelPiece(const base::Steel& steel) noexcept;

  // Response to the field of everything at the base as if there were no steel: Vec3 field_T(const Vec3& point_base_m).
  // Linear in it. What does not depend on the point is computed once. Piece and field outlive it.
  template <class Field>
  class Answer {
   public:
    Answer(const SteelPiece& piece, const Field& field_T) noexcept : Answer(piece, field_T, piece.MeanField(field_T)) {}
    // mean_T = piece.MeanField(field_T), known already.
    Answer(const SteelPiece& piece, const Field& field_T, const Vec3& mean_T) noexcept
        : piece_(piece), field_T_(field_T), mean_T_(mean_T) {}
    Vec3 FieldAt(const Vec3& point_base_m) const noexcept {
      if (!piece_.IsPlane()) return piece_.AnswerTo(mean_T_, point_base_m);
      const Vec3 mirrored_T = field_T_(piece_.MirroredPoint(point_base_m));
      return -piece_.steel_.strength * piece_.MirroredDirection(mirrored_T);
    }

   private:
    const SteelPiece& piece_;
    const Field& field_T_;
    Vec3 mean_T_;
  };

  bool IsPlane() const noexcept { return steel_.shape == base::SteelShape::kPlane; }
  // Over a ball or bar, weighed by the cross-section; zero of a plane.
  template <class Field>
  Vec3 MeanField(const Field& field_T) const noexcept {
    Vec3 mean_T;
    for (std::size_t i = 0; i < node_count_; ++i) mean_T += share_[i] * field_T(node_base_m_[i]);
    return mean_T;
  }
  // Of a ball or bar in that mean field.
  Vec3 AnswerTo(const Vec3& mean_T, const Vec3& point_base_m) const noexcept;

 private:
  static constexpr std::size_t kNodes = 9;
  Vec3 MirroredPoint(const Vec3& point_base_m) const noexcept;
  Vec3 MirroredDirection(const Vec3& v) const noexcept;

  base::Steel steel_;
  double along_Am2_T_ = 0, across_Am2_T_ = 0;  // moment per field, along the bar's axis and across
  std::size_t node_count_ = 0;
  std::array<Vec3, kNodes> node_base_m_;
  std::array<double, kNodes> share_{};  // of the moment
};

}  // namespace omni::sim
