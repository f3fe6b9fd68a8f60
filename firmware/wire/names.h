// Names for the numeric values of the wire: one table each, for user messages, logs and docs/protocol/wire.md.
#pragma once

#include <cstddef>
#include <cstdint>

#include "firmware/wire/messages.h"

namespace omni::wire {

struct Name {
  std::uint32_t value;
  const char* name;
  const char* meaning;
};

struct FaultText {
  Fault fault;
  const char* name;     // two or three words
  const char* meaning;  // the condition that the base detected
  const char* advice;   // one sentence: how to fix it
  const char* part;     // what FaultEvent::part counts, unless it is the whole base; empty: always the whole base
  const char* unit;     // of FaultEvent::value; empty: the value is meaningless
};

// A table and its length.
template <class Row>
struct Rows {
  const Row* first;
  std::size_t count;
  const Row* begin() const noexcept { return first; }
  const Row* end() const noexcept { return first + count; }
};

// In the order of the values.
Rows<Name> MessageTypes() noexcept;
Rows<Name> CapabilityNames() noexcept;
Rows<Name> StateNames() noexcept;
Rows<Name> ModeNames() noexcept;
Rows<Name> ArmSteps() noexcept;
Rows<Name> ConfigOps() noexcept;
Rows<Name> ConfigIds() noexcept;
Rows<Name> LogLevels() noexcept;
Rows<FaultText> FaultTexts() noexcept;

// "unknown" for a value unknown to this build.
const char* MessageTypeName(MessageType type) noexcept;
const char* StateName(State state) noexcept;
const char* ModeName(Mode mode) noexcept;
const char* ArmStepName(ArmStep step) noexcept;
const char* ConfigOpName(ConfigOp op) noexcept;
const char* ConfigIdName(std::uint16_t id) noexcept;  // per coil: the name without its coil
const char* LogLevelName(LogLevel level) noexcept;

// `fault` is one bit of Fault. Null for one unknown to this build.
const FaultText* FindFault(std::uint32_t fault) noexcept;
const char* FaultName(std::uint32_t fault) noexcept;
const char* FaultAdvice(std::uint32_t fault) noexcept;

}  // namespace omni::wire
