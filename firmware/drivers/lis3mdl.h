// Magnetometer LIS3MDL on SPI: 1000 samples a second, +-16 gauss, free-running on its own clock.
//
// Bus policy, one object per chip select:
//   BusStatus Transfer(const std::uint8_t* out, std::uint8_t* in, std::size_t size) noexcept;
//     The chip is selected for exactly these bytes; in[i] is received while out[i] is sent. SPI mode 3, at most 10 MHz.
//     kTimeout: the controller did not finish within its bound.
#pragma once

#include <cstddef>
#include <cstdint>

#include "firmware/drivers/chip_status.h"
#include "firmware/drivers/lis3mdl_registers.h"

namespace omni::drivers {

struct Lis3mdlSample {
  std::int16_t field[3] = {};  // counts: 1711 a gauss (5.84e-8 T each), full scale 27376
  bool overrun = false;        // an older sample was lost unread
};

template <class Bus>
class Lis3mdl {
 public:
  explicit Lis3mdl(Bus& bus) noexcept : bus_(bus) {}

  // Identity, software reset, configuration, read-back. At most kResetReads + 5 transfers. Errors: kTimeout, kNoAnswer,
  // kWrongIdentity, kNotTaken; try again later.
  ChipStatus Start() noexcept {
    started_ = false;
    self_test_ = false;
    ChipStatus status = CheckIdentity();
    if (status == ChipStatus::kOk) status = SoftReset();
    if (status == ChipStatus::kOk) status = Configure();
    started_ = status == ChipStatus::kOk;
    return Count(status);
  }

  // Whether Read would find a new sample: kOk, or kNoNewSample. Two bytes on the bus. An undriven line reads as either.
  ChipStatus CheckForSample() noexcept {
    if (!started_) return ChipStatus::kNotStarted;
    std::uint8_t value = 0;
    const ChipStatus status = ReadRegisters(lis3mdl::kStatus, &value, 1);
    if (status != ChipStatus::kOk) return Count(status);
    return (value & lis3mdl::kStatusNew) != 0 ? ChipStatus::kOk : ChipStatus::kNoNewSample;
  }

  // The newest sample. kNoNewSample fills it too, with the previous sample if there was one. Eight bytes on the bus.
  // Not the temperature: behind OUT_Z_H a burst goes on at OUT_X_L [5.1.1: the registers of the output wrap around].
  ChipStatus Read(Lis3mdlSample& sample) noexcept {
    if (!started_) return ChipStatus::kNotStarted;
    std::uint8_t bytes[7] = {};  // STATUS, OUT_X..OUT_Z
    ChipStatus status = ReadRegisters(lis3mdl::kStatus, bytes, sizeof bytes);
    if (status == ChipStatus::kOk && AllEqual(bytes, sizeof bytes)) {
      // The chip also reads as zeros before its first sample.
      if (bytes[0] == 0x00 && !sampled_) return ChipStatus::kNoNewSample;
      status = ChipStatus::kNoAnswer;
    }
    if (status != ChipStatus::kOk) return Count(status);
    for (int axis = 0; axis < 3; ++axis) sample.field[axis] = Word(bytes + 1 + 2 * axis);
    sample.overrun = (bytes[0] & lis3mdl::kStatusOverrun) != 0;
    const bool fresh = (bytes[0] & lis3mdl::kStatusNew) != 0;
    sampled_ = sampled_ || fresh;
    return fresh ? ChipStatus::kOk : ChipStatus::kNoNewSample;
  }

  // Checks the control registers. If a brown-out has cleared them, the chip is configured again (kChanged). Once a
  // second or so is enough; a chip that was reset is powered down, so its samples stop at once.
  ChipStatus Verify() noexcept {
    if (!started_) return ChipStatus::kNotStarted;
    bool same = false;
    ChipStatus status = Compare(same);
    if (status != ChipStatus::kOk || same) return Count(status);
    started_ = false;
    status = CheckIdentity();
    if (status == ChipStatus::kOk) status = Configure();
    started_ = status == ChipStatus::kOk;
    return Count(started_ ? ChipStatus::kChanged : status);
  }

  // The chip adds a known field of its own; see lis3mdl::kSelfTest for the expected answer.
  ChipStatus SetSelfTest(bool on) noexcept {
    if (!started_) return ChipStatus::kNotStarted;
    if (on == self_test_) return ChipStatus::kOk;
    self_test_ = on;
    return Count(Configure());
  }

  static bool SelfTestAnswerIsRight(const std::int16_t (&without)[3], const std::int16_t (&with)[3]) noexcept {
    for (int axis = 0; axis < 3; ++axis) {
      const int difference = with[axis] - without[axis];
      const int answer = difference < 0 ? -difference : difference;
      const lis3mdl::SelfTestRange& range = lis3mdl::kSelfTest[axis];
      if (!(answer >= range.min_counts && answer <= range.max_counts)) return false;
    }
    return true;
  }

