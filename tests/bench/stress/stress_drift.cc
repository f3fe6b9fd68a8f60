// Hours in a room that changes: the ambient field wanders, magnet and sensors warm up and cool down. In every minute
// the pen is waved for some seconds, each time on another path; the time without a pen is skipped, and one loop runs
// through all of it. All its state (filter, moment, ambient field, doubts, clock, gate) must follow and must not
// diverge. The base is as usually built, calibrated by the whole of `omni calibrate` before the hours begin. A
// simulation.
#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "service/config/files/device_file.h"
#include "service/config/files/twin_file.h"
#include "service/haptics/scene/scene.h"
#include "service/loop/realtime.h"
#include "service/loop/tick_config.h"
#include "service/sim/fields/vec3.h"
#include "service/tools/calibrate/calibrate_twin.h"
#include "tests/bench/harness/errors.h"
#include "tests/bench/stress/stress.h"
#include "tests/support/rig/trace.h"

namespace omni::bench {
namespace {

constexpr double kHour_s = 3600;
constexpr int kRowsMax = 10;
constexpr double kWaved_s = 5;      // of each minute; the twin takes a fifth of a second for one
constexpr int kSettleTicks = 200;   // after the jump from the end of one path to the start of the next
constexpr double kWander_T = 1e-6;  // of the ambient field, per axis, within a step ...
constexpr double kForget_s = 3600;  // ... with this correlation time: 6 uT rms in all
constexpr double kMagnetPeriod_s = 2.5 * kHour_s, kMagnet_K = 10;
constexpr double kSensorPeriod_s = 3.5 * kHour_s, kSensor_K = 6;
constexpr double kSensorOffset_T_K = 5e-7, kSensorGain_1_K = 1e-4;  // per axis and sensor, each its own; assumptions

const auto kStepTicks = static_cast<std::uint64_t>(std::llround(kCourseStep_s / base::kTickPeriod_s));

// From 0 up to `size` and back.
double Swing(double size, double t_s, double period_s) {
  return 0.5 * size * (1 - std::cos(2 * std::numbers::pi * t_s / period_s));
}

base::TruthParameters DriftingRoom() {
  base::TruthParameters truth = config::RoomTwin();
  truth.imperfections.sensor_offset_T_K = kSensorOffset_T_K;
  truth.imperfections.sensor_gain_1_K = kSensorGain_1_K;
  return truth;
}

// The room at one step of its course: the field changes throughout, the temperature is that of its middle.
base::TruthParameters RoomAt(const RoomCourse& course, std::size_t step) {
  base::TruthParameters truth = DriftingRoom();
  base::TruthEffects& effects = truth.effects;
  const RoomMoment &from = course[step], &to = course[step + 1];
  effects.ambient_drift_T = 0;
  effects.run_s = 1e-3;  // warm from the start
  effects.magnet_warming_K = 0.5 * (from.magnet_K + to.magnet_K);
  effects.sensor_warming_K = 0.5 * (from.sensor_K + to.sensor_K);
  effects.earth_field_base_T = effects.earth_field_base_T + from.ambient_base_T;
  effects.room.steps.push_back({.change_base_T = to.ambient_base_T - from.ambient_base_T, .over_s = kCourseStep_s});
  return truth;
}

std::vector<sim::TraceRow> RecordStep(const base::DeviceGeometry& device, const base::TruthParameters& truth,
                                      std::uint64_t rig_seed, std::uint64_t step) {
  sim::Rig rig(device, sim::OptionsOf(rig_seed, sim::NoiseMode::kLowPower, truth));
  sim::TraceOptions options{.duration_s = kWaved_s, .start_s = 1e-3, .seed = rig_seed + step};
  options.motion = {.seed = rig_seed + step, .radius_max_m = 0.09, .tilt_max_rad = std::numbers::pi / 4};
  options.currents = sim::StaggeredSawtooth(4, 0.5);
  return sim::RecordTrace(rig, options);
}

struct DriftTally {
  ErrorSet errors;
  std::size_t ticks = 0, tracked = 0, silent = 0;

