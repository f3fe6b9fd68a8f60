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
// A force f (N, in B) needs the currents I = ampere_per_newton f + bias_A; it is feasible if
// |I_k| <= current_max_A[k]. valid = false (pose unknown or out of reach): nothing may be rendered.
struct ForceLimit {
  bool valid = false;
  bool near_singular = false;                 // one direction of force is faded out of ampere_per_newton
  std::array<double, 9> ampere_per_newton{};  // row-major 3x3
  std::array<double, kCoilCount> bias_A{};    // cancels the core's pull on the magnet, 0 when not compensated
  std::array<double, kCoilCount> current_max_A{};
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
