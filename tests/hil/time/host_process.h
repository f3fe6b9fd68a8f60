// An unmodified program: the one that talks to the emulated base, or an application of it. It ends with us, whatever
// happens to us.
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

#include "service/base/result.h"

namespace omni::hil {

class HostProcess {
 public:
  // Arguments as of main; the first is found along PATH. Its output is ours. `environment`: "NAME=value", added to
  // ours.
  static base::Result<HostProcess> Start(const std::vector<std::string>& arguments,
                                         const std::vector<std::string>& environment);
  HostProcess(HostProcess&& other) noexcept;
  HostProcess& operator=(HostProcess&&) = delete;
  ~HostProcess();  // kills it

  pid_t pid() const { return pid_; }
  void Signal(int signal);

  // Its exit status, or 128 + signal, once it has ended.
  std::optional<int> Ended();

  // Asks it to end; it goes on if it was stopped.
  void Ask();
  // Ends it; its exit status as above.
  int Kill();

 private:
  explicit HostProcess(pid_t pid) : pid_(pid) {}
  pid_t pid_;
  std::optional<int> status_;
};

}  // namespace omni::hil
