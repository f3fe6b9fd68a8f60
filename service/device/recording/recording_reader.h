// Reads a device recording record by record, and summarises a whole one.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "service/base/result.h"
#include "service/base/unique_fd.h"
#include "service/device/recording/recording_format.h"

namespace omni::device {

enum class RecordStatus : std::uint8_t {
  kRecord = 0,
  kOver,       // no bytes after the last record
  kTruncated,  // the file ends within a record: its writer was killed, or the disk was full
  kCorrupt,    // a record's CRC is wrong
  kFailed      // the file could not be read
};

class RecordingReader {
 public:
  // The file is read from its beginning; it may still be growing.
  static base::Result<std::unique_ptr<RecordingReader>> Open(const std::string& path);

  const RecordingInfo& info() const noexcept { return info_; }
  const std::string& path() const noexcept { return path_; }

  // The next record; `view` holds until the next call. No allocation.
  RecordStatus Next(RecordView& view) noexcept;
  // Byte of the file at which the last Next started.
  std::uint64_t offset() const noexcept { return offset_; }
  // Error message: what is wrong at offset(), and what to do. Empty for kRecord and kOver.
  std::string Explain(RecordStatus status) const;

 private:
  RecordingReader(base::UniqueFd file, std::string path) : file_(std::move(file)), path_(std::move(path)) {}
  bool Fill() noexcept;

  static constexpr std::size_t kBufferSize = 1U << 16;
  static_assert(kBufferSize > kRecordSizeMax);

  base::UniqueFd file_;
  const std::string path_;
  RecordingInfo info_;
  std::array<std::uint8_t, kBufferSize> buffer_;
  std::size_t begin_ = 0, end_ = 0;  // of the unread bytes in buffer_
  std::size_t taken_ = 0;            // size of the record returned last
  std::uint64_t offset_ = 0;         // of buffer_[begin_] in the file
  int error_ = 0;
};

// One fault bit that occurs in a recording.
struct RecordedFault {
  std::uint64_t scans = 0;  // with that bit
  double first_s = 0;       // since the first scan
};

struct RecordingSummary {
  RecordingInfo info;
  std::uint64_t bytes = 0;
  std::uint64_t scans = 0;
  std::uint64_t commands = 0;
  std::uint64_t refused_commands = 0;
  std::uint64_t lost = 0;       // records lost to a full ring
  std::uint64_t missed = 0;     // ticks missing in the sequence
  std::uint64_t backward = 0;   // scans whose stamp is not after that of the scan before
  double duration_s = 0;        // from the first stamp to the last
  double longest_gap_s = 0;     // between two stamps
  double longest_gap_at_s = 0;  // where it begins
  double current_peak_A = 0;    // measured, largest magnitude; of finite ones
  std::array<RecordedFault, 32> faults{};
  bool ended = false;        // an end record stands at the end
  ReadStatus last_status{};  // of that record: why no more scans came
  std::string cut;           // message: why the file ends early; empty: it does not
};

// One pass over the whole file. A file that was cut off is valid up to the cut (`cut` says so); one with a damaged
// record in the middle is refused, with the offset.
base::Result<RecordingSummary> SummariseRecording(const std::string& path);

}  // namespace omni::device
