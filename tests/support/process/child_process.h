// Child processes of the tools: start them with extra environment, end them reliably, count their system calls.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>
#include <vector>

#include "service/base/result.h"

namespace omni::test {

using Environment = std::vector<std::string>;  // "NAME=value", added to ours; "NAME=" removes

class ChildProcess {
 public:
  // stdout goes to `output_path` if not empty.
  static base::Result<ChildProcess> Start(const std::vector<std::string>& arguments, const Environment& environment,
                                          const std::string& output_path = {});
  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess& operator=(ChildProcess&&) = delete;
  ~ChildProcess();  // SIGTERM, after 2 s SIGKILL

  // Exit status; 128 + signal when killed.
  int Wait();
  pid_t pid() const { return pid_; }

 private:
  explicit ChildProcess(pid_t pid) : pid_(pid) {}
  pid_t pid_;
};

// Runs a program under ptrace and returns how many system calls its main thread made between successive calls of
// getppid() (the marker): n markers give n - 1 counts.
base::Result<std::vector<std::uint64_t>> CountSystemCalls(const std::vector<std::string>& arguments,
                                                          const Environment& environment);

}  // namespace omni::test
