// Whether the tracker's poses explain the sensors' readings while a magnet is near. They do not with a calibration of
// another base, or of a base that was changed since, or with a second magnet beside the pen.
#pragma once

#include <cstdint>

#include "service/room/verdict.h"

namespace omni::room {

// Turns counts of loop::FitStatistics into a verdict, second by second. Seconds without a pen leave the verdict as it
// is.
class FitWatch {
 public:
  // Without a client there are about 62 ticks in a span. A calibration that fits leaves almost none unexplained.
  static constexpr SpanRule kRule{
      .span_ns = 1'000'000'000, .least = 20, .spans = 3, .bad_above = 0.1, .good_below = 0.02};

  // Call now and then. True: the verdict has changed.
  bool Update(std::uint64_t explained, std::uint64_t contradicted, std::int64_t now_ns) noexcept {
    return verdict_.Update(explained + contradicted, contradicted, now_ns);
  }
  bool misfit() const noexcept { return verdict_.bad(); }
  double share() const noexcept { return verdict_.share(); }  // without an explanation, of the last span that counted

 private:
  SpanVerdict verdict_{kRule};
};

}  // namespace omni::room
