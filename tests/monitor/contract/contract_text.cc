#include "tests/monitor/contract/contract_text.h"

#include <span>
#include <vector>

#include "firmware/wire/names.h"
#include "service/monitor/page/bit_names.h"
#include "service/monitor/page/channels.h"

namespace omni::monitor {
namespace {

std::string Union(const std::string& type, const std::vector<std::string>& names) {
  std::string text = "export type " + type + " =";
  for (const std::string& name : names) text += "\n  | '" + name + "'";
  return text + ";\n";
}

std::string Masks(const std::string& constant, std::span<const BitName> names) {
  std::string text = "export const " + constant + " = {\n";
  for (const BitName& row : names) text += std::string("  ") + row.name + ": " + std::to_string(row.mask) + ",\n";
  return text + "} as const;\n";
}

}  // namespace

std::string ContractText() {
  std::vector<std::string> channels, flags, faults;
  for (const Channel& channel : Channels()) channels.push_back(channel.name);
  for (const BitName& row : FlagNames()) flags.push_back(row.name);
  for (const wire::FaultText& fault : wire::Faults()) faults.push_back(fault.name);
  return "// Printed by build/release/bin/page_contract from the service's tables (service/monitor/page/channels.cc,\n"
         "// bit_names.cc, firmware/wire/names.cc); the test PageContract.IsUpToDate compares. A name that is not here "
         "is\n"
         "// an error of the compiler.\n" +
         Union("ChannelName", channels) + Union("FlagName", flags) + "// Of the channel \"tick_faults\".\n" +
         Masks("kTickFault", TickFaultNames()) + "// Of the channel \"tool_limits\".\n" +
         Masks("kToolLimit", ToolLimitNames()) + "// Of the channel \"device_faults\".\n" +
         Union("DeviceFaultName", faults);
}

}  // namespace omni::monitor
