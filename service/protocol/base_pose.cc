#include "service/protocol/base_pose.h"

#include <cmath>

namespace omni::protocol {

const char* PoseProblem(const WirePose& pose) noexcept {
  for (const double x : pose.position_m) {
    if (!(std::abs(x) <= kFarthestBase_m)) return "position_m is not within 100 m";
  }
  double norm2 = 0;
  for (const double x : pose.orientation_wxyz) norm2 += x * x;
  return norm2 >= 0.99 && norm2 <= 1.01 ? nullptr : "orientation_wxyz is not a unit quaternion";
}

}  // namespace omni::protocol
