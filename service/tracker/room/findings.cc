#include "service/tracker/room/findings.h"

namespace omni::tracker {

void ReportFindings(const RoomState& room, bool frozen, base::ToolState& tool) noexcept {
  const Doubt& doubt = room.doubt;
  if (frozen) tool.limits |= base::kToolFrozen;
  tool.sensors_left_out = doubt.left_out >= 0 ? 1u << doubt.left_out : 0;
  tool.sensors_disagree = doubt.agreed == 0 ? tool.sensors_left_out : 0;
  const auto [x_T, y_T, z_T] = AmbientField_T(room.drift);
  tool.ambient_base_T = {x_T, y_T, z_T};
  tool.stray_rms_T = room.stray.believed ? RootMeanSquare(room.stray.mean_T) : 0;
  ReportMagnet(room.drift, room.magnet, tool);
  tool.model_error_relative = doubt.model_error;
}

}  // namespace omni::tracker
