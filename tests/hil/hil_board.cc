#include "tests/hil/hil_board.h"

#include <utility>

#include "firmware/core/lockstep_board.h"
#include "tests/hil/board/qemu_board.h"

namespace omni::hil {
namespace {

class HostBoard final : public HilBoard {
 public:
  base::Status Step(const firmware::LockstepRequest& request, firmware::LockstepAnswer& answer) override {
    board_.HandleRequest(request, answer);
    return base::Ok{};
  }
  base::Status Reset(firmware::ResetCause cause) override {
    firmware::LockstepRequest request;
    request.op = firmware::LockstepOp::kReset;
    request.argument = static_cast<std::uint32_t>(cause);
    firmware::LockstepAnswer answer;
    board_.HandleRequest(request, answer);
    return base::Ok{};
  }

 private:
  firmware::FaultRecord record_;
  firmware::LockstepBoard board_{firmware::Settings{}, firmware::ResetCause::kPower, 1, record_};
};

class EmulatedBoard final : public HilBoard {
 public:
  explicit EmulatedBoard(std::unique_ptr<QemuBoard> board) : board_(std::move(board)) {}

  base::Status Step(const firmware::LockstepRequest& request, firmware::LockstepAnswer& answer) override {
    const base::Result<firmware::LockstepAnswer> answered = board_->Step(request);
    if (!answered) return base::Error{answered.error()};
    answer = *answered;
    return base::Ok{};
  }
  base::Status Reset(firmware::ResetCause cause) override { return board_->Reset(cause); }

 private:
  std::unique_ptr<QemuBoard> board_;
};

base::Result<std::unique_ptr<HilBoard>> MakeHost() { return std::unique_ptr<HilBoard>(std::make_unique<HostBoard>()); }

base::Result<std::unique_ptr<HilBoard>> MakeEmulated() {
  base::Result<std::unique_ptr<QemuBoard>> started = QemuBoard::Start({});
  if (!started) return base::Error{started.error()};
  return std::unique_ptr<HilBoard>(std::make_unique<EmulatedBoard>(std::move(*started)));
}

struct BoardKind {
  const char* name;
  base::Result<std::unique_ptr<HilBoard>> (*make)();
};
constexpr BoardKind kBoards[] = {{"host", &MakeHost}, {"qemu", &MakeEmulated}};

}  // namespace

base::Result<std::unique_ptr<HilBoard>> MakeBoard(const std::string& kind) {
  std::string known;
  for (const BoardKind& board : kBoards) {
    if (kind == board.name) return board.make();
    known += std::string(known.empty() ? "" : ", ") + board.name;
  }
  return base::Error{"no board \"" + kind + "\": there are " + known};
}

}  // namespace omni::hil
