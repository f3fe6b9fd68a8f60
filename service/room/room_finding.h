// What is wrong with a sensor or with the room, in words for people. docs/protocol/ipc.md has the kinds
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "service/base/vec.h"

namespace omni::room {

struct RoomFinding {
  std::string kind;
  std::vector<int> sensors;  // that it is about
  std::string what, fix;     // `fix`: what to do
  bool operator==(const RoomFinding&) const = default;
};

// Of the earth and the room, about the base.
struct RoomField {
  base::Vec3 field_base_T;
  std::int64_t second_ns = 0;  // the second it is of
};

inline std::string RoomText(const RoomFinding& finding) { return finding.what + "; " + finding.fix; }

}  // namespace omni::room
