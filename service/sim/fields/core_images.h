// The iron core's response to magnetic charges outside it.
//
// A sphere of permeability mu and radius a answers a charge q at distance r0, order by order, with kappa_l times the
// answer of an infinitely permeable one, kappa_l = l (mu - 1) / (l (mu + 1) + 1) [Stratton, Electromagnetic Theory,
// 3.23]. With kappa_inf = (mu - 1) / (mu + 1),
//   kappa_l = kappa_inf (1 - 1 / (l (mu + 1) + 1)),
// an image -kappa_inf q a / r0 at a^2 / r0 and a line charge from there to the centre [Neumann 1883; Lindell 1992],
// which three charges on the ray replace: they have its moments l = 1, 2, 3. A charge at the centre keeps the core
// neutral. docs/theory/truth.md (3)-(5).
#pragma once

#include <array>
#include <cstddef>

#include "service/sim/fields/charges.h"

namespace omni::sim {

class CoreImages {
 public:
  // core_kappa = (mu - 1) / (mu + 2) in [0, 1]; 1: infinitely permeable.
  CoreImages(double core_radius_m, double core_kappa, const Vec3& centre_base_m = {}) noexcept;

  // How many images `sources` charges have.
  std::size_t image_count(std::size_t sources) const noexcept { return sources * (1 + node_count_) + 1; }
  // Precondition: all charges outside the core; `images` has image_count(charges.size()) entries.
  void PlaceImages(const Charges& charges, Charges& images) const noexcept;

 private:
  static constexpr std::size_t kNodes = 3;
  double radius_m_;
  Vec3 centre_base_m_;
  double image_strength_;                // kappa_inf
  std::size_t node_count_ = 0;           // 0: infinitely permeable
  std::array<double, kNodes> weight_{};  // of the image's charge, at kNodePlaces of its distance from the centre
};

}  // namespace omni::sim
