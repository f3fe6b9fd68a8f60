// The subcommands of `omni device` on any bus; device_command.cc adds them to the command line.
#pragma once

#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "service/base/result.h"
#include "service/device/usb/usb_bus.h"
#include "service/device/usb/usb_probe.h"

namespace omni::tools {

// All return an exit status (command_line.h); errors go to stderr as one line. `as_json`: `out` gets JSON, also
// of an error.

int DeviceList(device::UsbBus& bus, bool as_json, std::ostream& out);

// Which programs hold the base, and the service's status; fabricated in tests.
struct OtherPrograms {
  std::function<std::vector<device::Holder>(const std::string& node)> holders;
  std::function<base::Result<nlohmann::json>()> service_status;
};
OtherPrograms ThoseOfThisMachine();

// `serial` empty: the only base there is. If omnid holds the base, shows what omnid knows.
int DeviceInfo(device::UsbBus& bus, const std::string& serial, bool as_json, std::ostream& out,
               const OtherPrograms& others = ThoseOfThisMachine());

// `agreed` is called before anything is done to the base; false cancels.
int DeviceSelfTest(device::UsbBus& bus, const std::string& serial, const std::function<bool()>& agreed, bool as_json,
                   std::ostream& out);

// `serial` empty: every base, because an emergency stop must not ask which one.
int DeviceEstop(device::UsbBus& bus, const std::string& serial, std::ostream& out);

// What `omni device` prints about a base.

inline constexpr double kResistanceUnit_ohm = 1e-4;  // of wire::Telemetry

struct ListedBase {
  device::UsbBase base;
  std::string firmware;  // "0.1"; empty: unknown
  std::vector<device::Holder> holders;
};
// "0.1"
std::string FirmwareText(std::uint16_t version);
std::string DeviceListText(const std::vector<ListedBase>& bases);

// Its identity and capabilities.
std::string DeviceIdentityText(const device::UsbBase& base, const wire::Hello& hello);
// Its current measurements, its faults with advice, and the fault kept across its last reset.
std::string DeviceLiveText(const device::UsbProbe& probe);

// One finding of `omni device selftest`.
struct SelfTestRow {
  std::string name;
  bool passed = false;
  std::string text;
};
std::vector<SelfTestRow> JudgeSelfTest(const device::UsbProbe& probe);
std::string SelfTestText(const std::vector<SelfTestRow>& rows);

std::string FlashHelpText();

// What `omni device --json` prints about a base: the same facts as the texts, SI units.

// An array, one object per base.
nlohmann::ordered_json DeviceListJson(const std::vector<ListedBase>& bases);

// Its identity and capabilities.
nlohmann::ordered_json DeviceIdentityJson(const device::UsbBase& base, const wire::Hello& hello);

// Its current measurements, its faults with advice, and the fault kept across its last reset.
nlohmann::ordered_json DeviceLiveJson(const device::UsbProbe& probe);

nlohmann::ordered_json HoldersJson(const std::vector<device::Holder>& holders);

nlohmann::ordered_json SelfTestJson(const std::vector<SelfTestRow>& rows);

// What `omni device info` prints about a base that another program holds.
std::string DeviceHeldText(const std::vector<device::Holder>& holders);

// What omnid knows of `base`: state, faults with advice; or why that is not available. `status`: of FetchStatus.
std::string DeviceServedText(const base::Result<nlohmann::json>& status, const device::UsbBase& base);

// What to do to see the rest.
std::string DeviceFreeItText(bool is_service);

}  // namespace omni::tools
