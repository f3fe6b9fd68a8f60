#include "service/tracker/room/findings.h"

namespace omni::tracker {

void ReportFindings(const State& state, bool frozen, base::ToolState& tool) noexcept {
  const Doubt& doubt = state.doubt;
  if (frozen) tool.limits |= base::kToolFrozen;
  tool.sensors_left_out = doubt.left_out >= 0 ? 1u << doubt.left_out : 0;
  tool.sensors_disagree = doubt.agreed == 0 ? tool.sensors_left_out : 0;
  const auto [x_T, y_T, z_T] = AmbientField_T(state.drift);
  tool.ambient_base_T = {x_T, y_T, z_T};
  tool.stray_rms_T = state.stray.believed ? RootMeanSquare(state.stray.mean_T) : 0;
  ReportMagnet(state.drift, state.magnet, tool);
  tool.model_error_relative = doubt.model_error;
}

}  // namespace omni::tracker
