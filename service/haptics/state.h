// What the haptic renderer remembers from tick to tick: haptics.h.
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "service/base/vec.h"
#include "service/haptics/deformable/soft_contact_state.h"
#include "service/haptics/haptics.h"
#include "service/haptics/scene/material.h"
#include "service/haptics/sculpt/stroke.h"

namespace omni::haptics {

// What a grating knows of the tip on it, in the object's rest frame: contact/grating.h.
struct GratingState {
  bool started = false;
  base::Vec3 place_m;   // of the tip, smoothed
  base::Vec3 slip_m_s;  // of that place
  base::Vec3 rate_m_s;  // measured slip, smoothed for a short time ...
  base::Vec3 pace_m_s;  // ... and that of the place for a long one
  base::Vec3 across;    // unit, across the ridges; zero: not known yet
  double turned_m = 0;  // way that the tip has gone in another direction
  double shift = 0;     // turns, of the phase from that of the place
};

// One touched object.
struct ContactState {
  bool active = false;
  std::uint32_t object = kNoIndex;
  std::uint32_t triangle = kNoIndex;  // of the proxy
  base::Vec3 proxy_m;                 // on the surface, in the object's rest frame; of a soft body, undeformed
  base::Vec3 held_m;                  // what the spring pulls the tip to: the proxy, or the centre of a ball
  base::Vec3 normal;                  // of the contact at the last tick, unit, out of the object, in that frame
  bool one_place = true;              // false: a ball rests on several at once; the others count in the direction only
  bool sticking = false;
  std::uint32_t anchor_triangle = kNoIndex;  // stick anchor, barycentric: survives deformation
  std::array<double, 3> anchor_weights{};
  base::Vec3 anchor_m;        // where it was at the last tick, in the same frame
  double depth_m = 0;         // of the tip under the proxy, as the proxy was found
  double side = 1;            // +1 entered from the front, -1 from the back (double-sided objects)
  double bound_N_m = 0;       // stiffness bound in the contact's direction since it began; only falls; 0: new
  double relaxation_N = 0;    // softness: viscous part
  double elastic_N = 0;       // softness: elastic part at the last tick
  base::Vec3 last_force_N;    // of the last tick, in that frame
  base::Vec3 swapped_from_N;  // force before the proxy was moved to another place ...
  double swap_left_s = 0;     // ... which fades out over this time
  bool popped = false;        // popped through, or appeared around the tip: no force until the tip is outside
  bool in_flight = false;     // a ball that nothing holds is on its way to the tip: no force until it meets something
  double through_s = 0;       // how long the tip has been out on the far side
  GratingState grating;

