#include "service/sim/trace.h"

#include <algorithm>
#include <cmath>

#include "firmware/wire/scaling.h"
#include "service/device/command_life.h"
#include "service/device/scan_conversion.h"
#include "service/sim/coil_drive.h"
#include "service/sim/tick_sampler.h"

namespace omni::sim {
namespace {

constexpr std::int64_t kClockStart_ns = 1'000'000'000;  // stamps start at 1 s: 0 stays "never"
constexpr double kTimeToLive_s = 1e-3 * device::kCommandTimeToLive_ms;
constexpr int kLeadTicks = 50;  // before the first row: every sensor has sampled, currents have settled

double SetPoint_A(const Sawtooth& tooth, double t_s) noexcept {
  const double x = t_s / tooth.period_s + tooth.phase;
  return tooth.offset_A + tooth.amplitude_A * (2 * (x - std::floor(x)) - 1);
}

// Device time 0 is the first row's tick; the lead-in has negative times, with pen and set-points as they are at 0.
class Run {
 public:
  Run(Rig& rig, const TraceOptions& options);
  TraceRow Tick() noexcept;

 private:
  void Advance() noexcept;
  wire::Telemetry Report(std::int64_t& newest_ns) noexcept;
  static double Seconds(std::int64_t t_ns) noexcept { return std::max(0.0, static_cast<double>(t_ns) * 1e-9); }

  base::DeviceGeometry device_;
  TraceOptions options_;
  Random random_;
  FreeMotion motion_;
  CoilDrive drive_;
  TickSampler sampler_;
  Surroundings surroundings_;
  device::DeviceInfo info_;
  std::uint64_t tick_ = 0;
};

Run::Run(Rig& rig, const TraceOptions& options)
    : device_(rig.device()),
      options_(options),
      random_(options.seed),
      motion_(device_, options.motion, options.duration_s + base::kTickPeriod_s),
      drive_(device_, DriveConfig{.delay_s = options.current_delay_s}, ThermalConfig{}, rig.imperfections()),
      sampler_(device_, rig.options().effects, rig.options().sensor, rig.truth(),
               {motion_.At(0).pose, options.present, {}}, ~rig.options().seed, -kLeadTicks * base::kTickPeriod_ns,
               random_) {
  info_.field_lsb_T = device_.sensor_lsb_T;
  for (int i = 0; i < kLeadTicks; ++i) Tick();
  tick_ = 0;
}

void Run::Advance() noexcept {
  const double t_s = Seconds(sampler_.now_ns());
  CoilArray set_point_A{};
  for (std::size_t k = 0; k < set_point_A.size(); ++k) set_point_A[k] = SetPoint_A(options_.currents[k], t_s);
  drive_.Command(set_point_A, kTimeToLive_s, sampler_.now_ns());
  drive_.Watch(0);
  sampler_.Begin();
  surroundings_ = sampler_.Now(options_.start_s + t_s);
  for (int i = 1; i <= TickSampler::kSubSteps; ++i) {
    const std::int64_t now_ns = sampler_.now_ns() + TickSampler::kSubStep_ns;
    drive_.Step(now_ns, TickSampler::kSubStep_s);
    sampler_.Add({motion_.Pose(Seconds(now_ns)), options_.present, drive_.current_A()}, surroundings_);
  }
  drive_.Heat(base::kTickPeriod_s);
  sampler_.Sample(surroundings_, random_);
}

wire::Telemetry Run::Report(std::int64_t& newest_ns) noexcept {
  wire::Telemetry telemetry;
  newest_ns = sampler_.hall().Report(telemetry);
  const CoilArray measured_A = drive_.Measured(sampler_.MeanCurrent());
  for (std::size_t k = 0; k < measured_A.size(); ++k) {
    telemetry.current[k] = wire::ToCounts<std::int16_t>(measured_A[k], wire::kCurrentUnit_A);
    telemetry.temperature[k] = wire::ToCounts<std::int16_t>(drive_.temperature_C()[k], wire::kTemperatureUnit_K);
  }
  telemetry.supply = wire::ToCounts<std::uint16_t>(device_.supply_V, wire::kSupplyUnit_V);
  telemetry.faults = drive_.faults();
  return telemetry;
}

TraceRow Run::Tick() noexcept {
  Advance();
  std::int64_t newest_ns = 0;
  const wire::Telemetry telemetry = Report(newest_ns);
  TraceRow row;
  const auto t_us = static_cast<std::uint64_t>((newest_ns + kClockStart_ns) / 1000);
  row.scan = device::ScanFromTelemetry(info_, telemetry, t_us, ++tick_);
  const FreeMotion::State state = motion_.At(Seconds(row.scan.t_ns - kClockStart_ns));
  row.pose = state.pose;
  row.velocity_base_m_s = state.velocity_base_m_s;
  row.current_A = sampler_.At(row.scan.t_ns - kClockStart_ns).current_A;
  row.tick_end_ns = sampler_.now_ns() + kClockStart_ns;
  return row;
}

}  // namespace

CurrentScript StaggeredSawtooth(double amplitude_A, double period_s) noexcept {
  CurrentScript script;
  for (std::size_t k = 0; k < script.size(); ++k) {
    script[k] = {amplitude_A, period_s, static_cast<double>(k) / static_cast<double>(script.size()), 0};
  }
  return script;
}

std::vector<TraceRow> RecordTrace(Rig& rig, const TraceOptions& options) {
  Run run(rig, options);
  std::vector<TraceRow> rows;
  const auto count = static_cast<std::size_t>(std::llround(options.duration_s / base::kTickPeriod_s));
  rows.reserve(count);
  for (std::size_t i = 0; i < count; ++i) rows.push_back(run.Tick());
  return rows;
}

}  // namespace omni::sim
