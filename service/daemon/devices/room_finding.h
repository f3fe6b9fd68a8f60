// What is wrong with a sensor or with the room, in words for people. docs/protocol/ipc.md has the kinds
#pragma once

#include <string>
#include <vector>

namespace omni::daemon {

struct RoomFinding {
  std::string kind;
  std::vector<int> sensors;  // that it is about
  std::string what, fix;     // `fix`: what to do
  bool operator==(const RoomFinding&) const = default;
};

inline std::string RoomText(const RoomFinding& finding) { return finding.what + "; " + finding.fix; }

}  // namespace omni::daemon