  void Add(const base::ToolState& tool, const sim::MagnetPose& truth) {
    ++ticks;
    if (tool.status != base::TrackingStatus::kTracking) return;
    ++tracked;
    const PoseError error = ErrorOf(truth, tool.position_base_m, tool.axis_base);
    errors.Add(error);
    silent += IsSilent(error, tool) ? 1 : 0;
  }
};

nlohmann::ordered_json Row(double hours, const RoomMoment& room, const DriftTally& tally, std::uint64_t seed) {
  return {{"table", "drift"},
          {"hours", hours},
          {"ticks", tally.ticks},
          {"ambient_change_uT", 1e6 * base::Norm(room.ambient_base_T)},
          {"magnet_K", room.magnet_K},
          {"sensor_K", room.sensor_K},
          {"tracked_fraction", static_cast<double>(tally.tracked) / static_cast<double>(tally.ticks)},
          {"mean_mm", tools::Mean(tally.errors.position_mm)},
          {"p95_mm", tools::Quantile(tally.errors.position_mm, 0.95)},
          {"max_mm", tools::Quantile(tally.errors.position_mm, 1)},
          {"orientation_mean_deg", tools::Mean(tally.errors.axis_deg)},
          {"over_2mm", tally.errors.LargerThan(kLarge_m)},
          {"silent", tally.silent},
          {"failures", tally.errors.failures},
          {"seed", seed}};
}

}  // namespace

RoomCourse MakeRoomCourse(std::size_t steps, std::uint64_t seed) {
  sim::Random random(seed);
  RoomCourse course(steps + 1);
  for (std::size_t i = 1; i < course.size(); ++i) {
    const double t_s = kCourseStep_s * static_cast<double>(i);
    course[i] = {(1 - kCourseStep_s / kForget_s) * course[i - 1].ambient_base_T + random.NormalVector(kWander_T),
                 Swing(kMagnet_K, t_s, kMagnetPeriod_s), Swing(kSensor_K, t_s, kSensorPeriod_s)};
  }
  return course;
}

base::Result<BenchRows> StressDrift(double hours, std::uint64_t seed) {
  loop::FlushDenormals();
  const base::DeviceGeometry& device = config::DefaultDevice();
  const auto calibrated = tools::CalibrateTwin(device, seed, DriftingRoom());
  if (!calibrated.ok()) return base::Error{calibrated.error()};
  const loop::TickConfig config = loop::MakeTickConfig(device, calibrated->outcome.calibration);
  const auto state = std::make_unique<loop::LoopState>();
  const auto output = std::make_unique<loop::TickOutput>();
  const haptics::Scene scene;
  loop::EnterScene(scene, 1, *state);
  const auto steps = std::max<std::size_t>(1, static_cast<std::size_t>(std::ceil(hours * kHour_s / kCourseStep_s)));
  const std::size_t steps_per_row = (steps + kRowsMax - 1) / kRowsMax;
  const RoomCourse course = MakeRoomCourse(steps, seed);
  BenchRows rows;
  DriftTally tally;
  for (std::size_t step = 0; step < steps; ++step) {
    const std::vector<sim::TraceRow> trace = RecordStep(device, RoomAt(course, step), seed, step);
    for (std::size_t i = 0; i < trace.size(); ++i) {
      base::HallScan scan = trace[i].scan;
      scan.t_ns += static_cast<std::int64_t>(step * kStepTicks) * base::kTickPeriod_ns;
      scan.sequence += step * kStepTicks;
      const loop::Commands commands{
          .t_ns = scan.t_ns, .gate = loop::ForceGate::kOpen, .idle = false, .scene_generation = 1};
      loop::Tick(config, scan, commands, scene, *state, *output);
      if (i >= kSettleTicks) tally.Add(output->tool, trace[i].pose);
    }
    if ((step + 1) % steps_per_row != 0 && step + 1 < steps) continue;
    rows.push_back(Row(static_cast<double>(step + 1) * kCourseStep_s / kHour_s, course[step + 1], tally, seed));
    tally = {};
  }
  return rows;
}

}  // namespace omni::bench
