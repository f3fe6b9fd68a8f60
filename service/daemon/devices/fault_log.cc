#include "service/daemon/devices/fault_log.h"

#include <algorithm>
#include <utility>

#include "firmware/wire/names.h"

namespace omni::daemon {
namespace {

std::string FaultLineText(const wire::FaultText& fault, const std::string& place) {
  return std::string(fault.name) + place + ": " + fault.meaning + ". " + fault.advice;
}

}  // namespace

bool LineRate::Allows(std::int64_t now_ns) noexcept {
  const std::int64_t due = std::max<std::int64_t>(0, now_ns - filled_ns_) / kPeriod_ns;
  if (due > 0) {
    tokens_ = static_cast<int>(std::min<std::int64_t>(kBurst, tokens_ + due));
    filled_ns_ = now_ns;
  }
  if (tokens_ == 0) return false;
  --tokens_;
  return true;
}

void FaultLog::Say(bool is_problem, std::string text, std::int64_t now_ns) {
  if (!rate_.Allows(now_ns)) {
    ++left_out_;
    return;
  }
  if (left_out_ != 0) lines_.push_back({false, std::to_string(left_out_) + " messages of the base were left out"});
  left_out_ = 0;
  lines_.push_back({is_problem, std::move(text)});
}

void FaultLog::AddNote(const device::BaseNote& note, std::int64_t now_ns) {
  left_out_ += note.lost_before;
  if (note.type == wire::MessageType::kFault) {
    HearFault(note.fault, now_ns);
    return;
  }
  Say(note.log.level >= wire::LogLevel::kWarning,
      "message: " + device::PrintableText(note.log.text, std::min<std::size_t>(note.log.size, sizeof note.log.text)),
      now_ns);
}

void FaultLog::HearFault(const wire::FaultEvent& event, std::int64_t now_ns) {
  if (event.fault == 0) return;  // "none", the answer to a query
  if (event.after_reset != 0) {
    Say(false, "kept from before its last reset: " + device::FaultEventText(event), now_ns);
  } else if ((event.fault & wire::kFaultsOfTheHost) != 0) {
    Say(false, device::FaultEventText(event) + "; it is armed again automatically", now_ns);
  } else if (heard_.size() < kHeardMax) {
    TakePlace(event.fault);  // the newer one counts
    heard_.push_back({event, now_ns});
  } else {
    ++left_out_;
  }
}

std::string FaultLog::TakePlace(std::uint32_t fault) {
  const auto found =
      std::find_if(heard_.begin(), heard_.end(), [&](const Heard& heard) { return heard.event.fault == fault; });
  if (found == heard_.end()) return {};
  std::string place = device::FaultPlaceText(found->event);
  heard_.erase(found);
  return place;
}

std::vector<FaultLine> FaultLog::PopLines(const device::TransportState& state) {
  std::vector<FaultLine> news = std::exchange(lines_, {});
  // Those of the host come and go with every start and are cleared by arming.
  const std::uint32_t now = state.faults & ~wire::kFaultsOfTheHost;
  const std::uint32_t before = last_.faults & ~wire::kFaultsOfTheHost;
  for (const wire::FaultText& fault : wire::FaultTexts()) {
    if ((now & ~before & fault.fault) == 0) continue;
    news.push_back({true, FaultLineText(fault, TakePlace(fault.fault))});
  }
  // A fault that telemetry does not show: gone already, or its frame was lost.
  for (const Heard& heard : heard_) {
    if (!heard.waits) Say(true, device::FaultEventText(heard.event), heard.t_ns);
  }
  for (FaultLine& line : std::exchange(lines_, {})) news.push_back(std::move(line));
  heard_.erase(std::remove_if(heard_.begin(), heard_.end(), [](const Heard& heard) { return !heard.waits; }),
               heard_.end());
  for (Heard& heard : heard_) heard.waits = false;
  if (now == 0 && before != 0) news.push_back({false, "all faults are cleared"});
  if (state.waits_for_person && !last_.waits_for_person) {
    news.push_back({true, device::kWaitsForPersonText});
  }
  last_ = state;
  return news;
}

}  // namespace omni::daemon
