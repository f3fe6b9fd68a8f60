#include "service/sim/coils/plant.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "firmware/wire/messages.h"

namespace omni::sim {

void SupplyRail::Step(double load_A, double dt_s) noexcept {
  const double draw_A = load_A + parameters_.quiescent_A;
  double left_s = dt_s;
  if (draw_A < 0) rail_V_ = std::max(rail_V_, source_V_);
  if (rail_V_ > source_V_ || draw_A < 0) {
    // The diode blocks until the load has pulled the rail down to the source.
    const double change_V = -draw_A * left_s / parameters_.capacitance_F;
    const bool reaches_source = rail_V_ + change_V < source_V_;
    left_s = reaches_source ? left_s - (rail_V_ - source_V_) * parameters_.capacitance_F / draw_A : 0;
    rail_V_ = reaches_source ? source_V_ : rail_V_ + change_V;
  }
  const double settled_V = source_V_ - parameters_.source_ohm * draw_A;
  const double decay = std::exp(-left_s / (parameters_.source_ohm * parameters_.capacitance_F));
  rail_V_ = std::clamp(settled_V + (rail_V_ - settled_V) * decay, 0.0, parameters_.clamp_V);
}

namespace {

static_assert(firmware::kStepPeriod_us * 1000 == TickSampler::kSubStep_ns);
static_assert(firmware::kStepsPerTick == TickSampler::kSubSteps);

constexpr double kVoltageGainError = 1e-3;  // INA260: of its voltage reading
// LIS3MDL: its own test field adds 1 to 3 G to x and y, 0.1 to 1 G to z.
constexpr double kTestField_T[3] = {2e-4, 2e-4, 0.5e-4};
// A short between turns leaves a few of them.
constexpr double kShortedResistance = 0.08, kShortedInductance = 0.02;

Imperfections Draw(const PlantOptions& options, Random& random) noexcept {
  if (options.imperfections) return *options.imperfections;
  return options.imperfect ? DrawImperfections(options.truth.imperfections, random) : Imperfections{};
}

base::TruthEffects Effects(const PlantOptions& options) noexcept {
  return options.imperfect ? options.truth.effects : base::TruthEffects{};
}

Vec3 ToVec3(const CoilArray& values) noexcept { return {values[0], values[1], values[2]}; }

constexpr bool Bit(std::uint8_t mask, std::size_t i) noexcept { return ((mask >> i) & 1U) != 0; }
constexpr std::uint8_t WithBit(std::uint8_t mask, std::size_t i, bool on) noexcept {
  return static_cast<std::uint8_t>(on ? mask | (1U << i) : mask & ~(1U << i));
}

}  // namespace

Plant::Plant(const base::DeviceGeometry& device, const PlantOptions& options)
    : device_(device),
      bridge_(options.bridge),
      random_(options.seed),
      imperfections_(Draw(options, random_)),
      truth_(device, imperfections_, options.flip_coil_sign, Effects(options).room.steel),
      coils_(device, options.truth.thermal),
      rail_(options.supply, device.supply_V),
      hand_(options.script, TrueSizes(device, imperfections_), random_, options.led),
      motion_(options.motion),
      run_s_(options.run_s),
      pen_(Pen(0)),
      sampler_(device, Effects(options), options.truth.sensor, truth_, pen_,
               options.environment_seed.value_or(~options.seed), options.start_ns, random_),
      surroundings_(sampler_.SurroundingsNow(run_s_)),
      clock_zero_ns_(options.start_ns),
      induction_(Effects(options).room.induction) {
  Random gains(~options.seed ^ 0x5EED);
  for (double& gain : voltage_gain_) gain = options.imperfect ? 1 + kVoltageGainError * gains.Uniform(-1, 1) : 1;
  Report({});
}

Snapshot Plant::Pen(double t_s) const noexcept {
  if (motion_ != nullptr) return {motion_->Pose(std::max(0.0, t_s)), true, {}};
  return {hand_.pose(), hand_.present(), {}};
}

void Plant::ResetClock() noexcept {
  clock_zero_ns_ = now_ns();
  inputs_.now_us = 0;
}

const firmware::Inputs& Plant::Step(const firmware::Outputs& outputs) noexcept {
  const double t_s = static_cast<double>(now_ns()) * 1e-9;
  sampler_.Begin();
  surroundings_ = sampler_.SurroundingsNow(run_s_ + std::max(t_s, 0.0));
  Drive(outputs);
  coils_.StepHeat(TickSampler::kSubStep_s, faults_.extra_heat_W);
  MovePen(t_s);
  sampler_.Add({pen_.pose, pen_.present, coils_.current_A()}, surroundings_);
  surroundings_ = sampler_.SurroundingsNow(run_s_ + std::max(t_s, 0.0));
  sampler_.TakeSamples(surroundings_, random_);
  Report(outputs);
  return inputs_;
}

// The force map is taken once per tick of four steps, at the pose expected in its middle (midpoint rule). Currents,
// spring and hull act in every step.
void Plant::MovePen(double t_s) noexcept {
  const bool is_tick = step_++ % firmware::kStepsPerTick == 0;
  if (motion_ == nullptr) {
    if (is_tick) {
      forces_ = hand_.present()
                    ? truth_.ForcesAt(hand_.PredictedPose(t_s + 0.5 * base::kTickPeriod_s), surroundings_.steel_mask)
                    : ForceMap{};
    }
    hand_.Step(t_s, TickSampler::kSubStep_s, forces_.Force(coils_.current_A(), surroundings_));
  }
  const MagnetPose before = pen_.pose;
  pen_ = Pen(t_s + TickSampler::kSubStep_s);
  Induce(before);
}

// What a coil's current does to the pen, the pen's motion does to the coil: power is kept.
//   V_k = F_k . v + T_k . w   with F_k, T_k per ampere, w: the turn of the axis
void Plant::Induce(const MagnetPose& before) noexcept {
  if (induction_ == 0 || motion_ != nullptr) return;
  const Vec3 turn_rad_s = (1 / TickSampler::kSubStep_s) * Cross(before.axis_base, pen_.pose.axis_base);
  const double scale = pen_.present ? induction_ * surroundings_.magnet_scale : 0;
  for (std::size_t k = 0; k < induced_V_.size(); ++k) {
    const ForceAndTorque& of = forces_.coil[k];
    induced_V_[k] = scale * (Dot(of.force_N, hand_.velocity_base_m_s()) + Dot(of.torque_Nm, turn_rad_s));
  }
}

// Mean voltage duty * supply over a PWM period, the rest of it brakes: |duty| I flows out of the supply. A bridge that
// sleeps gives its current back.
void Plant::Drive(const firmware::Outputs& outputs) noexcept {
  rail_.SetSource(faults_.supply_V.value_or(device_.supply_V));
  const double supply_V = rail_.voltage_V();
  double load_A = 0;
  for (std::size_t k = 0; k < mean_A_.size(); ++k) {
    const double duty = std::clamp(static_cast<double>(outputs.duty[k]) / wire::kDutyFull, -1.0, 1.0);
    coils_.Scale(k, faults_.coil_shorted[k] ? kShortedResistance : 1, faults_.coil_shorted[k] ? kShortedInductance : 1);
    if (faults_.coil_open[k]) {
      coils_.Break(k);
      mean_A_[k] = 0;
      coil_V_[k] = duty * supply_V;
    } else if (Bit(outputs.awake, k) && !faults_.bridge[k]) {
      mean_A_[k] = coils_.Step(k, duty * supply_V - induced_V_[k], bridge_.on_ohm, TickSampler::kSubStep_s);
      coil_V_[k] = duty * supply_V - bridge_.on_ohm * mean_A_[k];
      load_A += duty * mean_A_[k];
    } else {
      const double against_V = supply_V + 2 * bridge_.diode_V;
      mean_A_[k] = coils_.Coast(k, against_V, TickSampler::kSubStep_s);
      coil_V_[k] = mean_A_[k] == 0 ? 0 : against_V;
      load_A -= std::abs(mean_A_[k]);
    }
  }
  rail_.Step(load_A, TickSampler::kSubStep_s);
}

void Plant::Report(const firmware::Outputs& outputs) noexcept {
  inputs_.now_us = static_cast<std::uint64_t>(now_ns() - clock_zero_ns_) / 1000;
  for (std::size_t i = 0; i < base::kSensorCount; ++i) ReportHall(i, outputs.hall_self_test != 0);
  for (std::size_t k = 0; k < base::kCoilCount; ++k) ReportCoil(k);
  const double wanted_rpm = faults_.fan_stands ? 0 : bridge_.fan_max_rpm * outputs.fan / 255;
  fan_rpm_ += (wanted_rpm - fan_rpm_) * TickSampler::kSubStep_s / bridge_.fan_start_s;
  if (faults_.fan_stands) fan_rpm_ = 0;
  inputs_.fan_rpm = wire::ToCounts<std::uint16_t>(fan_rpm_, 1);
  inputs_.supply = wire::ToCounts<std::uint16_t>(rail_.voltage_V(), wire::kSupplyUnit_V);
  inputs_.board_temperature = wire::ToCounts<std::int16_t>(coils_.body_C(), wire::kTemperatureUnit_K);
  inputs_.emergency_stop = faults_.emergency_stop ? 1 : 0;
}

// A stuck sensor's registers keep what they held when it stuck, and are still marked as new.
void Plant::ReportHall(std::size_t i, bool test_field) noexcept {
  const HallFault fault = faults_.hall[i];
  const HallArray::Registers now = sampler_.hall().Read(i);
  const bool answers = fault != HallFault::kDead && fault != HallFault::kWrongIdentity;
  const bool converts = fault == HallFault::kNone;
  const bool fresh = now.fresh && answers && fault != HallFault::kStopped;
  if (converts && now.sampled_ns != HallArray::kNever_ns) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double added = test_field ? kTestField_T[axis] / device_.sensor_lsb_T : 0;
      inputs_.field[i][axis] = wire::ToCounts<std::int16_t>(now.counts[axis] + added, 1);
    }
  }
  constexpr std::int64_t kOldest_us = std::numeric_limits<std::uint16_t>::max();
  const std::int64_t since_us =
      now.sampled_ns == HallArray::kNever_ns ? kOldest_us : (now_ns() - now.sampled_ns) / 1000;
  const std::int64_t older_us = inputs_.field_age_us[i] + std::int64_t{firmware::kStepPeriod_us};
  const std::int64_t age_us = fresh || converts ? since_us : older_us;
  inputs_.field_age_us[i] = static_cast<std::uint16_t>(std::clamp<std::int64_t>(age_us, 0, kOldest_us));
  inputs_.field_fresh = WithBit(inputs_.field_fresh, i, fresh);
  inputs_.field_answers = WithBit(inputs_.field_answers, i, answers);
}

