#include "service/protocol/sample_range.h"

#include <algorithm>
#include <cmath>

namespace omni::protocol {
namespace {

bool TimeInRange(std::int64_t t_ns) noexcept { return t_ns >= 0 && t_ns <= kLatestTime_ns; }

template <std::size_t N>
bool ValuesInRange(const std::array<double, N>& values) noexcept {
  for (const double value : values) {
    if (!(std::abs(value) <= kLargestValue)) return false;
  }
  return true;
}

bool IsTurn(const std::array<double, 4>& q) noexcept {
  return std::abs(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] - 1) <= kUnitTolerance;
}

// A NaN is the largest value: an unknown gap or sigma is a large one.
double Clamped(double value) noexcept {
  return std::isnan(value) ? kLargestValue : std::clamp(value, -kLargestValue, kLargestValue);
}

bool ContactInRange(const ContactSample& contact) noexcept {
  const std::array<double, 3> scalars{contact.normal_force_N, contact.tangential_force_N, contact.penetration_m};
  const auto& n = contact.normal_base;
  return ValuesInRange(contact.point_base_m) && ValuesInRange(n) && ValuesInRange(contact.force_base_N) &&
         ValuesInRange(contact.slip_base_m_s) && ValuesInRange(scalars) &&
         std::abs(n[0] * n[0] + n[1] * n[1] + n[2] * n[2] - 1) <= kUnitTolerance;
}

// Calls `visit` with each of its floating point numbers. `Telemetry`: the sample, constant or not.
template <class Telemetry, class Visit>
void VisitValues(Telemetry& telemetry, const Visit& visit) noexcept {
  for (auto* values : {&telemetry.current_A, &telemetry.measured_A, &telemetry.coil_C, &telemetry.ambient_T}) {
    for (auto& value : *values) visit(value);
  }
  for (auto& value : telemetry.tip_variance_m2) visit(value);
  for (auto* value : {&telemetry.supply_V, &telemetry.fit_chi2, &telemetry.field_T, &telemetry.stray_T,
                      &telemetry.model_error, &telemetry.gate}) {
    visit(*value);
  }
}

}  // namespace

bool InRange(const ToolSample& sample) noexcept {
  if (!TimeInRange(sample.t_ns) || (sample.flags & ~kKnownToolFlags) != 0) return false;
  const std::array<double, 2> scalars{sample.position_sigma_m, sample.gap_m};
  const auto& q = sample.orientation_base_wxyz;
  const bool finite =
      ValuesInRange(sample.position_base_m) && ValuesInRange(q) && ValuesInRange(sample.linear_velocity_base_m_s) &&
      ValuesInRange(sample.angular_velocity_base_rad_s) && ValuesInRange(sample.force_base_N) && ValuesInRange(scalars);
  if (!finite) return false;
  if ((sample.flags & kToolPoseValid) == 0) return true;
  return IsTurn(q);
}

bool InRange(const BaseSample& sample) noexcept {
  const auto& q = sample.orientation_space_wxyz;
  return TimeInRange(sample.t_ns) && (sample.flags & ~kKnownBaseFlags) == 0 && ValuesInRange(sample.position_space_m) &&
         ValuesInRange(sample.linear_velocity_space_m_s) && ValuesInRange(sample.angular_velocity_space_rad_s) &&
         IsTurn(q);
}

bool InRange(const InputSnapshot& inputs) noexcept {
  if (!TimeInRange(inputs.t_ns)) return false;
  for (const InputValue& component : inputs.components) {
    if (!(std::abs(component.value) <= 1) || !TimeInRange(component.t_change_ns)) return false;
  }
  return true;
}

bool InRange(const ContactSnapshot& contacts) noexcept {
  if (!TimeInRange(contacts.t_ns) || contacts.count > kMaxSampledContacts) return false;
  for (std::uint32_t i = 0; i < contacts.count; ++i) {
    if (!ContactInRange(contacts.contacts[i])) return false;
  }
  return true;
}

bool InRange(const VehicleSnapshot& vehicle) noexcept {
  const std::array<double, 5> scalars{vehicle.heading_rad, vehicle.speed_m_s, vehicle.lap_s, vehicle.last_lap_s,
                                      vehicle.best_lap_s};
  return TimeInRange(vehicle.t_ns) && vehicle.on <= 1 && vehicle.sliding <= 1 &&
         ValuesInRange(vehicle.position_base_m) && ValuesInRange(scalars);
}

bool InRange(const TelemetrySample& telemetry) noexcept {
  bool in_range = true;
  VisitValues(telemetry, [&](const float& value) { in_range = in_range && std::abs(value) <= kLargestValue; });
  return in_range;
}

ToolSample Clamped(const ToolSample& sample) noexcept {
  if (InRange(sample)) return sample;
  ToolSample clamped = sample;
  clamped.t_ns = std::clamp<std::int64_t>(sample.t_ns, 0, kLatestTime_ns);
  clamped.flags &= kKnownToolFlags;
  clamped.position_sigma_m = Clamped(sample.position_sigma_m);
  clamped.gap_m = Clamped(sample.gap_m);
  if (InRange(clamped)) return clamped;
  ToolSample poseless;
  poseless.t_ns = clamped.t_ns;
  poseless.flags = clamped.flags & (kToolJoystick | kToolAligned);
  poseless.position_sigma_m = kLargestValue;
  poseless.gap_m = kLargestValue;
  return poseless;
}

InputSnapshot Clamped(const InputSnapshot& inputs) noexcept {
  if (InRange(inputs)) return inputs;
  InputSnapshot clamped = inputs;
  clamped.t_ns = std::clamp<std::int64_t>(inputs.t_ns, 0, kLatestTime_ns);
  for (InputValue& component : clamped.components) {
    component.value = std::isnan(component.value) ? 0.0f : std::clamp(component.value, -1.0f, 1.0f);
    component.t_change_ns = std::clamp<std::int64_t>(component.t_change_ns, 0, kLatestTime_ns);
  }
  return clamped;
}

ContactSnapshot Clamped(const ContactSnapshot& contacts) noexcept {
  if (InRange(contacts)) return contacts;
  ContactSnapshot clamped;
  clamped.t_ns = std::clamp<std::int64_t>(contacts.t_ns, 0, kLatestTime_ns);
  clamped.scene_generation = contacts.scene_generation;
  for (std::uint32_t i = 0; i < std::min(contacts.count, kMaxSampledContacts); ++i) {
    if (ContactInRange(contacts.contacts[i])) clamped.contacts[clamped.count++] = contacts.contacts[i];
  }
  return clamped;
}

VehicleSnapshot Clamped(const VehicleSnapshot& vehicle) noexcept {
  if (InRange(vehicle)) return vehicle;
  VehicleSnapshot none;
  none.t_ns = std::clamp<std::int64_t>(vehicle.t_ns, 0, kLatestTime_ns);
  none.scene_generation = vehicle.scene_generation;
  return none;
}

TelemetrySample Clamped(const TelemetrySample& telemetry) noexcept {
  TelemetrySample clamped = telemetry;
  constexpr auto kLargest = static_cast<float>(kLargestValue);
  VisitValues(clamped,
              [kLargest](float& value) { value = std::isnan(value) ? 0 : std::clamp(value, -kLargest, kLargest); });
  return clamped;
}

}  // namespace omni::protocol
