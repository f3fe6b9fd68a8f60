// The file of a device recording: what went through a Transport, bit for bit. Little endian.
//
//   header: "OMNIDEV\0" | u32 format | u16 sensors | u16 coils | u8 simulation | u8 virtual_time | u16 0
//           | f64 current_max_A | i64 begun, seconds since 1970 | char serial[32] | char name[64] | u32 CRC-32C
//   then records: u8 kind | u8 0 | u16 size | payload of `size` bytes | u32 CRC-32C of all bytes before it
//
// Units are those of base::HallScan. A reader skips whole records of an unknown kind; another format is refused. A file
// without an end record was cut off: the records in it are valid.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "service/base/force_limit.h"
#include "service/base/hall_scan.h"
#include "service/device/transport.h"

namespace omni::device {

constexpr std::uint32_t kRecordingFormat = 2;
constexpr std::size_t kRecordingHeaderSize = 136;
constexpr std::size_t kRecordPayloadMax = 1024;
constexpr std::size_t kRecordHeadSize = 4;
constexpr std::size_t kRecordSizeMax = kRecordHeadSize + kRecordPayloadMax + 4;

struct RecordingInfo {
  std::string name;  // of the transport, cut to 64 bytes
  std::string serial;
  bool simulation = false;
  bool virtual_time = false;  // stamps of scans are unrelated to the host's clock
  double current_max_A = 0;   // largest set-point that the transport accepted
  std::int64_t begun_unix_s = 0;
};

enum class RecordKind : std::uint8_t { kScan = 1, kCommand = 2, kLoss = 3, kEnd = 4 };

// A scan returned by Read.
struct ScanRecord {
  static constexpr RecordKind kKind = RecordKind::kScan;
  std::int64_t read_ns = 0;  // CLOCK_MONOTONIC when Read returned
  base::HallScan scan;
};

// Set-points passed to Write, in the order of the calls.
struct CommandRecord {
  static constexpr RecordKind kKind = RecordKind::kCommand;
  std::int64_t written_ns = 0;
  base::CoilCurrents currents;
  std::uint32_t sent = 0;  // 0: the transport refused
};

// Records lost to a full ring, since the start.
struct LossRecord {
  static constexpr RecordKind kKind = RecordKind::kLoss;
  std::uint64_t lost = 0;
};

// The recording was closed; why Read returned no more scans.
struct EndRecord {
  static constexpr RecordKind kKind = RecordKind::kEnd;
  std::uint64_t scans = 0;
  std::uint64_t commands = 0;
  std::uint64_t lost = 0;
  std::uint32_t last_status = 0;  // of ReadStatus
};

// Bytes written to `bytes` (kRecordingHeaderSize, or at most kRecordSizeMax).
void EncodeHeader(const RecordingInfo& info, std::uint8_t* bytes) noexcept;
template <class Record>
std::size_t EncodeRecord(const Record& record, std::uint8_t* bytes) noexcept;

enum class HeaderStatus : std::uint8_t { kOk = 0, kNotARecording, kOtherFormat, kOtherArray, kBadCrc };

struct HeaderResult {
  HeaderStatus status = HeaderStatus::kOk;
  std::uint32_t format = 0;  // that of the file
};

// `bytes`: kRecordingHeaderSize of them.
HeaderResult DecodeHeader(const std::uint8_t* bytes, RecordingInfo& info);

// One record's bytes as stored in the file.
struct RecordView {
  std::uint8_t kind = 0;
  const std::uint8_t* payload = nullptr;
  std::size_t payload_size = 0;
  std::size_t size = 0;  // with head and CRC
};

enum class ViewStatus : std::uint8_t {
  kOk = 0,
  kMore,   // the record is longer than the bytes available
  kBadCrc  // or an invalid record head
};
ViewStatus ViewRecord(const std::uint8_t* bytes, std::size_t size, RecordView& view) noexcept;

// False: another kind, or a payload of the wrong size. Bytes after the fields are ignored.
template <class Record>
bool DecodeRecord(const RecordView& view, Record& record) noexcept;

}  // namespace omni::device
