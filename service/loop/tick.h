// Tick: one pass of the loop, every millisecond.
//
//   HallScan -> tracker -> ToolState -> haptics -> Wrench -> actuation -> CoilCurrents
//
// The daemon, replay, tests and benchmarks all call it. noexcept, no allocation, no lock, no system call: time comes
// from the scan's stamps. Only this module knows the order of the stages; they never include each other.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "service/actuation/actuation.h"
#include "service/base/hall_scan.h"
#include "service/base/input_mapping.h"
#include "service/base/life_page.h"
#include "service/base/tool_state.h"
#include "service/haptics/applied/applied.h"
#include "service/haptics/haptics.h"
#include "service/haptics/state.h"
#include "service/loop/force_limiter.h"
#include "service/loop/inputs.h"
#include "service/loop/scene_motion.h"
#include "service/loop/vibration.h"
#include "service/tracker/tracker.h"

namespace omni::loop {

// Prepared off the tick from DeviceGeometry and settings; constant while a loop runs.
struct TickConfig {
  tracker::Config tracker;
  actuation::Config actuation;
  haptics::Config haptics;
  haptics::AppliedConfig applied;
  InputConfig inputs;
  double open_ramp_s = 0.100;    // force fades in over this when an owner appears or a scene becomes current
  double gate_ramp_s = 0.010;    // force fades to zero over this when the owner is gone or hands over
  double silent_ramp_s = 0.100;  // fade when an owner is silent or the control thread stuck
  std::int64_t command_timeout_ns = 100'000'000;          // commands older than this: the control thread is stuck, fade
  std::int64_t applied_timeout_ns = 35'000'000;           // the same for an application's own forces and constraints
  std::int64_t silent_after_ns = 250'000'000;             // an owner without a sign of life for longer is silent: fade
  std::int64_t applied_silent_after_ns = 50'000'000;      // the same for its own forces and constraints
  std::array<double, base::kCoilCount> cold_current_A{};  // of a cold device; prepared by MakeTickConfig
  int bridge_scans = 10;  // scans in a row without a fit that do not end a contact: the pose is held
  VibrationConfig vibration;
  ForceLimiterConfig limiter;
};

enum class ForceGate : std::uint8_t {
  kClosed = 0,  // no owner, or it is gone: zero within gate_ramp_s
  kOpen = 1     // while its owner gives signs of life
};

// The page of the application that owns the force. The tick reads it itself: what it learns from the control thread may
// be old. The control thread keeps it mapped until TickStatistics::owner_number names a later one.
struct OwnerLife {
  const base::LifePage* page = nullptr;  // null: no process is behind these commands, and none can fall silent
  std::uint64_t number = 0;              // of the hand-over; never reused
};

// Fixed-size snapshot of what clients want, handed over by Latest<Commands>.
struct Commands {
  std::int64_t t_ns = 0;  // when the control thread wrote it (CLOCK_MONOTONIC)
  ForceGate gate = ForceGate::kClosed;
  OwnerLife owner;
  bool idle = true;                    // no client at all: once coils are at zero the thread tracks at a low rate
  std::uint64_t scene_generation = 0;  // the scene that should be current; the tick ramps out and requests it
  double force_scale = 1;              // [0, 1], from apps.d
  HapticWaveform haptic;               // of the owner
  base::InputMapping inputs = base::DefaultMapping();  // of the owner
  haptics::AppliedCommand applied;                     // the owner's own forces and constraints
  SceneControl scene;
};
static_assert(std::is_trivially_copyable_v<Commands>);

// Inputs from other threads beside the commands; valid for one tick.
struct TickFeeds {
  const VibrationSamples* samples = nullptr;  // of a waveform that has some
  const base::KeyStates* keys = nullptr;      // null: no keyboard and no pedal is read
  std::int64_t owner_silence_ns = 0;          // since the owner's last sign of life
};

// How long commands have come in time, without a break. A break counts as over only with a sign of life that was given
// after it: the control thread may come back before it knows that the application does not.
struct CommandWatch {
  std::int64_t steady_ns = std::numeric_limits<std::int64_t>::max();
};

struct LoopState {
  tracker::State tracker;
  haptics::State haptics;
  haptics::AppliedState applied;
  actuation::State actuation;
  InputTracker inputs;
  DetentState detent;
  std::int64_t t_ns = 0;  // of the last scan
  std::uint64_t tick = 0;
  int lost_scans = 0;                       // in a row
  double gate = 0;                          // 0..1 gain on everything rendered
  CommandWatch commands, applied_commands;  // by command_timeout_ns and applied_timeout_ns
  std::uint64_t scene_generation = 0;       // of the scene passed to Tick
  VibrationState vibration;
  bool pulses = false;  // the last tick added a vibration or a detent to what haptics renders
  ForceLimiterState limiter;
  std::uint64_t haptic_pulses = 0;
  SceneMotionState scene_motion;
  std::array<double, 4> orientation_wxyz{1, 0, 0, 0};  // tool frame, roll by minimal twist
};
static_assert(std::is_trivially_copyable_v<LoopState>);

struct TickOutput {
  std::uint64_t tick = 0;
  std::int64_t t_ns = 0;  // of the scan
  base::ToolState tool;
  base::Quat orientation_base_tool;  // frame T: -z out of the tip
  haptics::Output haptics;
  haptics::AppliedOutput applied;
  base::Wrench wrench;          // as made, after gate and last limiter; the torque is a side effect of the currents
  base::CoilCurrents currents;  // as sent: finite, within limits
  base::InputState inputs;
  base::SourceMask sources = 0;        // inputs' sources that are on
  std::uint64_t scene_generation = 0;  // that the contacts are of
  bool wants_scene = false;            // ramped out: the caller may now swap to commands.scene_generation
  std::uint64_t haptic_pulses = 0;     // waveforms that reached the coil command so far
  std::uint32_t faults = 0;            // TickFault bits of this tick
  double gate = 0;
  bool near_singular = false;  // pen nearly perpendicular to the radius: one direction of force is faded out
  bool out_of_reach = false;   // no force can be made at this pose, or there is none
  bool saturated = false;      // the device's limit cut the force
  bool warm = false;           // coils may carry less current than cold ones
};
static_assert(std::is_trivially_copyable_v<TickOutput>);

// Share of the forces of contacts and constraints that the watches of docs/theory/haptics.md (3.9), (3.10) leave.
inline double ContactGain(const TickOutput& output) noexcept {
  return std::min(output.haptics.energy_gain, output.applied.energy_gain);
}

enum TickFault : std::uint32_t {
  kFaultDevice = 1,     // the device reports faults
  kFaultTracking = 2,   // not tracking
  kFaultTime = 4,       // stamp went back or jumped
  kFaultNotFinite = 8,  // a stage produced a non-finite value; currents are zero
  kFaultCommandsStale = 16
};

// `state.scene_generation` names `scene`. When a caller swaps the scene it calls EnterScene first.
void Tick(const TickConfig& config, const base::HallScan& scan, const Commands& commands, const haptics::Scene& scene,
          LoopState& state, TickOutput& output, const TickFeeds& feeds = {}) noexcept;

// Call between two ticks, when the last output said wants_scene (or before the first tick).
void EnterScene(const haptics::Scene& scene, std::uint64_t generation, LoopState& state) noexcept;

}  // namespace omni::loop
