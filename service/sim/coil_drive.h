// Coils and their driver: set-points with delay and watchdog, L/R lag behind a limited supply, heat, current sensor.
#pragma once

#include <array>
#include <cstdint>

#include "service/base/device_geometry.h"
#include "service/sim/imperfections.h"
#include "service/sim/truth_model.h"

namespace omni::sim {

using DriveConfig = base::DriverParameters;

// Each coil's copper, and the body that all three share:
//   Cc dTc = I^2 R(Tc) dt - Gcb (Tc - Tb) dt,  Cb dTb = sum Gcb (Tc - Tb) dt - Gba (Tb - Ta) dt
// fitted to the paper's temperatures of one coil (39 C at 65 s after 15 A for 25 s, 47 C after 15 min at 5 A) with the
// copper's heat capacity from its mass.
using ThermalConfig = base::ThermalParameters;

class CoilDrive {
 public:
  CoilDrive(const base::DeviceGeometry& device, const DriveConfig& drive, const ThermalConfig& thermal,
            const Imperfections& imperfections);

  // A valid command received at device time `t_ns`.
  void Command(const CoilArray& set_point_A, double time_to_live_s, std::int64_t t_ns) noexcept;

  // Once per device tick, before its sub-steps.
  void Watch(double host_silence_s) noexcept;

  // Currents over one sub-step that ends at device time `t_ns`.
  void Step(std::int64_t t_ns, double dt_s) noexcept;

  void Heat(double dt_s) noexcept;

  const CoilArray& current_A() const noexcept { return current_A_; }
  const CoilArray& set_point_A() const noexcept { return set_point_A_; }
  const CoilArray& temperature_C() const noexcept { return copper_C_; }
  double body_C() const noexcept { return body_C_; }  // what a thermometer on the base would show
  CoilArray Measured(const CoilArray& mean_current_A) const noexcept;
  std::uint32_t faults() const noexcept { return faults_; }

 private:
  struct Pending {
    std::int64_t effective_ns = 0;
    CoilArray set_point_A{};
  };
  static constexpr std::size_t kPendingMax = 64;  // full: the newest entry is replaced

  double Resistance(std::size_t k) const noexcept;

  base::DeviceGeometry device_;
  DriveConfig drive_;
  ThermalConfig thermal_;
  CoilArray current_gain_, current_offset_A_;
  std::array<Pending, kPendingMax> pending_{};
  std::size_t pending_count_ = 0;
  bool commanded_ = false;  // ever
  double time_to_live_s_ = 0;
  CoilArray set_point_A_{};
  CoilArray current_A_{};
  CoilArray copper_C_{};
  double body_C_ = 0;
  std::uint32_t faults_ = 0;
};

}  // namespace omni::sim
