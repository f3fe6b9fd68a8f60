// omni-bench calibration: bases that start wrong by manufacturing tolerances, calibrated from what a person would
// record, compared with the truth of the simulation. Errors: static single scans, solved cold. Three recordings per
// base: "held" (500 poses and 120 touches held still, one scan each), "moving" (the whole of `omni calibrate` on the
// twin: coil sweep, pen waved for 20 s by a trembling hand, 100 touches, asynchronous sensors in low-power noise, and
// every effect of the twin: eddy currents, remanence, drift, a warming magnet, current errors, bent sensors) and "room"
// (the same in a room, on a base whose hull and core are off too).
#include <chrono>
#include <functional>

#include "service/base/in_parallel.h"
#include "service/calibration/fit/adjust.h"
#include "service/calibration/fit/self_calibration.h"
#include "service/config/files/device_file.h"
#include "service/config/files/twin_file.h"
#include "service/magnetics/nominal.h"
#include "service/tools/calibrate/calibrate_twin.h"
#include "service/tools/common/row_table.h"
#include "tests/bench/harness/bench.h"
#include "tests/bench/peers/ceres_bundle.h"
#include "tests/support/rig/adjustment_start.h"
#include "tests/support/rig/calibration_error.h"
#include "tests/support/rig/rig_recording.h"

