// Whether this computer keeps up with the base: ticks that come late, and scans that a newer one had overtaken before
// they were read. A hand may feel that as a rough surface, and no other figure names the cause.
#pragma once

#include <cstdint>

namespace omni::daemon {

// Turns counts into a verdict, span by span: it is given after some seconds of one kind, and taken back likewise.
class HostWatch {
 public:
  static constexpr std::int64_t kSpan_ns = 2'000'000'000;
  static constexpr std::uint64_t kTicksMin = 100;  // in a span; without a client there are about 125
  static constexpr int kSpans = 3;                 // of one kind in a row
  static constexpr double kStarvedAbove = 0.01;    // share of a span's ticks
  static constexpr double kFineBelow = 0.002;

  // Call now and then, with counts that only grow: ticks, those that were late, scans that were overtaken. True: the
  // verdict has changed.
  bool Update(std::uint64_t ticks, std::uint64_t late, std::uint64_t superseded, std::int64_t now_ns) noexcept {
    const std::uint64_t bad = late + superseded;
    if (begin_ns_ == 0) Begin(ticks, bad, now_ns);
    if (now_ns - begin_ns_ < kSpan_ns) return false;
    const std::uint64_t passed = ticks - ticks_, missed = bad - bad_;
    Begin(ticks, bad, now_ns);
    if (passed < kTicksMin) return false;
    share_ = static_cast<double>(missed) / static_cast<double>(passed);
    const bool other = starved_ ? share_ < kFineBelow : share_ > kStarvedAbove;
    spans_ = other ? spans_ + 1 : 0;
    if (spans_ < kSpans) return false;
    starved_ = !starved_;
    spans_ = 0;
    return true;
  }
  bool starved() const noexcept { return starved_; }
  double share() const noexcept { return share_; }  // of the last span that counted

 private:
  void Begin(std::uint64_t ticks, std::uint64_t bad, std::int64_t now_ns) noexcept {
    ticks_ = ticks;
    bad_ = bad;
    begin_ns_ = now_ns;
  }

  std::uint64_t ticks_ = 0, bad_ = 0;  // at the span's begin
  std::int64_t begin_ns_ = 0;
  bool starved_ = false;
  int spans_ = 0;  // that speak against it, in a row
  double share_ = 0;
};

}  // namespace omni::daemon
