#include "service/device/recording/recording_format.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "firmware/wire/bytes.h"
#include "firmware/wire/frame.h"

namespace omni::device {
namespace {

constexpr std::array<char, 8> kMagic{'O', 'M', 'N', 'I', 'D', 'E', 'V', '\0'};
constexpr std::size_t kSerialSize = 32;
constexpr std::size_t kNameSize = 64;
constexpr std::size_t kCrcSize = 4;

template <class T, RecordKind kKind>
concept RecordOf = T::kKind == kKind;

// Fields of a record, in the order of the file: written and read by the same list.
template <class Vector, class Visit>
void VisitVector(Vector& v, Visit&& visit) {
  visit(v.x);
  visit(v.y);
  visit(v.z);
}
template <RecordOf<RecordKind::kScan> Record, class Visit>
void VisitFields(Record& record, Visit&& visit) {
  visit(record.read_ns);
  auto& scan = record.scan;
  visit(scan.t_ns);
  visit(scan.sequence);
  for (auto& field : scan.field_sensor_T) VisitVector(field, visit);
  for (auto& age_ns : scan.age_ns) visit(age_ns);
  visit(scan.fresh_mask);
  visit(scan.saturated_mask);
  for (auto& current_A : scan.coil_current_A) visit(current_A);
  for (auto& step : scan.step_current_A) {
    for (auto& current_A : step) visit(current_A);
  }
  visit(scan.tick_lead_ns);
  visit(scan.response_ns);
  for (auto& temperature_C : scan.coil_temperature_C) visit(temperature_C);
  visit(scan.supply_V);
  visit(scan.has_steps);
  visit(scan.device_faults);
}
template <RecordOf<RecordKind::kCommand> Record, class Visit>
void VisitFields(Record& record, Visit&& visit) {
  visit(record.written_ns);
  for (auto& current_A : record.currents.current_A) visit(current_A);
  visit(record.sent);
}
template <RecordOf<RecordKind::kLoss> Record, class Visit>
void VisitFields(Record& record, Visit&& visit) {
  visit(record.lost);
}
template <RecordOf<RecordKind::kEnd> Record, class Visit>
void VisitFields(Record& record, Visit&& visit) {
  visit(record.scans);
  visit(record.commands);
  visit(record.lost);
  visit(record.last_status);
}

struct PutField {
  wire::ByteWriter& out;
  void operator()(std::int64_t value) noexcept { out.U64(static_cast<std::uint64_t>(value)); }
  void operator()(std::uint64_t value) noexcept { out.U64(value); }
  void operator()(std::uint32_t value) noexcept { out.U32(value); }
  void operator()(double value) noexcept { out.U64(std::bit_cast<std::uint64_t>(value)); }
};

struct GetField {
  wire::ByteReader& in;
  void operator()(std::int64_t& value) noexcept { value = static_cast<std::int64_t>(in.U64()); }
  void operator()(std::uint64_t& value) noexcept { value = in.U64(); }
  void operator()(std::uint32_t& value) noexcept { value = in.U32(); }
  void operator()(double& value) noexcept { value = std::bit_cast<double>(in.U64()); }
};

void PutText(wire::ByteWriter& out, const std::string& text, std::size_t size) noexcept {
  for (std::size_t i = 0; i < size; ++i) out.U8(i < text.size() ? static_cast<std::uint8_t>(text[i]) : 0);
}

// Up to the first zero; control characters never reach a terminal.
std::string GetText(wire::ByteReader& in, std::size_t size) {
  std::string text;
  bool ended = false;
  for (std::size_t i = 0; i < size; ++i) {
    const char c = static_cast<char>(in.U8());
    ended = ended || c == '\0';
    if (!ended) text += c >= ' ' && c <= '~' ? c : '?';
  }
  return text;
}

}  // namespace

void EncodeHeader(const RecordingInfo& info, std::uint8_t* bytes) noexcept {
  wire::ByteWriter out(bytes, kRecordingHeaderSize);
  for (const char c : kMagic) out.U8(static_cast<std::uint8_t>(c));
  out.U32(kRecordingFormat);
  out.U16(base::kSensorCount);
  out.U16(base::kCoilCount);
  out.U8(info.simulation ? 1 : 0);
  out.U8(info.virtual_time ? 1 : 0);
  out.U16(0);
  out.U64(std::bit_cast<std::uint64_t>(info.current_max_A));
  out.U64(static_cast<std::uint64_t>(info.begun_unix_s));
  PutText(out, info.serial, kSerialSize);
  PutText(out, info.name, kNameSize);
  out.U32(wire::Crc32c(bytes, kRecordingHeaderSize - kCrcSize));
}

HeaderResult DecodeHeader(const std::uint8_t* bytes, RecordingInfo& info) {
  wire::ByteReader in(bytes, kRecordingHeaderSize);
  for (const char c : kMagic) {
    if (in.U8() != static_cast<std::uint8_t>(c)) return {.status = HeaderStatus::kNotARecording};
  }
  HeaderResult result{.format = in.U32()};
  const bool same_array = in.U16() == base::kSensorCount && in.U16() == base::kCoilCount;
  if (result.format != kRecordingFormat) {
    result.status = HeaderStatus::kOtherFormat;
  } else if (wire::ByteReader crc(bytes + kRecordingHeaderSize - kCrcSize, kCrcSize);
             crc.U32() != wire::Crc32c(bytes, kRecordingHeaderSize - kCrcSize)) {
    result.status = HeaderStatus::kBadCrc;
  } else if (!same_array) {
    result.status = HeaderStatus::kOtherArray;
  } else {
    info.simulation = in.U8() != 0;
    info.virtual_time = in.U8() != 0;
    in.U16();
    info.current_max_A = std::bit_cast<double>(in.U64());
    info.begun_unix_s = static_cast<std::int64_t>(in.U64());
    info.serial = GetText(in, kSerialSize);
    info.name = GetText(in, kNameSize);
  }
  return result;
}

template <class Record>
std::size_t EncodeRecord(const Record& record, std::uint8_t* bytes) noexcept {
  wire::ByteWriter payload(bytes + kRecordHeadSize, kRecordPayloadMax);
  VisitFields(record, PutField{payload});
  wire::ByteWriter head(bytes, kRecordHeadSize);
  head.U8(static_cast<std::uint8_t>(Record::kKind));
  head.U8(0);
  head.U16(static_cast<std::uint16_t>(payload.size()));
  const std::size_t body = kRecordHeadSize + payload.size();
  wire::ByteWriter crc(bytes + body, kCrcSize);
  crc.U32(wire::Crc32c(bytes, body));
  return body + kCrcSize;
}

ViewStatus ViewRecord(const std::uint8_t* bytes, std::size_t size, RecordView& view) noexcept {
  if (size < kRecordHeadSize) return ViewStatus::kMore;
  wire::ByteReader head(bytes, kRecordHeadSize);
  view.kind = head.U8();
  head.U8();
  view.payload_size = head.U16();
  if (view.payload_size > kRecordPayloadMax) return ViewStatus::kBadCrc;
  view.size = kRecordHeadSize + view.payload_size + kCrcSize;
  if (size < view.size) return ViewStatus::kMore;
  view.payload = bytes + kRecordHeadSize;
  wire::ByteReader crc(bytes + view.size - kCrcSize, kCrcSize);
  return crc.U32() == wire::Crc32c(bytes, view.size - kCrcSize) ? ViewStatus::kOk : ViewStatus::kBadCrc;
}

template <class Record>
bool DecodeRecord(const RecordView& view, Record& record) noexcept {
  if (view.kind != static_cast<std::uint8_t>(Record::kKind)) return false;
  wire::ByteReader in(view.payload, view.payload_size);
  VisitFields(record, GetField{in});
  return in.ok();
}

#define OMNI_RECORD(Record)                                                 \
  template std::size_t EncodeRecord(const Record&, std::uint8_t*) noexcept; \
  template bool DecodeRecord(const RecordView&, Record&) noexcept;  // NOLINT(bugprone-macro-parentheses): a type
OMNI_RECORD(ScanRecord)
OMNI_RECORD(CommandRecord)
OMNI_RECORD(LossRecord)
OMNI_RECORD(EndRecord)
#undef OMNI_RECORD

}  // namespace omni::device