// A dead current sensor's words stay as they were.
void Plant::ReportCoil(std::size_t k) noexcept {
  const bool answers = !faults_.current_sensor_dead[k];
  inputs_.current_answers = WithBit(inputs_.current_answers, k, answers);
  inputs_.driver_fault = WithBit(inputs_.driver_fault, k, faults_.bridge[k]);
  if (!answers) return;
  const double measured_A = imperfections_.current_gain[k] * mean_A_[k] + imperfections_.current_offset_A[k];
  inputs_.current[k] = wire::ToCounts<std::int16_t>(measured_A, wire::kCurrentUnit_A);
  inputs_.voltage[k] = wire::ToCounts<std::uint16_t>(voltage_gain_[k] * std::abs(coil_V_[k]), wire::kSupplyUnit_V);
}

TruthRow Plant::Truth(const HostView& host, std::int64_t clock_offset_ns) const noexcept {
  TruthRow row;
  row.t_ns = now_ns() + clock_offset_ns;
  row.present = pen_.present;
  row.magnet_m = pen_.pose.centre_base_m;
  row.axis = pen_.pose.axis_base;
  row.tip_m = row.magnet_m + hand_.magnet().tip_offset_m * row.axis;
  row.velocity_m_s = hand_.velocity_base_m_s();
  row.current_A = ToVec3(coils_.current_A());
  row.set_point_A = ToVec3(host.set_point_A);
  row.temperature_C = ToVec3(coils_.temperature_C());
  row.coil_force_N = surroundings_.magnet_scale * forces_.CoilForce(coils_.current_A());
  row.force_N = forces_.Force(coils_.current_A(), surroundings_);
  row.gap_m = hand_.gap_m();
  row.command_age_s = host.command_age_s;
  row.faults = host.faults;
  return row;
}

}  // namespace omni::sim