namespace omni::bench {
namespace {

constexpr std::size_t kRigs = 10;
constexpr int kHeldWaves = 500, kHeldTouches = 120;
constexpr double kTouchSigma_m = 0.1e-3;
constexpr int kAdjustIterations = 60;
constexpr double kUncalibrated = 0.05;  // model error that a solver must allow before calibration

// An uncalibrated base with all effects of the twin, faster than usual: over the hundred seconds of the recording the
// pen warms by 10 K and the background drifts by 5 mG.
base::TruthParameters HardTruth() {
  base::TruthParameters truth = config::IdealTwin();
  const double nonlinearity = truth.imperfections.sensor_nonlinearity;
  truth.imperfections = sim::UncalibratedImperfections();
  truth.imperfections.sensor_nonlinearity = nonlinearity;
  truth.effects.magnet_warming_K = 10;
  truth.effects.run_s = 100;
  return truth;
}

base::DeviceGeometry DeviceIn(sim::NoiseMode noise) {
  base::DeviceGeometry device = config::DefaultDevice();
  device.sensor_noise_T = sim::NoiseOf_T(noise);
  return device;
}

struct Done {
  calibration::Outcome outcome;
  sim::Rig rig;             // the same base, for the judgement
  double moment_scale = 1;  // of its magnet, at its temperature then
};

base::Result<Done> CalibrateHeld(std::uint64_t seed) {
  const base::DeviceGeometry device = DeviceIn(sim::NoiseMode::kUltraHigh);
  sim::Rig rig(device, {.seed = seed, .sizes = sim::UncalibratedImperfections()});
  const calibration::Recording recording = test::MakeRecording(
      rig, {.waves = kHeldWaves, .touches = kHeldTouches, .touch_sigma_m = kTouchSigma_m, .seed = seed + 1});
  auto outcome = calibration::SelfCalibrate(magnetics::NominalCalibration(device), device.coils, recording);
  if (!outcome.ok()) return base::Error{outcome.error()};
  return Done{std::move(*outcome), std::move(rig)};
}

// Surroundings in which the base is judged: those of its calibration, without temporary effects.
base::TruthEffects EffectsThatStay(const base::TruthEffects& run) {
  base::TruthEffects effects;
  effects.magnet_warming_K = run.magnet_warming_K;
  effects.magnet_per_K = run.magnet_per_K;
  effects.run_s = run.run_s;
  effects.earth_field_base_T = run.earth_field_base_T;
  effects.background_known = run.background_known;
  effects.room.steel = run.room.steel;
  return effects;
}

base::Result<Done> CalibrateMoving(std::uint64_t seed, const base::TruthParameters& truth) {
  auto done = tools::CalibrateTwin(DeviceIn(sim::NoiseMode::kLowPower), seed, truth);
  if (!done.ok()) return base::Error{done.error()};
  // Judged with the magnet at its temperature then.
  sim::Rig rig(config::DefaultDevice(),
               {.seed = seed, .sizes = truth.imperfections, .effects = EffectsThatStay(truth.effects)});
  rig.SetTime(done->middle_s);
  const double moment_scale = rig.environment().At(done->middle_s).magnet_scale;
  return Done{std::move(done->outcome), std::move(rig), moment_scale};
}

base::Result<nlohmann::ordered_json> Row(std::size_t number, std::uint64_t seed, const char* recording, Done& done) {
  const base::Calibration nominal = magnetics::NominalCalibration(DeviceIn(sim::NoiseMode::kUltraHigh));
  base::Calibration calibrated = done.outcome.calibration;
  calibrated.sensor_noise_T = nominal.sensor_noise_T;
  const auto before = test::MeasureCalibrationError(
      done.rig, nominal, {.poses = 300, .model_error_relative = kUncalibrated, .seed = seed + 2});
  if (!before.ok()) return base::Error{before.error()};
  const bool swept = std::string(recording) != "held";
  const auto after =
      test::MeasureCalibrationError(done.rig, calibrated, {.poses = 1500, .swept = swept, .seed = seed + 3});
  const auto systematic = test::MeasureCalibrationError(
      done.rig, calibrated, {.poses = 700, .noise = false, .swept = swept, .seed = seed + 4});
  base::Calibration exact = done.rig.ExactCalibration();
  exact.moment_Am2 *= done.moment_scale;
  const auto best = test::MeasureCalibrationError(done.rig, exact, {.poses = 1500, .seed = seed + 3});
  const auto best_systematic =
      test::MeasureCalibrationError(done.rig, exact, {.poses = 300, .noise = false, .seed = seed + 4});
  if (!best.ok() || !best_systematic.ok()) return base::Error{"the solver rejects the exact calibration"};
  if (!after.ok() || !systematic.ok()) return base::Error{after.ok() ? systematic.error() : after.error()};
  const calibration::Report& report = done.outcome.report;
  return nlohmann::ordered_json{{"rig", std::to_string(number)},
                                {"seed", seed},
                                {"before_mm", before->raw_mm},
                                {"raw_mm", after->raw_mm},
                                {"aligned_mm", after->aligned_mm},
                                {"systematic_mm", systematic->aligned_mm},
                                {"seconds", report.seconds},
                                {"recording", recording},
                                {"exact_mm", best->raw_mm},
                                {"exact_systematic_mm", best_systematic->raw_mm},
                                {"systematic_raw_mm", systematic->raw_mm},
                                {"rotation_deg", systematic->rotation_deg},
                                {"orientation_deg", after->orientation_deg},
                                {"chi2_per_dof", report.chi2_per_dof},
                                {"expected_mm", 1e3 * report.expected_error_m},
                                {"expected_over_true", 1e3 * report.expected_error_m / systematic->raw_rms_mm}};
}

// Mean and worst of the rows of one kind of recording.
void AddSummary(const char* recording, BenchRows& rows) {
  nlohmann::ordered_json mean = rows.back(), worst = rows.back();
  for (const auto& [key, value] : rows.back().items()) {
    if (!value.is_number_float()) continue;
    std::vector<double> values;
    for (const auto& row : rows) {
      if (row["recording"] == recording) values.push_back(row[key].get<double>());
    }
    mean[key] = tools::Mean(values);
    worst[key] = tools::Quantile(values, 1);
  }
  mean["rig"] = "mean", worst["rig"] = "worst";
  mean["seed"] = worst["seed"] = nullptr;
  rows.push_back(mean);
  rows.push_back(worst);
}

// Rows of one kind of recording become a separate table: they are not measured under standard conditions.
void ToSideTable(const char* recording, BenchRows& rows) {
  for (nlohmann::ordered_json& row : rows) {
    if (row["recording"] == recording) row["table"] = recording;
  }
}

// Our own bundle adjustment and Ceres on the same problem: fixed weights, no maps, both from the cold start's poses.
base::Result<BenchRows> CompareAdjustments(std::uint64_t seed) {
  using Clock = std::chrono::steady_clock;
  const auto start = test::MakeAdjustmentStart(
      DeviceIn(sim::NoiseMode::kUltraHigh), seed,
      {.waves = kHeldWaves, .touches = kHeldTouches, .touch_sigma_m = kTouchSigma_m, .seed = seed + 1});
  if (!start.ok()) return base::Error{start.error()};
  const auto& [problem, parameters, instants] = *start;
  const auto begin = Clock::now();
  const calibration::Adjustment ours = calibration::AdjustOnce(problem, parameters, instants, kAdjustIterations);
  const auto middle = Clock::now();
  const peers::BundleFit theirs =
      peers::SolveBundle(problem, parameters, instants, {.iterations_max = kAdjustIterations});
  const auto end = Clock::now();
  const auto row = [&](const char* method, Clock::duration time, int iterations, double cost, bool converged) {
    return nlohmann::ordered_json{{"table", "adjustment"},
                                  {"method", method},
                                  {"seed", seed},
                                  {"samples", start->instants.size()},
                                  {"seconds", std::chrono::duration<double>(time).count()},
                                  {"iterations", iterations},
                                  {"cost", cost},
                                  {"converged", converged}};
  };
  return BenchRows{row("omni", middle - begin, ours.iterations, ours.system.cost, ours.converged),
                   row("ceres DENSE_SCHUR", end - middle, theirs.iterations, theirs.cost, theirs.converged)};
}

}  // namespace

base::Result<BenchRows> BenchCalibration(const BenchOptions& options) {
  struct Recording {
    const char* name;
    std::function<base::Result<Done>(std::uint64_t seed)> calibrate;
  };
  const std::array<Recording, 3> recordings{
      {{"held", CalibrateHeld},
       {"moving", [](std::uint64_t seed) { return CalibrateMoving(seed, HardTruth()); }},
       {"room", [](std::uint64_t seed) { return CalibrateMoving(seed, config::RoomTwin()); }}}};
  BenchRows rows;
  for (const Recording& recording : recordings) {
    std::vector<base::Result<nlohmann::ordered_json>> done(kRigs, base::Error{"not run"});
    base::InParallel(kRigs, [&](std::size_t n) {
      const std::uint64_t seed = 1000 * options.seed + 10 * n;
      auto calibrated = recording.calibrate(seed);
      if (!calibrated.ok()) {
        done[n] = base::Error{"seed " + std::to_string(seed) + ": " + calibrated.error()};
      } else {
        done[n] = Row(n, seed, recording.name, *calibrated);
      }
    });
    for (const auto& row : done) {
      if (!row.ok()) return base::Error{row.error()};
      rows.push_back(*row);
    }
    AddSummary(recording.name, rows);
    if (rows.size() > kRigs + 2) ToSideTable(recording.name, rows);
  }
  for (const std::uint64_t seed : ThreeSeeds(options.seed)) {
    auto both = CompareAdjustments(seed);
    if (!both.ok()) return base::Error{both.error()};
    rows.insert(rows.end(), both->begin(), both->end());
  }
  return rows;
}

}  // namespace omni::bench
