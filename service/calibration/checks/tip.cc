#include "service/calibration/checks/tip.h"

#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

#include "service/base/eigen.h"

namespace omni::calibration {
namespace {

using Eigen::Vector3d;

constexpr double kMoved_m = 0.3e-3;      // rms: a good calibration leaves a fifth of it beside the base (simulated)
constexpr double kSigma_m = 0.2e-3;      // little beside what the calibration leaves of the pen's place
constexpr double kFromDrawing_m = 5e-3;  // five tolerances of 1 mm: beyond, it is another pen
constexpr double kIndependentPoses = 4;  // errors of similar poses are similar
constexpr double kErrorShare = 0.3;      // of the calibration's error, what turns with the pen (simulated: 0.2 rms)

template <class... Arguments>
base::Error Refused(const char* format, Arguments... arguments) {
  char text[320];
  std::snprintf(text, sizeof text, format, arguments...);
  return {"tip not measured: " + std::string(text)};
}

// Least squares of p + d u = c over the unknowns d and c: c is the mean of the left side, and
//   d = -sum (u - mean u).(p - mean p) / sum |u - mean u|^2
Tip Solve(std::span<const PivotPose> poses) {
  const auto n = static_cast<double>(poses.size());
  Vector3d p_mean = Vector3d::Zero(), u_mean = Vector3d::Zero();
  for (const PivotPose& pose : poses) {
    p_mean += base::ToEigen(pose.position_base_m) / n;
    u_mean += base::ToEigen(pose.axis_base) / n;
  }
  double pp = 0, pu = 0, uu = 0;
  for (const PivotPose& pose : poses) {
    const Vector3d p = base::ToEigen(pose.position_base_m) - p_mean, u = base::ToEigen(pose.axis_base) - u_mean;
    pp += p.squaredNorm() / n;
    pu += p.dot(u) / n;
    uu += u.squaredNorm() / n;
  }
  const double d = -pu / uu;
  return {.tip_offset_m = d, .rms_m = std::sqrt(std::fmax(0, pp - d * d * uu)), .swing_rad = std::sqrt(uu)};
}

}  // namespace

base::Result<Tip> FindTip(std::span<const PivotPose> poses, double drawn_m, double expected_error_m) {
  Tip tip = Solve(poses);
  const double fit_m = tip.rms_m / (std::sqrt(kIndependentPoses) * tip.swing_rad);
  tip.sigma_m = std::hypot(fit_m, kErrorShare * expected_error_m);
  if (!(tip.rms_m <= kMoved_m)) {
    return Refused(
        "the tip moved by %.2f mm rms, the limit is %.1f: it slid, or it is not on the pen's axis; rest it in a deeper "
        "dimple, and do not turn the pen about its own axis",
        1e3 * tip.rms_m, 1e3 * kMoved_m);
  }
  if (!(fit_m <= kSigma_m)) {
    return Refused(
        "the pen leaned by %.0f degrees rms, which locates the tip only to %.2f mm, the limit is %.1f: lean it "
        "further, to all sides, in a dimple beside the base",
        tip.swing_rad * 180 / std::numbers::pi, 1e3 * fit_m, 1e3 * kSigma_m);
  }
  if (!(tip.sigma_m <= kSigma_m)) {
    return Refused(
        "the calibration leaves errors of %.2f mm, too much to locate the tip to %.1f mm; calibrate this base "
        "again: omni calibrate --replace",
        1e3 * expected_error_m, 1e3 * kSigma_m);
  }
  if (!(tip.tip_offset_m >= 0 && std::abs(tip.tip_offset_m - drawn_m) <= kFromDrawing_m)) {
    return Refused(
        "it is %.2f mm from the magnet's centre, the drawing says %.2f, the limit is %.0f more or less: rest the tip, "
        "and nothing else of the pen, in the dimple; a pen of another length needs a drawing of its own "
        "(magnet.tip_offset_m of omni calibrate --device-file)",
        1e3 * tip.tip_offset_m, 1e3 * drawn_m, 1e3 * kFromDrawing_m);
  }
  return tip;
}

}  // namespace omni::calibration
