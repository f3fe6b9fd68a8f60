// The control core in lockstep with the host: requests arrive through one FIFO, answers leave through the other. kReset
// resets the whole machine: start-up, constructors and core run again, and only the retained memory is kept.
//   lockstep          as fast as the host sends requests
//   lockstep count    the same, and counts the instructions of every step into the report
#include <cstring>
#include <new>
#include <optional>

#include "firmware/board/mps2_an500/host_link.h"
#include "firmware/board/mps2_an500/instruction_counter.h"
#include "firmware/board/mps2_an500/semihosting.h"
#include "firmware/board/mps2_an500/start.h"
#include "firmware/board/mps2_an500/text.h"
#include "firmware/core/lockstep_board.h"

namespace omni::firmware::board {
namespace {

// Kept across a reset. Without the mark it is random memory from power-on.
struct Retained {
  std::uint64_t mark;
  std::int32_t to_board, from_board;  // a reset is invisible to the host: handles stay open
  std::uint32_t starts;
  std::uint32_t cause;
  FaultRecord record;
};
constexpr std::uint64_t kMark = 0x4F4D4E4952455421ULL;
alignas(Retained) __attribute__((section(".noinit"))) unsigned char retained_bytes[sizeof(Retained)];
Retained& retained = *std::launder(reinterpret_cast<Retained*>(retained_bytes));

bool OpenLink() noexcept {
  retained.to_board = OpenFile(kToBoard, FileMode::kRead);
  if (retained.to_board < 0) return false;
  retained.from_board = OpenFile(kFromBoard, FileMode::kWrite);
  return retained.from_board >= 0;
}

void WriteReport(const LockstepBoard& board, const StepCounts& counts, const InstructionCounter& counter) noexcept {
  Text report;
  report.Add("ticks_of_1024_instructions ").Add(counter.rate()).Add("\n");
  report.Add("stack_bytes ").Add(StackUsed_bytes()).Add("\n");
  report.Add("stack_size_bytes ").Add(StackSize_bytes()).Add("\n");
  report.Add("refused ").Add(board.refused()).Add("\n");
  counts.Write(report);
  const int file = OpenFile(kReport, FileMode::kWrite);
  if (file < 0) return;
  WriteAll(file, report.c_str(), report.size());
  CloseFile(file);
}

// Used until kExit. Static because it is large.
int Serve(LockstepBoard& board, bool count_instructions) noexcept {
  static LockstepRequest request;
  static LockstepAnswer answer;
  static StepCounts counts;
  static InstructionCounter counter;
  for (;;) {
    if (!ReadAll(retained.to_board, &request, sizeof request)) return kExitLinkLost;
    if (request.op == LockstepOp::kExit) {
      WriteReport(board, counts, counter);
      return static_cast<int>(request.argument);
    }
    if (request.op == LockstepOp::kReset && IsResetCause(request.argument)) {
      retained.cause = request.argument;
      ResetMachine();  // start-up sends the answer
    }
    const wire::State state = board.core().state();
    counter.Begin();
    board.HandleRequest(request, answer);
    const std::uint32_t instructions = counter.End();
    if (count_instructions && request.op == LockstepOp::kStep) {
      counts.Add(state, answer.frames[0].size != 0, instructions);
    }
    if (!WriteAll(retained.from_board, &answer, sizeof answer)) return kExitLinkLost;
  }
}

}  // namespace

int Main(const char* command_line) {
  const bool count = std::strcmp(command_line, kCount) == 0;
  if (!count && *command_line != '\0') {
    Print("lockstep: the only argument is \"count\"\n");
    return kExitUsage;
  }
  const bool is_power_on = retained.mark != kMark || !IsResetCause(retained.cause);
  if (is_power_on) {
    if (!OpenLink()) {
      Print("lockstep: to_board or from_board cannot be opened in the working directory\n");
      return kExitNoLink;
    }
    retained.cause = static_cast<std::uint32_t>(ResetCause::kPower);
    retained.starts = 0;
    retained.mark = kMark;
  }
  static std::optional<LockstepBoard> board;
  board.emplace(Settings{}, static_cast<ResetCause>(retained.cause), retained.starts++, retained.record);
  static const LockstepAnswer kNothing;
  if (!is_power_on && !WriteAll(retained.from_board, &kNothing, sizeof kNothing)) return kExitLinkLost;
  return Serve(*board, count);
}

}  // namespace omni::firmware::board
