#include "service/device/scan_conversion.h"

#include <cstddef>

#include "firmware/wire/messages.h"
#include "service/device/base_notes.h"

namespace omni::device {

static_assert(wire::kSensors == base::kSensorCount && wire::kCoils == base::kCoilCount &&
              wire::kStepsPerTick == base::kStepsPerTick);

namespace {

// Far wider than any Hall sensor and coil driver, far narrower than what a corrupt HELLO can contain.
constexpr float kFieldLsbMin_T = 1e-10F;
constexpr float kFieldLsbMax_T = 1e-5F;
constexpr float kCurrentMax_A = 100;

}  // namespace

base::Result<DeviceInfo> InfoFromHello(const wire::Hello& hello, Clocks clocks) {
  DeviceInfo info;
  info.serial = PrintableText(hello.serial, sizeof hello.serial);
  if (!(wire::kVersion >= hello.version_min && wire::kVersion <= hello.version_max)) {
    return base::Error{"device " + info.serial + ": speaks protocol versions " + std::to_string(hello.version_min) +
                       " to " + std::to_string(hello.version_max) + ", this service speaks " +
                       std::to_string(wire::kVersion) + ": update whichever is older"};
  }
  info.clock_is_host = (hello.capabilities & wire::kDeviceClockIsHostMonotonic) != 0;
  if (clocks == Clocks::kHostOnly && !info.clock_is_host) {
    return base::Error{"device " + info.serial +
                       ": uses a clock of its own, but this transport needs stamps of the host's CLOCK_MONOTONIC: "
                       "connect it through a transport that maps clocks"};
  }
  if (!(hello.field_lsb_T >= kFieldLsbMin_T && hello.field_lsb_T <= kFieldLsbMax_T && hello.current_max_A > 0 &&
        hello.current_max_A <= kCurrentMax_A)) {
    return base::Error{"device " + info.serial + ": HELLO reports a field count of " +
                       std::to_string(hello.field_lsb_T * 1e9F) + " nT and a largest current of " +
                       std::to_string(hello.current_max_A) +
                       " A, which is not plausible: flash the right firmware (omni device flash-help)"};
  }
  info.firmware_version = hello.firmware_version;
  info.arming = (hello.capabilities & wire::kArming) != 0;
  info.simulation = (hello.capabilities & wire::kSimulation) != 0;
  info.field_lsb_T = static_cast<double>(hello.field_lsb_T);
  info.field_range_T = info.field_lsb_T * hello.field_full_scale;
  info.current_max_A = static_cast<double>(hello.current_max_A);
  info.calibration_hash = hello.calibration_hash;
  return info;
}

base::HallScan ScanFromTelemetry(const DeviceInfo& info, const wire::Telemetry& telemetry, std::uint64_t t_device_us,
                                 std::uint64_t sequence) noexcept {
  base::HallScan scan;
  scan.t_ns = static_cast<std::int64_t>(t_device_us) * 1000;
  scan.sequence = sequence;
  for (std::size_t i = 0; i < base::kSensorCount; ++i) {
    const auto& counts = telemetry.field[i];
    scan.field_sensor_T[i] = {counts[0] * info.field_lsb_T, counts[1] * info.field_lsb_T, counts[2] * info.field_lsb_T};
    scan.age_ns[i] = telemetry.age[i] * wire::kAgeUnit_ns;
  }
  scan.fresh_mask = telemetry.fresh_mask;
  scan.saturated_mask = telemetry.saturated_mask;
  for (std::size_t k = 0; k < base::kCoilCount; ++k) {
    for (std::size_t step = 0; step < base::kStepsPerTick; ++step) {
      const double current_A = telemetry.current[step][k] * wire::kCurrentUnit_A;
      scan.step_current_A[step][k] = current_A;
      scan.coil_current_A[k] += current_A / base::kStepsPerTick;
    }
    scan.coil_temperature_C[k] = telemetry.temperature[k] * wire::kTemperatureUnit_K;
  }
  scan.has_steps = 1;
  scan.tick_lead_ns = std::int64_t{telemetry.tick_lead} * 1000;
  scan.supply_V = telemetry.supply * wire::kSupplyUnit_V;
  scan.device_faults = telemetry.faults;
  return scan;
}

}  // namespace omni::device
