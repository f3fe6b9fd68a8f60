#include "service/device/base_notes.h"

#include <algorithm>
#include <cstdio>
#include <cstring>

#include "firmware/wire/names.h"

namespace omni::device {

wire::Status BaseNotes::Add(const wire::FrameView& view) noexcept {
  BaseNote note;
  note.type = view.header.type;
  const wire::Status status =
      note.type == wire::MessageType::kFault ? wire::Decode(view, note.fault) : wire::Decode(view, note.log);
  if (status != wire::Status::kOk) return status;
  note.lost_before = lost_;
  lost_ = ring_.TryPush(note) ? 0 : lost_ + 1;
  return status;
}

std::string FaultPlaceText(const wire::FaultEvent& event) {
  const wire::FaultText* words = wire::FindFault(event.fault);
  const char* part = words != nullptr ? words->part : "part";
  const char* unit = words != nullptr ? words->unit : "";
  std::string text;
  if (event.part != wire::kWholeBase && part[0] != '\0') {
    text += " at " + std::string(part) + " " + std::to_string(event.part);
  }
  if (unit[0] != '\0') {
    char value[48];
    std::snprintf(value, sizeof value, ", %.4g %s", static_cast<double>(event.value), unit);
    text += value;
  }
  return text;
}

std::string FaultEventText(const wire::FaultEvent& event) {
  char when[64];
  std::snprintf(when, sizeof when, ", in state %s, %.3f s after its start", wire::StateName(event.state),
                1e-6 * static_cast<double>(event.t_us));
  return wire::FaultName(event.fault) + FaultPlaceText(event) + when;
}

std::string PrintableText(const char* text, std::size_t size) {
  std::string clean(text, strnlen(text, size));
  std::replace_if(
      clean.begin(), clean.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return clean;
}

}  // namespace omni::device
