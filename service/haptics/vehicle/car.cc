#include "service/haptics/vehicle/car.h"

#include <numbers>

#include "service/haptics/vehicle/wall_slice.h"

namespace omni::haptics {
namespace {

constexpr double kReverseShare = 0.3;  // of the top speed
constexpr double kBrakeFactor = 2;     // braking over accelerating
constexpr double kCoastFactor = 0.5;
constexpr int kMaxPieces = 64;  // of a tick's motion; what is left over is not driven
constexpr int kMaxPushes = 4;   // walls that may push at once, in a corner
constexpr double kTouching_m = 2e-5;
constexpr double kFelt_m_s = 1e-3;  // slower contacts with a wall are not hits

// J = hit_force (1 - exp(-(1 + e) v / hit_speed)): monotone, never above hit_force   (8.3). A weaker hit does not cut a
// running stronger pulse short.
void Hit(const VehicleInput& car, const Vec3& wall_normal, double restitution, double speed_m_s,
         VehicleState& state) noexcept {
  state.hits += 1;
  const double amplitude_N = -car.hit_force_N * std::expm1(-(1 + restitution) * speed_m_s / car.hit_speed_m_s);
  if (state.pulse_time_s >= 0 && !(amplitude_N > state.pulse_amplitude_N)) return;
  state.pulse_time_s = 0;
  state.pulse_amplitude_N = amplitude_N;
  state.pulse_direction = wall_normal;
}

// A tick's motion, wall by wall.
class Drive {
 public:
  Drive(const VehicleInput& car, const Scene& scene, const Surface& surface, VehicleState& state) noexcept
      : car_(car),
        scene_(scene),
        surface_(surface),
        state_(state),
        heading_{std::cos(state.heading_rad), std::sin(state.heading_rad), 0} {}

  void Go(double dt_s) noexcept {
    const double piece_m = 0.25 * car_.radius_m;
    Vec3 motion = (state_.speed_m_s * dt_s) * heading_;
    for (int k = 0; k < kMaxPieces; ++k) {
      const double left_m = Norm(motion);
      if (!(left_m > 0)) break;
      const Wall wall = Near(car_.radius_m + left_m);
      const double clearance_m = wall.found ? wall.distance_m - car_.radius_m : left_m;
      const double share = std::min(1.0, std::max(clearance_m, piece_m) / left_m);
      const Vec3 before = state_.position_base_m;
      state_.position_base_m = before + share * motion;
      motion = (1 - share) * motion;
      if (!PushOut(motion)) {
        state_.position_base_m = before;
        state_.speed_m_s = 0;
        break;
      }
    }
    state_.touching = state_.touching && Near(car_.radius_m + kTouching_m).found;
  }

 private:
  Wall Near(double reach_m) const noexcept { return NearestWall(scene_, surface_, state_.position_base_m, reach_m); }

  // Takes the car out of walls it overlaps and the part into them out of its motion   (8.2). False if it is still
  // wedged deeper than a tenth of its radius.
  bool PushOut(Vec3& motion) noexcept {
    for (int k = 0; k < kMaxPushes; ++k) {
      const Wall wall = Near(car_.radius_m);
      if (!wall.found) return true;
      Bounce(wall);
      motion = motion - std::min(0.0, Dot(motion, wall.normal)) * wall.normal;
      state_.position_base_m = state_.position_base_m + (car_.radius_m - wall.distance_m) * wall.normal;
    }
    return !Near(0.9 * car_.radius_m).found;
  }

  void Bounce(const Wall& wall) noexcept {
    const double along = Dot(heading_, wall.normal);
    const double impact_m_s = -state_.speed_m_s * along;
    if (!(impact_m_s > 0)) return;
    const bool hit = !state_.touching && impact_m_s > kFelt_m_s;
    if (hit) Hit(car_, wall.normal, scene_.materials()[wall.material].restitution, impact_m_s, state_);
    state_.touching = true;
    // What goes into the wall is lost at the hit. Scraping along it afterwards costs nothing, pushing into it does.
    if (hit || along * along > 0.5) state_.speed_m_s *= 1 - along * along;
  }

