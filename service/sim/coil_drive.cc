#include "service/sim/coil_drive.h"

#include <algorithm>
#include <cmath>

#include "firmware/wire/messages.h"

namespace omni::sim {
namespace {

constexpr double kRampToZero_s = 5e-3;  // from full current

}  // namespace

CoilDrive::CoilDrive(const base::DeviceGeometry& device, const DriveConfig& drive, const ThermalConfig& thermal,
                     const Imperfections& imperfections)
    : device_(device),
      drive_(drive),
      coils_(device, thermal),
      current_gain_(imperfections.current_gain),
      current_offset_A_(imperfections.current_offset_A),
      faults_(wire::kFaultHostSilent) {}

void CoilDrive::Command(const CoilArray& set_point_A, double time_to_live_s, std::int64_t t_ns) noexcept {
  commanded_ = true;
  time_to_live_s_ = time_to_live_s;
  if (pending_count_ == kPendingMax) --pending_count_;
  pending_[pending_count_++] = {t_ns + std::llround(drive_.delay_s * 1e9), set_point_A};
}

void CoilDrive::Watch(double host_silence_s) noexcept {
  const double limit_s = std::min(drive_.host_timeout_s, time_to_live_s_);
  const bool silent = !commanded_ || !(host_silence_s < limit_s);
  const CoilArray& copper_C = coils_.temperature_C();
  const double hottest_C = *std::max_element(copper_C.begin(), copper_C.end());
  const bool was_hot = (faults_ & wire::kFaultOverTemperature) != 0;
  const bool hot = !(hottest_C < (was_hot ? device_.temperature_derate_C : device_.temperature_max_C));
  faults_ = (silent ? wire::kFaultHostSilent : 0U) | (hot ? wire::kFaultOverTemperature : 0U);
}

// V = R I_set as far as the supply reaches.
void CoilDrive::Step(std::int64_t t_ns, double dt_s) noexcept {
  std::size_t due = 0;
  while (due < pending_count_ && pending_[due].effective_ns <= t_ns) ++due;
  if (due > 0) {
    if (faults_ == 0) set_point_A_ = pending_[due - 1].set_point_A;
    std::copy(pending_.begin() + static_cast<std::ptrdiff_t>(due),
              pending_.begin() + static_cast<std::ptrdiff_t>(pending_count_), pending_.begin());
    pending_count_ -= due;
  }
  for (std::size_t k = 0; k < set_point_A_.size(); ++k) {
    const double limit_A = device_.current_max_A;
    if (faults_ != 0) {
      const double step_A = limit_A * dt_s / kRampToZero_s;
      set_point_A_[k] -= std::clamp(set_point_A_[k], -step_A, step_A);
    }
    const double wanted_A = std::clamp(set_point_A_[k], -limit_A, limit_A);
    coils_.Step(k, std::clamp(coils_.Resistance(k) * wanted_A, -device_.supply_V, device_.supply_V), 0, dt_s);
  }
}

CoilArray CoilDrive::Measured(const CoilArray& mean_current_A) const noexcept {
  CoilArray measured_A{};
  for (std::size_t k = 0; k < measured_A.size(); ++k) {
    measured_A[k] = current_gain_[k] * mean_current_A[k] + current_offset_A_[k];
  }
  return measured_A;
}

}  // namespace omni::sim
