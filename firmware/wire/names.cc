#include "firmware/wire/names.h"

namespace omni::wire {
namespace {

template <class Enum>
constexpr std::uint32_t Value(Enum value) {
  return static_cast<std::uint32_t>(value);
}

constexpr Name kMessageTypes[] = {
    {Value(MessageType::kHello), "HELLO", "host: empty request; base: its identity"},
    {Value(MessageType::kTelemetry), "TELEMETRY", "base, every millisecond: its measurements"},
    {Value(MessageType::kCommand), "COMMAND", "host: currents, and their time to live"},
    {Value(MessageType::kConfig), "CONFIG", "host: get or set one setting; base: the answer"},
    {Value(MessageType::kArm), "ARM", "both: the two steps that enable currents"},
    {Value(MessageType::kEstop), "ESTOP", "host: brake now"},
    {Value(MessageType::kFault), "FAULT", "base: a new fault; host: empty request for the recorded one"},
    {Value(MessageType::kLog), "LOG", "base: a line of text for the user"},
};

constexpr Name kCapabilities[] = {
    {kDeviceClockIsHostMonotonic, "device clock is the host's", "t_device_us is the host's CLOCK_MONOTONIC"},
    {kSimulation, "simulation", "no hardware behind it"},
    {kCurrentSensors, "current sensors", "coil currents are measured, one sensor per coil"},
    {kArming, "arming", "coils stay at zero until ARM"},
};

constexpr Name kStates[] = {
    {Value(State::kBoot), "boot", "starting, coils off"},
    {Value(State::kSelfTest), "self-test", "sensors and coils are being tested"},
    {Value(State::kIdle), "idle", "ready, coils at zero"},
    {Value(State::kArmed), "armed", "coils follow COMMAND"},
    {Value(State::kFault), "fault", "coils at zero until ARM finds the cause gone"},
};

constexpr Name kModes[] = {
    {Value(Mode::kOff), "off", "currents to zero"},
    {Value(Mode::kCurrent), "current", "currents to their set-points"},
};

constexpr Name kArmSteps[] = {
    {Value(ArmStep::kRequest), "request", "host: asks"},
    {Value(ArmStep::kChallenge), "challenge", "base: sends a nonce"},
    {Value(ArmStep::kConfirm), "confirm", "host: returns the nonce"},
    {Value(ArmStep::kArmed), "armed", "base: done"},
    {Value(ArmStep::kRefused), "refused", "base: not armed; `faults` says why"},
};

constexpr Name kConfigOps[] = {
    {Value(ConfigOp::kGet), "get", "host: requests the value in force"},
    {Value(ConfigOp::kSet), "set", "host: sets this value; idle only"},
    {Value(ConfigOp::kValue), "value", "base: the value in force"},
    {Value(ConfigOp::kRefused), "refused", "base: not set; the value still in force"},
};

constexpr Name kConfigIds[] = {
    {Value(ConfigId::kCurrentMax_A), "current_max_A", "largest set-point, A"},
    {Value(ConfigId::kSlewMax_A_s), "slew_max_A_s", "largest change of a current, A/s"},
    {Value(ConfigId::kPowerMax_W), "power_max_W", "of all coils together, W"},
    {Value(ConfigId::kTemperatureDerate_C), "temperature_derate_C", "copper, from here currents shrink, C"},
    {Value(ConfigId::kTemperatureMax_C), "temperature_max_C", "copper, from here it is a fault, C"},
    {Value(ConfigId::kResistance20_ohm), "resistance_20C_ohm", "of coil 0, 1, 2 at 20 C, ohm; id + coil"},
    {Value(ConfigId::kInductance_H), "inductance_H", "of coil 0, 1, 2, H; id + coil"},
};

constexpr Name kLogLevels[] = {
    {Value(LogLevel::kDebug), "debug", "for firmware developers"},
    {Value(LogLevel::kInfo), "info", "for information"},
    {Value(LogLevel::kWarning), "warning", "works, but not as it should"},
    {Value(LogLevel::kError), "error", "does not work"},
};

constexpr FaultText kFaults[] = {
    {kFaultNotArmed, "not armed", "no error: the base has not been armed", "Start the service: it arms automatically.",
     "", ""},
    {kFaultHostSilent, "host silent", "no valid COMMAND within its time to live",
     "Check that omnid is running and the cable is plugged in; the service arms again automatically.", "", "s"},
    {kFaultOverTemperature, "over temperature", "a coil is too hot, by its resistance or by the heat model",
     "Let the base cool for a few minutes, and check that its fan turns and its vents are clear.", "coil", "C"},
    {kFaultOverCurrent, "over current", "a coil's current exceeded its limit, or the sensor raised its alert",
     "Switch the base off, check the coil's wiring and bridge, then arm again.", "coil", "A"},
    {kFaultDriver, "driver fault", "an H bridge reports a fault",
     "Switch the base off and on; if the fault persists, check that bridge for heat and shorts.", "coil", "A"},
    {kFaultSupplyLow, "supply low", "the supply's voltage is below its range",
     "Check the power supply and its plug: it must hold its voltage under load.", "", "V"},
    {kFaultSupplyHigh, "supply high", "the supply's voltage is above its range",
     "Disconnect the power supply at once and use one of 12 to 24 V.", "", "V"},
    {kFaultPower, "power limit", "all coils together take more than the limit",
     "Arm again; if it comes back, lower power_max_W or use a stronger supply.", "", "W"},
    {kFaultCoilOpen, "coil open", "voltage on a coil but no current",
     "Switch the base off and check that coil's connector and wire for a break.", "coil", "A"},
    {kFaultCoilShort, "coil short", "more current in a coil than its voltage explains",
     "Switch the base off and measure that coil: its turns or its wire are shorted.", "coil", "A"},
    {kFaultModel, "current off its model", "a current does not follow its set-point",
     "Arm again; if it comes back, run the self-test and check the coil's resistance and inductance settings.", "coil",
     "A or ohm"},
    {kFaultCurrentSensor, "current sensor", "a current sensor does not answer, or reports impossible values",
     "Switch the base off and on; if the fault persists, check that sensor's bus and address.", "coil", "A"},
    {kFaultHallSensor, "Hall sensor", "a Hall sensor does not answer, is another chip or has no fresh sample",
     "Switch the base off and on; if the fault persists, check that sensor's connector.", "sensor", ""},
    {kFaultHallStuck, "Hall sensor stuck", "a Hall sensor repeats the same sample",
     "Switch the base off and on; if the fault persists, replace that sensor.", "sensor", ""},
    {kFaultHallJump, "Hall sensor jump", "a Hall sensor's field changed faster than a moving magnet can cause",
     "Keep other magnets and loose cables away, then arm again.", "sensor", ""},
    {kFaultFan, "fan stands", "the fan does not turn although it should",
     "Free the fan, check its plug, then arm again.", "", "1/min"},
    {kFaultEmergencyStop, "emergency stop", "the switch, ESTOP, or the endpoint 0 request",
     "Release the emergency stop when it is safe, then arm again.", "", ""},
    {kFaultSelfTest, "self-test", "the self-test at boot failed",
     "Run omni device selftest: it names the part that failed.", "part", "T or ohm"},
    {kFaultWatchdog, "watchdog", "the watchdog caused the last reset",
     "Arm again; if it comes back, report it with the output of omni device info.", "", ""},
    {kFaultInternal, "internal", "a number that is not finite, a corrupt record, or a bridge driven while not armed",
     "Switch the base off and on; if it comes back, report it with the output of omni device info.", "", ""},
};

constexpr const char* kUnknown = "unknown";

template <class Row, std::size_t kCount>
constexpr Rows<Row> All(const Row (&rows)[kCount]) noexcept {
  return {rows, kCount};
}

const char* Find(Rows<Name> names, std::uint32_t value) noexcept {
  for (const Name& row : names) {
    if (row.value == value) return row.name;
  }
  return kUnknown;
}

}  // namespace

Rows<Name> MessageTypes() noexcept { return All(kMessageTypes); }
Rows<Name> CapabilityNames() noexcept { return All(kCapabilities); }
Rows<Name> StateNames() noexcept { return All(kStates); }
Rows<Name> ModeNames() noexcept { return All(kModes); }
Rows<Name> ArmSteps() noexcept { return All(kArmSteps); }
Rows<Name> ConfigOps() noexcept { return All(kConfigOps); }
Rows<Name> ConfigIds() noexcept { return All(kConfigIds); }
Rows<Name> LogLevels() noexcept { return All(kLogLevels); }
Rows<FaultText> FaultTexts() noexcept { return All(kFaults); }

const char* MessageTypeName(MessageType type) noexcept { return Find(MessageTypes(), Value(type)); }
const char* StateName(State state) noexcept { return Find(StateNames(), Value(state)); }
const char* ModeName(Mode mode) noexcept { return Find(ModeNames(), Value(mode)); }
const char* ArmStepName(ArmStep step) noexcept { return Find(ArmSteps(), Value(step)); }
const char* ConfigOpName(ConfigOp op) noexcept { return Find(ConfigOps(), Value(op)); }
const char* LogLevelName(LogLevel level) noexcept { return Find(LogLevels(), Value(level)); }

const char* ConfigIdName(std::uint16_t id) noexcept {
  constexpr ConfigId kPerCoil[] = {ConfigId::kResistance20_ohm, ConfigId::kInductance_H};
  for (const ConfigId per_coil : kPerCoil) {
    const std::uint32_t first = Value(per_coil);
    if (id >= first && id < first + kCoils) return Find(ConfigIds(), first);
  }
  return Find(ConfigIds(), id);
}

const FaultText* FindFault(std::uint32_t fault) noexcept {
  for (const FaultText& row : kFaults) {
    if (row.fault == fault) return &row;
  }
  return nullptr;
}

const char* FaultName(std::uint32_t fault) noexcept {
  const FaultText* row = FindFault(fault);
  return row != nullptr ? row->name : kUnknown;
}

const char* FaultAdvice(std::uint32_t fault) noexcept {
  const FaultText* row = FindFault(fault);
  return row != nullptr ? row->advice
                        : "Update this program: the base's firmware reports a fault that it does not know.";
}

}  // namespace omni::wire