  const VehicleInput& car_;
  const Scene& scene_;
  const Surface& surface_;
  VehicleState& state_;
  Vec3 heading_;
};

// A lap: over the start line in its direction, after having been away from it.
void CountLap(const VehicleInput& car, const Vec3& before, VehicleState& state) noexcept {
  const Vec3 ahead{std::cos(car.start_heading_rad), std::sin(car.start_heading_rad), 0};
  const Vec3 left{-ahead.y, ahead.x, 0};
  const double reach_m = 10 * car.radius_m;
  const Vec3 from_start = state.position_base_m - car.start_base_m;
  if (Norm(from_start) > reach_m) state.away = true;
  const bool crossed = Dot(before - car.start_base_m, ahead) < 0 && Dot(from_start, ahead) >= 0;
  if (!state.away || !crossed || !(std::abs(Dot(from_start, left)) < reach_m)) return;
  state.laps += 1;
  state.away = false;
}

}  // namespace

void StartCar(const VehicleInput& car, VehicleState& state) noexcept {
  state = {};
  state.position_base_m = car.start_base_m;
  state.heading_rad = car.start_heading_rad;
  state.started = true;
}

// Bicycle, rear axle: x' = v cos h, y' = v sin h, h' = v tan(delta) / L   (8.1)
void DriveCar(const VehicleInput& car, const Scene& scene, const Surface& surface, const Thumbstick& stick, double dt_s,
              VehicleState& state) noexcept {
  double wanted_m_s = 0;
  double rate_m_s2 = kCoastFactor * car.acceleration_m_s2;
  if (stick.y > 0) {
    wanted_m_s = stick.y * car.speed_max_m_s;
    rate_m_s2 = (state.speed_m_s < 0 ? kBrakeFactor : 1) * car.acceleration_m_s2;
  } else if (stick.y < 0) {
    wanted_m_s = state.speed_m_s > 0 ? 0 : kReverseShare * stick.y * car.speed_max_m_s;
    rate_m_s2 = (state.speed_m_s > 0 ? kBrakeFactor * -stick.y : 1) * car.acceleration_m_s2;
  }
  const double change_m_s = std::clamp(wanted_m_s - state.speed_m_s, -rate_m_s2 * dt_s, rate_m_s2 * dt_s);
  state.speed_m_s += change_m_s;
  const double turn_rad_s = state.speed_m_s / car.wheelbase_m * std::tan(-stick.x * car.steer_max_rad);
  state.heading_rad = std::remainder(state.heading_rad + turn_rad_s * dt_s, 2 * std::numbers::pi);
  const Vec3 before = state.position_base_m;
  MoveCar(car, scene, surface, dt_s, state);
  CountLap(car, before, state);
}

// In free space the car moves by its clearance [conservative advancement, Mirtich 1996]; near walls by a quarter of its
// radius and is then pushed out. Its centre is never nearer to a wall than 0.9 radii before a piece and a piece moves
// it by less than that, so no speed carries it through.
void MoveCar(const VehicleInput& car, const Scene& scene, const Surface& surface, double dt_s,
             VehicleState& state) noexcept {
  Drive(car, scene, surface, state).Go(dt_s);
}

// Half sine   (8.4)
Vec3 PulseForce(const VehicleInput& car, double dt_s, VehicleState& state) noexcept {
  if (!(state.pulse_time_s >= 0)) return {};
  state.pulse_time_s += dt_s;
  if (!(state.pulse_time_s < car.hit_duration_s)) {
    state.pulse_time_s = -1;
    return {};
  }
  return state.pulse_amplitude_N * std::sin(std::numbers::pi * state.pulse_time_s / car.hit_duration_s) *
         state.pulse_direction;
}

}  // namespace omni::haptics
