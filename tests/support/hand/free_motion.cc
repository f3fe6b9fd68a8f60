#include "tests/support/hand/free_motion.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace omni::sim {
namespace {

constexpr double kGrid_s = 1e-3;
constexpr double kStep = 1e-4;      // of the path parameter, in differences
constexpr double kAmplitude = 1.3;  // of a wave: the bounded coordinates come near their ends now and then
constexpr double kRateMin = 0.4, kRateMax = 1.6;  // of the waves, per unit of the path parameter
constexpr double kPaceMin = 0.02;                 // of the greatest speed
constexpr double kPaceRate_rad_s = 2;             // how fast the pace changes
constexpr double kSlack = 0.999;                  // of the greatest speed: over what interpolation adds

std::array<double, 2> Disc(double x, double y) noexcept {
  const double k = 1 / std::sqrt(1 + x * x + y * y);
  return {k * x, k * y};
}

}  // namespace

double FreeMotion::Coordinate::At(double s) const noexcept {
  double x = 0;
  for (const Wave& wave : waves) x += std::sin(wave.rate * s + wave.phase);
  return kAmplitude * x;
}

FreeMotion::FreeMotion(const base::DeviceGeometry& device, const MotionOptions& options, double duration_s)
    : magnet_(device.magnet), hull_radius_m_(device.hull_radius_m), options_(options), tremor_([&] {
        Random random(~options.seed);
        return Tremor(options.tremor_m, random);
      }()) {
  Random random(options.seed);
  const auto draw = [&](Coordinate& coordinate) {
    for (Coordinate::Wave& wave : coordinate.waves) {
      wave.rate = random.Uniform(kRateMin, kRateMax);
      wave.phase = 2 * std::numbers::pi * random.Uniform();
    }
  };
  for (Coordinate& coordinate : coordinates_) draw(coordinate);
  draw(pace_);
  // ds/dt = RateAt(t, s) by the midpoint rule.
  double s = 0;
  const auto count = static_cast<std::size_t>(std::ceil(duration_s / kGrid_s)) + 1;
  for (std::size_t i = 0; i <= count; ++i) {
    const double t_s = static_cast<double>(i) * kGrid_s;
    const double rate = RateAt(t_s, s);
    knots_.push_back({s, rate});
    s += kGrid_s * RateAt(t_s + 0.5 * kGrid_s, s + 0.5 * kGrid_s * rate);
  }
}

// The least distance of the magnet's centre at which the disc is gap_min away from the hull: face towards it,
// r cos b = H + h, as long as the foot point lies on the face (r sin b <= R); beyond, its edge:
// (r sin b - R)^2 + (r cos b - h)^2 = H^2.
double FreeMotion::ContactRadius(double tilt_rad) const noexcept {
  const double H = hull_radius_m_ + options_.gap_min_m + Tremor::kReach_rms * options_.tremor_m + 1e-9;
  const double R = magnet_.radius_m;
  const double h = magnet_.half_height_m;
  const double c = std::cos(tilt_rad);
  const double s = std::sin(tilt_rad);
  const double face_m = (H + h) / c;
  if (c > 0 && face_m * s <= R) return face_m;
  const double p = R * s + h * c;
  return p + std::sqrt(std::max(0.0, p * p - (R * R + h * h - H * H)));
}

MagnetPose FreeMotion::PoseAt(double s) const noexcept {
  const auto raw = [&](std::size_t i) { return coordinates_[i].At(s); };
  const std::array<double, 2> place = Disc(raw(0), raw(1));
  const std::array<double, 2> lean = Disc(raw(3), raw(4));
  // From straight up by a rotation vector in the plane; the axis turns with it, then leans.
  const double span = 0.5 * std::numbers::pi - options_.elevation_min_rad;
  const Vec3 swing{span * place[0], span * place[1], 0};
  const Vec3 outwards = Rotated(Vec3{0, 0, 1}, swing);
  const Vec3 tilt = Rotated(Vec3{options_.tilt_max_rad * lean[0], options_.tilt_max_rad * lean[1], 0}, swing);
  const double least_m = ContactRadius(Norm(tilt));
  const double x = raw(2);
  const double fraction = 0.5 + 0.5 * x / std::sqrt(1 + x * x);
  const double radius_m = least_m + fraction * std::max(0.0, options_.radius_max_m - least_m);
  return {radius_m * outwards, Rotated(-outwards, tilt)};
}

// Bounded by the speed of the centre and by the turn rate of the axis, whichever is reached first.
double FreeMotion::RateAt(double t_s, double s) const noexcept {
  const MagnetPose a = PoseAt(s - kStep);
  const MagnetPose b = PoseAt(s + kStep);
  const double speed = Norm(b.centre_base_m - a.centre_base_m) / (2 * kStep) / options_.speed_max_m_s;
  const double turn = Norm(b.axis_base - a.axis_base) / (2 * kStep) / options_.turn_rate_max_rad_s;
  const double x = pace_.At(kPaceRate_rad_s * t_s);
  const double pace = kPaceMin + (1 - kPaceMin) * (0.5 + 0.5 * x / std::sqrt(1 + x * x));
  return kSlack * pace / std::sqrt(speed * speed + turn * turn + 1e-12);
}

// s = a.s + x (A + x (B + x C)), slopes a.rate and b.rate at the ends.
std::array<double, 2> FreeMotion::Along(double t_s) const noexcept {
  const double at = std::clamp(t_s / kGrid_s, 0.0, static_cast<double>(knots_.size() - 2));
  const auto i = std::min(static_cast<std::size_t>(at), knots_.size() - 2);
  const double x = t_s / kGrid_s - static_cast<double>(i);
  const Knot& a = knots_[i];
  const Knot& b = knots_[i + 1];
  const double rise = b.s - a.s;
  const double A = a.rate * kGrid_s;
  const double B = 3 * rise - kGrid_s * (2 * a.rate + b.rate);
  const double C = kGrid_s * (a.rate + b.rate) - 2 * rise;
  return {a.s + x * (A + x * (B + x * C)), (A + x * (2 * B + x * 3 * C)) / kGrid_s};
}

FreeMotion::State FreeMotion::StateAt(double t_s) const noexcept {
  const auto [s, rate] = Along(t_s);
  State state;
  state.pose = PoseAt(s);
  state.velocity_base_m_s = (rate / (2 * kStep)) * (PoseAt(s + kStep).centre_base_m - PoseAt(s - kStep).centre_base_m);
  tremor_.AddTo(t_s, state.pose.centre_base_m, state.velocity_base_m_s);
  return state;
}

MagnetPose FreeMotion::Pose(double t_s) const noexcept {
  MagnetPose pose = PoseAt(Along(t_s)[0]);
  Vec3 velocity_m_s;
  tremor_.AddTo(t_s, pose.centre_base_m, velocity_m_s);
  return pose;
}

}  // namespace omni::sim
