#include "service/tracker/solve/frozen.h"

#include <algorithm>

namespace omni::tracker {

int FindFrozen(const base::HallScan& scan, int times_min, Repetition& repetition) noexcept {
  int frozen = -1, repeating = 0, changed = 0;
  for (std::size_t i = 0; i < repetition.times.size(); ++i) {
    if (((scan.fresh_mask >> i) & 1u) == 0) continue;
    int& times = repetition.times[i];
    times = scan.field_sensor_T[i] == repetition.last_T[i] ? std::min(times + 1, times_min) : 0;
    repetition.last_T[i] = scan.field_sensor_T[i];
    repeating += times > 0 ? 1 : 0;
    changed += times == 0 ? 1 : 0;
    if (times >= times_min) frozen = static_cast<int>(i);
  }
  return repeating == 1 && changed > 0 ? frozen : -1;
}

bool IsAllFrozen(const base::HallScan& scan, int times_min, const Repetition& repetition) noexcept {
  bool some = false;
  for (std::size_t i = 0; i < repetition.times.size(); ++i) {
    if (((scan.fresh_mask >> i) & 1u) == 0) continue;
    if (repetition.times[i] < times_min) return false;
    some = true;
  }
  return some;
}

}  // namespace omni::tracker
