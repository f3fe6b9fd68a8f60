// What a base says of itself between telemetry, FAULT and LOG: kept until somebody asks, and the words for it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "firmware/wire/messages.h"
#include "service/base/spsc_ring.h"

namespace omni::device {

struct BaseNote {
  wire::MessageType type = wire::MessageType::kLog;  // kFault or kLog: which of the two is filled
  wire::FaultEvent fault;
  wire::Log log;
  std::uint64_t lost_before = 0;  // notes for which there was no room since the one before
};

// From the thread that takes frames to one that tells people. Full: the newest is lost and counted.
class BaseNotes {
 public:
  static constexpr std::size_t kCapacity = 64;

  // A FAULT or LOG frame; what it refuses is no note. No allocation.
  wire::Status Add(const wire::FrameView& view) noexcept;
  // False: there is none.
  bool Take(BaseNote& note) noexcept { return ring_.TryPop(note); }

 private:
  base::SpscRing<BaseNote, kCapacity> ring_;
  std::uint64_t lost_ = 0;
};

// "over temperature at coil 2, 71.5 C, in state armed, 12.346 s after its start"
std::string FaultEventText(const wire::FaultEvent& event);
// Where, and what was measured: " at coil 2, 71.5 C"; empty where there is nothing to say.
std::string FaultPlaceText(const wire::FaultEvent& event);

// What TransportState::waits_for_person means for people.
inline constexpr const char* kWaitsForPersonText =
    "its coils stay off until a person has looked: end omnid, then `omni device selftest`";

// What came from outside, for terminals and logs: other characters than printable ASCII become '?'. Ends at a zero.
std::string PrintableText(const char* text, std::size_t size);

}  // namespace omni::device
