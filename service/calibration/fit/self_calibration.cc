#include "service/calibration/fit/self_calibration.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <vector>

#include "service/base/eigen.h"
#include "service/calibration/checks/checks.h"
#include "service/calibration/fit/adjust.h"
#include "service/calibration/fit/start.h"
#include "service/calibration/types.h"

namespace omni::calibration {
namespace {

using RowMajor3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

constexpr double kLostWeight = 0.3;  // a sample below counts as rejected, a touch as a rest in the air

// What was kept of a recording: samples with a pose.
struct Kept {
  Recording recording;
  std::vector<Instant> instants;
  Coverage coverage;
};

Kept KeepFound(const Recording& recording, const std::vector<ColdPose>& poses) {
  Kept kept;
  kept.recording.responses = recording.responses;
  for (std::size_t n = 0; n < poses.size(); ++n) {
    if (!poses[n].found) continue;
    kept.recording.samples.push_back(recording.samples[n]);
    kept.instants.push_back({poses[n].position_base_m, poses[n].axis_base});
    kept.coverage.Add(base::FromEigen(poses[n].position_base_m));
  }
  return kept;
}

base::SteelPlane FoundSteel(const Adjustment& adjustment) {
  if (!SeesSteel(adjustment)) return {};
  base::SteelPlane steel = adjustment.parameters.Steel();
  steel.height_base_m += adjustment.parameters.CoreCentre_m().z();
  return steel;
}

base::Calibration ToCalibration(const Problem& problem, const Adjustment& adjustment) {
  const Parameters& parameters = adjustment.parameters;
  base::Calibration calibration = problem.nominal();  // maps and background: as measured
  for (int i = 0; i < parameters.sensors(); ++i) {
    const SensorState state = parameters.Sensor(i);
    base::SensorCalibration& sensor = calibration.sensors[static_cast<std::size_t>(i)];
    sensor.position_base_m = base::FromEigen(state.position_base_m + parameters.CoreCentre_m());
    Eigen::Map<RowMajor3d>(sensor.gain_sensor_base.data()) = state.gain;
  }
  calibration.moment_Am2 = parameters.Moment_Am2(0);
  calibration.core_kappa = parameters.Kappa();
  if (problem.follows_core()) {
    calibration.core_kept_A = std::clamp(parameters.Kept_A(), base::kCoreKeptMin_A, base::kCoreKeptMax_A);
  }
  calibration.core_centre_base_m = base::FromEigen(parameters.CoreCentre_m());
  calibration.hull_radius_m = parameters.HullRadius_m();
  calibration.steel = FoundSteel(adjustment);
  return calibration;
}

void CountSamples(const Recording& recording, const Problem& problem, Report& report) {
  report.samples = static_cast<int>(recording.samples.size());
  report.rejected = report.samples - static_cast<int>(problem.observations().size());
  for (const Observation& observation : problem.observations()) {
    const bool in_air = observation.touch_weight < kLostWeight;
    report.touches += observation.touches_hull && !in_air ? 1 : 0;
    report.rests_in_air += observation.touches_hull && in_air ? 1 : 0;
    report.rejected += observation.weight < kLostWeight ? 1 : 0;
  }
}

Parameters StartAt(const base::Calibration& nominal, std::span<const base::CoilGeometry> coils,
                   const Tolerances& tolerances) {
  Parameters parameters(nominal, tolerances);
  std::array<Eigen::Vector3d, base::kCoilCount> axes{Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(),
                                                     Eigen::Vector3d::UnitZ()};
  for (std::size_t k = 0; k < coils.size() && k < axes.size(); ++k) {
    axes[k] = base::ToEigen(coils[k].axis_base).normalized();
  }
  parameters.SetCoilAxes(axes);
  return parameters;
}

}  // namespace

base::Result<Outcome> SelfCalibrate(const base::Calibration& nominal, std::span<const base::CoilGeometry> coils,
                                    const Recording& recording, const Options& options) {
  const auto begin = std::chrono::steady_clock::now();
  const auto refused = [](const std::string& why) { return base::Error{"calibration refused: " + why}; };
  if (const std::string why = RecordingProblem(nominal, recording, options.limits); !why.empty()) return refused(why);

  const Problem measured(nominal, coils, {{}, recording.responses}, options.tolerances);
  const auto cold = ColdStart::Make(measured.nominal(), options.tolerances);
  if (!cold.ok()) return refused(cold.error());
  std::vector<ColdPose> poses;
  for (const Sample& sample : recording.samples) poses.push_back(cold->FindPose(sample));
  if (const std::string why = PosesProblem(nominal, recording, poses, options.limits); !why.empty()) {
    return refused(why);
  }
  Kept kept = KeepFound(recording, poses);
  Problem problem(nominal, coils, kept.recording, options.tolerances);
  const Adjustment adjustment = Adjust(problem, StartAt(problem.nominal(), coils, options.tolerances),
                                       std::move(kept.instants), options.iterations_max);
  Outcome outcome{ToCalibration(problem, adjustment), AssessAdjustment(problem, adjustment)};
  CountSamples(recording, problem, outcome.report);
  outcome.report.steel = outcome.calibration.steel;
  outcome.calibration.expected_error_m = outcome.report.expected_error_m;
  outcome.report.coverage = kept.coverage.share();
  outcome.report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (const std::string why = ResultProblem(adjustment, outcome.report, options.limits); !why.empty()) {
    return refused(why);
  }
  return outcome;
}

}  // namespace omni::calibration
