#include "tests/hil/faulty_link.h"

#include <utility>

namespace omni::hil {

void FaultyLink::Pass(Frame frame, const std::function<void(Frame)>& out) {
  ++counts_.frames;
  if (Happens(faults_.drop) || frame.empty()) {
    ++counts_.dropped;
    return;
  }
  bool twice = false;
  if (Happens(faults_.corrupt)) {
    ++counts_.corrupted;
    const std::uint64_t bit = random_.Bits() % (8 * frame.size());
    frame[bit / 8] = static_cast<std::uint8_t>(frame[bit / 8] ^ (1U << (bit % 8)));
  } else if (frame.size() > 1 && Happens(faults_.truncate)) {
    ++counts_.truncated;
    frame.resize(1 + random_.Bits() % (frame.size() - 1));
  } else if (Happens(faults_.duplicate)) {
    ++counts_.duplicated;
    twice = true;
  } else if (held_.empty() && Happens(faults_.reorder)) {
    ++counts_.reordered;
    held_ = std::move(frame);
    return;
  }
  if (twice) out(frame);
  out(std::move(frame));
  if (!held_.empty()) out(std::exchange(held_, {}));
}

}  // namespace omni::hil
