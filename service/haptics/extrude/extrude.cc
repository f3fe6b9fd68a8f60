#include "service/haptics/extrude/extrude.h"

#include <numbers>

namespace omni::haptics {
namespace {

constexpr double kLetGoShare = 0.8;        // of the grab force: hysteresis while pressing
constexpr double kFollowSpeed_m_s = 0.25;  // of a held face; faster pulls tear it off the pen
constexpr double kSettleSpeed_m_s = 0.05;
constexpr double kPullForce_N = 0.8;
constexpr double kClickForce_N = 0.15;
constexpr double kClick_s = 0.02;
constexpr double kSlow_m_s = 0.015;  // the tip rests ...
constexpr double kSlow_s = 0.1;      // ... for so long: the face settles

struct Range {
  double in_m, out_m;
};

Range OffsetRange(const Extrude& e) noexcept { return {-e.steps_in * e.step_m, e.steps_out * e.step_m}; }

int NearestStep(const Extrude& e, double offset_m) noexcept {
  return std::clamp(static_cast<int>(std::lround(offset_m / e.step_m)), -e.steps_in, e.steps_out);
}

void Settle(RegionState& state) noexcept {
  state.phase = ExtrudePhase::kSettling;
  state.timer_s = 0;
}

void StepFree(const Extrude& e, const RegionTouch& touch, RegionState& state) noexcept {
  if (!(touch.normal_force_N >= e.grab_force_N)) return;
  state.phase = ExtrudePhase::kPressed;
  state.timer_s = 0;
}

void StepPressed(const Extrude& e, const RegionTouch& touch, double height_m, const ExtrudeInput& input,
                 RegionState& state) noexcept {
  if (!(touch.normal_force_N >= kLetGoShare * e.grab_force_N)) {
    state.phase = ExtrudePhase::kFree;
    return;
  }
  state.timer_s += input.dt_s;
  if (state.timer_s < e.dwell_s) return;
  state.phase = ExtrudePhase::kHeld;
  state.timer_s = 0;
  state.slow_s = 0;
  state.grab_offset_m = -touch.depth_m;
  state.face_height_m = height_m - state.offset_m + touch.depth_m;
}

// The face follows the tip inwards when it is pressed deeper than it was when taken, outwards when the pull has
// stretched the bond to `bond_m`; in between it rests. It always moves away from the tip, or after it: it never pushes.
// (9.2)
void Follow(const Extrude& e, double tip_over_rest_m, double bond_m, double dt_s, RegionState& state) noexcept {
  double wanted_m = state.offset_m;
  wanted_m = std::min(wanted_m, tip_over_rest_m - state.grab_offset_m);
  wanted_m = std::max(wanted_m, tip_over_rest_m - bond_m);
  const Range range = OffsetRange(e);
  const double most_m = kFollowSpeed_m_s * dt_s;
  state.offset_m += std::clamp(std::clamp(wanted_m, range.in_m, range.out_m) - state.offset_m, -most_m, most_m);
}

Vec3 StepHeld(const Region& region, const Extrude& e, double height_m, double lateral_m, const ExtrudeInput& input,
              RegionState& state) noexcept {
  state.timer_s += input.dt_s;
  const double k = 0.5 * input.stiffness_limit_N_m;
  const double pull_N = std::min(kPullForce_N, e.grab_force_N);
  const double bond_m = k > 0 ? std::min(pull_N / k, 0.5 * e.step_m) : 0.5 * e.step_m;
  const double tip_over_rest_m = height_m - state.face_height_m;
  Follow(e, tip_over_rest_m, bond_m, input.dt_s, state);
  const double gap_m = tip_over_rest_m - state.offset_m;
  if (gap_m > 2 * e.step_m || lateral_m > region.radius_m + 2 * e.step_m) {
    Settle(state);
    return {};
  }
  const bool slow = std::abs(Dot(input.velocity_m_s, region.normal)) < kSlow_m_s;
  state.slow_s = std::max(0.0, state.slow_s + (slow ? input.dt_s : -input.dt_s));
  const bool left_its_step = std::abs(state.offset_m - state.step * e.step_m) > 0.5 * e.step_m;
  if (left_its_step && state.slow_s >= kSlow_s) {
    Settle(state);
    return {};
  }
  // Bond above the face, click just after it was taken   (9.3)
  double force_N = gap_m > 0 ? -std::min(k * gap_m, kPullForce_N) : 0;
  if (state.timer_s < kClick_s) force_N += kClickForce_N * std::sin(std::numbers::pi * state.timer_s / kClick_s);
  return force_N * region.normal;
}

void StepSettling(const Extrude& e, double dt_s, RegionState& state) noexcept {
  const int step = NearestStep(e, state.offset_m);
  const double wanted_m = step * e.step_m;
  const double most_m = kSettleSpeed_m_s * dt_s;
  state.offset_m += std::clamp(wanted_m - state.offset_m, -most_m, most_m);
  if (!(std::abs(wanted_m - state.offset_m) <= 1e-9)) return;
  state.offset_m = wanted_m;
  if (step != state.step) ++state.edits;
  state.step = step;
  state.phase = ExtrudePhase::kFree;
  state.timer_s = 0;
}

}  // namespace

Vec3 StepRegion(const Region& region, const Extrude& extrude, const RegionTouch& touch, const ExtrudeInput& input,
                RegionState& state) noexcept {
  state.last_offset_m = state.offset_m;
  if (!input.tracked && (state.phase == ExtrudePhase::kPressed || state.phase == ExtrudePhase::kHeld)) Settle(state);
  const Vec3 over = input.tip - region.centroid_base_m;
  const double height_m = Dot(over, region.normal);
  switch (state.phase) {
    case ExtrudePhase::kFree:
      StepFree(extrude, touch, state);
      break;
    case ExtrudePhase::kPressed:
      StepPressed(extrude, touch, height_m, input, state);
      break;
    case ExtrudePhase::kHeld:
      return StepHeld(region, extrude, height_m, Norm(over - height_m * region.normal), input, state);
    case ExtrudePhase::kSettling:
      StepSettling(extrude, input.dt_s, state);
      break;
  }
  return {};
}

}  // namespace omni::haptics
