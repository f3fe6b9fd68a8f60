#include "service/daemon/clients/publish.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace omni::daemon {
namespace {

static_assert(protocol::kInputCount == base::kInputComponentCount);

std::array<double, 3> ToArray(const base::Vec3& v) noexcept { return {v.x, v.y, v.z}; }

std::uint32_t Flags(const loop::TickOutput& output) noexcept {
  std::uint32_t flags = 0;
  const bool absent = output.tool.status == base::TrackingStatus::kAbsent;
  if (output.tool.ever_tracked && !absent) flags |= protocol::kToolPoseValid;
  if (output.tool.status == base::TrackingStatus::kTracking) flags |= protocol::kToolTracked;
  if (output.haptics.in_contact && output.gate > 0) flags |= protocol::kToolContact;
  if (output.haptics.joystick) flags |= protocol::kToolJoystick;
  if (output.haptics.holding && output.gate > 0) flags |= protocol::kToolHolding;
  if (output.haptics.waits && output.gate > 0) flags |= protocol::kToolWaits;
  if (output.applied.acts && output.gate > 0) flags |= protocol::kToolPushed;
  if (output.saturated) flags |= protocol::kToolForceCut;
  if (output.warm) flags |= protocol::kToolWarm;
  if (output.out_of_reach) flags |= protocol::kToolOutOfReach;
  if ((output.faults & loop::kFaultDevice) != 0) flags |= protocol::kToolDeviceFault;
  const bool softened = loop::ContactGain(output) < 1;
  if (softened) flags |= protocol::kToolSoftened;
  if (output.applied.stiffness_limited || softened) flags |= protocol::kToolStiffnessLimited;
  return flags;
}

protocol::ContactSnapshot ContactsOf(const loop::TickOutput& output) noexcept {
  protocol::ContactSnapshot contacts;
  contacts.t_ns = output.t_ns;
  contacts.scene_generation = output.scene_generation;
  static_assert(haptics::kMaxContacts == static_cast<int>(protocol::kMaxSampledContacts));
  for (int k = 0; k < output.haptics.contact_count; ++k) {
    const haptics::Contact& from = output.haptics.contacts[static_cast<std::size_t>(k)];
    contacts.contacts[contacts.count++] = {.object = from.object,
                                           .material = from.material,
                                           .point_base_m = ToArray(from.point_base_m),
                                           .normal_base = ToArray(from.normal_base),
                                           .force_base_N = ToArray(from.force_base_N),
                                           .slip_base_m_s = ToArray(from.slip_base_m_s),
                                           .normal_force_N = from.normal_force_N,
                                           .tangential_force_N = from.tangential_force_N,
                                           .penetration_m = std::max(0.0, -from.gap_m)};
  }
  return contacts;
}

protocol::VehicleSnapshot VehicleOf(const loop::TickOutput& output) noexcept {
  const haptics::VehicleReport& car = output.haptics.vehicle;
  return {.t_ns = output.t_ns,
          .scene_generation = output.scene_generation,
          .on = car.on ? 1U : 0U,
          .sliding = car.sliding ? 1U : 0U,
          .laps = car.laps,
          .hits = car.hits,
          .position_base_m = ToArray(car.position_base_m),
          .heading_rad = car.heading_rad,
          .speed_m_s = car.speed_m_s,
          .lap_s = car.lap_s,
          .last_lap_s = car.last_lap_s,
          .best_lap_s = car.best_lap_s};
}

std::array<float, 3> Floats(const std::array<double, 3>& values) noexcept {
  return {static_cast<float>(values[0]), static_cast<float>(values[1]), static_cast<float>(values[2])};
}

std::uint32_t Nanoseconds(std::int64_t ns) noexcept {
  return static_cast<std::uint32_t>(std::clamp<std::int64_t>(ns, 0, std::numeric_limits<std::uint32_t>::max()));
}

protocol::TelemetrySample TelemetryOf(const loop::TickOutput& output, const base::HallScan& scan,
                                      const loop::TickTimes& times) noexcept {
  const base::ToolState& tool = output.tool;
  return {.tick_faults = output.faults,
          .device_faults = scan.device_faults,
          .tool_limits = tool.limits,
          .sensors_left_out = tool.sensors_left_out,
          .saturated_mask = scan.saturated_mask,
          .tick_ns = Nanoseconds(times.tick_ns),
          .latency_ns = Nanoseconds(times.latency_ns),
          .fit_dof = static_cast<std::uint32_t>(std::max(0, tool.dof)),
          .current_A = Floats(output.currents.current_A),
          .measured_A = Floats(scan.coil_current_A),
          .coil_C = Floats(scan.coil_temperature_C),
          .ambient_T = Floats(ToArray(tool.ambient_base_T)),
          .tip_variance_m2 = {static_cast<float>(tool.device_point_noise.position_m2),
                              static_cast<float>(tool.device_point_noise_along.position_m2)},
          .supply_V = static_cast<float>(scan.supply_V),
          .fit_chi2 = static_cast<float>(tool.chi2),
          .field_T = static_cast<float>(tool.field_rms_T),
          .stray_T = static_cast<float>(tool.stray_rms_T),
          .model_error = static_cast<float>(tool.model_error_relative),
          .gate = static_cast<float>(output.gate)};
}

}  // namespace

void PublishSink::Publish(const loop::TickOutput& output, const base::HallScan& scan,
                          const loop::TickTimes& times) noexcept {
  const base::ToolState& tool = output.tool;
  const base::Quat& q = output.orientation_base_tool;
  protocol::ToolSample sample;
  sample.t_ns = output.t_ns;
  sample.flags = Flags(output);
  sample.contact_count = static_cast<std::uint32_t>(std::max(0, output.haptics.contact_count));
  if (aligned_.load(std::memory_order_relaxed)) sample.flags |= protocol::kToolAligned;
  sample.position_base_m = ToArray(tool.device_point_base_m);
  sample.orientation_base_wxyz = {q.w, q.x, q.y, q.z};
  sample.linear_velocity_base_m_s = ToArray(tool.device_point_velocity_base_m_s);
  sample.angular_velocity_base_rad_s = ToArray(tool.angular_velocity_base_rad_s);
  sample.force_base_N = ToArray(output.wrench.force_N);
  sample.position_sigma_m = std::sqrt(std::max(0.0, tool.covariance[0] + tool.covariance[6] + tool.covariance[12]));
  sample.gap_m = tool.gap_m;
  protocol::InputSnapshot inputs;
  inputs.t_ns = output.t_ns;
  for (std::size_t i = 0; i < inputs.components.size(); ++i) {
    const base::InputValue& from = output.inputs.components[i];
    inputs.components[i] = {.value = from.value,
                            .press_count = from.press_count,
                            .release_count = from.release_count,
                            .reserved = 0,
                            .t_change_ns = from.t_change_ns};
  }
  publisher_.PublishContacts(ContactsOf(output));
  publisher_.PublishVehicle(VehicleOf(output));
  publisher_.PublishTelemetry(TelemetryOf(output, scan, times));
  publisher_.Publish(sample, inputs);
}

}  // namespace omni::daemon
