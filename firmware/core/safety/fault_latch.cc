#include "firmware/core/safety/fault_latch.h"

#include "firmware/wire/bytes.h"
#include "firmware/wire/frame.h"

namespace omni::firmware {

std::uint32_t CheckOf(const FaultRecord& record) noexcept {
  std::uint8_t bytes[24] = {};
  wire::ByteWriter out(bytes, sizeof bytes);
  out.U32(record.fault);
  out.U32(record.faults);
  out.U8(record.state);
  out.U8(record.part);
  out.U16(record.count);
  out.F32(record.value);
  out.U64(record.t_us);
  return wire::Crc32c(bytes, out.size());
}

FaultLatch::FaultLatch(FaultRecord& record) noexcept : record_(record) {
  record_was_broken_ = record.check != CheckOf(record) ||
                       record.state > static_cast<std::uint8_t>(wire::State::kFault) || !IsFinite(record.value);
  if (record_was_broken_) {
    record = FaultRecord{};
    record.check = CheckOf(record);
  }
  before_reset_ = record;
}

bool FaultLatch::Raise(wire::Fault fault, std::uint8_t part, float value, wire::State state,
                       std::uint64_t t_us) noexcept {
  if ((latched_ & fault) != 0) return false;
  latched_ |= fault;
  if ((fault & wire::kFaultsOfTheHost) != 0) return true;
  FaultRecord record;
  record.fault = fault;
  record.faults = latched_;
  record.state = static_cast<std::uint8_t>(state);
  record.part = part;
  record.count = static_cast<std::uint16_t>(record_.count + 1);
  record.value = IsFinite(value) ? value : 0;
  record.t_us = t_us;
  record.check = CheckOf(record);
  record_ = record;
  return true;
}

wire::FaultEvent FaultLatch::BeforeReset() const noexcept {
  wire::FaultEvent event;
  event.fault = before_reset_.fault;
  event.faults = before_reset_.faults;
  event.state = static_cast<wire::State>(before_reset_.state);
  event.part = before_reset_.part;
  event.after_reset = 1;
  event.value = before_reset_.value;
  event.t_us = before_reset_.t_us;
  return event;
}

}  // namespace omni::firmware
