#include "service/sim/trace.h"

#include <algorithm>
#include <cmath>

#include "firmware/wire/scaling.h"
#include "service/device/scan_conversion.h"
#include "service/sim/coil_drive.h"
#include "service/sim/hall_array.h"

namespace omni::sim {
namespace {

constexpr std::int64_t kClockStart_ns = 1'000'000'000;  // stamps start at 1 s: 0 stays "never"
constexpr int kSubSteps = 4;
constexpr std::int64_t kSubStep_ns = base::kTickPeriod_ns / kSubSteps;
constexpr double kSubStep_s = base::kTickPeriod_s / kSubSteps;
constexpr double kTimeToLive_s = 0.020;
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
  void SampleSensors() noexcept;
  CoilArray CurrentAt(std::int64_t t_ns) const noexcept;
  FreeMotion::State StateAt(std::int64_t t_ns) const noexcept { return motion_.At(Seconds(t_ns)); }
  static double Seconds(std::int64_t t_ns) noexcept { return std::max(0.0, static_cast<double>(t_ns) * 1e-9); }

  Rig& rig_;
  TraceOptions options_;
  Random random_;
  FreeMotion motion_;
  CoilDrive drive_;
  HallArray hall_;
  device::DeviceInfo info_;
  std::array<CoilArray, kSubSteps + 1> currents_{};  // at the boundaries of the tick's sub-steps
  CoilArray mean_current_A_{};
  std::int64_t now_ns_ = -kLeadTicks * base::kTickPeriod_ns;
  std::uint64_t tick_ = 0;
};

Run::Run(Rig& rig, const TraceOptions& options)
    : rig_(rig),
      options_(options),
      random_(options.seed),
      motion_(rig.device(), options.motion, options.duration_s + base::kTickPeriod_s),
      drive_(rig.device(), DriveConfig{.delay_s = options.current_delay_s}, ThermalConfig{}, rig.imperfections()),
      hall_(rig.device(), random_, now_ns_) {
  info_.field_lsb_T = rig.device().sensor_lsb_T;
  for (int i = 0; i < kLeadTicks; ++i) Tick();
  tick_ = 0;
}

void Run::Advance() noexcept {
  CoilArray set_point_A{};
  const double limit_A = rig_.device().current_max_A;
  for (std::size_t k = 0; k < set_point_A.size(); ++k) {
    set_point_A[k] = std::clamp(SetPoint_A(options_.currents[k], Seconds(now_ns_)), -limit_A, limit_A);
  }
  drive_.Command(set_point_A, kTimeToLive_s, now_ns_);
  drive_.Watch(0);
  currents_.front() = currents_.back();
  mean_current_A_ = {};
  for (std::size_t i = 1; i < currents_.size(); ++i) {
    now_ns_ += kSubStep_ns;
    drive_.Step(now_ns_, kSubStep_s);
    currents_[i] = drive_.current_A();
    for (std::size_t k = 0; k < mean_current_A_.size(); ++k) mean_current_A_[k] += currents_[i][k] / kSubSteps;
  }
  drive_.Heat(base::kTickPeriod_s);
}

CoilArray Run::CurrentAt(std::int64_t t_ns) const noexcept {
  const std::int64_t since_ns = std::max<std::int64_t>(0, t_ns - (now_ns_ - base::kTickPeriod_ns));
  const std::size_t i = std::min<std::size_t>(static_cast<std::size_t>(since_ns / kSubStep_ns), kSubSteps - 1);
  const double s = static_cast<double>(since_ns - static_cast<std::int64_t>(i) * kSubStep_ns) / kSubStep_ns;
  CoilArray between{};
  for (std::size_t k = 0; k < between.size(); ++k) {
    between[k] = currents_[i][k] + s * (currents_[i + 1][k] - currents_[i][k]);
  }
  return between;
}

void Run::SampleSensors() noexcept {
  for (std::size_t i = 0; i < base::kSensorCount; ++i) {
    std::int64_t sample_ns = 0;
    if (!hall_.NextSample(i, now_ns_, sample_ns)) continue;
    const FreeMotion::State state = StateAt(sample_ns);
    const Vec3 reading_T = rig_.truth().SensorField(i, options_.present ? &state.pose : nullptr, CurrentAt(sample_ns));
    hall_.Sample(i, sample_ns, reading_T, random_);
  }
}

TraceRow Run::Tick() noexcept {
  Advance();
  SampleSensors();
  wire::Telemetry telemetry;
  const std::int64_t newest_ns = hall_.Report(telemetry);
  const CoilArray measured_A = drive_.Measured(mean_current_A_);
  for (std::size_t k = 0; k < measured_A.size(); ++k) {
    telemetry.current[k] = wire::ToCounts<std::int16_t>(measured_A[k], wire::kCurrentUnit_A);
    telemetry.temperature[k] = wire::ToCounts<std::int16_t>(drive_.temperature_C()[k], wire::kTemperatureUnit_K);
  }
  telemetry.supply = wire::ToCounts<std::uint16_t>(rig_.device().supply_V, wire::kSupplyUnit_V);
  telemetry.faults = drive_.faults();
  TraceRow row;
  const auto t_us = static_cast<std::uint64_t>((newest_ns + kClockStart_ns) / 1000);
  row.scan = device::ScanFromTelemetry(info_, telemetry, t_us, ++tick_);
  const FreeMotion::State state = StateAt(row.scan.t_ns - kClockStart_ns);
  row.pose = state.pose;
  row.velocity_base_m_s = state.velocity_base_m_s;
  row.current_A = CurrentAt(row.scan.t_ns - kClockStart_ns);
  row.tick_end_ns = now_ns_ + kClockStart_ns;
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
