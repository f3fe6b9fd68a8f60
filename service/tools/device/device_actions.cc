#include <algorithm>
#include <ostream>

#include <nlohmann/json.hpp>

#include "service/console/wrap.h"
#include "service/tools/common/command_line.h"
#include "service/tools/common/service_link.h"
#include "service/tools/device/device_command.h"
#include "service/tools/device/device_held.h"
#include "service/tools/device/device_text.h"

namespace omni::tools {
namespace {

constexpr const char* kServiceName = "omnid";   // as in /proc/PID/comm
constexpr std::uint8_t kReasonCommandLine = 1;  // for the base's fault record

base::Result<device::UsbBase> ChooseBase(device::UsbBus& bus, const std::string& serial) {
  const base::Result<std::vector<device::UsbBase>> bases = bus.List();
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

}  // namespace

int DeviceList(device::UsbBus& bus, std::ostream& out) {
  const base::Result<std::vector<device::UsbBase>> bases = bus.List();
  if (!bases.ok()) return Fail("omni device list", bases.error());
  if (bases->empty()) {
    return Fail("omni device list", "no Omni base on USB: connect it and switch its supply on");
  }
  std::vector<ListedBase> listed;
  for (const device::UsbBase& base : *bases) {
    listed.push_back({.base = base, .firmware = FirmwareOf(bus, base), .holders = device::HoldersOf(base.node)});
  }
  out << console::ForPeople(DeviceListText(listed));
  return kExitOk;
}

OtherPrograms ThoseOfThisMachine() {
  return {.holders = [](const std::string& node) { return device::HoldersOf(node); },
          .service_status = [] { return FetchStatus(""); }};
}

int DeviceInfo(device::UsbBus& bus, const std::string& serial, std::ostream& out, const OtherPrograms& others) {
  const base::Result<device::UsbBase> base = ChooseBase(bus, serial);
  if (!base.ok()) return Fail("omni device info", base.error());
  const base::Result<wire::Hello> hello = device::AskUsbHello(bus, *base);
  if (!hello.ok()) return Fail("omni device info", hello.error());
  out << console::ForPeople(DeviceIdentityText(*base, *hello));
  if (const std::vector<device::Holder> holders = others.holders(base->node); !holders.empty()) {
    const bool is_service = std::any_of(holders.begin(), holders.end(),
                                        [](const device::Holder& holder) { return holder.name == kServiceName; });
    out << console::ForPeople(DeviceHeldText(holders));
    if (is_service) out << console::ForPeople(DeviceServedText(others.service_status(), *base));
    out << console::ForPeople(DeviceFreeItText(is_service));
    return kExitOk;
  }
  const base::Result<device::UsbProbe> probe = device::ProbeUsbBase(bus, *base, {});
  if (!probe.ok()) return Fail("omni device info", probe.error());
  out << console::ForPeople(DeviceLiveText(*probe));
  return kExitOk;
}

int DeviceSelfTest(device::UsbBus& bus, const std::string& serial, const std::function<bool()>& agreed,
                   std::ostream& out) {
  const base::Result<device::UsbBase> base = ChooseBase(bus, serial);
  if (!base.ok()) return Fail("omni device selftest", base.error());
  out << console::ForPeople(
      "Listens to " + device::UsbBaseName(*base) +
      " for a second, then arms it for a moment with all currents at zero. Arming clears\n"
      "faults whose cause is gone. Move the pen and other magnets a metre away, and check that all looks well.\n");
  if (!agreed()) return Fail("omni device selftest", "cancelled");
  const base::Result<device::UsbProbe> probe =
      device::ProbeUsbBase(bus, *base, {.listen_ns = 1'000'000'000, .arm = true});
  if (!probe.ok()) return Fail("omni device selftest", probe.error());
  const std::vector<SelfTestRow> rows = JudgeSelfTest(*probe);
  out << console::ForPeople(DeviceIdentityText(*base, probe->hello) + DeviceLiveText(*probe) + SelfTestText(rows));
  const bool passed = std::all_of(rows.begin(), rows.end(), [](const SelfTestRow& row) { return row.passed; });
  return passed ? kExitOk : Fail("omni device selftest", "failed; see the FAIL lines above");
}

int DeviceEstop(device::UsbBus& bus, const std::string& serial, std::ostream& out) {
  const base::Result<std::vector<device::UsbBase>> bases = bus.List();
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