  bool started() const noexcept { return started_; }
  const ChipCounters& counters() const noexcept { return counters_; }

  static constexpr int kResetReads = 64;

 private:
  static constexpr std::size_t kRegisters = sizeof lis3mdl::kConfiguration;
  static constexpr std::size_t kTransferMax = 8;

  ChipStatus CheckIdentity() noexcept {
    std::uint8_t identity = 0;
    const ChipStatus status = ReadRegisters(lis3mdl::kWhoAmI, &identity, 1);
    if (status != ChipStatus::kOk) return status;
    if (identity == lis3mdl::kIdentity) return ChipStatus::kOk;
    return identity == 0x00 || identity == 0xFF ? ChipStatus::kNoAnswer : ChipStatus::kWrongIdentity;
  }

  ChipStatus SoftReset() noexcept {
    const std::uint8_t reset = lis3mdl::kCtrl2SoftReset;
    ChipStatus status = WriteRegisters(lis3mdl::kCtrl2, &reset, 1);
    for (int i = 0; i < kResetReads && status == ChipStatus::kOk; ++i) {
      std::uint8_t value = 0;
      status = ReadRegisters(lis3mdl::kCtrl2, &value, 1);
      if (status == ChipStatus::kOk && (value & lis3mdl::kCtrl2SoftReset) == 0) return ChipStatus::kOk;
    }
    return status == ChipStatus::kOk ? ChipStatus::kNotTaken : status;
  }

  ChipStatus Configure() noexcept {
    sampled_ = false;
    std::uint8_t wanted[kRegisters];
    Wanted(wanted);
    ChipStatus status = WriteRegisters(lis3mdl::kCtrl1, wanted, kRegisters);
    bool same = false;
    if (status == ChipStatus::kOk) status = Compare(same);
    if (status == ChipStatus::kOk && !same) return ChipStatus::kNotTaken;
    return status;
  }

  ChipStatus Compare(bool& same) noexcept {
    std::uint8_t wanted[kRegisters];
    std::uint8_t found[kRegisters] = {};
    Wanted(wanted);
    const ChipStatus status = ReadRegisters(lis3mdl::kCtrl1, found, kRegisters);
    same = status == ChipStatus::kOk;
    for (std::size_t i = 0; i < kRegisters; ++i) same = same && found[i] == wanted[i];
    return status;
  }

  void Wanted(std::uint8_t (&wanted)[kRegisters]) const noexcept {
    for (std::size_t i = 0; i < kRegisters; ++i) wanted[i] = lis3mdl::kConfiguration[i];
    if (self_test_) wanted[0] |= lis3mdl::kCtrl1SelfTest;
  }

  ChipStatus ReadRegisters(std::uint8_t first, std::uint8_t* values, std::size_t count) noexcept {
    std::uint8_t out[kTransferMax] = {};
    std::uint8_t in[kTransferMax] = {};
    out[0] = static_cast<std::uint8_t>(first | lis3mdl::kSpiRead | (count > 1 ? lis3mdl::kSpiIncrement : 0));
    const ChipStatus status = ToChipStatus(bus_.Transfer(out, in, count + 1));
    for (std::size_t i = 0; i < count; ++i) values[i] = in[i + 1];
    return status;
  }

  ChipStatus WriteRegisters(std::uint8_t first, const std::uint8_t* values, std::size_t count) noexcept {
    std::uint8_t out[kTransferMax] = {};
    std::uint8_t in[kTransferMax] = {};
    out[0] = static_cast<std::uint8_t>(first | (count > 1 ? lis3mdl::kSpiIncrement : 0));
    for (std::size_t i = 0; i < count; ++i) out[i + 1] = values[i];
    return ToChipStatus(bus_.Transfer(out, in, count + 1));
  }

  // An undriven line reads as only ones or only zeros. A chip that has just been reset answers only zeros too, which is
  // not a sample either.
  static bool AllEqual(const std::uint8_t* bytes, std::size_t count) noexcept {
    for (std::size_t i = 0; i < count; ++i) {
      if (bytes[i] != bytes[0]) return false;
    }
    return bytes[0] == 0x00 || bytes[0] == 0xFF;
  }

  static std::int16_t Word(const std::uint8_t* low_then_high) noexcept {
    return static_cast<std::int16_t>(low_then_high[0] | (low_then_high[1] << 8));
  }

  ChipStatus Count(ChipStatus status) noexcept {
    if (status == ChipStatus::kNack || status == ChipStatus::kTimeout || status == ChipStatus::kNoAnswer) {
      ++counters_.bus_errors;
    }
    if (status == ChipStatus::kWrongIdentity) ++counters_.wrong_identity;
    if (status == ChipStatus::kChanged || status == ChipStatus::kNotTaken) ++counters_.changed;
    return status;
  }

  Bus& bus_;
  bool started_ = false;
  bool self_test_ = false;
  bool sampled_ = false;  // since the configuration was written
  ChipCounters counters_;
};

}  // namespace omni::drivers
