// Prints docs/protocol/wire.md. Runs on the host: build/release/bin/wire_page > docs/protocol/wire.md
#include <cstdio>
#include <cstring>

#include "firmware/wire/cobs.h"
#include "firmware/wire/messages.h"
#include "firmware/wire/names.h"

namespace omni::wire {
namespace {

void PrintIntroduction() {
  std::printf(
      "# The wire between host and base\n"
      "\n"
      "Generated from firmware/wire by `wire_page`; a test checks it. The same code runs in the base, in the twin and "
      "in\n"
      "omnid. All numbers are little-endian; floats are IEEE 754 single precision.\n"
      "\n"
      "## Envelope\n"
      "\n"
      "| offset | type | field | meaning |\n"
      "|---|---|---|---|\n"
      "| 0 | u16 | magic | 0x%04X: `OM` |\n"
      "| 2 | u8 | version | %d |\n"
      "| 3 | u8 | type | see below |\n"
      "| 4 | u16 | seq | counts the frames of one direction, of all types |\n"
      "| 6 | u16 | payload_len | bytes |\n"
      "| 8 | u64 | t_device_us | TELEMETRY: instant of the newest Hall sample, device clock; COMMAND: 0 |\n"
      "| %zu | | payload | at most %zu bytes |\n"
      "| %zu + payload_len | u32 | crc | CRC-32C (Castagnoli) of all bytes before |\n"
      "\n"
      "One frame is one USB bulk transfer or one seqpacket datagram: at most %zu bytes, so a short packet always ends "
      "it\n"
      "and no further framing is needed. On byte streams (UART, pty) a frame travels as COBS and a zero byte: at most "
      "%zu\n"
      "bytes (firmware/wire/cobs.h).\n"
      "\n",
      static_cast<unsigned>(kMagic), int{kVersion}, kHeaderSize, kPayloadSizeMax, kHeaderSize, kFrameSizeMax,
      kCobsFrameSizeMax + 1);
}

void PrintRules() {
  std::printf(
      "## Rules\n"
      "\n"
      "- A frame that fails a check (size, magic, version, length, CRC, range, NaN or infinity) is dropped and "
      "counted.\n"
      "  Nothing in it has any effect.\n"
      "- A valid frame of an unknown type is ignored. Unknown bytes after a payload's fields are ignored, so that a "
      "newer\n"
      "  sender may append fields. A payload shorter than its fields is rejected.\n"
      "- A frame of another version is rejected, except HELLO, whose layout never changes, so that each side can "
      "report\n"
      "  which of them is older. A base never arms for another version.\n"
      "- `seq` is compared as a serial number [RFC 1982]: b is after a if (b - a) mod 65536 is 1 to 32767. A frame "
      "that is\n"
      "  not after the last one (replayed, duplicated, reordered) is dropped and counted; a gap is counted as missed.\n"
      "- A COMMAND is valid for its time to live, 1 to %d ms. If no other follows, the base ramps its coils to zero "
      "and brakes\n"
      "  (host silent).\n"
      "- A base with the capability *arming* keeps its coils at zero until ARM, in two steps: request, challenge with "
      "a\n"
      "  nonce, confirm with that nonce within 100 ms. No single frame, whatever its origin, can arm the base.\n"
      "- A fault bit stays set until ARM finds its cause gone; any bit keeps the coils at zero. *Not armed* and *host\n"
      "  silent* are not failures: the host arms again by itself.\n"
      "- ESTOP may be sent at any time and any number of times, also as a vendor request to endpoint 0.\n"
      "- The device clock counts microseconds since reset by its own crystal, unless the capability says otherwise. "
      "The\n"
      "  host relates it to its own clock by acknowledged commands (service/device/clock_map.h): host_us when sent,\n"
      "  ack_rx_device_us and t_device_us in the base, arrival at the host.\n"
      "\n",
      int{kTimeToLiveMax_ms});
}

void PrintNames(const char* title, Rows<Name> names, bool hexadecimal) {
  std::printf("### %s\n\n| value | name | meaning |\n|---|---|---|\n", title);
  for (const Name& row : names) {
    std::printf(hexadecimal ? "| 0x%02X | %s | %s |\n" : "| %u | %s | %s |\n", static_cast<unsigned>(row.value),
                row.name, row.meaning);
  }
  std::printf("\n");
}

template <class Field>
const char* TypeName() {
  if constexpr (std::is_enum_v<Field>) {
    return TypeName<std::underlying_type_t<Field>>();
  } else if constexpr (std::is_same_v<Field, char>) {
    return "char";
  } else if constexpr (std::is_same_v<Field, float>) {
    return "f32";
  } else if constexpr (std::is_signed_v<Field>) {
    return sizeof(Field) == 1 ? "i8" : sizeof(Field) == 2 ? "i16" : sizeof(Field) == 4 ? "i32" : "i64";
  } else {
    return sizeof(Field) == 1 ? "u8" : sizeof(Field) == 2 ? "u16" : sizeof(Field) == 4 ? "u32" : "u64";
  }
}

// One row of the table per field, counting offsets from the payload's begin.
class FieldRows {
 public:
  template <class Field>
  void operator()(const char* name, const Field&, const char* unit, const char* meaning) {
    using Element = std::remove_all_extents_t<Field>;
    std::printf("| %zu | %s | ", offset_, TypeName<Element>());
    if constexpr (std::rank_v<Field> == 2) {
      std::printf("%zu x %zu", std::extent_v<Field, 0>, std::extent_v<Field, 1>);
    } else if constexpr (std::rank_v<Field> == 1) {
      std::printf("%zu", std::extent_v<Field>);
    } else {
      std::printf("1");
    }
    std::printf(" | %s | %s | %s |\n", name, unit, meaning);
    offset_ += sizeof(Field);
  }

