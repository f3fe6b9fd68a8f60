#include <algorithm>
#include <ostream>

#include <nlohmann/json.hpp>

#include "service/console/wrap.h"
#include "service/tools/common/command_line.h"
#include "service/tools/common/output.h"
#include "service/tools/common/service_link.h"
#include "service/tools/device/device.h"

namespace omni::tools {
namespace {

using nlohmann::ordered_json;

constexpr const char* kServiceName = "omnid";   // as in /proc/PID/comm
constexpr std::uint8_t kReasonCommandLine = 1;  // for the base's fault record

base::Result<device::UsbBase> ChooseBase(device::UsbBus& bus, const std::string& serial) {
  const base::Result<std::vector<device::UsbBase>> bases = bus.ListBases();
  if (!bases.ok()) return base::Error{bases.error()};
  base::Result<device::UsbBase> chosen = device::ChooseUsbBase(*bases, serial);
  if (chosen.ok() && !chosen->problem.empty()) {
    return base::Error{device::UsbBaseName(*chosen) + ": " + chosen->problem};
  }
  return chosen;
}

std::string FirmwareOf(device::UsbBus& bus, const device::UsbBase& base) {
  if (!base.problem.empty()) return {};
  const base::Result<wire::Hello> hello = device::AskUsbHello(bus, base);
  return hello.ok() ? FirmwareText(hello->firmware_version) : std::string();
}

// Where the facts go, as JSON or as text.
struct Output {
  const char* command;
  bool as_json;
  std::ostream& out;

  void Show(const ordered_json& facts, const std::string& text) const {
    if (as_json) {
      WriteJson(out, facts);
    } else {
      out << console::ForPeople(text);
    }
  }
  int Failed(const std::string& error) const {
    if (as_json) Show({{"error", error}}, "");
    return Fail(command, error);
  }
};

}  // namespace

int DeviceList(device::UsbBus& bus, bool as_json, std::ostream& out) {
  const Output output{"omni device list", as_json, out};
  const base::Result<std::vector<device::UsbBase>> bases = bus.ListBases();
  if (!bases.ok()) return output.Failed(bases.error());
  if (bases->empty()) return output.Failed("no Omni base on USB: connect it and switch its supply on");
  std::vector<ListedBase> listed;
  for (const device::UsbBase& base : *bases) {
    listed.push_back({.base = base, .firmware = FirmwareOf(bus, base), .holders = device::HoldersOf(base.node)});
  }
  output.Show(DeviceListJson(listed), DeviceListText(listed));
  return kExitOk;
}

OtherPrograms ThoseOfThisMachine() {
  return {.holders = [](const std::string& node) { return device::HoldersOf(node); },
          .service_status = [] { return FetchStatus(""); }};
}

int DeviceInfo(device::UsbBus& bus, const std::string& serial, bool as_json, std::ostream& out,
               const OtherPrograms& others) {
  const Output output{"omni device info", as_json, out};
  const base::Result<device::UsbBase> base = ChooseBase(bus, serial);
  if (!base.ok()) return output.Failed(base.error());
  const base::Result<wire::Hello> hello = device::AskUsbHello(bus, *base);
  if (!hello.ok()) return output.Failed(hello.error());
  ordered_json facts = DeviceIdentityJson(*base, *hello);
  std::string text = DeviceIdentityText(*base, *hello);
  const std::vector<device::Holder> holders = others.holders(base->node);
  facts["held_by"] = HoldersJson(holders);
  if (!holders.empty()) {
    const bool is_service = std::any_of(holders.begin(), holders.end(),
                                        [](const device::Holder& holder) { return holder.name == kServiceName; });
    text += DeviceHeldText(holders);
    if (is_service) text += DeviceServedText(others.service_status(), *base);
    output.Show(facts, text + DeviceFreeItText(is_service));
    return kExitOk;
  }
  const base::Result<device::UsbProbe> probe = device::ProbeUsbBase(bus, *base, {});
  if (!probe.ok()) {
    if (!as_json) output.Show({}, text);  // what is known of it
    return output.Failed(probe.error());
  }
  facts["now"] = DeviceLiveJson(*probe);
  output.Show(facts, text + DeviceLiveText(*probe));
  return kExitOk;
}

int DeviceSelfTest(device::UsbBus& bus, const std::string& serial, const std::function<bool()>& agreed, bool as_json,
                   std::ostream& out) {
  const Output output{"omni device selftest", as_json, out};
  const base::Result<device::UsbBase> base = ChooseBase(bus, serial);
  if (!base.ok()) return output.Failed(base.error());
  if (!as_json) {
    out << console::ForPeople(
        "Listens to " + device::UsbBaseName(*base) +
        " for a second, then arms it for a moment with all currents at zero. Arming clears\n"
        "faults whose cause is gone. Move the pen and other magnets a metre away, and check that all looks well.\n");
  }
  if (!agreed()) return output.Failed("cancelled");
  const base::Result<device::UsbProbe> probe =
      device::ProbeUsbBase(bus, *base, {.listen_ns = 1'000'000'000, .arm = true});
  if (!probe.ok()) return output.Failed(probe.error());
  const std::vector<SelfTestRow> rows = JudgeSelfTest(*probe);
  const bool passed = std::all_of(rows.begin(), rows.end(), [](const SelfTestRow& row) { return row.passed; });
  ordered_json facts = DeviceIdentityJson(*base, probe->hello);
  facts["now"] = DeviceLiveJson(*probe);
  facts["tests"] = SelfTestJson(rows);
  facts["passed"] = passed;
  output.Show(facts, DeviceIdentityText(*base, probe->hello) + DeviceLiveText(*probe) + SelfTestText(rows));
  return passed ? kExitOk : Fail(output.command, "failed; see the FAIL lines above");
}

int DeviceEstop(device::UsbBus& bus, const std::string& serial, std::ostream& out) {
  const base::Result<std::vector<device::UsbBase>> bases = bus.ListBases();
  if (!bases.ok()) return Fail("omni device estop", bases.error());
  int meant = 0;
  std::string problems;
  for (const device::UsbBase& base : *bases) {
    if (!serial.empty() && base.serial != serial) continue;
    ++meant;
    const base::Status stopped = base.problem.empty() ? device::StopUsbBase(bus, base, kReasonCommandLine)
                                                      : base::Error{device::UsbBaseName(base) + ": " + base.problem};
    if (stopped.ok()) {
      out << console::ForPeople(device::UsbBaseName(base) + ": stopped; `omni device selftest` arms it again\n");
    } else {
      problems += (problems.empty() ? "" : "; ") + stopped.error();
    }
  }
  if (meant == 0) problems = "no Omni base" + (serial.empty() ? "" : " with serial " + serial) + " on USB";
  return problems.empty() ? kExitOk
                          : Fail("omni device estop", "NOT STOPPED, switch the coils' supply off: " + problems);
}

}  // namespace omni::tools
