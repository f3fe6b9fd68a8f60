#include "service/tracker/room/field_split.h"

namespace omni::tracker {

std::array<double, 3> FarFieldAt(std::size_t shape, double x, double y, double z) noexcept {
  switch (shape) {
    case 0:
      return {1, 0, 0};
    case 1:
      return {0, 1, 0};
    case 2:
      return {0, 0, 1};
    case 3:
      return {x, -y, 0};
    case 4:
      return {x, y, -2 * z};
    case 5:
      return {y, x, 0};
    case 6:
      return {z, 0, x};
    default:
      return {0, z, y};
  }
}

}  // namespace omni::tracker
