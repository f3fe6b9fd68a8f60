// Tells people about a base's faults and what it says of itself: each fault once when it comes, with where, what was
// measured and what to do, and when they are over; its own messages, but not more than people can read.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "service/device/transport.h"

namespace omni::daemon {

struct FaultLine {
  bool is_problem = false;  // else good news
  std::string text;
};

// So many lines at once, and so many a second after that.
class LineRate {
 public:
  static constexpr int kBurst = 10;
  static constexpr std::int64_t kPeriod_ns = 1'000'000'000;

  bool Allows(std::int64_t now_ns) noexcept;

 private:
  int tokens_ = kBurst;
  std::int64_t filled_ns_ = 0;
};

class FaultLog {
 public:
  // What the base said, in its order; before News.
  void Hear(const device::BaseNote& note, std::int64_t now_ns);
  // What is new since the last call.
  std::vector<FaultLine> News(const device::TransportState& state);

 private:
  struct Heard {
    wire::FaultEvent event;
    std::int64_t t_ns = 0;
    bool waits = true;  // for telemetry that shows it, one call long
  };
  void HearFault(const wire::FaultEvent& event, std::int64_t now_ns);
  void Say(bool is_problem, std::string text, std::int64_t now_ns);
  // Where and what of a fault, once.
  std::string TakePlace(std::uint32_t fault);

  static constexpr std::size_t kHeardMax = 32;  // one a bit; a base that invents more says nothing more

  device::TransportState last_;
  std::vector<Heard> heard_;
  std::vector<FaultLine> lines_;
  LineRate rate_;
  std::uint64_t left_out_ = 0;
};

}  // namespace omni::daemon
