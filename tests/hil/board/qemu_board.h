// The control core in an emulated Cortex-M7, one control step at a time. Virtual time: the board stands still between
// requests, so the host's speed does not matter.
#pragma once

#include <map>
#include <memory>
#include <string>

#include "firmware/core/lockstep_board.h"
#include "service/base/result.h"
#include "tests/hil/board/qemu_process.h"
#include "tests/support/process/temp_folder.h"

namespace omni::hil {

class QemuBoard {
 public:
  struct Options {
    int timeout_ms = 10'000;          // for each answer, the first one with QEMU's own start
    bool count_instructions = false;  // of every step, into the report; slower
  };

  // Fails with NoBoardReason. Call it from a thread that outlives the board.
  static base::Result<std::unique_ptr<QemuBoard>> Start(const Options& options);
  QemuBoard(const QemuBoard&) = delete;
  QemuBoard& operator=(const QemuBoard&) = delete;
  ~QemuBoard();  // kills

  // One request, its answer. Not kExit, which has none: that is Exit. An error names what happened to the board (exit
  // status, what it printed, a time-out); every later call fails too.
  base::Result<firmware::LockstepAnswer> Step(const firmware::LockstepRequest& request);

  // Resets the whole machine; only its retained memory stays.
  base::Status Reset(firmware::ResetCause cause);

  // Ends it: exit status, and the report's numbers by name ("stack_bytes", "armed_mean"; see
  // firmware/board/mps2_an500/instruction_counter.h).
  struct End {
    int status = 0;
    std::map<std::string, std::uint32_t> report;
  };
  base::Result<End> Exit(int status);

  // For tests: bytes written go to the board unchanged.
  base::Status SendRaw(const void* data, std::size_t size);
  pid_t pid() const { return process_->pid(); }

 private:
  explicit QemuBoard(const Options& options) : options_(options) {}
  base::Status Open();
  base::Status Receive(void* data, std::size_t size);
  base::Error Lost(const std::string& what);

  const Options options_;
  const test::TempFolder folder_;  // outlives the process
  std::unique_ptr<QemuProcess> process_;
  int to_board_ = -1, from_board_ = -1;
  std::string lost_;  // the first error
};

}  // namespace omni::hil
