#include "service/tools/device/device.h"

#include <nlohmann/json.hpp>

#include "firmware/wire/messages.h"
#include "firmware/wire/names.h"
#include "service/device/base_notes.h"

namespace omni::tools {
namespace {

using nlohmann::ordered_json;

template <class Count>
ordered_json Scaled(const Count (&counts)[wire::kCoils], double unit) {
  ordered_json values = ordered_json::array();
  for (const Count count : counts) values.push_back(count * unit);
  return values;
}

ordered_json TextOrNothing(const std::string& text) { return text.empty() ? ordered_json() : ordered_json(text); }

}  // namespace

ordered_json HoldersJson(const std::vector<device::Holder>& holders) {
  ordered_json rows = ordered_json::array();
  for (const device::Holder& holder : holders) rows.push_back({{"pid", holder.pid}, {"name", holder.name}});
  return rows;
}

ordered_json DeviceListJson(const std::vector<ListedBase>& bases) {
  ordered_json rows = ordered_json::array();
  for (const ListedBase& listed : bases) {
    rows.push_back({{"serial", listed.base.serial},
                    {"port", listed.base.port},
                    {"speed", listed.base.speed},
                    {"node", listed.base.node},
                    {"firmware", TextOrNothing(listed.firmware)},
                    {"held_by", HoldersJson(listed.holders)},
                    {"problem", TextOrNothing(listed.base.problem)}});
  }
  return rows;
}

ordered_json DeviceIdentityJson(const device::UsbBase& base, const wire::Hello& hello) {
  ordered_json capabilities = ordered_json::array();
  for (const wire::Name& capability : wire::CapabilityNames()) {
    if ((hello.capabilities & capability.value) != 0) capabilities.push_back(capability.name);
  }
  return {{"serial", device::PrintableText(hello.serial, sizeof hello.serial)},
          {"port", base.port},
          {"speed", base.speed},
          {"node", base.node},
          {"firmware", FirmwareText(hello.firmware_version)},
          {"protocol", {{"min", hello.version_min}, {"max", hello.version_max}, {"of_omni", wire::kVersion}}},
          {"current_max_A", hello.current_max_A},
          {"field_count_T", hello.field_lsb_T},
          {"field_full_scale_counts", hello.field_full_scale},
          {"calibration_hash", hello.calibration_hash},
          {"capabilities", std::move(capabilities)}};
}

ordered_json DeviceLiveJson(const device::UsbProbe& probe) {
  const wire::Telemetry& now = probe.telemetry;
  ordered_json faults = ordered_json::array();
  for (const wire::FaultText& fault : wire::FaultTexts()) {
    if ((now.faults & fault.fault) != 0) faults.push_back({{"name", fault.name}, {"advice", fault.advice}});
  }
  return {{"state", wire::StateName(now.state)},
          {"supply_V", now.supply * wire::kSupplyUnit_V},
          {"currents_A", Scaled(now.current[wire::kStepsPerTick - 1], wire::kCurrentUnit_A)},
          {"coil_temperatures_C", Scaled(now.temperature, wire::kTemperatureUnit_K)},
          {"coil_resistances_ohm", Scaled(now.resistance, kResistanceUnit_ohm)},
          {"board_temperature_C", now.board_temperature * wire::kTemperatureUnit_K},
          {"fan_rpm", now.fan_rpm},
          {"faults", std::move(faults)},
          {"kept_fault", probe.kept_fault ? ordered_json(device::FaultEventText(*probe.kept_fault)) : ordered_json()}};
}

ordered_json SelfTestJson(const std::vector<SelfTestRow>& rows) {
  ordered_json tests = ordered_json::array();
  for (const SelfTestRow& row : rows) {
    tests.push_back({{"name", row.name}, {"passed", row.passed}, {"text", row.text}});
  }
  return tests;
}

}  // namespace omni::tools
