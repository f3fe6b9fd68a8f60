#include "service/haptics/vehicle/car_motion.h"

#include <numbers>

namespace omni::haptics {
namespace {

constexpr double kLongestStep_s = 0.5e-3;
constexpr double kReverseShare = 0.3;   // of the top speed
constexpr double kBrakeFactor = 2;      // braking over accelerating
constexpr double kRollingShare = 0.3;   // rolling resistance over accelerating
constexpr double kDragShare = 0.5;      // air drag at top speed over accelerating
constexpr double kEngineGain = 4;       // full power while more than 1 / gain of the top speed is missing
constexpr double kStill = 1e-3;         // of the top speed: below, the brake becomes the reverse gear
constexpr double kLeastSideGrip = 0.3;  // what braking or accelerating leaves for the side
constexpr double kLeaningGrip = 0.1;    // of the side grip, while a wall carries the car along
constexpr double kSlowest_m_s = 1e-4;   // the rolling speed that slip is measured against at least

// Acceleration along the car that the engine, the brake, air and rolling resistance add up to   (8.5)
double Along(const VehicleInput& car, double stick_y, double speed_m_s, double dt_s) noexcept {
  const double a = car.acceleration_m_s2, top = car.speed_max_m_s;
  const double forward = speed_m_s / top;
  const double resistance = kRollingShare * a + kDragShare * a * forward * forward;
  const bool braking = stick_y < 0 && forward > kStill;
  const double wanted = braking ? 0 : (stick_y < 0 ? kReverseShare * stick_y : stick_y);
  const bool driving = wanted != 0 && (wanted > 0 ? forward < wanted + kStill : forward > wanted - kStill);
  double change_m_s2 = 0;
  if (driving && forward * wanted >= 0) {
    change_m_s2 = std::clamp(kEngineGain * a * (wanted - forward), -a, a);
  } else {
    // What only resists stops the car, it does not turn it round.
    const double brake = braking || forward * wanted < 0 ? kBrakeFactor * a * std::min(1.0, std::abs(stick_y)) : 0;
    const double most = std::abs(speed_m_s - wanted * top) / dt_s;
    change_m_s2 = -std::copysign(std::min(resistance + brake, most), speed_m_s - wanted * top);
  }
  const double grip_m_s2 = car.grip_g * kGravity_m_s2;
  return std::clamp(change_m_s2, -grip_m_s2, grip_m_s2);
}

// One axle: F = -D w against its slip velocity w, with the secant D(w) frozen over the step   (8.3)
struct Axle {
  double n[3];  // generalised direction of the side force: along the car, across it, turn
  double damping_1_s;
  double slip;
};

Axle MakeAxle(const VehicleInput& car, double load, double stiffness, double side_share, const Vec3& wheel,
              double ahead_m, const double (&q)[3]) noexcept {
  const double s = wheel.y, c = wheel.x;
  Axle axle{{-s, c, ahead_m * c}, 0, 0};
  const double across = q[1] + ahead_m * q[2];
  const double slip_m_s = std::abs(axle.n[0] * q[0] + c * across);
  const double rolling_m_s = std::max(std::abs(c * q[0] + s * across), kSlowest_m_s);
  axle.slip = stiffness * slip_m_s / (car.grip_g * rolling_m_s);
  const double grip_m_s2 = load * side_share * car.grip_g * kGravity_m_s2;
  // D = F / w; F grows as slip for small ones.
  axle.damping_1_s = axle.slip > 1e-6 ? grip_m_s2 * BrushTyre(axle.slip) / slip_m_s
                                      : grip_m_s2 * stiffness / (car.grip_g * rolling_m_s);
  return axle;
}

// (M + h sum D n n') q' = M q + h a: symmetric and positive, whatever D is   (8.4). Cholesky.
void SolveStep(const Axle& front, const Axle& rear, double gyration_m2, double dt_s, const double (&a)[3],
               double (&q)[3]) noexcept {
  const double mass[3] = {1, 1, gyration_m2};
  double m[3][3], y[3];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j <= i; ++j) {
      m[i][j] = dt_s * (front.damping_1_s * front.n[i] * front.n[j] + rear.damping_1_s * rear.n[i] * rear.n[j]);
    }
    m[i][i] += mass[i];
    y[i] = mass[i] * q[i] + dt_s * a[i];
  }
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j <= i; ++j) {
      double sum = m[i][j];
      for (int k = 0; k < j; ++k) sum -= m[i][k] * m[j][k];
      m[i][j] = i == j ? std::sqrt(sum) : sum / m[j][j];
    }
    for (int k = 0; k < i; ++k) y[i] -= m[i][k] * y[k];
    y[i] /= m[i][i];
  }
  for (int i = 2; i >= 0; --i) {
    for (int k = i + 1; k < 3; ++k) y[i] -= m[k][i] * q[k];
    q[i] = y[i] / m[i][i];
  }
}