  bool IsFelt() const noexcept { return active && !popped && !in_flight; }
};

enum class ExtrudePhase : std::uint8_t { kFree = 0, kPressed = 1, kHeld = 2, kSettling = 3 };

struct RegionState {
  ExtrudePhase phase = ExtrudePhase::kFree;
  double offset_m = 0;  // along the region's normal, now
  int step = 0;         // settled step it rests at or moves to
  double timer_s = 0;
  double grab_offset_m = 0;  // tip height over the face when it was taken
  std::uint32_t edits = 0;   // finished steps so far
  double face_height_m = 0;  // of the rest face where it was taken, over the region's centroid
  double slow_s = 0;         // held: how long the tip has been slow
  double last_offset_m = 0;  // offset of the tick before: the face may sweep over a still tip
};

inline constexpr int kMaxPulses = 4;  // hits rendered at once; a further one replaces the one nearest its end

// Force pulse of one hit: half a sine.
struct HitPulse {
  double time_s = -1;  // < 0: not running
  double amplitude_N = 0;
  base::Vec3 direction;  // unit, away from the wall
};

// Laps and their times. Lines are passed in order and in their direction; driving back undoes a passage.
struct LapState {
  bool running = false;    // the start line was crossed: the clock runs
  std::uint32_t next = 0;  // checkpoint that is due; all passed: the start line
  std::uint32_t owed = 0;  // crossings of the start line against its direction, to be made good
  std::uint32_t laps = 0;
  double time_s = 0;  // of the lap being driven
  double last_s = 0;  // of the last finished lap; 0: none
  double best_s = 0;
};

struct VehicleState {
  bool started = false;
  bool sliding = false;          // an axle is at the limit of its grip
  base::Vec3 position_base_m;    // centre of mass
  base::Vec3 velocity_base_m_s;  // in the plane, z = 0
  double heading_rad = 0;
  double yaw_rate_rad_s = 0;
  std::array<base::Vec3, 2> touched_normal;  // of the walls it leans on, unit, away from them
  std::uint32_t touched = 0;                 // how many
  std::uint32_t hits = 0;
  double hit_speed_m_s = 0;  // of the last hit, into the wall
  std::array<HitPulse, kMaxPulses> pulses;
  double engine_turns = 0, road_turns = 0;  // phases, in [0, 1)
  LapState lap;
};

// The stiffness bound, which changes slowly: stability/stability.h.
struct StiffnessBoundState {
  bool known = false;
  double age_s = 0;  // since it was renewed
  double predict_s = 0;
  double recent_N_m = 0, recent_along_N_m = 0;  // the limits, smoothed
  double stiffness_N_m = 0;                     // the bound in the worst direction ...
  double along_N_m = 0;                         // ... and along the pen's axis
  double damping_Ns_m = 0;                      // the bound
};

// What contacts have given to the hand: stability/contact_watch.h.
struct EnergyState {
  bool has_tip = false;
  base::Vec3 tip;
  ActingForce acting;
  double given_J = 0;
  double gain = 1;  // on contact forces
  std::uint32_t leaking_ticks = 0;
};

inline constexpr std::size_t kSwingBands = 4;

struct SwingBandState {
  double swing_N = 0, acting_N = 0;    // of the contact's and the acting force's changes: what is above the corner
  double fed_J = 0, motion_m2_s = 0;   // work of that force and integral of v^2; earlier half swings count less
  double step_m = 0, step_s = 0;       // of that integral
  double damping_Ns_m = 0;             // that the force took from the hand over the last half swings
  double half_s = 0, last_half_s = 0;  // since it changed sides; of the half before
  double peak_N = 0, last_peak_N = 0;
  int side = 0;
  int halves = 0;  // half swings that lasted, less those that died away
};

// How the tip swings against what it touches: stability/contact_watch.h.
struct SwingState {
  std::array<SwingBandState, kSwingBands> bands{};
  base::Vec3 direction;  // of the force
  double stiffness_N_m = 0;
  double left_s = 0;  // time since anything was touched
  bool has_tip = false;
  base::Vec3 tip;  // at the last tick
  ActingForce acting;
  double gain = 1;                           // on the forces
  double held = 1;                           // what the hand holds: the gain comes back to it
  double cut_s = 0, idle_s = 0;              // since the last cut; since anything moved
  double first_peak_N = 0, last_peak_N = 0;  // of the motion soon after the cut, and later
  bool own = false;                          // the hand trembles by itself ...
  double own_N = 0, held_before = 0;         // ... by so much; and what it was thought to hold
  bool fed = false;                          // that was wrong
};

// A soft body that is touched: slot k of its contacts is State::contacts[k].
struct SoftTouch {
  std::uint32_t object = kNoIndex;  // kNoIndex: free
  SoftContactState body;
};

// A sculpted surface: the n-th sculpt session of the scene.
struct SculptTouchState {
  std::uint64_t generation = 0;  // of the surface at the last tick
  sculpt::SculptToolState tool;
};

// A kinematic object that the application has moved: where it stands, and stood at the tick before.
struct MovedObject {
  std::uint32_t object = kNoIndex;  // kNoIndex: free
  base::Quat rotation, last_rotation;
  base::Vec3 translation_m, last_translation_m;
};

// A material that the application has changed, moving towards the requested values.
struct LiveMaterial {
  std::uint32_t material = kNoIndex;  // kNoIndex: free
  Material now;
};

// All that changes. Fixed size, trivially copyable, deterministic: equal inputs give equal bits.
struct State {
  bool was_tracked = false;
  bool appears =
      false;          // the scene comes to a pen that is there: what the tip is in acts once the tip was outside of it
  double away_s = 0;  // time without a pose
  base::Vec3 last_device_point_base_m;
  std::array<ContactState, kMaxContacts> contacts;
  std::array<RegionState, kMaxRegions> regions;
  std::uint64_t ball_restarts = 0;  // one bit per object: its ball's place is unknown; it restarts at the tip
  std::array<SoftTouch, kMaxContacts> soft;
  std::array<std::uint8_t, kMaxObjects> is_soft{};  // 1: the object's soft body has been adopted
  std::array<SculptTouchState, kMaxSculpted> sculpted;
  std::array<MovedObject, kMaxMoved> moved;
  std::array<LiveMaterial, kMaxLiveMaterials> materials;
  Placement placement;  // at the last tick: forces and places here are in the frame of the scene
  VehicleState vehicle;
  StiffnessBoundState bound;
  EnergyState energy;
  SwingState swing;
  base::Vec3 left_N;       // force of contacts whose surface was taken from under the tip ...
  double left_fade_s = 0;  // ... which fades out over this time
  double ramp = 0;         // 0..1 gain on contact forces
  base::Vec3 last_force_N;
  double felt_share = 1;      // of the contacts' force, by the limit of the last tick
  double far_distance_m = 0;  // motion bound: nothing can be touched before the tip moved this far
  base::Vec3 far_origin_base_m;
};
static_assert(std::is_trivially_copyable_v<State>);

}  // namespace omni::haptics
