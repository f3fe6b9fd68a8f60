#include "service/haptics/sculpt/sculpt_tool.h"

namespace omni::haptics::sculpt {
namespace {

constexpr double kLetGoShare = 0.8;    // of the grab force: hysteresis while pressing
constexpr double kArmShare = 0.5;      // of the grab force: a press below is none
constexpr double kRest_N = 0.12;       // below, the tip is neither pressed nor pulled: several times its noise
constexpr double kFastest_m_s = 0.25;  // that the surface follows
constexpr double kFarthestTip_m = 100;

// A tip whose height, smoothed for so long, stays within so much for so often the material's time rests: others move,
// if slowly.
struct Stillness {
  double smooth_s, within_m, times;
};
constexpr std::array kStill{Stillness{0.05, 1.5e-4, 1},
                            Stillness{0.2, 3e-4, 1.4}};  // a noisy pen; a hand that trembles

void Take(const SculptInput& input, SculptToolState& state) noexcept {
  state.phase = SculptPhase::kHeld;
  state.rests = {};
  state.releases = input.releases;
  state.grip_base_m = input.tip_base_m;
  state.normal = input.touch.normal;
  state.start_force_N = input.touch.normal_force_N;
  state.offset_m = state.sent_offset_m = 0;
  state.held_force_N = state.start_force_N * state.normal;
  ++state.stroke;
  state.begin = {StrokeKind::kBegin,   state.stroke,
                 input.touch.triangle, input.generation,
                 input.touch.weights,  input.touch.point_base_m,
                 input.brush,          0};
  state.begin_waits = true;
}

void StepFree(const SculptParameters& parameters, const SculptInput& input, SculptToolState& state) noexcept {
  const double press_N = input.touch.touching ? input.touch.normal_force_N : 0;
  if (press_N < kArmShare * parameters.grab_force_N) state.armed = true;
  if (!state.armed || state.end_waits || !(press_N >= parameters.grab_force_N)) return;
  state.phase = SculptPhase::kPressed;
  state.timer_s = 0;
}

void StepPressed(const SculptParameters& parameters, const SculptInput& input, SculptToolState& state) noexcept {
  if (!(input.touch.touching && input.touch.normal_force_N >= kLetGoShare * parameters.grab_force_N)) {
    state.phase = SculptPhase::kFree;
    return;
  }
  state.timer_s += input.dt_s;
  if (state.timer_s >= parameters.dwell_s) Take(input, state);
}

// R = Y + H |o|
double Bears_N(const SculptParameters& parameters, const SculptToolState& state) noexcept {
  return parameters.yield_N + parameters.hardening_N_m * std::abs(state.offset_m);
}

// F = F_0 - k (x - o), x = height of the tip over the grip. Wax: while the force exceeds its limit, F_0 + Y + H |o|
// inwards and Y + H |o| outwards, the offset o follows at (excess) / c; backward Euler in o.   (5.1)-(5.3)
double GiveWay(const SculptParameters& parameters, double height_m, double stiffness_N_m, double dt_s,
               SculptToolState& state) noexcept {
  const double trial_N = state.start_force_N - stiffness_N_m * (height_m - state.offset_m);
  const double bears_N = Bears_N(parameters, state);
  const double in_N = trial_N - state.start_force_N - bears_N, out_N = -trial_N - bears_N;
  const double excess_N = in_N > 0 ? -in_N : std::max(0.0, out_N);
  const double lag = parameters.viscosity_Ns_m + (stiffness_N_m + parameters.hardening_N_m) * dt_s;
  const double most_m = kFastest_m_s * dt_s;
  const double move_m = lag > 0 ? std::clamp(excess_N * dt_s / lag, -most_m, most_m) : 0;
  state.offset_m = std::clamp(state.offset_m + move_m, -parameters.offset_max_m, parameters.offset_max_m);
  return state.start_force_N - stiffness_N_m * (height_m - state.offset_m);
}

// Stretched or pressed beyond where the surface yields, however soft the spring.   (5.4)
bool IsTorn(const SculptParameters& parameters, double height_m, double stiffness_N_m,
            const SculptToolState& state) noexcept {
  if (!(stiffness_N_m > 0)) return true;
  const double in_m = Bears_N(parameters, state) / stiffness_N_m, out_m = state.start_force_N / stiffness_N_m + in_m;
  const double stretch_m = height_m - state.offset_m;
  return !(stretch_m <= parameters.tear_m + std::min(out_m, parameters.offset_max_m) &&
           stretch_m >= -parameters.tear_m - std::min(in_m, parameters.offset_max_m));
}

// Neither pressed nor pulled, and still, for as long as the material says.
bool HasRested(const SculptParameters& parameters, double height_m, double stiffness_N_m, double dt_s,
               SculptToolState& state) noexcept {
  bool rested = false;
  for (std::size_t n = 0; n < kStill.size(); ++n) {
    TipRest& rest = state.rests[n];
    rest.height_m += dt_s / (dt_s + kStill[n].smooth_s) * (height_m - rest.height_m);
    const double smooth_N = state.start_force_N - stiffness_N_m * (rest.height_m - state.offset_m);
    const bool stays = std::abs(rest.height_m - rest.rest_height_m) < kStill[n].within_m;
    const bool rests = stays && std::abs(smooth_N) < kRest_N;
    rest.rested_s = rests ? rest.rested_s + dt_s : 0;
    if (!rests) rest.rest_height_m = rest.height_m;
    rested |= rest.rested_s >= kStill[n].times * parameters.rest_s;
  }
  return rested && parameters.rest_s > 0;
}

void StepHeld(const SculptParameters& parameters, const SculptInput& input, SculptToolState& state) noexcept {
  const Vec3 from_grip = input.tip_base_m - state.grip_base_m;
  const double height_m = Dot(from_grip, state.normal);
  const Vec3 sideways = from_grip - height_m * state.normal;
  const double k = std::min(parameters.stiffness_N_m, std::max(0.0, input.normal_stiffness_limit_N_m));
  const double side_k = std::min(parameters.stiffness_N_m, std::max(0.0, input.stiffness_limit_N_m));
  const double normal_N = GiveWay(parameters, height_m, k, input.dt_s, state);
  const double side_m = Norm(sideways);
  const double side_N = std::min(side_k * side_m, parameters.side_force_max_N);
  state.held_force_N = std::clamp(normal_N, -parameters.hold_force_max_N, parameters.hold_force_max_N) * state.normal -
                       side_N * Normalized(sideways);
  const bool rested = HasRested(parameters, height_m, k, input.dt_s, state);
  const bool torn = IsTorn(parameters, height_m, k, state) || !(side_m <= input.brush.radius_m + parameters.tear_m);
  if (torn || rested || input.releases != state.releases) state.phase = SculptPhase::kSettling;
}

void StepSettling(const SculptParameters& parameters, double dt_s, SculptToolState& state) noexcept {
  const double wanted_m = parameters.grid_step_m > 0
                              ? parameters.grid_step_m * std::round(state.offset_m / parameters.grid_step_m)
                              : state.offset_m;
  const double most_m = kSettleSpeed_m_s * dt_s;
  state.offset_m += std::clamp(wanted_m - state.offset_m, -most_m, most_m);
  if (!(std::abs(wanted_m - state.offset_m) <= 1e-9)) return;
  state.offset_m = wanted_m;
  state.phase = SculptPhase::kFree;
  state.armed = false;
  state.end_waits = true;
}

// Begin, moves, end, in this order, one per tick.
void Send(SculptToolState& state, StrokeRing& ring) noexcept {
  if (state.begin_waits) {
    state.begin_waits = !ring.TryPush(state.begin);
    return;
  }
  const bool working = state.phase == SculptPhase::kHeld || state.phase == SculptPhase::kSettling;
  if (!working && !state.end_waits) return;
  StrokeMessage message;
  message.stroke = state.stroke;
  message.offset_m = state.offset_m;
  const double move_m = std::abs(state.offset_m - state.sent_offset_m);
  if (move_m >= kLeastMove_m || (state.end_waits && move_m > 0)) {
    if (ring.TryPush(message)) state.sent_offset_m = state.offset_m;
  } else if (state.end_waits) {
    message.kind = StrokeKind::kEnd;
    state.end_waits = !ring.TryPush(message);
  }
}

}  // namespace

SculptToolOutput StepSculptTool(const SculptParameters& parameters, const SculptInput& input, SculptToolState& state,
                                StrokeRing& ring) noexcept {
  const bool tracked = input.tracked && IsWithin(input.tip_base_m, kFarthestTip_m);
  const double dt_s = input.dt_s >= 0 && input.dt_s <= 5e-3 ? input.dt_s : 0;
  SculptInput clean = input;
  clean.dt_s = dt_s;
  if (!tracked && state.phase == SculptPhase::kPressed) state.phase = SculptPhase::kFree;
  if (!tracked && state.phase == SculptPhase::kHeld) state.phase = SculptPhase::kSettling;
  if (tracked && state.phase == SculptPhase::kFree) {
    StepFree(parameters, clean, state);
  } else if (tracked && state.phase == SculptPhase::kPressed) {
    StepPressed(parameters, clean, state);
  } else if (state.phase == SculptPhase::kHeld) {
    StepHeld(parameters, clean, state);
  } else if (state.phase == SculptPhase::kSettling) {
    StepSettling(parameters, dt_s, state);
  }
  Send(state, ring);
  const double most = dt_s / kHandOver_s;
  const double wanted = state.phase == SculptPhase::kHeld ? 1 : 0;
  state.hold += std::clamp(wanted - state.hold, -most, most);
  if (!IsWithin(state.held_force_N, 1e3)) state.held_force_N = {};
  return {state.hold * state.held_force_N, 1 - state.hold};
}

}  // namespace omni::haptics::sculpt
