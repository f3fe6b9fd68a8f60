// Log lines about a base's faults and messages: each fault once when it appears, with part, measured value and remedy,
// and when all are cleared; the base's own messages at a limited rate.
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

// A burst of kBurst lines, after that one per kPeriod_ns.
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
  // Messages of the base, in their order; call before PopLines.
  void AddNote(const device::BaseNote& note, std::int64_t now_ns);
  // New lines since the last call.
  std::vector<FaultLine> PopLines(const device::TransportState& state);

 private:
  struct Heard {
    wire::FaultEvent event;
    std::int64_t t_ns = 0;
    bool waits = true;  // for one call, for telemetry that shows it
  };
  void HearFault(const wire::FaultEvent& event, std::int64_t now_ns);
  void Say(bool is_problem, std::string text, std::int64_t now_ns);
  // Part and measured value of a fault; forgets it.
  std::string TakePlace(std::uint32_t fault);

  static constexpr std::size_t kHeardMax = 32;  // one per bit; further ones are only counted

  device::TransportState last_;
  std::vector<Heard> heard_;
  std::vector<FaultLine> lines_;
  LineRate rate_;
  std::uint64_t left_out_ = 0;
};

}  // namespace omni::daemon
