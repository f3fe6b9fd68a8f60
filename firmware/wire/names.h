// Words for what the wire says in numbers: one table each, for messages to people, logs and docs/protocol/wire.md.
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
  const char* meaning;  // what the base saw
  const char* advice;   // one sentence: what a person does about it
  const char* part;     // what FaultEvent::part counts, unless it is the whole base; empty: it always is
  const char* unit;     // of FaultEvent::value; empty: the value says nothing
};

// A table that ends.
template <class Row>
struct Rows {
  const Row* first;
  std::size_t count;
  const Row* begin() const noexcept { return first; }
  const Row* end() const noexcept { return first + count; }
};

// In the order of the values.
Rows<Name> MessageTypes() noexcept;
Rows<Name> Capabilities() noexcept;
Rows<Name> States() noexcept;
Rows<Name> Modes() noexcept;
Rows<Name> ArmSteps() noexcept;
Rows<Name> ConfigOps() noexcept;
Rows<Name> ConfigIds() noexcept;
Rows<Name> LogLevels() noexcept;
Rows<FaultText> Faults() noexcept;

// "unknown" for a value that this build does not know.
const char* MessageTypeName(MessageType type) noexcept;
const char* StateName(State state) noexcept;
const char* ModeName(Mode mode) noexcept;
const char* ArmStepName(ArmStep step) noexcept;
const char* ConfigOpName(ConfigOp op) noexcept;
const char* ConfigIdName(std::uint16_t id) noexcept;  // per coil: the name without its coil
const char* LogLevelName(LogLevel level) noexcept;

// `fault` is one bit of Fault. Null for one that this build does not know.
const FaultText* FindFault(std::uint32_t fault) noexcept;
const char* FaultName(std::uint32_t fault) noexcept;
const char* FaultAdvice(std::uint32_t fault) noexcept;

}  // namespace omni::wire
