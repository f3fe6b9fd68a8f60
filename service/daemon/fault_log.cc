#include "service/daemon/fault_log.h"

#include "firmware/wire/names.h"

namespace omni::daemon {

std::vector<FaultLine> FaultLog::News(const device::TransportState& state) {
  std::vector<FaultLine> news;
  // Those of the host come and go with every start and are mended by arming.
  const std::uint32_t now = state.faults & ~wire::kFaultsOfTheHost;
  const std::uint32_t before = last_.faults & ~wire::kFaultsOfTheHost;
  for (const wire::FaultText& fault : wire::Faults()) {
    if ((now & ~before & fault.fault) == 0) continue;
    news.push_back({true, std::string(fault.name) + ": " + fault.meaning + ". " + fault.advice});
  }
  if (now == 0 && before != 0) news.push_back({false, "no fault any more"});
  if (state.waits_for_person && !last_.waits_for_person) {
    news.push_back({true, "its coils stay off until a person has looked: end omnid, then `omni device selftest`"});
  }
  last_ = state;
  return news;
}

}  // namespace omni::daemon
