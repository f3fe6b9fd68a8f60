// Verdicts with hysteresis: of seconds, and of spans of a count.
#pragma once

#include <cstdint>
#include <optional>

namespace omni::room {

// Changes after `seconds` contrary seconds in a row.
class Verdict {
 public:
  explicit Verdict(int seconds) : seconds_(seconds) {}

  // Result of one second; empty: undecided, the verdict stays.
  void Add(std::optional<bool> so) noexcept {
    if (!so) return;
    against_ = *so != holds_ ? against_ + 1 : 0;
    if (against_ < seconds_) return;
    holds_ = !holds_;
    against_ = 0;
  }
  bool holds() const noexcept { return holds_; }

 private:
  int seconds_;
  int against_ = 0;  // seconds that speak against it, in a row
  bool holds_ = false;
};

// At least 80 % of a second's samples.
inline bool IsMostly(int some, int all) noexcept { return some > 0 && some >= 0.8 * all; }

// Turns counts that only grow into a verdict, span by span: given after some spans of one kind in a row, and taken back
// likewise. Spans with few events leave it as it is.
struct SpanRule {
  std::int64_t span_ns;
  std::uint64_t least;           // events in a span
  int spans;                     // of one kind in a row
  double bad_above, good_below;  // share of a span's events
};

class SpanVerdict {
 public:
  explicit SpanVerdict(const SpanRule& rule) noexcept : rule_(rule) {}

  // Call now and then, with all events and the bad ones so far. True: the verdict has changed.
  bool Update(std::uint64_t events, std::uint64_t bad, std::int64_t now_ns) noexcept {
    if (begin_ns_ == 0) Begin(events, bad, now_ns);
    if (now_ns - begin_ns_ < rule_.span_ns) return false;
    const std::uint64_t in_span = events - events_, bad_in_span = bad - bad_count_;
    Begin(events, bad, now_ns);
    if (in_span < rule_.least) return false;
    share_ = static_cast<double>(bad_in_span) / static_cast<double>(in_span);
    const bool other = bad_ ? share_ < rule_.good_below : share_ > rule_.bad_above;
    spans_ = other ? spans_ + 1 : 0;
    if (spans_ < rule_.spans) return false;
    bad_ = !bad_;
    spans_ = 0;
    return true;
  }
  bool bad() const noexcept { return bad_; }
  double share() const noexcept { return share_; }  // of bad events, of the last span that counted

 private:
  void Begin(std::uint64_t events, std::uint64_t bad, std::int64_t now_ns) noexcept {
    events_ = events;
    bad_count_ = bad;
    begin_ns_ = now_ns;
  }

  SpanRule rule_;
  std::uint64_t events_ = 0, bad_count_ = 0;  // at the span's begin
  std::int64_t begin_ns_ = 0;
  bool bad_ = false;
  int spans_ = 0;  // that speak against the verdict, in a row
  double share_ = 0;
};

}  // namespace omni::room
