#include "service/haptics/deformable/local_model.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace omni::haptics {
namespace {

constexpr int kMostDentSteps = 8;
constexpr double kDentTolerance = 1e-7;  // of s; Newton squares it once more

// s^3 (1 + g1 s + g2 s^2)
double DentPolynomial(const SoftGain& g, double s) noexcept {
  return s * s * s * (1 + s * (g.linear + s * g.quadratic));
}
double DentPolynomialSlope(const SoftGain& g, double s) noexcept {
  return s * s * (3 + s * (4 * g.linear + s * 5 * g.quadratic));
}

double ForceScale(const LocalModel& model) noexcept {
  return 4.0 / 3 * model.modulus_Pa * model.radius_m * model.radius_m;
}

}  // namespace

double ContactRadius(double ball_radius_m, double curvature_1_m) noexcept {
  const double curvature = 1 / ball_radius_m + curvature_1_m;
  const double most = 4 / ball_radius_m;
  return 1 / (curvature >= 1 / (4 * ball_radius_m) ? std::min(curvature, most) : 1 / (4 * ball_radius_m));
}

// dF/dx = dF/ds / (2 R s)
LocalPoint LocalAtDent(const LocalModel& model, double dent_m) noexcept {
  if (!(dent_m > 0)) return {};
  const double end_m = model.radius_m * kLargestDent * kLargestDent;
  const double s = std::min(std::sqrt(dent_m / model.radius_m), kLargestDent);
  const double scale = ForceScale(model);
  const double slope = scale * DentPolynomialSlope(model.gain, s) / (2 * model.radius_m * s);
  const double force = scale * DentPolynomial(model.gain, s);
  return {dent_m, dent_m > end_m ? force + (dent_m - end_m) * slope : force, slope};
}

LocalPoint LocalAtForce(const LocalModel& model, double force_N, double near_m) noexcept {
  if (!(force_N > 0)) return {};
  const double scale = ForceScale(model);
  const double y = force_N / scale;
  const double end = DentPolynomial(model.gain, kLargestDent);
  if (y >= end) {
    const LocalPoint last = LocalAtDent(model, model.radius_m * kLargestDent * kLargestDent);
    return {last.dent_m + (force_N - last.force_N) / last.slope_N_m, force_N, last.slope_N_m};
  }
  double s = near_m > 0 ? std::min(std::sqrt(near_m / model.radius_m), kLargestDent) : 0;
  const double guess = DentPolynomial(model.gain, s);
  if (!(guess > 0.5 * y && guess < 2 * y)) s = std::min(std::cbrt(y), kLargestDent);
  for (int step = 0; step < kMostDentSteps; ++step) {
    const double change = (DentPolynomial(model.gain, s) - y) / DentPolynomialSlope(model.gain, s);
    s = std::clamp(s - change, 1e-9, kLargestDent);
    if (std::abs(change) < kDentTolerance * s) break;
  }
  const double slope = scale * DentPolynomialSlope(model.gain, s) / (2 * model.radius_m * s);
  return {model.radius_m * s * s, force_N, slope};
}

double LocalForce(const LocalModel& model, double dent_m) noexcept { return LocalAtDent(model, dent_m).force_N; }
double LocalSlope(const LocalModel& model, double dent_m) noexcept { return LocalAtDent(model, dent_m).slope_N_m; }
double LocalDent(const LocalModel& model, double force_N) noexcept { return LocalAtForce(model, force_N, 0).dent_m; }

double ContactPatchRadius(const LocalModel& model, double dent_m) noexcept {
  return std::sqrt(model.radius_m * std::max(dent_m, 0.0));
}

double DentProfile(double r_over_a) noexcept {
  const double r = r_over_a;
  if (!(r > 1)) return 1 - 0.5 * r * r;
  if (r > 30) return 4 / (3 * std::numbers::pi * r);
  return ((2 - r * r) * std::asin(1 / r) + std::sqrt(r * r - 1)) / std::numbers::pi;
}

namespace {

constexpr double kSteepest = 0.8;          // how much of the local displacement a negative compliance may take away
constexpr double kSmallestForce_N = 1e-5;  // below, the slope of the dent is taken from here
constexpr int kMostAloneSteps = 24;
constexpr double kAloneTolerance = 1e-10;  // of the dent

struct DepthOfDent {
  double depth_m, slope;  // d depth / d dent
};

DepthOfDent Follow(const BallCompliance& give, const LocalPoint& p) noexcept {
  if (p.dent_m <= give.limit_dent_m) {
    const double c = give.compliance_m_N + give.series_m_N;
    return {p.dent_m + c * p.force_N, 1 + c * p.slope_N_m};
  }
  const double rest = 1 - kSteepest;
  return {give.limit_dent_m + give.compliance_m_N * give.limit_N + rest * (p.dent_m - give.limit_dent_m) +
              give.series_m_N * p.force_N,
          rest + give.series_m_N * p.slope_N_m};
}

}  // namespace

BallCompliance MakeBallCompliance(const LocalModel& model, double compliance_m_N, double series_m_N) noexcept {
  BallCompliance give{model, compliance_m_N, series_m_N};
  if (compliance_m_N < 0) {
    // Hertz: 1 / slope = 1 / (2 M a); the body may take kSteepest of it, so a = kSteepest / (2 M |c|).
    const double a = kSteepest / (2 * model.modulus_Pa * -compliance_m_N);
    give.limit_dent_m = a * a / model.radius_m;
    give.limit_N = LocalForce(model, give.limit_dent_m);
  }
  return give;
}

GivePoint GiveAtForce(const BallCompliance& give, double force_N, double near_m) noexcept {
  const LocalPoint p = LocalAtForce(give.model, force_N, near_m);
  const double depth_m = Follow(give, p).depth_m;
  const LocalPoint steep = force_N > kSmallestForce_N ? p : LocalAtForce(give.model, kSmallestForce_N, 0);
  return {p.dent_m, depth_m, Follow(give, steep).slope / steep.slope_N_m};
}

// Newton on the dent x, whose force is explicit: x + c F(x) = depth. A bracket catches the steps that leave it.
double ForceAlone(const BallCompliance& give, double depth_m, double near_m) noexcept {
  if (!(depth_m > 0)) return 0;
  double low = 0;
  // Without a spring at least (1 - kSteepest) x of the depth is the dent's.
  double high = give.compliance_m_N >= 0 ? depth_m : depth_m / (1 - kSteepest);
  double x = near_m > 0 && near_m < high ? near_m : std::min(depth_m, high);
  for (int step = 0; step < kMostAloneSteps; ++step) {
    const DepthOfDent at = Follow(give, LocalAtDent(give.model, x));
    (at.depth_m < depth_m ? low : high) = x;
    double next = x - (at.depth_m - depth_m) / at.slope;
    if (!(next >= low && next <= high)) next = 0.5 * (low + high);
    const bool done = std::abs(next - x) <= kAloneTolerance * next;
    x = next;
    if (done) break;
  }
  return LocalForce(give.model, x);
}

}  // namespace omni::haptics
