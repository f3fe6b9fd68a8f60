// Force limit of a device that can produce two newtons in every direction.
#pragma once

#include "service/base/force_limit.h"

namespace omni::test {

inline base::ForceLimit UsualLimit() {
  base::ForceLimit limit;
  limit.valid = true;
  limit.ampere_per_newton = {5, 0, 0, 0, 5, 0, 0, 0, 5};
  limit.current_max_A = {15, 15, 15};
  limit.force_max_N = 2;
  return limit;
}

}  // namespace omni::test
