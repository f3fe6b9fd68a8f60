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
      thermal_(thermal),
      current_gain_(imperfections.current_gain),
      current_offset_A_(imperfections.current_offset_A),
      body_C_(thermal.air_C),
      faults_(wire::kFaultHostSilent) {
  copper_C_.fill(thermal.air_C);
}

void CoilDrive::Command(const CoilArray& set_point_A, double time_to_live_s, std::int64_t t_ns) noexcept {
  commanded_ = true;
  time_to_live_s_ = time_to_live_s;
  if (pending_count_ == kPendingMax) --pending_count_;
  pending_[pending_count_++] = {t_ns + std::llround(drive_.delay_s * 1e9), set_point_A};
}

void CoilDrive::Watch(double host_silence_s) noexcept {
  const double limit_s = std::min(drive_.host_timeout_s, time_to_live_s_);
  const bool silent = !commanded_ || !(host_silence_s < limit_s);
  const double hottest_C = *std::max_element(copper_C_.begin(), copper_C_.end());
  const bool was_hot = (faults_ & wire::kFaultOverTemperature) != 0;
  const bool hot = !(hottest_C < (was_hot ? device_.temperature_derate_C : device_.temperature_max_C));
  faults_ = (silent ? wire::kFaultHostSilent : 0U) | (hot ? wire::kFaultOverTemperature : 0U);
}

double CoilDrive::Resistance(std::size_t k) const noexcept {
  return device_.coils[k].resistance_20C_ohm * (1 + thermal_.resistance_per_K * (copper_C_[k] - 20));
}

// L dI/dt = V - R I with V = R I_set as far as the supply reaches: exact over a step of constant V.
void CoilDrive::Step(std::int64_t t_ns, double dt_s) noexcept {
  std::size_t due = 0;
  while (due < pending_count_ && pending_[due].effective_ns <= t_ns) ++due;
  if (due > 0) {
    if (faults_ == 0) set_point_A_ = pending_[due - 1].set_point_A;
    std::copy(pending_.begin() + static_cast<std::ptrdiff_t>(due),
              pending_.begin() + static_cast<std::ptrdiff_t>(pending_count_), pending_.begin());
    pending_count_ -= due;
  }
  for (std::size_t k = 0; k < current_A_.size(); ++k) {
    const double limit_A = device_.current_max_A;
    if (faults_ != 0) {
      const double step_A = limit_A * dt_s / kRampToZero_s;
      set_point_A_[k] -= std::clamp(set_point_A_[k], -step_A, step_A);
    }
    const double resistance = Resistance(k);
    const double wanted_A = std::clamp(set_point_A_[k], -limit_A, limit_A);
    const double final_A = std::clamp(resistance * wanted_A, -device_.supply_V, device_.supply_V) / resistance;
    const double decay = std::exp(-resistance * dt_s / device_.coils[k].inductance_H);
    current_A_[k] = final_A + (current_A_[k] - final_A) * decay;
  }
}

void CoilDrive::Heat(double dt_s) noexcept {
  double into_body_W = -thermal_.body_to_air_W_K * (body_C_ - thermal_.air_C);
  for (std::size_t k = 0; k < copper_C_.size(); ++k) {
    const double flow_W = thermal_.copper_to_body_W_K * (copper_C_[k] - body_C_);
    copper_C_[k] += (current_A_[k] * current_A_[k] * Resistance(k) - flow_W) * dt_s / thermal_.copper_J_K;
    into_body_W += flow_W;
  }
  body_C_ += into_body_W * dt_s / thermal_.body_J_K;
}

CoilArray CoilDrive::Measured(const CoilArray& mean_current_A) const noexcept {
  CoilArray measured_A{};
  for (std::size_t k = 0; k < measured_A.size(); ++k) {
    measured_A[k] = current_gain_[k] * mean_current_A[k] + current_offset_A_[k];
  }
  return measured_A;
}

}  // namespace omni::sim
