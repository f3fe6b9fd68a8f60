// QEMU with an image of the mps2-an500 board, as a child process in a folder of its own.
#pragma once

#include <sys/types.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "service/base/result.h"
#include "tests/support/process/temp_folder.h"

namespace omni::hil {

class QemuProcess {
 public:
  struct Options {
    std::string image;                   // name of an image of this build
    std::vector<std::string> arguments;  // for the program in it; words without spaces
    // Every instruction takes the same emulated time: SysTick counts them. Slower.
    bool count_instructions = false;
  };

  // `folder`: working directory of the emulator, where the program finds its files.
  // The child is killed when the thread that started it ends for any reason: no test leaves one behind.
  static base::Result<std::unique_ptr<QemuProcess>> Start(const Options& options, const std::string& folder);
  ~QemuProcess();  // kills
  QemuProcess(const QemuProcess&) = delete;
  QemuProcess& operator=(const QemuProcess&) = delete;

  // The exit status (128 + signal when it was killed); nothing: it still runs after `timeout_ms`.
  std::optional<int> Wait(int timeout_ms);
  void Kill();

  // Output of program and emulator so far.
  std::string output() const;
  pid_t pid() const { return pid_; }
  int pidfd() const { return pidfd_; }  // readable: it has ended

 private:
  QemuProcess(pid_t pid, int pidfd, std::string output_path)
      : pid_(pid), pidfd_(pidfd), output_path_(std::move(output_path)) {}

  const pid_t pid_;
  const int pidfd_;
  const std::string output_path_;
  std::optional<int> status_;
};

// Runs a program to its end.
struct QemuRun {
  int status = 0;
  std::string output;
};
base::Result<QemuRun> RunImage(const QemuProcess::Options& options, int timeout_ms);

}  // namespace omni::hil
