// omni device list|info|selftest|flash-help|estop: bases on USB.
#include "service/tools/device/device.h"

#include <iostream>
#include <memory>
#include <string>

#include "service/tools/common/command_line.h"
#include "service/tools/common/output.h"

namespace omni::tools {
namespace {

struct DeviceArguments {
  std::string serial;
  bool yes = false, as_json = false;
};

bool ConfirmToContinue() {
  std::cerr << "Continue? [y/N] " << std::flush;
  std::string answer;
  return std::getline(std::cin, answer) && (answer == "y" || answer == "Y" || answer == "yes");
}

using Action = int (*)(device::UsbBus& bus, const DeviceArguments& arguments);

int List(device::UsbBus& bus, const DeviceArguments& arguments) {
  return DeviceList(bus, arguments.as_json, std::cout);
}
int Info(device::UsbBus& bus, const DeviceArguments& arguments) {
  return DeviceInfo(bus, arguments.serial, arguments.as_json, std::cout);
}
int SelfTest(device::UsbBus& bus, const DeviceArguments& arguments) {
  return DeviceSelfTest(
      bus, arguments.serial, [&] { return arguments.yes || ConfirmToContinue(); }, arguments.as_json, std::cout);
}
int Estop(device::UsbBus& bus, const DeviceArguments& arguments) {
  return DeviceEstop(bus, arguments.serial, std::cout);
}

struct ActionEntry {
  const char* name;
  const char* about;
  Action action;
  bool takes_serial;
  bool asks;
  bool prints_facts;
};
constexpr ActionEntry kDeviceActions[] = {
    {"list", "list all bases: serial, port, speed, firmware, programs that hold them", List, false, false, true},
    {"info", "show one base: identity, limits, temperatures, faults with advice, kept fault", Info, true, false, true},
    {"selftest", "check one base, arm it for a moment without current, and report what fails", SelfTest, true, true,
     true},
    {"estop", "switch the coils off now, on every base or on one; works while omnid runs", Estop, true, false, false},
};

int RunAction(const ActionEntry& entry, const DeviceArguments& arguments) {
  const base::Result<std::unique_ptr<device::UsbBus>> bus = device::MakeUsbBus(false);
  if (!bus.ok()) return Fail(std::string("omni device ") + entry.name, bus.error());
  return entry.action(**bus, arguments);
}

}  // namespace

void AddDevice(Command& app) {
  auto arguments = std::make_shared<DeviceArguments>();
  Command device = app.AddCommand("device", "bases on USB");
  device.RequireCommand();
  for (const ActionEntry& entry : kDeviceActions) {
    Command action = device.AddCommand(entry.name, entry.about);
    if (entry.takes_serial) action.Add("serial", arguments->serial, "of the base, if there are several");
    if (entry.asks) action.Add("-y,--yes", arguments->yes, "do not ask for confirmation");
    if (entry.prints_facts) action.Add("--json", arguments->as_json, "as JSON");
    action.SetAction([&entry, arguments] { return RunAction(entry, *arguments); });
  }
  device.AddCommand("flash-help", "how to put the firmware on a Teensy 4.0").SetAction([] {
    Print(FlashHelpText());
    return kExitOk;
  });
}

}  // namespace omni::tools
