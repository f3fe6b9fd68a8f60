#include "service/tools/hand/touch_task.h"

#include <algorithm>
#include <cstdio>

namespace omni::tools {
namespace {

constexpr double kSafe_m = 0.012;  // over the highest place
constexpr double kTravel_m_s = 0.06, kSlow_m_s = 0.01, kProbe_m_s = 0.006, kShape_m_s = 0.03;
constexpr double kNear_m = 0.003;     // over the surface: slowly from here on
constexpr double kDeepest_m = 0.012;  // the hand aims at most so far under the surface
constexpr double kPatience_s = 2.5;   // how long to press at one place
constexpr double kHoldStill_s = 0.4;
constexpr double kGrabMargin = 1.2;  // times the clay's grab force
constexpr double kSoftPress_N = 0.25, kFirmPress_N = 0.5, kMostPress_N = 1.1;
constexpr double kDentEnough_m = 0.0005;  // of a soft body, to count
// With the clay: travel of the tip above the surface, and below the place where it was grabbed; the hand aims further.
constexpr double kPull_m = 0.010, kPush_m = 0.0035;
constexpr double kPullAim_m = 0.015, kPushAim_m = 0.012;
constexpr double kLetsGo_s = 4;       // at most, until clay lets go of a pen that rests: a hand trembles
constexpr double kAside_m = 0.025;    // and so far to the side, if it has not: then it tears
constexpr double kSettled_s = 0.5;    // until a stroke is counted
constexpr int kWanted[] = {3, 2, 2};  // of each kind

double Wanted_N(const Touch& touch) {
  if (touch.kind == TouchKind::kClay) return kGrabMargin * touch.press_N;
  return touch.kind == TouchKind::kSoft ? kSoftPress_N : kFirmPress_N;
}

}  // namespace

std::vector<Touch> TouchesOf(const haptics::Scene& scene, const std::vector<TouchPlace>& places) {
  std::vector<Touch> touches;
  for (const TouchPlace& place : places) {
    const haptics::Material& material = scene.materials()[place.material];
    Touch touch{.place_base_m = place.point_base_m};
    if (material.sculpt.enabled) {
      touch.kind = TouchKind::kClay;
      touch.press_N = material.sculpt.grab_force_N;
    } else if (material.softness.model == haptics::SoftnessModel::kTet) {
      touch.kind = TouchKind::kSoft;
    }
    touches.push_back(touch);
  }
  return touches;
}

TouchTask::TouchTask(std::vector<Touch> touches) : touches_(std::move(touches)) {
  for (const Touch& touch : touches_) safe_z_m_ = std::max(safe_z_m_, touch.place_base_m.z + kSafe_m);
}

std::optional<sim::HandAim> TouchTask::NextAim(const Perceived& seen) {
  const double dt_s = steps_.Next(seen.t_s);
  if (!seen.pen) return std::nullopt;
  pen_seen_ = true;
  if (!aim_.placed()) aim_.Place(seen.tip_base_m);
  if (!presses_before_) presses_before_ = seen.select_presses;
  clicked_ |= seen.select_presses > *presses_before_;
  if (!strokes_judged_ && seen.clay) strokes_judged_ = seen.strokes;
  deepest_dent_m_ = std::max(deepest_dent_m_, seen.dent_m);
  phase_s_ += dt_s;
  Act(seen, dt_s);
  return aim_.aim();
}

void TouchTask::Act(const Perceived& seen, double dt_s) {
  const base::Vec3 safe = Above(safe_z_m_ - touch().place_base_m.z);
  switch (phase_) {
    case Phase::kTravel:
      if (aim_.MoveTo(safe, kTravel_m_s, dt_s)) Enter(Phase::kWait);
      break;
    case Phase::kWait:
      there_ = There(seen);
      dent_m_ = 0;
      pressed_ = false;
      if (there_) Enter(Phase::kLower);
      break;
    case Phase::kLower:
      Lower(seen, dt_s);
      break;
    case Phase::kHold:
      HoldDown(seen, dt_s);
      break;
    case Phase::kShape:
      Shape(seen, dt_s);
      break;
    case Phase::kRest:
      aim_.MoveTo(seen.tip_base_m, kProbe_m_s, dt_s);  // clay that is pressed is not let go of
      if (!seen.stroke_open || phase_s_ >= kLetsGo_s) Enter(Phase::kLift);
      break;
    case Phase::kLift:
      if (aim_.MoveTo(seen.stroke_open ? safe + base::Vec3{kAside_m, 0, 0} : safe, kTravel_m_s, dt_s)) {
        Enter(Phase::kJudge);
      }
      break;
    case Phase::kJudge:
      Judge(seen);
      break;
    case Phase::kLeave:
      if (aim_.MoveTo(Above(safe_z_m_ + kSafe_m - touch().place_base_m.z), kTravel_m_s, dt_s)) Enter(Phase::kDone);
      break;
    case Phase::kDone:
      break;
  }
}

bool TouchTask::There(const Perceived& seen) const {
  return touch().kind == TouchKind::kFirm || (touch().kind == TouchKind::kSoft ? seen.soft : seen.clay);
}

base::Vec3 TouchTask::Above(double height_m) const { return touch().place_base_m + base::Vec3{0, 0, height_m}; }

// True: as deep as the hand goes.
bool TouchTask::Sink(double speed_m_s, double dt_s) { return aim_.MoveTo(Above(-kDeepest_m), speed_m_s, dt_s); }

// Fast to the visible surface, then slowly until the press is reported.
void TouchTask::Lower(const Perceived& seen, double dt_s) {
  if (aim_.tip_base_m().z > touch().place_base_m.z + kNear_m) {
    aim_.MoveTo(Above(kNear_m), kTravel_m_s, dt_s);
    return;
  }
  const bool deepest = Sink(kSlow_m_s, dt_s);
  if (seen.press_N >= Wanted_N(touch())) Enter(Phase::kHold);
  if (deepest && phase_s_ > kPatience_s) Enter(Phase::kLift);
}

void TouchTask::HoldDown(const Perceived& seen, double dt_s) {
  pressed_ = true;
  dent_m_ = std::max(dent_m_, seen.dent_m);
  const bool clay = touch().kind == TouchKind::kClay, soft = touch().kind == TouchKind::kSoft;
  const bool deeper = soft && seen.press_N < kMostPress_N;
  if (deeper || seen.press_N < Wanted_N(touch())) Sink(kProbe_m_s, dt_s);
  if (clay && seen.stroke_open) {
    grip_z_m_ = seen.tip_base_m.z;
    Enter(Phase::kShape);
  } else if (phase_s_ > kPatience_s || (!clay && !deeper && phase_s_ > kHoldStill_s)) {
    Enter(Phase::kLift);
  }
}

// Alternately pulls out and pushes in.
void TouchTask::Shape(const Perceived& seen, double dt_s) {
  const bool out = succeeded_ % 2 == 0;
  base::Vec3 goal = touch().place_base_m;
  goal.z = out ? goal.z + kPullAim_m : grip_z_m_ - kPushAim_m;
  const bool farthest = aim_.MoveTo(goal, kShape_m_s, dt_s);
  const double moved_m = out ? seen.tip_base_m.z - touch().place_base_m.z : grip_z_m_ - seen.tip_base_m.z;
  const bool enough = moved_m >= (out ? kPull_m : kPush_m);
  if (farthest || enough || !seen.stroke_open) Enter(Phase::kRest);
}

void TouchTask::Judge(const Perceived& seen) {
  const TouchKind kind = touch().kind;
  const bool worked = kind == TouchKind::kClay   ? seen.strokes > strokes_judged_.value_or(0)
                      : kind == TouchKind::kSoft ? dent_m_ >= kDentEnough_m
                                                 : pressed_;
  if (!worked && kind == TouchKind::kClay && phase_s_ < kSettled_s) return;
  strokes_judged_ = seen.strokes;
  ++tried_;
  if (worked) ++succeeded_;
  if (Enough()) return Enter(Phase::kLeave);
  ++next_;
  Enter(Phase::kTravel);
}

bool TouchTask::Enough() const { return clicked_ && succeeded_ >= kWanted[static_cast<std::size_t>(touch().kind)]; }

std::string TouchTask::Summary() const {
  if (!pen_seen_) return "no pen was tracked";
  if (!there_) {
    return touch().kind == TouchKind::kFirm   ? "the pen did not come near the scene"
           : touch().kind == TouchKind::kSoft ? "no soft body appeared"
                                              : "nothing sculptable appeared";
  }
  char dent[64];
  std::snprintf(dent, sizeof(dent), "%.2f", 1e3 * deepest_dent_m_);
  const std::string times = std::to_string(succeeded_) + " of " + std::to_string(tried_) + " tries";
  std::string text = touch().kind == TouchKind::kClay   ? "sculpted in " + times
                     : touch().kind == TouchKind::kSoft ? "dented in " + times + ", by " + dent + " mm at most"
                                                        : "pressed in " + times;
  return text + (clicked_ ? "; a press was reported" : "; no press was reported");
}

}  // namespace omni::tools
