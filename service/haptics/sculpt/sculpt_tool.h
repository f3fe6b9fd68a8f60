// The tick's side of sculpting: press the surface until it is held, then push or pull; it yields like wax, and messages
// report to the editor by how much. While held, the tool's own force replaces the contact's, so nothing the editor does
// to the surface can kick the pen. docs/theory/sculpting.md, section 5.
#pragma once

#include "service/haptics/sculpt/stroke.h"

namespace omni::haptics::sculpt {

// How a material resists the tool. SI.
struct SculptParameters {
  double grab_force_N = 0.5;      // (0, 2]: press at least this ...
  double dwell_s = 0.2;           // ... for this long to take hold
  double yield_N = 0.2;           // [0, 2]: below, it does not yield
  double hardening_N_m = 40;      // [0, 2000]: and this much more for every metre it was moved
  double viscosity_Ns_m = 4;      // [0, 100]: and this much more for every metre per second
  double stiffness_N_m = 400;     // [0, 2000], of the hold, at most what stability allows
  double hold_force_max_N = 1.5;  // (0, 2]
  double side_force_max_N = 0.4;  // across the direction of the pull
  double tear_m = 0.006;          // stretched this much beyond where it yields, the hold breaks
  double rest_s = 0.5;            // >= 0; resting this long, neither pressed nor pulled: released; 0: never
  double grid_step_m = 0;         // offsets settle on multiples of it; 0: no grid
  double offset_max_m = 0.05;     // (0, 1], either way
};

// Contact of the tip with the sculptable surface in this tick; not touching: the other members are ignored.
struct SculptTouch {
  bool touching = false;
  std::uint32_t triangle = 0;
  std::array<double, 3> weights{};
  Vec3 point_base_m;  // proxy
  Vec3 normal;        // unit, outwards
  double normal_force_N = 0;
};

struct SculptInput {
  bool tracked = false;
  Vec3 tip_base_m;
  double dt_s = 0;                        // [0, 5 ms]
  double stiffness_limit_N_m = 0;         // what stability allows in every direction ...
  double normal_stiffness_limit_N_m = 0;  // ... and along the normal of the hold
  std::uint64_t generation = 0;           // of the surface the touch is on
  std::uint32_t releases = 0;             // so often a user has asked to let go, by another one what is held is
  SculptTouch touch;
  Brush brush;
};

struct SculptToolOutput {
  Vec3 force_N;              // to be added
  double contact_share = 1;  // to multiply the contact force of the sculptable surface with
};

inline constexpr double kHandOver_s = 0.02;   // from the contact's force to the tool's, and back
inline constexpr double kLeastMove_m = 2e-5;  // smaller moves wait until they are this large, or the last
inline constexpr double kSettleSpeed_m_s = 0.05;

// One tick. Sends at most one message into `ring`; while that is full, messages wait.
SculptToolOutput StepSculptTool(const SculptParameters& parameters, const SculptInput& input, SculptToolState& state,
                                StrokeRing& ring) noexcept;

}  // namespace omni::haptics::sculpt
