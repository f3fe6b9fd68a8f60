#include "service/tools/device/device.h"

#include <cstdio>

#include <nlohmann/json.hpp>

#include "firmware/wire/names.h"
#include "service/device/base_notes.h"
#include "service/protocol/text.h"
#include "service/tools/common/output.h"

namespace omni::tools {
namespace {

using nlohmann::json;

std::string HeldLine(const char* title, const std::string& text) {
  char head[24];
  std::snprintf(head, sizeof head, "%-12s ", title);
  return head + text + "\n";
}

// The service names its base's faults as in firmware/wire/names.h.
std::string HeldFaults(const json& faults) {
  std::string names, advice;
  for (const json& fault : faults) {
    const std::string name = fault.is_string() ? protocol::Printable(fault.get<std::string>()) : fault.dump();
    names += (names.empty() ? "" : ", ") + name;
    for (const wire::FaultText& row : wire::FaultTexts()) {
      if (name == row.name) advice += HeldLine("", name + ": " + row.advice);
    }
  }
  return HeldLine("faults", names.empty() ? "none" : names) + advice;
}

}  // namespace

std::string DeviceHeldText(const std::vector<device::Holder>& holders) {
  return HeldLine("held by", device::HoldersText(holders));
}

std::string DeviceServedText(const base::Result<json>& status, const device::UsbBase& base) {
  if (!status.ok()) return HeldLine("omnid", "gives no status: " + status.error());
  const std::string serial = TextAt(*status, "/device/serial");
  if (serial != base.serial)
    return HeldLine("omnid", "gives no status of this base: the omnid that answers has another base");
  std::string text = HeldLine("state", TextAt(*status, "/device/state"));
  text += HeldFaults(ArrayAt(*status, "/device/faults"));
  if (TrueAt(*status, "/device/waits_for_person")) {
    text += HeldLine("", device::kWaitsForPersonText);
  }
  return text + HeldLine("telemetry", TextAt(*status, "/device/received") + " frames received, " +
                                          TextAt(*status, "/device/missed") + " lost, " +
                                          TextAt(*status, "/device/bad_frames") + " bad");
}

std::string DeviceFreeItText(bool is_service) {
  return HeldLine("to see more", is_service ? "stop omnid (`systemctl --user stop omnid`, or Ctrl-C where it runs) for "
                                              "supply, temperatures and the kept fault"
                                            : "stop that program: only one program at a time can read the base");
}

}  // namespace omni::tools
