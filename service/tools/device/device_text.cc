#include "service/tools/device/device.h"

#include <cstdio>
#include <string>
#include <vector>

#include "firmware/wire/messages.h"
#include "firmware/wire/names.h"
#include "service/console/wrap.h"
#include "service/device/base_notes.h"
#include "service/tools/common/output.h"

namespace omni::tools {
namespace {

constexpr double kTelemetryRate_Hz = 1000;
constexpr double kTelemetryTolerance = 0.05;

std::string Titled(const char* title, const std::string& text) { return Format("%-12s ", title) + text + "\n"; }

// "24.1, 24.0, 23.9"
template <class Count>
std::string ThreeCounts(const Count (&counts)[wire::kCoils], double unit, const char* format) {
  std::vector<std::string> numbers;
  for (const Count count : counts) {
    char number[32];
    std::snprintf(number, sizeof number, format, count * unit);
    numbers.emplace_back(number);
  }
  return console::Joined(numbers, ", ");
}

std::string CapabilityNames(std::uint32_t capabilities) {
  std::vector<std::string> names;
  for (const wire::Name& capability : wire::CapabilityNames()) {
    if ((capabilities & capability.value) != 0) names.emplace_back(capability.name);
  }
  return names.empty() ? "none" : console::Joined(names, ", ");
}

std::string FaultNames(std::uint32_t faults) {
  std::vector<std::string> names;
  for (const wire::FaultText& fault : wire::FaultTexts()) {
    if ((faults & fault.fault) != 0) names.emplace_back(fault.name);
  }
  return names.empty() ? "none" : console::Joined(names, ", ");
}

// Sensors of a mask, for people: counted from 0 as in the manifest.
std::string SensorList(unsigned mask) {
  std::vector<std::string> numbers;
  for (unsigned i = 0; i < wire::kSensors; ++i) {
    if ((mask >> i & 1U) != 0) numbers.push_back(std::to_string(i));
  }
  return console::Joined(numbers, ", ");
}

SelfTestRow JudgeRate(const device::UsbProbe& probe) {
  if (probe.frames < 2 || !(probe.listened_s > 0)) return {"telemetry", false, "none received"};
  const double rate_Hz = static_cast<double>(probe.frames - 1 + probe.missed) / probe.listened_s;
  const bool steady = rate_Hz >= kTelemetryRate_Hz * (1 - kTelemetryTolerance) &&
                      rate_Hz <= kTelemetryRate_Hz * (1 + kTelemetryTolerance);
  return {"telemetry", steady, Format("%.0f per second by its own clock, %.0f expected", rate_Hz, kTelemetryRate_Hz)};
}

SelfTestRow JudgeFrames(const device::UsbProbe& probe) {
  const bool whole = probe.frames > 0 && probe.missed == 0 && probe.bad_frames == 0;
  return {"frames", whole,
          Format("%llu received, %llu lost, %llu bad", static_cast<unsigned long long>(probe.frames),
                 static_cast<unsigned long long>(probe.missed), static_cast<unsigned long long>(probe.bad_frames)) +
              (whole ? "" : "; use another cable or port, without a hub")};
}

SelfTestRow JudgeSensors(const device::UsbProbe& probe) {
  const unsigned missing = ~static_cast<unsigned>(probe.fresh_sensors) & ((1U << wire::kSensors) - 1);
  unsigned saturated = 0;
  for (unsigned i = 0; i < wire::kSensors; ++i) {
    if ((probe.saturated_mask >> (3 * i) & 7U) != 0) saturated |= 1U << i;
  }
  if (missing != 0) return {"Hall sensors", false, "no new sample from " + SensorList(missing)};
  if (saturated != 0) {
    return {"Hall sensors", false, "saturated: " + SensorList(saturated) + "; take the pen and other magnets away"};
  }
  return {"Hall sensors", true, Format("all %d deliver samples, none is saturated", wire::kSensors)};
}

// Passed if none of `faults` is present.
SelfTestRow JudgeFaults(const char* name, const device::UsbProbe& probe, std::uint32_t faults, std::string measured) {
  const std::uint32_t there = probe.telemetry.faults & faults;
  if (there != 0) measured += "; " + FaultNames(there);
  return {name, there == 0, std::move(measured)};
}

SelfTestRow JudgeArming(const device::UsbProbe& probe) {
  if ((probe.hello.capabilities & wire::kArming) == 0) return {"arming", true, "this base needs none"};
  if (probe.armed) return {"arming", true, "armed; it disarms by itself"};
  if (probe.refused_by != 0) return {"arming", false, "refused because of: " + FaultNames(probe.refused_by)};
  return {"arming", false, std::string("no answer, state ") + wire::StateName(probe.armed_state)};
}

}  // namespace

std::string FirmwareText(std::uint16_t version) { return Format("%d.%d", version >> 8, version & 0xFF); }

std::string DeviceListText(const std::vector<ListedBase>& bases) {
  std::string text = Format("%-17s %-8s %-12s %-9s %s\n", "serial", "port", "speed", "firmware", "held by");
  for (const ListedBase& listed : bases) {
    const device::UsbBase& base = listed.base;
    const std::string holders = device::HoldersText(listed.holders);
    text += Format("%-17s %-8s %-12s %-9s ", base.serial.empty() ? "-" : base.serial.c_str(), base.port.c_str(),
                   base.speed.c_str(), listed.firmware.empty() ? "-" : listed.firmware.c_str());
    text += (holders.empty() ? "no program" : holders) + "\n";
    if (!base.problem.empty()) text += "  " + base.problem + "\n";
  }
  return text;
}

std::string DeviceIdentityText(const device::UsbBase& base, const wire::Hello& hello) {
  std::string text = Titled("base", device::PrintableText(hello.serial, sizeof hello.serial) + " at port " + base.port +
                                        ", " + base.speed + ", " + base.node);
  text += Titled("firmware",
                 FirmwareText(hello.firmware_version) + Format("; speaks protocol %d to %d, omni speaks %d",
                                                               hello.version_min, hello.version_max, wire::kVersion));
  text += Titled("limits", Format("%.2f A per coil; a field count is %.2f nT, %u and more are saturated",
                                  static_cast<double>(hello.current_max_A),
                                  1e9 * static_cast<double>(hello.field_lsb_T), hello.field_full_scale));
  text += Titled("calibration", hello.calibration_hash == 0
                                    ? "counts are nominal"
                                    : Format("hash %016llx", static_cast<unsigned long long>(hello.calibration_hash)));
  return text + Titled("can", CapabilityNames(hello.capabilities));
}

std::string DeviceLiveText(const device::UsbProbe& probe) {
  const wire::Telemetry& now = probe.telemetry;
  std::string text = Titled("state", wire::StateName(now.state));
  text += Titled("supply", Format("%.2f V", now.supply * wire::kSupplyUnit_V));
  text += Titled("currents", ThreeCounts(now.current[wire::kStepsPerTick - 1], wire::kCurrentUnit_A, "%.3f") + " A");
  text += Titled("coils", ThreeCounts(now.temperature, wire::kTemperatureUnit_K, "%.1f") + " C, " +
                              ThreeCounts(now.resistance, 1e3 * kResistanceUnit_ohm, "%.1f") + " mohm");
  text += Titled("board", Format("%.1f C, fan %u rpm", now.board_temperature * wire::kTemperatureUnit_K, now.fan_rpm));
  text += Titled("faults", FaultNames(now.faults));
  for (const wire::FaultText& fault : wire::FaultTexts()) {
    if ((now.faults & fault.fault) != 0) text += Titled("", std::string(fault.name) + ": " + fault.advice);
  }
  return text + Titled("kept fault", probe.kept_fault ? device::FaultEventText(*probe.kept_fault) : "none");
}

std::vector<SelfTestRow> JudgeSelfTest(const device::UsbProbe& probe) {
  const wire::Telemetry& now = probe.telemetry;
  return {JudgeRate(probe),
          JudgeFrames(probe),
          JudgeSensors(probe),
          JudgeFaults("supply", probe, wire::kFaultSupplyLow | wire::kFaultSupplyHigh,
                      Format("%.2f V", now.supply * wire::kSupplyUnit_V)),
          JudgeFaults("coils", probe,
                      wire::kFaultCoilOpen | wire::kFaultCoilShort | wire::kFaultModel | wire::kFaultOverTemperature |
                          wire::kFaultOverCurrent | wire::kFaultDriver | wire::kFaultCurrentSensor,
                      ThreeCounts(now.temperature, wire::kTemperatureUnit_K, "%.1f") + " C, " +
                          ThreeCounts(now.resistance, 1e3 * kResistanceUnit_ohm, "%.1f") + " mohm"),
          JudgeFaults("fan", probe, wire::kFaultFan, Format("%u rpm", now.fan_rpm)),
          JudgeFaults("own test", probe, wire::kFaultSelfTest | wire::kFaultWatchdog | wire::kFaultInternal,
                      std::string("state ") + wire::StateName(now.state)),
          JudgeArming(probe)};
}

std::string SelfTestText(const std::vector<SelfTestRow>& rows) {
  std::string text;
  for (const SelfTestRow& row : rows)
    text += Format("%-4s  ", row.passed ? "ok" : "FAIL") + Titled(row.name.c_str(), row.text);
  return text;
}

std::string FlashHelpText() {
  return R"(How to put the firmware on a Teensy 4.0

1. Build it (needs gcc-arm-none-eabi, libnewlib-arm-none-eabi, libstdc++-arm-none-eabi-newlib):
     scripts/setup all && scripts/configure release all && cmake --build --preset release
   The image is omni_teensy40.hex below build/release.
2. Switch the coils' supply off. The Teensy is powered over USB.
3. Install the loader and give this user access to the Teensy:
     sudo apt-get install teensy-loader-cli
     https://www.pjrc.com/teensy/00-teensy.rules goes into /etc/udev/rules.d/
4. Load; press the button on the Teensy when the loader says that it waits:
     teensy_loader_cli --mcu=TEENSY40 -w -v omni_teensy40.hex
5. `omni device list` shows the base. If permission is denied: docs/howto/device.md.
6. Before the first time with coils: the bring-up checklist in firmware/README.md.
7. Supply on, then `omni device selftest`.
)";
}

}  // namespace omni::tools