 private:
  std::size_t offset_ = 0;
};

template <class Message>
void PrintMessage(const char* note) {
  std::printf("### %s (%d)\n\n%s Payload %zu bytes, frame %zu.\n\n", MessageTypeName(Message::kType),
              static_cast<int>(Message::kType), note, PayloadSize<Message>(), FrameSize<Message>());
  std::printf("| offset | type | count | field | unit | meaning |\n|---|---|---|---|---|---|\n");
  FieldRows rows;
  const Message message{};
  Message::Visit(message, rows);
  std::printf("\n");
}

void PrintMessages() {
  std::printf("## Messages\n\nOffsets count from the start of the payload.\n\n");
  PrintNames("Types", MessageTypes(), false);
  PrintMessage<Hello>(
      "Base: after the link is up, and in answer to an empty HELLO. Positive, finite `field_lsb_T` and\n"
      "`current_max_A`; `version_min` <= `version_max`.");
  PrintMessage<Telemetry>("Base to host, 1 kHz.");
  PrintMessage<Command>(
      "Host to base. One set-point out of range rejects the whole frame; a sender refuses to encode what a\n"
      "receiver would reject.");
  PrintMessage<Config>("Both ways; set only while idle.");
  PrintMessage<Arm>("Both ways.");
  PrintMessage<Estop>("Host to base. Brake now, latched until ARM.");
  PrintMessage<FaultEvent>("Base to host. `value` is in SI.");
  PrintMessage<Log>("Base to host.");
}

void PrintEnums() {
  std::printf("## Values\n\n");
  PrintNames("Capability bits", CapabilityNames(), true);
  PrintNames("State", StateNames(), false);
  PrintNames("Mode", ModeNames(), false);
  PrintNames("ArmStep", ArmSteps(), false);
  PrintNames("ConfigOp", ConfigOps(), false);
  PrintNames("ConfigId", ConfigIds(), true);
  PrintNames("LogLevel", LogLevels(), false);
}

void PrintFaults() {
  std::printf(
      "### Fault bits\n\nIn FAULT, `part` numbers the parts named here (255: the whole base, or its board), and "
      "`value` has "
      "this unit (empty: none).\n\n| bit | name | what the base saw | part | value | what to do "
      "|\n|---|---|---|---|---|---|\n");
  for (const FaultText& row : FaultTexts()) {
    unsigned bit = 0;
    while ((1UL << bit) != row.fault) ++bit;
    std::printf("| %u | %s | %s | %s | %s | %s |\n", bit, row.name, row.meaning, row.part, row.unit, row.advice);
  }
}

}  // namespace
}  // namespace omni::wire

int main() {
  omni::wire::PrintIntroduction();
  omni::wire::PrintRules();
  omni::wire::PrintMessages();
  omni::wire::PrintEnums();
  omni::wire::PrintFaults();
  return 0;
}
