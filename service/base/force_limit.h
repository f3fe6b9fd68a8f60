// Seam structs between haptics, actuation and device, and the one rule for "can the device push this hard, there":
// shared by haptics (scales its request) and actuation (scales its output). Vector scaling keeps the direction
// (docs/theory/actuation.md).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
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
// valid = false (pose unknown or out of reach): nothing may be rendered.
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

// M v, M row-major 3x3 as in `ForceLimit`.
constexpr Vec3 Multiply(const std::array<double, 9>& M, const Vec3& v) noexcept {
  return {M[0] * v.x + M[1] * v.y + M[2] * v.z, M[3] * v.x + M[4] * v.y + M[5] * v.z,
          M[6] * v.x + M[7] * v.y + M[8] * v.z};
}

// One limit along a line: a s^2 + 2 b s + c <= 0 where s is within it.
struct LimitAlong {
  double a = 0, b = 0, c = 0;

  double At(double s) const noexcept { return (a * s + 2 * b) * s + c; }
  // `s` if it is within, else the greater root if that is less; negative if there is none.
  double ClampToLimit(double s) const noexcept {
    if (At(s) <= 0) return s;
    const double square = b * b - a * c;
    if (!(square >= 0)) return -1;
    return std::min(s, b > 0 ? -c / (b + std::sqrt(square)) : (std::sqrt(square) - b) / a);
  }
};

// The currents for a force, I = A f + w(|f|) b: what `ForceLimit` describes.   docs/theory/actuation.md (4.1), (4.2)
std::array<double, kCoilCount> CurrentsFor_A(const ForceLimit& limit, const Vec3& force_N) noexcept;

// Heat of the coils with these currents and the copper as warm as it is. NaN where either is.
double Power_W(const ForceLimit& limit, const std::array<double, kCoilCount>& current_A) noexcept;

// Largest s in [0, most] with start + s step within every coil's current and the total power; negative if there is
// none or anything is not finite.   docs/theory/actuation.md (5.2)
double LargestShare(const ForceLimit& limit, const std::array<double, kCoilCount>& start_A,
                    const std::array<double, kCoilCount>& step_A, double most) noexcept;

// Largest s in [0, 1] such that s * force is feasible under `limit`; 0 if the limit is invalid or anything is not
// finite.
double FeasibleScale(const ForceLimit& limit, const Vec3& force_N) noexcept;

// What is made of a feasible force: all of it, or, where near_singular, what is left when the direction that the coils
// cannot push has faded out.
Vec3 Rendered_N(const ForceLimit& limit, const Vec3& force_N) noexcept;

// The largest force that is made along `direction` (any length) by requests in that direction; 0 in doubt.
double ForceMax_N(const ForceLimit& limit, const Vec3& direction) noexcept;

// Force on the tool while `current_A` flow. Zero where the pose is unknown.
inline Vec3 ForceOf_N(const ForceLimit& limit, const std::array<double, kCoilCount>& current_A) noexcept {
  if (!limit.valid) return {};
  return Multiply(limit.newton_per_ampere, {current_A[0], current_A[1], current_A[2]}) + limit.snapping_N;
}

// Torque on the tool while `current_A` flow, about the magnet's centre. Zero where the pose is unknown.
inline Vec3 TorqueOf_Nm(const ForceLimit& limit, const std::array<double, kCoilCount>& current_A) noexcept {
  if (!limit.valid) return {};
  return Multiply(limit.newton_metre_per_ampere, {current_A[0], current_A[1], current_A[2]}) + limit.snapping_Nm;
}

}  // namespace omni::base
