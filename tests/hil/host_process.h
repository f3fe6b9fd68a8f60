// The unmodified program that talks to the emulated base. It ends with us, whatever happens to us.
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

#include "service/base/result.h"

namespace omni::hil {

class HostProcess {
 public:
  // Arguments as of main; the first is found along PATH. Its output is ours.
  static base::Result<HostProcess> Start(const std::vector<std::string>& arguments);
  HostProcess(HostProcess&& other) noexcept;
  HostProcess& operator=(HostProcess&&) = delete;
  ~HostProcess() { Stop(); }

  pid_t pid() const { return pid_; }
  void Signal(int signal);

  // Its exit status, or 128 + signal, once it has ended.
  std::optional<int> Ended();

  // Asks it to end, after 3 s insists.
  int Stop();

 private:
  explicit HostProcess(pid_t pid) : pid_(pid) {}
  pid_t pid_;
  std::optional<int> status_;
};

}  // namespace omni::hil
