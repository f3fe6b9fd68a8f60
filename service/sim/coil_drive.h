// Coils and their driver: set-points with delay and watchdog, L/R lag behind a limited supply, heat, current sensor.
#pragma once

#include <array>
#include <cstdint>

#include "service/base/device_geometry.h"
#include "service/sim/coil_bank.h"
#include "service/sim/imperfections.h"
#include "service/sim/truth_model.h"

namespace omni::sim {

using DriveConfig = base::DriverParameters;

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

  void Heat(double dt_s) noexcept { coils_.Heat(dt_s); }

  const CoilArray& current_A() const noexcept { return coils_.current_A(); }
  const CoilArray& set_point_A() const noexcept { return set_point_A_; }
  const CoilArray& temperature_C() const noexcept { return coils_.temperature_C(); }
  double body_C() const noexcept { return coils_.body_C(); }  // what a thermometer on the base would show
  CoilArray Measured(const CoilArray& mean_current_A) const noexcept;
  std::uint32_t faults() const noexcept { return faults_; }

 private:
  struct Pending {
    std::int64_t effective_ns = 0;
    CoilArray set_point_A{};
  };
  static constexpr std::size_t kPendingMax = 64;  // full: the newest entry is replaced

  base::DeviceGeometry device_;
  DriveConfig drive_;
  CoilBank coils_;
  CoilArray current_gain_, current_offset_A_;
  std::array<Pending, kPendingMax> pending_{};
  std::size_t pending_count_ = 0;
  bool commanded_ = false;  // ever
  double time_to_live_s_ = 0;
  CoilArray set_point_A_{};
  std::uint32_t faults_ = 0;
};

}  // namespace omni::sim
