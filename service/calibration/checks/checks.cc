#include "service/calibration/checks/checks.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "service/base/eigen.h"
#include "service/calibration/types.h"

namespace omni::calibration {
namespace {

using Eigen::Vector3d;
using RowMajor3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

constexpr double kBackgroundMax_T = 3e-4;  // the earth's field is at most 65 uT
constexpr double kMapRatioMin = 0.7, kMapRatioMax = 1.4;
constexpr double kLikeAnother = 0.35;  // a map is off another sensor's drawing by less ...
constexpr double kUnlikeOwn = 2;       // ... and off its own by more than so many times that: it is that one's

std::string Number(double value, const char* format = "%.3g") {
  char text[32];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

std::string Percent(double share) { return Number(100 * share, "%.0f") + " %"; }

bool IsComplete(const Sample& sample) {
  return std::all_of(sample.field_sensor_T.begin(), sample.field_sensor_T.end(), [](const base::Vec3& B) {
    return std::isfinite(B.x) && std::isfinite(B.y) && std::isfinite(B.z);
  });
}

std::string SampleProblem(const Sample& sample, std::size_t index, std::size_t sensors) {
  const std::string name = "samples[" + std::to_string(index) + "]";
  if (sample.field_sensor_T.size() != sensors) {
    return name + ".field_sensor_T has " + std::to_string(sample.field_sensor_T.size()) + " sensors, the device has " +
           std::to_string(sensors) + "; record with this device";
  }
  const bool finite =
      std::isfinite(sample.t_s) && std::all_of(sample.coil_current_A.begin(), sample.coil_current_A.end(),
                                               [](double current) { return std::isfinite(current); });
  if (!finite) return name + " has a time or a current that is not a number; record again";
  if (!(sample.noise_scale > 0 && sample.noise_scale <= 100)) {
    return name + ".noise_scale = " + Number(sample.noise_scale) + " is not within (0, 100]; record again";
  }
  return {};
}

std::string ResponseProblem(const base::SensorCalibration& drawn, const CoilResponse& response, std::size_t index) {
  const std::string name = "sensor " + std::to_string(index);
  const Vector3d background = base::ToEigen(response.background_sensor_T);
  if (!(background.norm() <= kBackgroundMax_T)) {
    return name + " reads " + Number(1e6 * background.norm()) + " uT at rest, more than " +
           Number(1e6 * kBackgroundMax_T) + "; take the pen and other magnets away";
  }
  const RowMajor3d measured = Eigen::Map<const RowMajor3d>(response.map_sensor_T_A.data());
  const RowMajor3d expected = Eigen::Map<const RowMajor3d>(drawn.current_map_T_A.data());
  if (!(measured.allFinite() && response.map_error_T_A >= 0))
    return name + ": its current map is not a number; sweep again";
  for (int k = 0; k < 3; ++k) {
    const double size = expected.col(k).norm();
    if (!(size > 0)) continue;
    const double along = measured.col(k).dot(expected.col(k)) / (size * size);
    if (along < 0) {
      return "coil " + std::string(1, "xyz"[k]) + " acts backwards on " + name +
             "; swap its leads, or correct its axis in the device file";
    }
    if (!(along >= kMapRatioMin && along <= kMapRatioMax)) {
      return "coil " + std::string(1, "xyz"[k]) + " acts on " + name + " with " + Percent(along) +
             " of its nominal field, allowed is 70 to 140 %; check coil, current sensor and device file";
    }
  }
  return {};
}

// How far the map of sensor `measured` is from the nominal map of `drawn`, relative to the latter.
double MapError(const base::Calibration& nominal, const std::vector<CoilResponse>& responses, std::size_t measured,
                std::size_t drawn) {
  const RowMajor3d map = Eigen::Map<const RowMajor3d>(responses[measured].map_sensor_T_A.data());
  const RowMajor3d drawing = Eigen::Map<const RowMajor3d>(nominal.sensors[drawn].current_map_T_A.data());
  return drawing.norm() > 0 ? (map - drawing).norm() / drawing.norm() : 0;
}

std::string SwapProblem(const base::Calibration& nominal, const std::vector<CoilResponse>& responses) {
  const auto is_of = [&](std::size_t measured, std::size_t drawn) {
    const double other = MapError(nominal, responses, measured, drawn);
    return other < kLikeAnother && MapError(nominal, responses, measured, measured) > kUnlikeOwn * other;
  };
  for (std::size_t a = 0; a < responses.size(); ++a) {
    for (std::size_t b = a + 1; b < responses.size(); ++b) {
      if (!is_of(a, b) || !is_of(b, a)) continue;
      return "sensors " + std::to_string(a) + " and " + std::to_string(b) +
             " are swapped: each reads the coils as the other should; exchange their cables or addresses";
    }
  }
  return {};
}

std::string CoverageProblem(const std::vector<ColdPose>& poses, const Limits& limits) {
  Coverage coverage;
  for (const ColdPose& pose : poses) {
    if (pose.found) coverage.Add(base::FromEigen(pose.position_base_m));
  }
  if (coverage.share() >= limits.coverage_min) return {};
  return "the pen was over " + Percent(coverage.share()) + " of the upper hemisphere, at least " +
         Percent(limits.coverage_min) + " are needed; wave it on all sides of the base, low and high";
}

}  // namespace

// Bands of equal height on a sphere have equal area [Archimedes].
void Coverage::Add(const base::Vec3& position_base_m) noexcept {
  const base::Vec3& p = position_base_m;
  const double height = p.z / Norm(p);
  if (!(height >= 0)) return;
  const double turn = std::atan2(p.y, p.x) / (2 * std::numbers::pi);
  const int band = std::min(kCoverageBands - 1, static_cast<int>(height * kCoverageBands));
  const int sector = std::min(kCoverageSectors - 1, static_cast<int>((turn < 0 ? turn + 1 : turn) * kCoverageSectors));
  ++visits[static_cast<std::size_t>(band) * kCoverageSectors + static_cast<std::size_t>(sector)];
}

double Coverage::share() const noexcept {
  const auto visited = std::count_if(visits.begin(), visits.end(), [](int count) { return count > 0; });
  return static_cast<double>(visited) / kCoverageCells;
}

std::string ResponsesProblem(const base::Calibration& nominal, const std::vector<CoilResponse>& responses) {
  const std::size_t sensors = nominal.sensors.size();
  if (!responses.empty() && responses.size() != sensors) {
    return std::to_string(responses.size()) + " current maps for " + std::to_string(sensors) + " sensors; sweep again";
  }
  if (auto problem = SwapProblem(nominal, responses); !problem.empty()) return problem;
  for (std::size_t i = 0; i < responses.size(); ++i) {
    if (auto problem = ResponseProblem(nominal.sensors[i], responses[i], i); !problem.empty()) return problem;
  }
  return {};
}

std::string RecordingProblem(const base::Calibration& nominal, const Recording& recording, const Limits& limits) {
  const std::size_t sensors = nominal.sensors.size();
  if (!(sensors >= base::kArraySensorsMin && sensors <= base::kArraySensorsMax)) {
    return "the device has " + std::to_string(sensors) + " sensors, 4 to 64 can be calibrated";
  }
  for (const double noise : nominal.sensor_noise_T) {
    if (!(noise > 0)) return "sensor_noise_T must be above 0 to weigh readings; correct the device file";
  }
  if (auto problem = ResponsesProblem(nominal, recording.responses); !problem.empty()) return problem;
  std::size_t incomplete = 0, touches = 0;
  for (std::size_t n = 0; n < recording.samples.size(); ++n) {
    if (auto problem = SampleProblem(recording.samples[n], n, sensors); !problem.empty()) return problem;
    incomplete += IsComplete(recording.samples[n]) ? 0 : 1;
    touches += recording.samples[n].touches_hull ? 1 : 0;
  }
  const std::size_t count = recording.samples.size();
  if (count < static_cast<std::size_t>(limits.samples_min)) {
    return std::to_string(count) + " usable poses, at least " + std::to_string(limits.samples_min) +
           " are needed; wave the pen longer";
  }
  if (nominal.hull_radius_m > 0 && touches < static_cast<std::size_t>(limits.touches_min)) {
    return std::to_string(touches) + " touches of the hull, at least " + std::to_string(limits.touches_min) +
           " are needed; touch it in more places and rest there for a moment";
  }
  const double share = static_cast<double>(incomplete) / static_cast<double>(count);
  if (!(share <= limits.saturated_max)) {
    return "sensors were saturated or silent in " + Percent(share) + " of the poses, at most " +
           Percent(limits.saturated_max) + " is allowed; look for a strong magnet near the base or a broken sensor";
  }
  return {};
}

std::string PosesProblem(const base::Calibration& nominal, const Recording& recording,
                         const std::vector<ColdPose>& poses, const Limits& limits) {
  double found = 0, outwards = 0;
  Vector3d mean = Vector3d::Zero();
  double square_m2 = 0;
  for (const ColdPose& pose : poses) {
    if (!pose.found) continue;
    ++found;
    mean += pose.position_base_m;
    square_m2 += pose.position_base_m.squaredNorm();
    outwards += pose.axis_base.dot(pose.position_base_m) > 0 ? 1 : 0;
  }
  const double misfit = 1 - found / static_cast<double>(recording.samples.size());
  if (!(misfit <= limits.misfit_max)) {
    return Percent(misfit) + " of the readings fit no pose of this magnet, at most " + Percent(limits.misfit_max) +
           " is allowed; remove other magnets and iron, and check magnet and sensors (order, axes) against the device "
           "file";
  }
  mean /= found;
  const double travel_m = std::sqrt(std::max(0.0, square_m2 / found - mean.squaredNorm()));
  if (!(travel_m >= limits.travel_min_m)) {
    return "the pen moved by " + Number(1e3 * travel_m, "%.1f") + " mm (rms), at least " +
           Number(1e3 * limits.travel_min_m, "%.0f") + " are needed; wave it all round the base";
  }
  if (!(nominal.hull_radius_m > 0)) return {};  // no base: no inside and outside
  if (outwards > 0.5 * found) {
    return "the magnet sits in the pen the wrong way round: its moment points away from the base in " +
           Percent(outwards / found) + " of the poses; turn it over";
  }
  return CoverageProblem(poses, limits);
}

std::string ResultProblem(const Adjustment& adjustment, const Report& report, const Limits& limits) {
  const Parameters& parameters = adjustment.parameters;
  if (report.rests_in_air > 0 && report.touches < limits.on_hull_min) {
    return std::to_string(report.touches) + " of " + std::to_string(report.touches + report.rests_in_air) +
           " touches lie on the hull, at least " + std::to_string(limits.on_hull_min) +
           " must; rest the pen's end on it, not above it";
  }
  if (!(report.chi2_per_dof <= limits.chi2_per_dof_max)) {
    return "readings and model disagree: chi2 per degree of freedom is " + Number(report.chi2_per_dof) +
           ", the limit is " + Number(limits.chi2_per_dof_max) +
           "; look for a second magnet, moving iron or a base that was pushed, and record again";
  }
  if (!(std::abs(report.moment_relative) <= limits.moment_max)) {
    return "the magnet is " + Percent(std::abs(report.moment_relative)) +
           (report.moment_relative < 0 ? " weaker" : " stronger") + " than in the device file, the limit is " +
           Percent(limits.moment_max) + "; is it the right magnet?";
  }
  if (!adjustment.converged || !adjustment.covariance.allFinite()) {
    return "the adjustment did not converge in " + std::to_string(report.iterations) +
           " iterations; record again, with the base at rest and nothing magnetic near";
  }
  Eigen::Index worst = 0;
  const double sigmas = parameters.x().cwiseAbs().maxCoeff(&worst);
  if (!(sigmas <= limits.tolerance_sigmas_max)) {
    const int index = static_cast<int>(worst);
    return parameters.Name(index) + " was found to be " +
           Number(parameters.x()[worst] * parameters.ToleranceInUnit(index)) + " " + parameters.Unit(index) + ", " +
           Number(sigmas, "%.1f") + " tolerances from the drawing, the limit is " +
           Number(limits.tolerance_sigmas_max) + "; check the device file and this sensor";
  }
  return {};
}

}  // namespace omni::calibration
