// Read by the boot ROM before the firmware runs: how to access the flash (FCB), where the program starts (IVT) and how
// long the image is [RM System Boot: FlexSPI serial NOR configuration block, program image].
#include <cstddef>
#include <cstdint>

#include "firmware/board/teensy40/boot/memory_map.h"

extern "C" {
[[noreturn]] void ResetHandler();
extern const char __flash_image_size[];  // its address is the number
}

namespace omni::board {
namespace {

// One instruction of a FlexSPI sequence [RM FlexSPI, look up table]; two in a word, the first one low.
enum class Op : std::uint32_t {
  kStop = 0,
  kCommand = 0x01,
  kAddress = 0x02,
  kMode8 = 0x07,
  kWrite = 0x08,
  kRead = 0x09,
  kDummy = 0x0C
};
enum class Pads : std::uint32_t { kOne = 0, kFour = 2 };

constexpr std::uint32_t Instruction(Op op, Pads pads, std::uint32_t operand) {
  return (static_cast<std::uint32_t>(op) << 10) | (static_cast<std::uint32_t>(pads) << 8) | operand;
}
constexpr std::uint32_t Pair(std::uint32_t first, std::uint32_t second = 0) { return first | (second << 16); }
constexpr std::uint32_t Command(std::uint32_t code) { return Instruction(Op::kCommand, Pads::kOne, code); }
constexpr std::uint32_t Address24(Pads pads) { return Instruction(Op::kAddress, pads, 24); }

struct Sequence {
  std::uint32_t words[4];
};
static_assert(sizeof(Sequence) == 16, "layout of the ROM");

struct FlashConfig {
  std::uint32_t tag;
  std::uint32_t version;
  std::uint32_t reserved0;
  std::uint8_t read_sample_clock, cs_hold, cs_setup, column_address_width;
  std::uint32_t device_mode[4], device_config[8];  // none needed: the quad enable bit is set at the factory
  std::uint32_t controller_options;
  std::uint8_t device_type, pads, clock, custom_sequences;
  std::uint32_t reserved1[2];
  std::uint32_t size_a1, size_a2, size_b1, size_b2;
  std::uint32_t pad_overrides[4];
  std::uint32_t time_out_ms, command_interval_ns, data_valid_time, busy_bit;
  Sequence sequences[16];
  std::uint32_t custom[16];
  std::uint32_t page_size, sector_size;
  std::uint8_t command_clock, uniform_block_size, reserved2[2];
  std::uint32_t reserved3;
  std::uint32_t block_size;
  std::uint32_t reserved4[11];
};
static_assert(offsetof(FlashConfig, device_type) == 0x44 && offsetof(FlashConfig, size_a1) == 0x50 &&
                  offsetof(FlashConfig, sequences) == 0x80 && offsetof(FlashConfig, page_size) == 0x1C0 &&
                  offsetof(FlashConfig, block_size) == 0x1D0 && sizeof(FlashConfig) == 0x200,
              "RM System Boot, FlexSPI NOR configuration block");

// W25Q16JV (Winbond). Read without "continuous mode" (mode byte 0): the flash accepts a command right after any reset
// of the processor, and speed does not matter, because only start-up runs from flash.
__attribute__((section(".boot.flash_config"), used)) const FlashConfig kFlashConfig = {
    0x42464346,  // "FCFB"
    0x56010000,
    0,
    1,  // read strobe looped back from the DQS pad
    3,
    3,
    0,
    {},
    {},
    0,
    1,  // serial NOR
    4,  // four pads
    6,  // 100 MHz; the flash takes 133
    0,
    {},
    kFlashSize,
    0,
    0,
    0,
    {},
    0,
    0,
    0,
    0,
    {
        // 0: read, quad I/O
        {{Pair(Command(0xEB), Address24(Pads::kFour)),
          Pair(Instruction(Op::kMode8, Pads::kFour, 0), Instruction(Op::kDummy, Pads::kFour, 4)),
          Pair(Instruction(Op::kRead, Pads::kFour, 4)), 0}},
        {{Pair(Command(0x05), Instruction(Op::kRead, Pads::kOne, 4)), 0, 0, 0}},  // 1: read status
        {},
        {{Pair(Command(0x06)), 0, 0, 0}},  // 3: write enable
        {},
        {{Pair(Command(0x20), Address24(Pads::kOne)), 0, 0, 0}},  // 5: erase sector
        {},
        {},
        {{Pair(Command(0xD8), Address24(Pads::kOne)), 0, 0, 0}},  // 8: erase block
        {{Pair(Command(0x02), Address24(Pads::kOne)), Pair(Instruction(Op::kWrite, Pads::kOne, 4)), 0,
          0}},  // 9: program
        {},
        {{Pair(Command(0x60)), 0, 0, 0}},  // 11: erase chip
        {},
        {},
        {},
        {},
    },
    {},
    256,
    4096,
    1,  // commands at 30 MHz
    0,
    {},
    0,
    0x10000,
    {},
};

struct BootData {
  std::uint32_t start;
  const void* length;
  std::uint32_t plugin;
};

struct ImageVectorTable {
  std::uint32_t header;  // tag D1, length 0020, version 43
  void (*entry)();
  std::uint32_t reserved1;
  const void* device_configuration;
  const BootData* boot_data;
  const ImageVectorTable* self;
  const void* command_sequence;  // of a signed image
  std::uint32_t reserved2;
};
static_assert(sizeof(void*) != 4 || sizeof(ImageVectorTable) == 32, "RM System Boot, image vector table");

__attribute__((section(".boot.data"), used)) const BootData kBootData = {kFlashBase, __flash_image_size, 0};

extern const ImageVectorTable kImageVectorTable;
__attribute__((section(".boot.ivt"), used)) const ImageVectorTable kImageVectorTable = {
    0x432000D1, ResetHandler, 0, nullptr, &kBootData, &kImageVectorTable, nullptr, 0};

}  // namespace
}  // namespace omni::board
