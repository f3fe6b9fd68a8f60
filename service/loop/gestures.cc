#include "service/loop/gestures.h"

#include <algorithm>
#include <cmath>

#include "service/base/clock.h"

namespace omni::loop {
namespace {

using base::InputSource;
using base::InputThresholds;
using base::SourceBit;
using base::SourceMask;
using base::Vec3;

constexpr double kLongestStep_s = 0.1;       // a longer gap between ticks ends all gestures
constexpr double kVelocityWindow_s = 0.010;  // speeds are mean speeds over this: tracker noise of 30 um makes 4 mm/s
constexpr double kTouchFilter_s = 0.003;
constexpr double kTouch_N = 0.06;  // a touch begins; tracker noise times stiffness stays below ...
constexpr double kLift_N = 0.03;   // ... and ends
constexpr double kShortestTap_s = 0.008;
constexpr double kLeaveShare = 0.4;    // of tap_speed_m_s: a hand leaves a surface more slowly than it comes
constexpr double kFlickReturn = 0.25;  // share of the peak speed at which the way back counts
constexpr double kFlickRest_s = 0.25;  // between two flicks
constexpr double kFlickAfterTouch_s = 0.1;
constexpr double kAxialCosine = 0.8;
constexpr double kDwellRelease = 1.5;  // times its radius
constexpr double kAwayRelease = 3.0;   // times away_still_m

void Remember(const GestureInput& input, TipTrail& trail) noexcept {
  trail.tip_base_m[trail.next] = input.tip_base_m;
  trail.t_ns[trail.next] = input.t_ns;
  trail.next = (trail.next + 1) % kTipTrail;
  trail.count = std::min(trail.count + 1, kTipTrail);
}

// Mean velocity over the last kVelocityWindow_s; zero while the trail is shorter.
Vec3 Velocity(const TipTrail& trail) noexcept {
  if (trail.count < 2) return {};
  const std::uint32_t newest = (trail.next + kTipTrail - 1) % kTipTrail;
  for (std::uint32_t back = 1; back < trail.count; ++back) {
    const std::uint32_t older = (newest + kTipTrail - back) % kTipTrail;
    const double elapsed_s = base::Elapsed_s(trail.t_ns[newest], trail.t_ns[older]);
    if (elapsed_s < kVelocityWindow_s) continue;
    return (1 / elapsed_s) * (trail.tip_base_m[newest] - trail.tip_base_m[older]);
  }
  return {};
}

void Click(InputSource source, const InputThresholds& thresholds, std::int64_t t_ns, GestureState& state) noexcept {
  const auto length_ns = static_cast<std::int64_t>(1e9 * thresholds.click_s);
  state.click_end_ns[static_cast<std::size_t>(source)] = base::StampAfter_ns(t_ns, length_ns);
}

SourceMask Clicking(std::int64_t t_ns, const GestureState& state) noexcept {
  SourceMask on = 0;
  for (const InputSource source :
       {InputSource::kTap, InputSource::kDoubleTap, InputSource::kFlick, InputSource::kFlickAxial}) {
    if (t_ns < state.click_end_ns[static_cast<std::size_t>(source)]) on |= SourceBit(source);
  }
  return on;
}

// The part of a displacement in the surface's plane.
double Sideways(const Vec3& displacement, const Vec3& normal) noexcept {
  return Norm(displacement - Dot(displacement, normal) * normal);
}

void BeginTouch(const InputThresholds& thresholds, const GestureInput& input, const Vec3& velocity,
                TouchState& touch) noexcept {
  touch.touching = true;
  touch.t_begin_ns = input.t_ns;
  touch.begin_base_m = input.tip_base_m;
  touch.normal_base = input.normal_base;
  touch.peak_N = touch.force_N;
  touch.travel_m = 0;
  touch.may_be_tap = -Dot(velocity, input.normal_base) >= thresholds.tap_speed_m_s;
}

// A tap comes in with some speed, stays short and in place, presses a little, and leaves with some speed. Hovering at
// a surface has no speed into it, tracing along it lasts or slides.
bool IsTap(const InputThresholds& thresholds, const GestureInput& input, const Vec3& velocity,
           const TouchState& touch) noexcept {
  const double lasted_s = base::Elapsed_s(input.t_ns, touch.t_begin_ns);
  return touch.may_be_tap && lasted_s >= kShortestTap_s && lasted_s <= thresholds.tap_max_s &&
         touch.peak_N >= thresholds.tap_force_N && touch.travel_m <= thresholds.tap_travel_m &&
         Dot(velocity, touch.normal_base) >= kLeaveShare * thresholds.tap_speed_m_s;
}

void Tapped(const InputThresholds& thresholds, const GestureInput& input, GestureState& state) noexcept {
  TapState& tap = state.tap;
  const TouchState& touch = state.touch;
  Click(InputSource::kTap, thresholds, input.t_ns, state);
  const bool second = tap.has_first && base::Elapsed_s(touch.t_begin_ns, tap.t_first_ns) <= thresholds.double_tap_s &&
                      Norm(touch.begin_base_m - tap.first_base_m) <= thresholds.double_tap_distance_m;
  if (second) Click(InputSource::kDoubleTap, thresholds, input.t_ns, state);
  tap = {.has_first = !second, .t_first_ns = input.t_ns, .first_base_m = touch.begin_base_m};
}

void FollowTouch(const InputThresholds& thresholds, const GestureInput& input, double dt_s, const Vec3& velocity,
                 GestureState& state) noexcept {
  TouchState& touch = state.touch;
  touch.force_N += dt_s / (kTouchFilter_s + dt_s) * (input.force_N - touch.force_N);
  if (!touch.touching) {
    if (touch.force_N >= kTouch_N) BeginTouch(thresholds, input, velocity, touch);
    return;
  }
  touch.peak_N = std::max(touch.peak_N, touch.force_N);
  touch.travel_m = std::max(touch.travel_m, Sideways(input.tip_base_m - touch.begin_base_m, touch.normal_base));
  if (touch.force_N >= kLift_N) return;
  touch.touching = false;
  touch.t_end_ns = input.t_ns;
  if (IsTap(thresholds, input, velocity, touch)) Tapped(thresholds, input, state);
}

SourceMask FollowDwell(const InputThresholds& thresholds, const GestureInput& input, bool touching,
                       DwellState& dwell) noexcept {
  const double reach_m = thresholds.dwell_radius_m * (dwell.on ? kDwellRelease : 1);
  if (touching != dwell.touching || !(Norm(input.tip_base_m - dwell.place_base_m) <= reach_m)) {
    dwell = {.touching = touching, .place_base_m = input.tip_base_m, .t_since_ns = input.t_ns};
  }
  dwell.on = base::Elapsed_s(input.t_ns, dwell.t_since_ns) >= thresholds.dwell_s;
  if (!dwell.on) return 0;
  return SourceBit(touching ? InputSource::kDwell : InputSource::kHoverDwell);
}

// There and back: reaching for something is as fast, but does not turn round.
void FollowFlick(const InputThresholds& thresholds, const GestureInput& input, const Vec3& velocity,
                 GestureState& state) noexcept {
  FlickState& flick = state.flick;
  const double speed_m_s = Norm(velocity);
  const double lasted_s = base::Elapsed_s(input.t_ns, flick.t_ns);
  const bool in_the_air =
      !state.touch.touching && base::Elapsed_s(input.t_ns, state.touch.t_end_ns) >= kFlickAfterTouch_s;
  if (flick.phase == FlickPhase::kRest) {
    if (lasted_s >= kFlickRest_s && speed_m_s < thresholds.flick_speed_m_s) flick.phase = FlickPhase::kIdle;
    return;
  }
  if (flick.phase == FlickPhase::kIdle) {
    if (!in_the_air || !(speed_m_s >= thresholds.flick_speed_m_s)) return;
    flick = {.phase = FlickPhase::kOut,
             .t_ns = input.t_ns,
             .direction_base = (1 / speed_m_s) * velocity,
             .peak_m_s = speed_m_s};
    return;
  }
  if (!in_the_air || lasted_s > thresholds.flick_s) {
    flick = {.phase = FlickPhase::kRest, .t_ns = input.t_ns};
    return;
  }
  const double along_m_s = Dot(velocity, flick.direction_base);
  if (along_m_s > flick.peak_m_s) {
    flick.direction_base = (1 / speed_m_s) * velocity;
    flick.peak_m_s = speed_m_s;
  }
  if (!(along_m_s <= -kFlickReturn * flick.peak_m_s)) return;
  const bool axial = std::abs(Dot(flick.direction_base, input.axis_base)) >= kAxialCosine;
  Click(axial ? InputSource::kFlickAxial : InputSource::kFlick, thresholds, input.t_ns, state);
  flick = {.phase = FlickPhase::kRest, .t_ns = input.t_ns};
}

// A pen that is not tracked, is far away, or lies stiller than a hand can hold it, is not held.
SourceMask FollowAway(const InputThresholds& thresholds, const GestureInput& input, bool touching,
                      AwayState& away) noexcept {
  if (!away.started) {
    away = {.started = true, .t_near_ns = input.t_ns, .t_still_ns = input.t_ns, .place_base_m = input.tip_base_m};
  }
  const bool near = input.tracked && Norm(input.tip_base_m) <= thresholds.away_distance_m;
  if (near) away.t_near_ns = input.t_ns;
  const double reach_m = thresholds.away_still_m * (away.on ? kAwayRelease : 1);
  const bool still = input.tracked && !touching && Norm(input.tip_base_m - away.place_base_m) <= reach_m;
  if (near && !still) {
    away.t_still_ns = input.t_ns;
    away.place_base_m = input.tip_base_m;
  }
  away.on = base::Elapsed_s(input.t_ns, away.t_near_ns) >= thresholds.away_untracked_s ||
            (near && base::Elapsed_s(input.t_ns, away.t_still_ns) >= thresholds.away_still_s);
  return away.on ? SourceBit(InputSource::kAway) : 0;
}

// Resets everything of the pen in the hand; away and the clock go on.
void Forget(std::int64_t t_ns, GestureState& state) noexcept {
  const AwayState away = state.away;
  state = GestureState{};
  state.away = away;
  state.t_ns = t_ns;
  state.touch.t_end_ns = t_ns;
  state.dwell.t_since_ns = t_ns;
}

}  // namespace

SourceMask UpdateGestures(const InputThresholds& thresholds, const GestureInput& input, GestureState& state) noexcept {
  const double dt_s = base::Elapsed_s(input.t_ns, state.t_ns);
  const bool gap = !(dt_s > 0 && dt_s <= kLongestStep_s);
  if (!input.live || gap) {
    Forget(input.t_ns, state);
    return FollowAway(thresholds, input, false, state.away);
  }
  state.t_ns = input.t_ns;
  Remember(input, state.trail);
  const Vec3 velocity = Velocity(state.trail);
  FollowTouch(thresholds, input, dt_s, velocity, state);
  FollowFlick(thresholds, input, velocity, state);
  const bool touching = state.touch.touching;
  state.detent = input.steady_force_N >= (state.detent ? thresholds.detent_release_N : thresholds.detent_press_N);
  const SourceMask away = FollowAway(thresholds, input, touching, state.away);
  SourceMask on = Clicking(input.t_ns, state) | FollowDwell(thresholds, input, touching, state.dwell) | away;
  if (state.detent) on |= SourceBit(InputSource::kDetent);
  if (away != 0) on &= ~SourceBit(InputSource::kHoverDwell);
  return on;
}

}  // namespace omni::loop
