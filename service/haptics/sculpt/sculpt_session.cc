#include "service/haptics/sculpt/sculpt_session.h"

namespace omni::haptics::sculpt {

void StrokeServer::Close() {
  if (open_ != 0) editor_.End();
  open_ = 0;
}

void StrokeServer::Begin(const StrokeMessage& message, ServeReport& report) {
  constexpr double kReach_m = 0.005;  // the surface may have changed since the tick saw it
  Close();                            // its end was lost
  const SurfacePoint at = editor_.Locate(message.point_base_m, kReach_m);
  const base::Status begun = editor_.Begin(at, message.brush);
  if (!begun.ok()) {
    report.problem = begun.error();
    return;
  }
  open_ = message.stroke;
  ++report.begun;
}

ServeReport StrokeServer::Poll() {
  ServeReport report;
  StrokeMessage message;
  bool moves = false;
  double offset_m = 0;
  const auto move = [&] {
    if (moves) editor_.MoveTo(offset_m);
    moves = false;
  };
  while (ring_.TryPop(message)) {
    ++report.messages;
    if (message.kind == StrokeKind::kBegin) {
      move();
      Begin(message, report);
    } else if (message.stroke != open_ || open_ == 0) {
      continue;
    } else if (message.kind == StrokeKind::kMove) {
      moves = true;
      offset_m = message.offset_m;
    } else {
      move();
      editor_.End();
      open_ = 0;
      ++report.ended;
    }
  }
  move();
  report.publish = editor_.Publish();
  return report;
}

}  // namespace omni::haptics::sculpt
