#include "service/protocol/hand_aim.h"

#include <cmath>
#include <cstring>

#include "service/protocol/sample_range.h"

namespace omni::protocol {

bool ReadHandAim(const void* bytes, std::size_t size, HandAim& aim) noexcept {
  if (size != sizeof(HandAim)) return false;
  HandAim read;
  std::memcpy(&read, bytes, sizeof(read));
  if (read.magic != kHandMagic || read.version != kHandVersion || read.present > 1) return false;
  for (const double x : read.tip_base_m) {
    if (!(std::abs(x) <= kHandReach_m)) return false;
  }
  const auto& u = read.axis_base;
  if (!(std::abs(u[0] * u[0] + u[1] * u[1] + u[2] * u[2] - 1) <= kUnitTolerance)) return false;
  aim = read;
  return true;
}

}  // namespace omni::protocol
