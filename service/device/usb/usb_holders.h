// Which processes have a device node open, for messages.
#pragma once

#include <string>
#include <vector>

namespace omni::device {

struct Holder {
  int pid = 0;
  std::string name;
};

// Except this process. Other users' processes are visible to root only. `proc`: where /proc is.
std::vector<Holder> HoldersOf(const std::string& node, const std::string& proc = "/proc");

// "omnid (pid 12), omni (pid 15)"; empty: none visible.
std::string HoldersText(const std::vector<Holder>& holders);

}  // namespace omni::device