// `wheel`: direction of the front wheels in the car.
void SubStep(const VehicleInput& car, const Thumbstick& stick, const Vec3& wheel, double dt_s,
             VehicleState& state) noexcept {
  const double turn_before_rad_s = state.yaw_rate_rad_s;
  const double heading = state.heading_rad + 0.5 * dt_s * turn_before_rad_s;
  const Vec3 ahead{std::cos(heading), std::sin(heading), 0}, left{-ahead.y, ahead.x, 0};
  double q[3] = {Dot(state.velocity_base_m_s, ahead), Dot(state.velocity_base_m_s, left), state.yaw_rate_rad_s};
  const double a[3] = {Along(car, stick.y, q[0], dt_s), 0, 0};
  // Friction circle: what goes into driving and braking is not there for the side.
  const double used = a[0] / (car.grip_g * kGravity_m_s2);
  const double side_share =
      std::max(kLeastSideGrip, std::sqrt(std::max(0.0, 1 - used * used))) * (state.touched > 0 ? kLeaningGrip : 1);
  const double to_front_m = (1 - car.front_share) * car.wheelbase_m, to_rear_m = car.front_share * car.wheelbase_m;
  const Axle front = MakeAxle(car, car.front_share, car.slip_stiffness_front_per_rad, side_share, wheel, to_front_m, q);
  const Axle rear =
      MakeAxle(car, 1 - car.front_share, car.slip_stiffness_rear_per_rad, side_share, {1, 0, 0}, -to_rear_m, q);
  SolveStep(front, rear, GyrationSquared_m2(car), dt_s, a, q);
  state.velocity_base_m_s = q[0] * ahead + q[1] * left;
  state.yaw_rate_rad_s = q[2];
  state.heading_rad += 0.5 * dt_s * (turn_before_rad_s + q[2]);
  const bool moves = SquaredNorm(state.velocity_base_m_s) > kSlowest_m_s * kSlowest_m_s;
  state.sliding = moves && std::max(front.slip, rear.slip) >= 3;
}

}  // namespace

double BrushTyre(double slip) noexcept {
  if (!(slip < 3)) return 1;
  return slip * (1 - slip * (1.0 / 3 - slip / 27));
}

double GyrationSquared_m2(const VehicleInput& car) noexcept {
  return car.inertia * car.front_share * (1 - car.front_share) * car.wheelbase_m * car.wheelbase_m;
}

void Accelerate(const VehicleInput& car, const Thumbstick& stick, double dt_s, VehicleState& state) noexcept {
  if (!(dt_s > 0)) return;
  const int steps = std::max(1, static_cast<int>(std::ceil(dt_s / kLongestStep_s - 1e-9)));
  const double steer_rad = -stick.x * car.steer_max_rad;
  const Vec3 wheel{std::cos(steer_rad), std::sin(steer_rad), 0};
  for (int k = 0; k < steps; ++k) SubStep(car, stick, wheel, dt_s / steps, state);
  if (!(std::abs(state.heading_rad) <= std::numbers::pi)) {
    state.heading_rad = std::remainder(state.heading_rad, 2 * std::numbers::pi);
  }
}

}  // namespace omni::haptics
