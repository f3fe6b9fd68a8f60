// The physical side of a base for a firmware core: bridges, coils, supply, current sensors, Hall sensors, heat, pen and
// hand. Outputs of a control step in, inputs of the next one out; time is the number of steps. A simulation: fields,
// hand and sensors are those of the digital twin (TwinCore), so that equal seeds are the same base.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>

#include "firmware/core/board_io.h"
#include "service/base/device_geometry.h"
#include "service/base/limits.h"
#include "service/base/truth_parameters.h"
#include "service/sim/coils/coil_bank.h"
#include "service/sim/fields/truth_model.h"
#include "service/sim/hand/hand.h"
#include "service/sim/twin/recording.h"
#include "service/sim/twin/tick_sampler.h"
#include "service/sim/twin/twin.h"

namespace omni::sim {

// What can be broken in a simulated base, all of it while it runs.
enum class HallFault : std::uint8_t {
  kNone,
  kStuck,          // the same sample again and again, each marked as fresh
  kStopped,        // answers, but its conversions have ended
  kDead,           // does not answer
  kWrongIdentity,  // another device answers
};

struct PlantFaults {
  std::array<HallFault, base::kSensorCount> hall{};
  std::array<bool, base::kCoilCount> current_sensor_dead{};
  std::array<bool, base::kCoilCount> coil_open{};
  std::array<bool, base::kCoilCount> coil_shorted{};  // most of its turns
  std::array<bool, base::kCoilCount> bridge{};        // reports a fault and no longer drives
  std::optional<double> supply_V;                     // of the source
  bool fan_stands = false;
  bool emergency_stop = false;  // the switch is open
  CoilArray extra_heat_W{};     // into the copper, from outside
};

// The base's supply: a source with a resistance and a diode, and the capacitor beside the bridges. It sags under load;
// what sleeping bridges give back has nowhere to go but into the capacitor.
struct SupplyParameters {
  double source_ohm = 0.05;     // source, cable and diode; assumption
  double capacitance_F = 1e-3;  // of the bridges' boards together; assumption, the worst of those considered
  double quiescent_A = 0.1;     // controller, sensors, fan; assumption
  double clamp_V = 33;          // a transient suppressor stands across it
};

class SupplyRail {
 public:
  SupplyRail(const SupplyParameters& parameters, double source_V) noexcept
      : parameters_(parameters), source_V_(source_V), rail_V_(source_V) {}

  void SetSource(double source_V) noexcept { source_V_ = source_V; }

  // The bridges draw `load_A` over the step; < 0: they give back.
  //   C dV/dt = (V0 - V) / Rs - I   while V < V0, without the first term above it
  void Step(double load_A, double dt_s) noexcept;

  double voltage_V() const noexcept { return rail_V_; }

 private:
  SupplyParameters parameters_;
  double source_V_;
  double rail_V_;
};

struct BridgeParameters {
  double on_ohm = 0.01;  // two transistors and the current sensor's shunt [INA260: 2 mOhm]
  double diode_V = 0.8;  // each of the two that conduct while a bridge sleeps
  double fan_max_rpm = 3000;
  double fan_start_s = 0.5;  // time constant
};

// Pose of a pen that follows a path regardless of forces.
class PenMotion {
 public:
  struct State {
    MagnetPose pose;
    Vec3 velocity_base_m_s;  // of the magnet's centre
  };
  virtual ~PenMotion() = default;
  virtual State StateAt(double t_s) const noexcept = 0;  // t >= 0
  virtual MagnetPose Pose(double t_s) const noexcept { return StateAt(t_s).pose; }
};

struct PlantOptions {
  std::uint64_t seed = 1;
  HandScript script;            // no waypoints: no pen
  bool led = false;             // Aim sets the wanted pose; the script only the hand's properties and start
  bool imperfect = true;        // false: nominal device, nothing but noise and heat
  bool flip_coil_sign = false;  // coil z wired backwards
  std::int64_t start_ns = 0;    // < 0: the hand rests at its start until 0
  // For traces. The pen follows this path instead of a hand, whatever pushes it; a base that is already known; what the
  // environment is at time 0, and its seed.
  std::shared_ptr<const PenMotion> motion;
  std::optional<Imperfections> imperfections;
  double run_s = 0;
  std::optional<std::uint64_t> environment_seed;
  base::TruthParameters truth;
  BridgeParameters bridge;
  SupplyParameters supply;
};

// What a recording holds of the host, which the plant cannot know.
struct HostView {
  CoilArray set_point_A{};
  double command_age_s = 0;
  std::uint32_t faults = 0;
};

class Plant {
 public:
  // Precondition: that of HandPath.
  Plant(const base::DeviceGeometry& device, const PlantOptions& options);

  // One control step of kStepPeriod_us under `outputs`; what a core reads at its end.
  const firmware::Inputs& Step(const firmware::Outputs& outputs) noexcept;
  // What a core reads now; before the first step: at its start.
  const firmware::Inputs& inputs() const noexcept { return inputs_; }

  // Precondition: options.led.
  void SetAim(const HandAim& aim) noexcept { hand_.SetAim(aim); }

  // The controller was reset: its clock starts again. Everything else goes on.
  void ResetClock() noexcept;

  PlantFaults& faults() noexcept { return faults_; }

  std::int64_t now_ns() const noexcept { return sampler_.now_ns(); }  // from options.start_ns on
  const CoilArray& current_A() const noexcept { return coils_.current_A(); }
  const CoilArray& temperature_C() const noexcept { return coils_.temperature_C(); }
  double supply_V() const noexcept { return rail_.voltage_V(); }
  const MagnetPose& pose() const noexcept { return pen_.pose; }
  // At an instant of the last control step.
  CoilArray CurrentAt(std::int64_t t_ns) const noexcept { return sampler_.StateAt(t_ns).current_A; }

  TruthRow Truth(const HostView& host, std::int64_t clock_offset_ns) const noexcept;

 private:
  Snapshot Pen(double t_s) const noexcept;
  void MovePen(double t_s) noexcept;
  void Induce(const MagnetPose& before) noexcept;
  void Drive(const firmware::Outputs& outputs) noexcept;
  void Report(const firmware::Outputs& outputs) noexcept;
  void ReportHall(std::size_t i, bool test_field) noexcept;
  void ReportCoil(std::size_t k) noexcept;

  base::DeviceGeometry device_;
  BridgeParameters bridge_;
  Random random_;
  Imperfections imperfections_;
  TruthModel truth_;
  CoilBank coils_;
  SupplyRail rail_;
  Hand hand_;
  std::shared_ptr<const PenMotion> motion_;  // null: the hand
  double run_s_;
  Snapshot pen_;
  TickSampler sampler_;
  Surroundings surroundings_;
  ForceMap forces_;
  PlantFaults faults_;
  firmware::Inputs inputs_;
  std::int64_t clock_zero_ns_ = 0;
  std::uint64_t step_ = 0;
  CoilArray mean_A_{}, coil_V_{};
  CoilArray voltage_gain_{};
  double fan_rpm_ = 0;
  double induction_;
  CoilArray induced_V_{};  // by the moving pen, against the current
};

}  // namespace omni::sim
