// A base's FAULT and LOG frames, which arrive between telemetry: queued until they are read, and formatted as text.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "firmware/wire/messages.h"
#include "service/base/handover.h"

namespace omni::device {

struct BaseNote {
  wire::MessageType type = wire::MessageType::kLog;  // kFault or kLog: which of the two is filled
  wire::FaultEvent fault;
  wire::Log log;
  std::uint64_t lost_before = 0;  // notes lost to a full queue since the previous one
};

// From the thread that receives frames to the one that logs them. When full, the newest is lost and counted.
class BaseNotes {
 public:
  static constexpr std::size_t kCapacity = 64;

  // A FAULT or LOG frame; other frames are refused. No allocation.
  wire::Status Add(const wire::FrameView& view) noexcept;
  // False: there is none.
  bool Pop(BaseNote& note) noexcept { return ring_.TryPop(note); }

 private:
  base::SpscRing<BaseNote, kCapacity> ring_;
  std::uint64_t lost_ = 0;
};

// "over temperature at coil 2, 71.5 C, in state armed, 12.346 s after its start"
std::string FaultEventText(const wire::FaultEvent& event);
// Where, and what was measured: " at coil 2, 71.5 C"; empty if neither applies.
std::string FaultPlaceText(const wire::FaultEvent& event);

// The user's message for TransportState::waits_for_person.
inline constexpr const char* kWaitsForPersonText =
    "its coils stay off until you have checked it: stop omnid, then run `omni device selftest`";

// Text from outside made safe for terminals and logs: all but printable ASCII becomes '?'. Ends at a zero.
std::string PrintableText(const char* text, std::size_t size);

}  // namespace omni::device
