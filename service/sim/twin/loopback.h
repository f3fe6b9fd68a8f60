// A simulated base and the host's end of its wire in one process and in virtual time: frames travel without delay. The
// base is armed as any host would do it.
#pragma once

#include <cstdint>

#include "service/base/force_limit.h"
#include "service/base/hall_scan.h"
#include "service/device/commands.h"
#include "service/device/scan_conversion.h"
#include "service/sim/twin/twin_core.h"

namespace omni::sim {

class Loopback {
 public:
  // As TwinCore. Stamps of scans start at kClockStart_ns: 0 stays "never".
  static constexpr std::int64_t kClockStart_ns = 1'000'000'000;
  Loopback(const base::DeviceGeometry& device, const PlantOptions& options);

  // Advances by 1 ms, or until a scan arrives; the newest, if there are two.
  void Tick(base::HallScan& scan) noexcept;

  // False: refused, nothing sent.
  bool Write(const base::CoilCurrents& currents) noexcept;

  // Precondition: options.led.
  void SetAim(const HandAim& aim) noexcept { core_.SetAim(aim); }

  const TwinCore& core() const noexcept { return core_; }

 private:
  std::int64_t Now_ns() const noexcept { return core_.now_ns() + core_.clock_offset_ns(); }
  void SendArm() noexcept;
  bool TakeFrames(base::HallScan& scan) noexcept;  // false: no scan

  TwinCore core_;
  device::DeviceInfo device_;
  device::Arming arming_;
  device::ResponseTime response_;
  std::uint64_t newest_device_us_ = 0;
  std::uint16_t arm_seq_ = 0, command_seq_ = 0;
};

}  // namespace omni::sim
