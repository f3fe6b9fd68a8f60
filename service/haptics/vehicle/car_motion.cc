#include "service/haptics/vehicle/car_motion.h"

namespace omni::haptics {
namespace {

constexpr int kMaxLegs = 12;        // straight pieces of a tick's path; the remainder is not driven
constexpr int kMaxPushes = 4;       // walls that may push at once
constexpr double kFelt_m_s = 1e-3;  // slower contacts with a wall are not hits
constexpr double kTouching = 0.1;   // of the radius: leans on a wall until it is that far away
constexpr double kSameWall = 0.9;   // cosine between normals of one curved wall
constexpr double kFastest_m_s = 1e3;
constexpr double kFastestTurn_rad_s = 1e4;

class Drive {
 public:
  Drive(const VehicleInput& car, const WallMap& walls, std::span<const Material> materials,
        VehicleState& state) noexcept
      : car_(car), walls_(walls), materials_(materials), state_(state) {}

  Impacts Go(double dt_s) noexcept {
    double left_s = dt_s;
    if (state_.velocity_base_m_s == Vec3{}) PushOut();
    for (int leg = 0; leg < kMaxLegs && left_s > 0; ++leg) {
      const Vec3 motion = left_s * state_.velocity_base_m_s;
      WallTouch touch = FirstTouch(walls_, state_.position_base_m, motion, car_.radius_m);
      if (leg == 0 && touch.overlaps) {
        PushOut();
        touch = FirstTouch(walls_, state_.position_base_m, motion, car_.radius_m);
      }
      state_.position_base_m = state_.position_base_m + touch.share * motion;
      if (!touch.found) break;
      left_s *= 1 - touch.share;
      HitWall(touch, left_s);
    }
    KeepTouched();
    return impacts_;
  }

 private:
  // Out of walls it overlaps (a car that was put there), by a motion that itself stops at walls
  void PushOut() noexcept {
    for (int k = 0; k < kMaxPushes; ++k) {
      const Wall wall = NearestWall(walls_, state_.position_base_m, car_.radius_m * (1 - 1e-9));
      if (!wall.found) return;
      const Vec3 motion = (car_.radius_m - wall.distance_m) * wall.normal;
      const WallTouch touch = FirstTouch(walls_, state_.position_base_m, motion, car_.radius_m);
      state_.position_base_m = state_.position_base_m + touch.share * motion;
      if (touch.share == 0) return;  // wedged
    }
  }

  void HitWall(const WallTouch& touch, double left_s) noexcept {
    const double speed_m_s = -Dot(state_.velocity_base_m_s, touch.normal);
    const bool hit = speed_m_s > kFelt_m_s && !Touched(touch.normal);
    const double restitution = hit ? std::clamp(materials_[touch.material].restitution, 0.0, 1.0) : 0;
    if (hit) {
      state_.hits += 1;
      state_.hit_speed_m_s = speed_m_s;
      if (impacts_.count < kMaxImpacts) {
        impacts_.of[static_cast<std::size_t>(impacts_.count++)] = {speed_m_s, touch.normal, restitution};
      }
    }
    TurnAlong(touch.normal, speed_m_s * left_s);
    Bounce(touch.normal, restitution);
    Remember(touch.normal);
    // Between two walls: what one of them sends into the other stays there.
    for (std::uint32_t k = 0; k < met_; ++k) {
      if (Dot(state_.velocity_base_m_s, met_normal_[k]) < -kFelt_m_s * 1e-3 && restitution == 0) {
        state_.velocity_base_m_s = {};
      }
    }
    if (met_ < met_normal_.size()) met_normal_[met_++] = touch.normal;
  }

  // Arm of the wall's push at the bumper that meets it, half a wheelbase ahead of the centre or behind it.
  double BumperArm_m(const Vec3& n) const noexcept {
    const Vec3 heading{std::cos(state_.heading_rad), std::sin(state_.heading_rad), 0};
    const double side = Dot(heading, n) > 0 ? -0.5 : 0.5;
    return side * car_.wheelbase_m * (heading.x * n.y - heading.y * n.x);
  }

  // The bumper is pushed aside by the distance `into_m` that the wall did not let it go: turns the car along the wall,
  // even where its tyres would hold it.
  void TurnAlong(const Vec3& n, double into_m) noexcept {
    const double lever_m = 0.5 * car_.wheelbase_m;
    state_.heading_rad += std::clamp(into_m / lever_m, 0.0, 0.1) * BumperArm_m(n) / lever_m;
  }

  // The bumper meets the wall: impulse J = -(1 + e) u / (1 + l^2/k^2) per mass, u = (v + turn) . n, l = its arm. Then
  // the centre itself may not go on into the wall.   (8.8)
  void Bounce(const Vec3& n, double restitution) noexcept {
    const double arm_m = BumperArm_m(n);
    const double approach_m_s = Dot(state_.velocity_base_m_s, n) + state_.yaw_rate_rad_s * arm_m;
    if (approach_m_s < 0) {
      const double gyration_m2 = GyrationSquared_m2(car_);
      const double impulse_m_s = -(1 + restitution) * approach_m_s / (1 + arm_m * arm_m / gyration_m2);
      state_.velocity_base_m_s = state_.velocity_base_m_s + impulse_m_s * n;
      state_.yaw_rate_rad_s += impulse_m_s * arm_m / gyration_m2;
    }
    const double still_into_m_s = Dot(state_.velocity_base_m_s, n);
    if (still_into_m_s < 0) state_.velocity_base_m_s = state_.velocity_base_m_s - still_into_m_s * n;
  }

  bool Touched(const Vec3& n) const noexcept {
    for (std::uint32_t k = 0; k < state_.touched; ++k) {
      if (Dot(state_.touched_normal[k], n) > kSameWall) return true;
    }
    return false;
  }

  void Remember(const Vec3& n) noexcept {
    for (std::uint32_t k = 0; k < state_.touched; ++k) {
      if (Dot(state_.touched_normal[k], n) <= kSameWall) continue;
      state_.touched_normal[k] = n;  // a curved wall's normal turns with the place
      return;
    }
    const std::uint32_t at = state_.touched < 2 ? state_.touched++ : 0;
    state_.touched_normal[at] = n;
  }

  // Walls it has left are forgotten.
  void KeepTouched() noexcept {
    const double near_m = kTouching * car_.radius_m;
    for (std::uint32_t k = 0; k < state_.touched; ++k) {
      const Vec3 back = (-2 * near_m) * state_.touched_normal[k];
      if (FirstTouch(walls_, state_.position_base_m, back, car_.radius_m).found) continue;
      state_.touched_normal[k] = state_.touched_normal[--state_.touched];
      --k;
    }
  }

  const VehicleInput& car_;
  const WallMap& walls_;
  std::span<const Material> materials_;
  VehicleState& state_;
  Impacts impacts_;
  std::array<Vec3, kMaxLegs> met_normal_;
  std::uint32_t met_ = 0;
};

}  // namespace

Impacts MoveCar(const VehicleInput& car, const WallMap& walls, std::span<const Material> materials, double dt_s,
                VehicleState& state) noexcept {
  if (!(Norm(state.velocity_base_m_s) <= kFastest_m_s)) state.velocity_base_m_s = {};
  if (!(std::abs(state.yaw_rate_rad_s) <= kFastestTurn_rad_s)) state.yaw_rate_rad_s = 0;
  return Drive(car, walls, materials, state).Go(dt_s);
}

}  // namespace omni::haptics
