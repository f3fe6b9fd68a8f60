// Seam structs between haptics, actuation and device.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "service/base/limits.h"
#include "service/base/vec.h"

namespace omni::base {

// Force and torque on the tool about `point_base_m`, in B.
struct Wrench {
  Vec3 force_N;
  Vec3 torque_Nm;
  Vec3 point_base_m;
};

struct CoilCurrents {
  std::array<double, kCoilCount> current_A{};
};

// Feasible forces at one pose and temperature, passed from actuation to haptics by loop.
// A force f (N, in B) needs the currents I = ampere_per_newton f + w bias_A, w = 1 from |f| = bias_fade_N on; it is
// feasible if |f| <= force_max_N, |I_k| <= current_max_A[k] and sum_k resistance_ohm[k] I_k^2 <= power_max_W.
// valid = false (pose unknown or out of reach): nothing may be rendered. Computed with by service/base/force_limit.h.
struct ForceLimit {
  bool valid = false;
  bool near_singular = false;                 // one direction of force is faded out of ampere_per_newton
  std::array<double, 9> ampere_per_newton{};  // row-major 3x3
  std::array<double, kCoilCount> bias_A{};    // cancels the core's pull on the magnet, 0 when not compensated
  double bias_fade_N = 0;                     // smaller requests have a share of it only, 0: none fades
  std::array<double, kCoilCount> current_max_A{};
  std::array<double, kCoilCount> resistance_ohm{};                // of the copper as warm as it is
  double power_max_W = std::numeric_limits<double>::infinity();   // of all coils together
  double force_max_N = 0;                                         // hard cap of |f|, whatever the currents allow
  double force_rise_N = std::numeric_limits<double>::infinity();  // the most by which |f| may grow in this tick
  // What currents I do here: force newton_per_ampere I + snapping_N on the tool and, as a side effect that three
  // currents cannot also control, torque newton_metre_per_ampere I + snapping_Nm about the magnet's centre.
  std::array<double, 9> newton_per_ampere{};        // row-major 3x3
  std::array<double, 9> newton_metre_per_ampere{};  // row-major 3x3
  Vec3 snapping_N, snapping_Nm;                     // the core's pull
  double conditioning = 0;  // smallest over largest singular value of newton_per_ampere; 0: singular
};
static_assert(std::is_trivially_copyable_v<Wrench> && std::is_trivially_copyable_v<ForceLimit>);

}  // namespace omni::base
