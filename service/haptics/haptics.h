// The haptic renderer: one function per tick, from the device point to a force.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <type_traits>

#include "service/base/force_limit.h"
#include "service/base/tool_state.h"
#include "service/base/vec.h"
#include "service/haptics/scene/material.h"

namespace omni::haptics {

class Scene;   // scene/scene.h
struct State;  // state.h

inline constexpr int kMaxContacts = 4;  // objects touched at once; the deepest ones are kept

struct Config {
  double force_slew_N_s = 850;      // |dF/dt| limit (0.85 N/ms)
  double ramp_s = 0.15;             // force fades in over this time after contact at start, scene swap, tracking loss
  double stiffness_max_N_m = 1000;  // upper bound, whatever the material says: rule in stability/stability.h
  double delay_s = 3e-3;            // as Input's, while none is measured; for the stability rule
  double coil_lag_s = 0.4e-3;       // control step to 63 % of a current; `omni-bench latency` measures .23 to .35 ms
  double predict_max_s = 0.020;     // the tip is predicted to when the current acts, at most so far
  double hand_damping_Ns_m = 1.0;   // assumed lower bound
  double contact_threshold_N = 0.010;  // "contact" in reports means more than this
};

inline constexpr std::uint32_t kMaxMoved = 16;  // kinematic objects that the application moves at a time

// Where the application holds a kinematic object: x = R x_rest + t.
struct ObjectPose {
  std::uint32_t object = kNoIndex;
  base::Quat rotation;       // unit, from where the scene has it
  base::Vec3 translation_m;  // base frame
  bool leaps = false;        // teleported since the last tick, not moved, however near
};

// How a scene as a whole has moved since the last tick (live/scene_changes.h). Its poses are in its own frame then.
enum class SceneMotion : std::uint8_t { kStill = 0, kMoves = 1, kLeaps = 2 };

// Where a whole scene stands: x_base = R x + t.
struct Placement {
  base::Quat rotation;  // unit
  base::Vec3 translation_m;
  friend bool operator==(const Placement&, const Placement&) = default;
};

// Force of the coils on the pen at the instant of a sample, from the currents measured with it: what was commanded
// before, however late it has arrived.
struct ActingForce {
  bool known = false;
  base::Vec3 force_N;  // base frame
  double share = 1;    // of what is rendered that is passed on to the coils
};

struct Input {
  std::int64_t t_ns = 0;
  double dt_s = 1e-3;              // time since the last tick, clamped to [0, 5 ms] by the caller
  bool tracked = false;            // false: force goes to zero under the slew limit; contacts are forgotten after 25 ms
  base::Vec3 device_point_base_m;  // at t_ns, not predicted
  base::Vec3 velocity_base_m_s;    // of the device point
  base::PointNoise noise;          // of the device point, along its worst direction
  base::PointNoise noise_along;    // along the pen's axis
  // Of the pen, unit, out of its tip. Zero: not known; noise is alike in all directions, and a ball at the tip is
  // around the device point.
  base::Vec3 axis_base;
  base::Vec3 axis_rate_base_1_s;  // its change
  double delay_s = 0;             // measured: sample instant to the control step that acts; 0: not known
  ActingForce acting;
  base::ForceLimit limit;
  std::span<const ObjectPose> poses;          // at t_ns, at most kMaxMoved; objects not named stay where they are
  std::span<const MaterialChange> materials;  // all that differ from the scene's, at most kMaxLiveMaterials
  SceneMotion scene_motion = SceneMotion::kStill;
  bool pushed = false;       // something else moves the hand now: its energy is not counted against contacts
  bool constrained = false;  // nor is that of springs of the application
};

struct Contact {
  std::uint32_t object = kNoIndex;
  std::uint32_t material = 0;
  std::uint32_t triangle = kNoIndex;
  base::Vec3 point_base_m;  // proxy
  base::Vec3 normal_base;   // unit, out of the object
  double gap_m = 0;         // signed: < 0 penetrating
  double normal_force_N = 0;
  double tangential_force_N = 0;
  double load = 0;           // its stiffness over the bound along the normal
  base::Vec3 force_base_N;   // total force that it requests on the tip
  base::Vec3 slip_base_m_s;  // of the tip along the surface, relative to it
};

// The car, for drawing and display.
struct VehicleReport {
  bool on = false;  // the scene has a vehicle
  bool sliding = false;
  std::uint32_t hits = 0, laps = 0;
  base::Vec3 position_base_m;                        // centre of mass
  double heading_rad = 0;                            // about +z, 0 = +x
  double speed_m_s = 0;                              // along its heading
  double lap_s = 0, last_lap_s = 0, best_lap_s = 0;  // 0: none
};

struct Output {
  base::Vec3 force_base_N;  // finite, <= limit, slew-limited
  bool in_contact = false;  // |rendered force| > contact_threshold
  bool holding = false;     // the tip holds a face or a sculpted surface, which follows it
  bool waits = false;       // the tip is inside what appeared around it or was pushed through: no force until it is out
  int contact_count = 0;
  std::array<Contact, kMaxContacts> contacts;
  double tip_normal_force_N = 0;  // sum of requested normal contact forces, before limits: drives tip force inputs
  bool joystick = false;          // the scene says joystick: thumbstick is live
  double thumbstick_x = 0, thumbstick_y = 0;  // -1..1, +y away from the user (+y of B), +x right
  bool saturated = false;                     // the limit cut the force
  double stiffness_cut = 1;                   // rendered / requested stiffness of the stiffest contact
  double stiffness_offered_N_m = 0;           // largest bound now: of a surface perpendicular to the pen's axis
  double energy_gain = 1;  // < 1: contacts gave energy to the hand, or made it swing, and are reduced
  VehicleReport vehicle;
};
static_assert(std::is_trivially_copyable_v<Output>);

// Sets `state` for a scene that has just become current: nothing touched, car at its start, ramp at zero. Keeps
// last_force_N, so that the slew limit holds over the swap.
void EnterScene(const Scene& scene, State& state) noexcept;

// Force on the tool at the device point. `scene` empty: zero force (slewed down).
void Step(const Config& config, const Scene& scene, const Input& input, State& state, Output& output) noexcept;

}  // namespace omni::haptics
