// An unmodified program: the host of the emulated base, or an application. It ends with this process in any case.
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

#include "service/base/result.h"

namespace omni::hil {

class HostProcess {
 public:
  // Arguments as of main; the first is found along PATH. It shares our output. `environment`: "NAME=value", additional.
  static base::Result<HostProcess> Start(const std::vector<std::string>& arguments,
                                         const std::vector<std::string>& environment);
  HostProcess(HostProcess&& other) noexcept;
  HostProcess& operator=(HostProcess&&) = delete;
  ~HostProcess();  // kills it

  pid_t pid() const { return pid_; }
  void Signal(int signal);

  // Its exit status, or 128 + signal, once it has ended.
  std::optional<int> Ended();

  // Requests it to end, and continues it if it was stopped.
  void Ask();
  // Ends it; its exit status as above.
  int Kill();

 private:
  explicit HostProcess(pid_t pid) : pid_(pid) {}
  pid_t pid_;
  std::optional<int> status_;
};

}  // namespace omni::hil
