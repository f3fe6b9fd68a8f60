// Forces that an application applies itself: one force under a deadman, and constraints. One call per tick, after
// haptics::Step and within its stiffness bound. docs/theory/haptics.md, section 14.
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "service/haptics/applied/constraint.h"
#include "service/haptics/haptics.h"
#include "service/haptics/stability/stability.h"
#include "service/haptics/state.h"

namespace omni::haptics {

inline constexpr std::uint32_t kMaxConstraints = 8;

struct AppliedConfig {
  double force_slew_N_s = 850;                        // |dF/dt| of force and constraints together
  double force_max_N = 2;                             // of force and constraints together, anywhere
  double close_s = 0.010;                             // fade to zero: deadman, stop, lost focus, silence
  double open_s = 0.050;                              // fade-in of constraints
  double force_open_s = 0.004;                        // fade-in of the force, unless its own ramp takes longer
  double blend_s = 0.010;                             // from one set of constraints to the next
  double follow_fall_s = 0.050, follow_rise_s = 0.5;  // of the stiffness allowed for constraints
};

// What the pen's owner requests, as fixed-size data.
struct AppliedCommand {
  bool open = false;           // may be rendered: focused, alive
  std::uint64_t force_id = 0;  // a new one: from the current force to this one, over ramp_s
  base::Vec3 force_base_N;
  std::int64_t force_end_ns = 0;  // CLOCK_MONOTONIC: the deadman
  double ramp_s = 0;
  std::uint64_t constraints_id = 0;   // a new one: a new set of constraints
  std::int64_t constraints_t_ns = 0;  // time of their poses
  std::uint32_t constraint_count = 0;
  std::array<Constraint, kMaxConstraints> constraints;
};
static_assert(std::is_trivially_copyable_v<AppliedCommand>);

struct AppliedInput {
  std::int64_t t_ns = 0;  // of the Hall sample
  double dt_s = 1e-3;
  bool allowed = true;  // commands are fresh, the device has no fault
  bool tracked = false;
  base::Vec3 device_point_base_m;  // as measured
  base::Vec3 velocity_base_m_s;
  double tip_sigma_m = 0, velocity_sigma_m_s = 0;  // of the worst direction
  ActingForce acting;
  StiffnessBound bound;              // of this tick's Step
  const Output* contacts = nullptr;  // of this tick's Step: their stiffness has priority
};

struct AppliedState {
  bool known = false;         // constraints have been adopted
  double presence = 0;        // 0..1 gain on constraints
  double force_presence = 0;  // on the force
  std::uint64_t force_id = 0;
  base::Vec3 from_N, to_N;  // the force moves from one to the other ...
  double moved_s = 0;       // ... for this long so far ...
  double move_s = 0;        // ... over this time
  std::uint64_t constraints_id = 0;
  base::Vec3 constraints_N;                                   // at the last tick
  base::Vec3 offset_N;                                        // left of the previous constraints' force; fades out ...
  double offset_left_s = 0;                                   // ... over this time
  double stiffness_N_m = 0, along_N_m = 0, damping_Ns_m = 0;  // allowed: follows the stiffness bound
  double share = 1;                                           // of it for each spring, for they add up
  EnergyState energy;
  SwingState swing;
  base::Vec3 last_N;
};
static_assert(std::is_trivially_copyable_v<AppliedState>);

struct AppliedOutput {
  base::Vec3 force_base_N;         // finite, slew-limited, at most force_max_N
  bool acts = false;               // a force or a constraint is active
  bool saturated = false;          // more than force_max_N was requested
  bool stiffness_limited = false;  // a constraint that acts is softer or less damped than requested
  double energy_gain = 1;          // < 1: constraints gave energy to the hand, or made it swing, and are reduced
};

// True: Apply would do nothing, and leaves `state` as it is.
bool IsAtRest(const AppliedCommand& command, const AppliedState& state) noexcept;

// noexcept, no allocation, no system call; whatever the command holds, the force is finite and within its limits.
void ComputeAppliedForce(const AppliedConfig& config, const AppliedCommand& command, const AppliedInput& input,
                         AppliedState& state, AppliedOutput& output) noexcept;

}  // namespace omni::haptics
