#include "service/tools/hand/race_task.h"

#include <cmath>

#include "service/tools/common/output.h"

namespace omni::tools {
namespace {

constexpr double kReach_m_s = 0.04;
constexpr double kStickMoves_m_s = 0.25;
constexpr double kArm_N_m = 150;     // stiffness of a person's arm: how far to push against a spring
constexpr double kCorrects_1_s = 2;  // visual correction of the stick's position
constexpr double kPushedMost_m = 0.006;
constexpr double kCrash_s = 3;  // at most, until the wall is there
constexpr double kStop_s = 0.4;
constexpr double kPress_m = 0.016, kPress_m_s = 0.02, kRelease_m_s = 0.05;  // down, until it clicks
constexpr double kPressed_s = 0.6;  // a click is held so long that a busy application sees it, too
constexpr int kClicks = 2;
constexpr double kLeave_m = 0.02;
constexpr double kLeave_s = 0.3;

}  // namespace

std::optional<sim::HandAim> RaceTask::NextAim(const Perceived& seen) {
  const double dt_s = steps_.Next(seen.t_s);
  if (!seen.pen) return std::nullopt;
  pen_seen_ = true;
  car_ = seen.car;
  if (!aim_.placed()) aim_.Place(seen.tip_base_m);
  phase_s_ += dt_s;
  const base::Vec3 centre = stick_.centre_base_m;
  switch (phase_) {
    case Phase::kReach:
      laps_before_ = seen.car.laps;
      if (aim_.MoveTo(centre, kReach_m_s, dt_s) && seen.car.on) Enter(Phase::kDrive);
      break;
    case Phase::kDrive:
      Hold(driver_.Steer(seen.car, dt_s), seen.tip_base_m, dt_s);
      hits_before_ = seen.car.hits;
      if (seen.car.laps > laps_before_) Enter(Phase::kCrash);
      break;
    case Phase::kCrash:
      Hold({0, 1}, seen.tip_base_m, dt_s);
      if (seen.car.hits > hits_before_ || phase_s_ > kCrash_s) Enter(Phase::kStop);
      break;
    case Phase::kStop:
      presses_before_ = seen.select_presses;
      pushed_m_ = {};
      if (aim_.MoveTo(centre, kStickMoves_m_s, dt_s) && phase_s_ >= kStop_s) Enter(Phase::kPress);
      break;
    case Phase::kPress: {
      const bool deepest = aim_.MoveTo(centre - base::Vec3{0, 0, kPress_m}, kPress_m_s, dt_s);
      clicked_ = seen.select_presses > presses_before_;
      if (clicked_) Enter(Phase::kPressed);
      if (deepest && phase_s_ > 2 * kPress_m / kPress_m_s) Enter(Phase::kRelease);
      break;
    }
    case Phase::kPressed:
      if (phase_s_ < kPressed_s) break;
      ++clicks_;
      Enter(Phase::kRelease);
      break;
    case Phase::kRelease:
      if (aim_.MoveTo(centre, kRelease_m_s, dt_s)) Enter(clicks_ < kClicks ? Phase::kStop : Phase::kLeave);
      break;
    case Phase::kLeave:
      if (aim_.MoveTo(centre + base::Vec3{0, 0, kLeave_m}, kReach_m_s, dt_s) && phase_s_ >= kLeave_s) {
        Enter(Phase::kDone);
      }
      break;
    case Phase::kDone:
      break;
  }
  return aim_.aim();
}

// Towards a deflection of the stick. Its spring pulls back, so the hand pushes further: by the expected amount plus the
// visible error.
void RaceTask::Hold(const StickWish& wish, const base::Vec3& tip_base_m, double dt_s) {
  const double size = std::hypot(wish.x, wish.y);
  base::Vec3 place;
  if (size > 0.02) {
    const double from_centre_m = stick_.dead_zone_m + size * (stick_.range_m - stick_.dead_zone_m);
    place = (from_centre_m / size) * base::Vec3{wish.x, wish.y, 0};
  }
  const base::Vec3 expected_m = (stick_.stiffness_N_m / kArm_N_m) * place;
  base::Vec3 missing = stick_.centre_base_m + place - tip_base_m;
  missing.z = 0;
  pushed_m_ = pushed_m_ + (kCorrects_1_s * dt_s) * missing;
  const double pushed = Norm(pushed_m_);
  if (pushed > kPushedMost_m) pushed_m_ = (kPushedMost_m / pushed) * pushed_m_;
  aim_.MoveTo(stick_.centre_base_m + place + expected_m + pushed_m_, kStickMoves_m_s, dt_s);
}

std::string RaceTask::Summary() const {
  if (!pen_seen_) return "no pen was tracked";
  if (phase_ == Phase::kReach) return car_.on ? "the joystick was not reached" : "no car appeared";
  const std::string race = Plural(car_.laps, "lap") + ", " + Plural(car_.hits, "hit");
  if (phase_ == Phase::kDrive) return "the car did not finish a lap (" + race + ")";
  return race + (clicks_ > 0 ? "; the stick clicked" : "; the stick did not click when it was pressed down");
}

}  // namespace omni::tools
