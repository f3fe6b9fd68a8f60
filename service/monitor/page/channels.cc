#include "service/monitor/page/channels.h"

#include <array>
#include <cmath>

namespace omni::monitor {
namespace {

using protocol::TelemetrySample;
using protocol::ToolSample;

// The tool's axis in the base frame: -z of the tool frame.
std::array<double, 3> AxisOf(const ToolSample& sample) {
  const auto& [w, x, y, z] = sample.orientation_base_wxyz;
  return {-2 * (x * z + w * y), -2 * (y * z - w * x), -(1 - 2 * (x * x + y * y))};
}

// Covariance of the tip: the variance along the axis there, the worst one across: v (I - u u^T) + v_u u u^T.
template <int I, int J>
float Covariance(const ToolSample& sample, const TelemetrySample& telemetry) {
  const std::array<double, 3> u = AxisOf(sample);
  const double across = telemetry.tip_variance_m2[0];
  const double along = telemetry.tip_variance_m2[1];
  return Single((I == J ? across : 0) + (along - across) * u[I] * u[J]);
}

#define OMNI_SAMPLE(expression) [](const ToolSample& sample, const TelemetrySample&) { return Single(expression); }
#define OMNI_TELEMETRY(expression) \
  [](const ToolSample&, const TelemetrySample& telemetry) { return Single(expression); }

constexpr auto kChannels = std::to_array<Channel>({
    {"tip_x_m", "tip x", "m", "position", OMNI_SAMPLE(sample.position_base_m[0])},
    {"tip_y_m", "tip y", "m", "position", OMNI_SAMPLE(sample.position_base_m[1])},
    {"tip_z_m", "tip z", "m", "position", OMNI_SAMPLE(sample.position_base_m[2])},
    {"gap_m", "gap between magnet and hull", "m", "position", OMNI_SAMPLE(sample.gap_m)},
    {"q_w", "orientation w", "", "orientation", OMNI_SAMPLE(sample.orientation_base_wxyz[0])},
    {"q_x", "orientation x", "", "orientation", OMNI_SAMPLE(sample.orientation_base_wxyz[1])},
    {"q_y", "orientation y", "", "orientation", OMNI_SAMPLE(sample.orientation_base_wxyz[2])},
    {"q_z", "orientation z", "", "orientation", OMNI_SAMPLE(sample.orientation_base_wxyz[3])},
    {"velocity_x_m_s", "speed x", "m/s", "speed", OMNI_SAMPLE(sample.linear_velocity_base_m_s[0])},
    {"velocity_y_m_s", "speed y", "m/s", "speed", OMNI_SAMPLE(sample.linear_velocity_base_m_s[1])},
    {"velocity_z_m_s", "speed z", "m/s", "speed", OMNI_SAMPLE(sample.linear_velocity_base_m_s[2])},
    {"force_x_N", "force x", "N", "force", OMNI_SAMPLE(sample.force_base_N[0])},
    {"force_y_N", "force y", "N", "force", OMNI_SAMPLE(sample.force_base_N[1])},
    {"force_z_N", "force z", "N", "force", OMNI_SAMPLE(sample.force_base_N[2])},
    {"gate", "gate", "", "force", OMNI_TELEMETRY(telemetry.gate)},
    {"current_x_A", "current x", "A", "current", OMNI_TELEMETRY(telemetry.current_A[0])},
    {"current_y_A", "current y", "A", "current", OMNI_TELEMETRY(telemetry.current_A[1])},
    {"current_z_A", "current z", "A", "current", OMNI_TELEMETRY(telemetry.current_A[2])},
    {"measured_x_A", "measured x", "A", "current", OMNI_TELEMETRY(telemetry.measured_A[0])},
    {"measured_y_A", "measured y", "A", "current", OMNI_TELEMETRY(telemetry.measured_A[1])},
    {"measured_z_A", "measured z", "A", "current", OMNI_TELEMETRY(telemetry.measured_A[2])},
    {"coil_x_C", "coil x", "°C", "temperature", OMNI_TELEMETRY(telemetry.coil_C[0])},
    {"coil_y_C", "coil y", "°C", "temperature", OMNI_TELEMETRY(telemetry.coil_C[1])},
    {"coil_z_C", "coil z", "°C", "temperature", OMNI_TELEMETRY(telemetry.coil_C[2])},
    {"supply_V", "supply", "V", "supply", OMNI_TELEMETRY(telemetry.supply_V)},
    {"sigma_m", "uncertainty of the tip", "m", "quality", OMNI_SAMPLE(sample.position_sigma_m)},
    {"cov_xx_m2", "covariance xx", "m²", "covariance", Covariance<0, 0>},
    {"cov_xy_m2", "covariance xy", "m²", "covariance", Covariance<0, 1>},
    {"cov_xz_m2", "covariance xz", "m²", "covariance", Covariance<0, 2>},
    {"cov_yy_m2", "covariance yy", "m²", "covariance", Covariance<1, 1>},
    {"cov_yz_m2", "covariance yz", "m²", "covariance", Covariance<1, 2>},
    {"cov_zz_m2", "covariance zz", "m²", "covariance", Covariance<2, 2>},
    {"fit_chi2", "residual of the fit", "", "quality", OMNI_TELEMETRY(telemetry.fit_chi2)},
    {"fit_dof", "expected residual", "", "quality", OMNI_TELEMETRY(telemetry.fit_dof)},
    {"model_error", "error of the tool's model", "", "quality", OMNI_TELEMETRY(telemetry.model_error)},
    {"field_T", "field of the tool", "T", "field", OMNI_TELEMETRY(telemetry.field_T)},
    {"ambient_x_T", "ambient x", "T", "field", OMNI_TELEMETRY(telemetry.ambient_T[0])},
    {"ambient_y_T", "ambient y", "T", "field", OMNI_TELEMETRY(telemetry.ambient_T[1])},
    {"ambient_z_T", "ambient z", "T", "field", OMNI_TELEMETRY(telemetry.ambient_T[2])},
    {"stray_T", "other magnets", "T", "field", OMNI_TELEMETRY(telemetry.stray_T)},
    {"tick_us", "tick", "µs", "timing", OMNI_TELEMETRY(1e-3 * telemetry.tick_ns)},
    {"latency_us", "sample to currents", "µs", "timing", OMNI_TELEMETRY(1e-3 * telemetry.latency_ns)},
    {"contacts", "surfaces touched", "", "state", OMNI_SAMPLE(sample.contact_count)},
    {"tick_faults", "tick faults", "", "state", OMNI_TELEMETRY(telemetry.tick_faults)},
    {"device_faults", "device faults", "", "state", OMNI_TELEMETRY(telemetry.device_faults)},
    {"tool_limits", "limits of tracking", "", "state", OMNI_TELEMETRY(telemetry.tool_limits)},
    {"sensors_left_out", "sensors left out", "", "state", OMNI_TELEMETRY(telemetry.sensors_left_out)},
    {"flags", "flags", "", "state", OMNI_SAMPLE(sample.flags)},
});

#undef OMNI_SAMPLE
#undef OMNI_TELEMETRY

}  // namespace

std::span<const Channel> Channels() noexcept { return kChannels; }

}  // namespace omni::monitor
