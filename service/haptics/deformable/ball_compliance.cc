#include "service/haptics/deformable/ball_compliance.h"

#include <algorithm>
#include <cmath>

namespace omni::haptics {
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
