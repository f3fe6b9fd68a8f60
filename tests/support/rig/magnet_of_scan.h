// Where the magnet truly was when a scan was taken: an instant between two rows of the twin's record.
#pragma once

#include <algorithm>
#include <cstdint>

#include "service/base/vec.h"
#include "service/sim/twin/recording.h"

namespace omni::support {

class MagnetOfScan {
 public:
  explicit MagnetOfScan(const sim::TruthRow& before) : before_(before) {}

  // Its centre, m, frame B. Once per tick, with the row after it.
  base::Vec3 At(std::int64_t t_ns, const sim::TruthRow& now) {
    const double whole_ns = static_cast<double>(std::max<std::int64_t>(1, now.t_ns - before_.t_ns));
    const double share = std::clamp(static_cast<double>(t_ns - before_.t_ns) / whole_ns, 0.0, 1.0);
    const base::Vec3 centre_m = before_.magnet_m + share * (now.magnet_m - before_.magnet_m);
    before_ = now;
    return centre_m;
  }

 private:
  sim::TruthRow before_;
};

}  // namespace omni::support
