#include "service/loop/tick.h"

#include <algorithm>
#include <cmath>

#include "service/base/clock.h"
#include "service/base/eigen.h"
#include "service/base/force_limit.h"
#include "service/base/limits.h"
#include "service/haptics/live/scene_changes.h"

namespace omni::loop {
namespace {

constexpr double kSigmas = 3;        // of a pose: its error is almost never larger
constexpr double kMaxStep_s = 5e-3;  // a longer gap counts as this much: nothing integrates over a hole

bool IsFinite(const base::Vec3& v) noexcept { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

// Seconds since the last scan, in [0, kMaxStep_s].
double Advance(const base::HallScan& scan, LoopState& state, TickOutput& output) noexcept {
  if (state.tick++ == 0) {
    state.t_ns = scan.t_ns;
    return base::kTickPeriod_s;
  }
  const double elapsed_s = base::Elapsed_s(scan.t_ns, state.t_ns);
  if (!(elapsed_s > 0 && elapsed_s <= kMaxStep_s)) output.faults |= kFaultTime;
  state.t_ns = scan.t_ns;
  return std::clamp(elapsed_s, 0.0, kMaxStep_s);
}

// Whether commands are younger than `timeout_ns`.
bool AreFresh(const Commands& commands, std::int64_t timeout_ns, std::int64_t t_ns, double dt_s,
              CommandWatch& watch) noexcept {
  const bool fresh = base::StampDifference_ns(t_ns, commands.t_ns) <= timeout_ns;
  watch.steady_ns = fresh ? base::StampAfter_ns(watch.steady_ns, std::llround(1e9 * dt_s)) : 0;
  return fresh;
}

// Whether the owner's last sign of life is younger than `silent_after_ns`, and than the last break in the commands.
bool IsAlive(std::int64_t owner_silence_ns, std::int64_t silent_after_ns, const CommandWatch& watch) noexcept {
  return owner_silence_ns <= std::min(silent_after_ns, watch.steady_ns);
}

// The gain on everything rendered: opens slowly, closes fast, and fades when the owner falls silent.
void MoveGate(const TickConfig& config, const Commands& commands, std::int64_t owner_silence_ns, std::int64_t t_ns,
              double dt_s, LoopState& state, TickOutput& output) noexcept {
  const bool fresh = AreFresh(commands, config.command_timeout_ns, t_ns, dt_s, state.commands);
  if (!fresh) output.faults |= kFaultCommandsStale;
  const bool swap = commands.scene_generation != state.scene_generation;
  if (output.faults & kFaultDevice || swap || commands.gate == ForceGate::kClosed) {
    state.gate = std::max(0.0, state.gate - dt_s / config.gate_ramp_s);
  } else if (!fresh || !IsAlive(owner_silence_ns, config.silent_after_ns, state.commands)) {
    state.gate = std::max(0.0, state.gate - dt_s / config.silent_ramp_s);
  } else {
    state.gate = std::min(1.0, state.gate + dt_s / config.open_ramp_s);
  }
  output.wants_scene = swap && state.gate == 0;
  output.gate = state.gate;
}

// Tool frame by minimal twist: the smallest rotation that takes the old axis to the new one.
void CarryOrientation(const base::ToolState& tool, LoopState& state, TickOutput& output) noexcept {
  const auto& held = state.orientation_wxyz;
  Eigen::Quaterniond R_BT(held[0], held[1], held[2], held[3]);
  const Eigen::Vector3d z_old = R_BT * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d z_new = -base::ToEigen(tool.axis_base);
  if (tool.ever_tracked) R_BT = (Eigen::Quaterniond::FromTwoVectors(z_old, z_new) * R_BT).normalized();
  state.orientation_wxyz = {R_BT.w(), R_BT.x(), R_BT.y(), R_BT.z()};
  output.orientation_base_tool = base::FromEigen(R_BT);
}

// Of the current at the end of the scan's tick, where the device sends it, else of its mean over the tick.
haptics::ActingForce ActingForceOf(const base::HallScan& scan, const base::ForceLimit& limit, double share) noexcept {
  const auto& current_A = scan.has_steps != 0 ? scan.step_current_A.back() : scan.coil_current_A;
  const base::Vec3 force_N = base::ForceOf_N(limit, current_A);
  return {limit.valid && IsFinite(force_N), force_N, share};
}

haptics::Input MakeHapticInput(const base::ToolState& tool, const base::ForceLimit& limit,
                               const haptics::ActingForce& acting, double delay_s, double dt_s,
                               const LoopState& state) noexcept {
  return {.t_ns = tool.t_ns,
          .dt_s = dt_s,
          .tracked = tool.status == base::TrackingStatus::kTracking,
          .device_point_base_m = tool.device_point_base_m,
          .velocity_base_m_s = tool.device_point_velocity_base_m_s,
          .noise = tool.device_point_noise,
          .noise_along = tool.device_point_noise_along,
          .axis_base = tool.axis_base,
          .axis_rate_base_1_s = Cross(tool.angular_velocity_base_rad_s, tool.axis_base),
          .delay_s = delay_s,
          .acting = acting,
          .limit = limit,
          .poses = {},
          .pushed = state.applied.force_presence > 0,
          .constrained = state.applied.last_N != base::Vec3{}};
}

// The application's own forces and constraints. Its silence, a control thread that is stuck, or a device with a fault
// ends them.
base::Vec3 Push(const TickConfig& config, const Commands& commands, std::int64_t owner_silence_ns,
                const haptics::Input& felt, LoopState& state, TickOutput& output) noexcept {
  const bool heard = AreFresh(commands, config.applied_timeout_ns, felt.t_ns, felt.dt_s, state.applied_commands) &&
                     IsAlive(owner_silence_ns, config.applied_silent_after_ns, state.applied_commands);
  if (haptics::IsAtRest(commands.applied, state.applied)) return {};
  const haptics::AppliedInput input{.t_ns = felt.t_ns,
                                    .dt_s = felt.dt_s,
                                    .allowed = heard && (output.faults & kFaultDevice) == 0,
                                    .tracked = felt.tracked,
                                    .device_point_base_m = felt.device_point_base_m,
                                    .velocity_base_m_s = felt.velocity_base_m_s,
                                    .tip_sigma_m = std::sqrt(std::max(0.0, felt.noise.position_m2)),
                                    .velocity_sigma_m_s = std::sqrt(std::max(0.0, felt.noise.velocity_m2_s2)),
                                    .acting = felt.acting,
                                    .bound = haptics::StiffnessBoundOf(felt.axis_base, state.haptics.bound),
                                    .contacts = &output.haptics};
  haptics::ComputeAppliedForce(config.applied, commands.applied, input, state.applied, output.applied);
  return output.applied.force_base_N;
}

// The scene's part of a tick: the application's control of it, if it is the active one, and the renderer.
void RenderScene(const TickConfig& config, const SceneControl& control, const haptics::Scene& scene,
                 haptics::Input input, LoopState& state, TickOutput& output) noexcept {
  output.scene_generation = state.scene_generation;
  if (control.generation != state.scene_generation || control.generation == 0) {
    return haptics::StepPlaced(config.haptics, scene, state.haptics.placement, false, input, state.haptics,
                               output.haptics);
  }
  SceneNow now;
  FollowScene(control, scene, state.t_ns, state.scene_motion, now);
  input.poses = {now.objects.data(), now.object_count};
  input.materials = {control.materials.data(), std::min<std::size_t>(control.material_count, control.materials.size())};
  haptics::StepPlaced(config.haptics, scene, now.placement, now.leaps, input, state.haptics, output.haptics);
}

double PoseError_m(const base::ToolState& tool) noexcept {
  return kSigmas * std::sqrt(tool.covariance[0] + tool.covariance[6] + tool.covariance[12]);
}

// A single scan that does not fit (a current step, a spike) holds the last pose instead of dropping the contact.
base::ToolState Bridged(const TickConfig& config, const base::ToolState& tool, LoopState& state) noexcept {
  state.lost_scans = tool.status == base::TrackingStatus::kTracking ? 0 : state.lost_scans + 1;
  base::ToolState bridged = tool;
  const bool brief = tool.status == base::TrackingStatus::kLost && state.lost_scans <= config.bridge_scans;
  if (brief) bridged.status = base::TrackingStatus::kTracking;
  return bridged;
}

// Whether the device makes less of a force than is wanted: scaled down, or with a direction faded out that the coils
// cannot push there.
bool IsCut(const base::ForceLimit& limit, const base::Vec3& wanted_N, double feasible) noexcept {
  constexpr double kUnnoticed = 0.005;  // of its size
  if (feasible < 1) return true;
  return limit.near_singular && Norm(base::Rendered_N(limit, wanted_N) - wanted_N) > kUnnoticed * Norm(wanted_N);
}

// All that is rendered, under the gate and the last limiter; counts a waveform once when it reaches the command.
base::Vec3 Mix(const base::Vec3& rest_N, const base::Vec3& vibration_N, const base::ForceLimit& limit,
               double force_scale, LoopState& state, TickOutput& output) noexcept {
  const base::Vec3 wanted = rest_N + vibration_N;
  const double gain = state.gate * std::clamp(force_scale, 0.0, 1.0);
  const double feasible = base::FeasibleScale(limit, wanted);
  output.saturated = output.haptics.saturated || output.applied.saturated ||
                     (gain > 0 && limit.valid && IsCut(limit, wanted, feasible));
  const base::Vec3 gated_N = (gain * feasible) * wanted;
  if (!IsFinite(gated_N)) output.faults |= kFaultNotFinite;
  const base::Vec3 force_N = LimitForce(limit, gated_N, state.limiter);
  const bool vibrates = vibration_N != base::Vec3{};
  if (vibrates && !state.vibration.counted && force_N != base::Vec3{}) {
    state.vibration.counted = true;
    ++state.haptic_pulses;
  }
  return force_N;
}

// Below this share of a cold device's currents: warm.
constexpr double kWarmBelow = 0.9;

void PublishLimits(const TickConfig& config, const base::ForceLimit& limit, TickOutput& output) noexcept {
  output.near_singular = limit.near_singular;
  output.out_of_reach = !(limit.valid && limit.force_max_N > 0);
  for (std::size_t k = 0; k < base::kCoilCount; ++k) {
    if (limit.valid && limit.current_max_A[k] < kWarmBelow * config.cold_current_A[k]) output.warm = true;
  }
}

// Inputs of this tick, and their pulses.
base::Vec3 FollowInputs(const TickConfig& config, const Commands& commands, const base::KeyStates* keys,
                        const base::ToolState& tool, double dt_s, LoopState& state, TickOutput& output) noexcept {
  const bool tracked = tool.status == base::TrackingStatus::kTracking;
  const InputSample sample{.t_ns = output.t_ns,
                           .live = tracked && state.gate > 0,
                           .owned = commands.gate != ForceGate::kClosed,
                           .tracked = tracked,
                           .tip_base_m = tool.device_point_base_m,
                           .axis_base = tool.axis_base};
  UpdateInputs(config.inputs, commands.inputs, sample, output.haptics, keys, state.inputs);
  output.inputs = state.inputs.inputs;
  output.sources = state.inputs.on;
  return DetentForce_N(commands.inputs, state.inputs, output.haptics, dt_s, state.detent);
}

constexpr std::uint64_t kScenesComeBack_ticks = 500;

}  // namespace

void EnterScene(const haptics::Scene& scene, std::uint64_t generation, LoopState& state) noexcept {
  const auto& contacts = state.haptics.contacts;
  const bool touching = std::any_of(contacts.begin(), contacts.end(), [](const auto& c) { return c.IsFelt(); });
  haptics::EnterScene(scene, state.haptics);
  // Else an application has changed the scene that is being touched, or pen and scene are both back after the base or
  // omnid was away.
  state.haptics.appears = !touching && state.tick >= kScenesComeBack_ticks;
  state.scene_generation = generation;
  state.scene_motion = {};
}

void Tick(const TickConfig& config, const base::HallScan& scan, const Commands& commands, const haptics::Scene& scene,
          LoopState& state, TickOutput& output, const TickFeeds& feeds) noexcept {
  output = TickOutput{};
  output.tick = state.tick;
  output.t_ns = scan.t_ns;
  const double dt_s = Advance(scan, state, output);
  if (scan.device_faults != 0) output.faults |= kFaultDevice;

  const bool pushed = state.limiter.last_N != base::Vec3{};
  tracker::Update(config.tracker, scan, state.tracker, output.tool, pushed);
  if (output.tool.status != base::TrackingStatus::kTracking) output.faults |= kFaultTracking;
  CarryOrientation(output.tool, state, output);
  MoveGate(config, commands, feeds.owner_silence_ns, scan.t_ns, dt_s, state, output);

  const base::ToolState tool = Bridged(config, output.tool, state);
  actuation::UpdateHeat(config.actuation, scan, state.actuation);
  base::ForceLimit limit = actuation::ComputeDeratedLimit(config.actuation, tool, state.actuation.heat);
  // On a pose that is only held the force may fall, but not rise.
  const bool held = output.tool.status != base::TrackingStatus::kTracking;
  NarrowLimit(config.limiter, PoseTrust(config.limiter, PoseError_m(tool)), held ? 0.0 : dt_s, limit);
  PublishLimits(config, limit, output);
  const double delay_s = 1e-9 * static_cast<double>(scan.response_ns);
  const double share = state.gate * std::clamp(commands.force_scale, 0.0, 1.0);
  haptics::ActingForce acting = ActingForceOf(scan, limit, share);
  acting.known = acting.known && !state.pulses;
  const haptics::Input felt = MakeHapticInput(tool, limit, acting, delay_s, dt_s, state);
  RenderScene(config, commands.scene, scene, felt, state, output);
  const base::Vec3 detent_N = FollowInputs(config, commands, feeds.keys, tool, dt_s, state, output);
  const base::Vec3 applied_N = Push(config, commands, feeds.owner_silence_ns, felt, state, output);
  const base::Vec3 pushed_N = output.haptics.force_base_N + applied_N + detent_N;
  const base::Vec3 vibration_N =
      VibrationForce_N(config.vibration, commands.haptic, feeds.samples, dt_s, state.vibration) * tool.axis_base;

  state.pulses = detent_N != base::Vec3{} || vibration_N != base::Vec3{};
  const base::Vec3 force_N = Mix(pushed_N, vibration_N, limit, commands.force_scale, state, output);
  const base::Vec3 made_N =
      actuation::Allocate(config.actuation, limit, force_N, dt_s, state.actuation, output.currents);
  output.wrench = {.force_N = made_N,
                   .torque_Nm = base::TorqueOf_Nm(limit, output.currents.current_A),
                   .point_base_m = output.tool.position_base_m};

  output.haptic_pulses = state.haptic_pulses;
}

}  // namespace omni::loop
