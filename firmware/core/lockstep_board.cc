#include "firmware/core/lockstep_board.h"

namespace omni::firmware {

LockstepBoard::LockstepBoard(const Settings& settings, ResetCause cause, std::uint32_t start,
                             FaultRecord& record) noexcept
    : settings_(settings), record_(record), start_(start) {
  Start(cause);
}

void LockstepBoard::HandleRequest(const LockstepRequest& request, LockstepAnswer& answer) noexcept {
  answer = LockstepAnswer{};
  if (request.op == LockstepOp::kStep) {
    Step(request, answer);
  } else if (request.op == LockstepOp::kReset && IsResetCause(request.argument)) {
    Start(static_cast<ResetCause>(request.argument));
  } else {
    ++refused_;
  }
}

void LockstepBoard::Start(ResetCause cause) noexcept {
  core_.emplace(settings_, cause, start_, record_);
  ++start_;
}

void LockstepBoard::Step(const LockstepRequest& request, LockstepAnswer& answer) noexcept {
  for (const LockstepFrame& frame : request.frames) {
    if (frame.size == 0) continue;
    core_->Receive(frame.bytes, frame.size <= wire::kFrameSizeMax ? frame.size : 0);
  }
  core_->Step(request.inputs, answer.outputs);
  for (LockstepFrame& frame : answer.frames) {
    frame.size = static_cast<std::uint16_t>(core_->NextFrame(frame.bytes, sizeof frame.bytes));
    if (frame.size == 0) break;
  }
}

bool IsResetCause(std::uint32_t number) noexcept { return number <= static_cast<std::uint32_t>(ResetCause::kSoftware); }

}  // namespace omni::firmware
