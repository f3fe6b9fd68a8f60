// Whether this computer keeps up with the base: ticks that come late, and scans that a newer one had overtaken before
// they were read. A hand may feel that as a rough surface, and no other figure names the cause.
#pragma once

#include <cstdint>

#include "service/room/verdict.h"

namespace omni::daemon {

class HostWatch {
 public:
  // Without a client there are about 125 ticks in a span.
  static constexpr room::SpanRule kRule{
      .span_ns = 2'000'000'000, .least = 100, .spans = 3, .bad_above = 0.01, .good_below = 0.002};

  // Call now and then, with counts that only grow: ticks, those that were late, scans that were overtaken. True: the
  // verdict has changed.
  bool Update(std::uint64_t ticks, std::uint64_t late, std::uint64_t superseded, std::int64_t now_ns) noexcept {
    return verdict_.Update(ticks, late + superseded, now_ns);
  }
  bool starved() const noexcept { return verdict_.bad(); }
  double share() const noexcept { return verdict_.share(); }  // of the last span that counted

 private:
  room::SpanVerdict verdict_{kRule};
};

}  // namespace omni::daemon
