#include "service/device/recording/recording_reader.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>

#include "service/base/clock.h"

namespace omni::device {
namespace {

std::string ExplainHeader(const std::string& path, const HeaderResult& header) {
  switch (header.status) {
    case HeaderStatus::kOtherFormat:
      return path + ": a device recording of format " + std::to_string(header.format) + ", this program reads format " +
             std::to_string(kRecordingFormat) + ": use the version of omni that made it, or record again";
    case HeaderStatus::kOtherArray:
      return path + ": recorded from a base with another number of sensors or coils: use a build for that base";
    case HeaderStatus::kBadCrc:
      return path + ": at byte 0: the header is damaged: use another copy, or record again";
    case HeaderStatus::kNotARecording:
    case HeaderStatus::kOk:
      break;
  }
  return path + ": at byte 0: not a device recording: omnid --record-device FILE creates one";
}

// Reads until `size` bytes are there or the file ends; -1: errno.
ssize_t ReadSome(int fd, std::uint8_t* bytes, std::size_t size) noexcept {
  std::size_t done = 0;
  while (done < size) {
    const ssize_t got = read(fd, bytes + done, size - done);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return -1;
    if (got == 0) break;
    done += static_cast<std::size_t>(got);
  }
  return static_cast<ssize_t>(done);
}

}  // namespace

base::Result<std::unique_ptr<RecordingReader>> RecordingReader::Open(const std::string& path) {
  base::UniqueFd file(open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (!file) return base::Error{path + ": cannot be read: " + std::strerror(errno) + ": check the name"};
  std::array<std::uint8_t, kRecordingHeaderSize> bytes{};
  const ssize_t size = ReadSome(file.get(), bytes.data(), bytes.size());
  if (size < 0) return base::Error{path + ": cannot be read: " + std::strerror(errno) + ": check the name"};
  std::unique_ptr<RecordingReader> reader(new RecordingReader(std::move(file), path));
  const HeaderResult header = DecodeHeader(bytes.data(), reader->info_);
  const bool begins_well = header.status != HeaderStatus::kNotARecording;
  if (begins_well && size < static_cast<ssize_t>(kRecordingHeaderSize)) {
    return base::Error{path + ": at byte " + std::to_string(size) +
                       ": the file ends within its header and contains no data: record again"};
  }
  if (header.status != HeaderStatus::kOk) return base::Error{ExplainHeader(path, header)};
  reader->offset_ = kRecordingHeaderSize;
  return reader;
}

// Reads more bytes after the unread ones. False: there are none.
bool RecordingReader::Fill() noexcept {
  std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
  end_ -= begin_;
  begin_ = 0;
  const ssize_t got = ReadSome(file_.get(), buffer_.data() + end_, buffer_.size() - end_);
  if (got < 0) error_ = errno;
  if (got <= 0) return false;
  end_ += static_cast<std::size_t>(got);
  return true;
}

RecordStatus RecordingReader::Next(RecordView& view) noexcept {
  begin_ += taken_;
  offset_ += taken_;
  taken_ = 0;
  for (;;) {
    switch (ViewRecord(buffer_.data() + begin_, end_ - begin_, view)) {
      case ViewStatus::kOk:
        taken_ = view.size;
        return RecordStatus::kRecord;
      case ViewStatus::kBadCrc:
        return RecordStatus::kCorrupt;
      case ViewStatus::kMore:
        break;
    }
    if (Fill()) continue;
    if (error_ != 0) return RecordStatus::kFailed;
    return begin_ == end_ ? RecordStatus::kOver : RecordStatus::kTruncated;
  }
}

std::string RecordingReader::Explain(RecordStatus status) const {
  const std::string at = path_ + ": at byte " + std::to_string(offset_) + ": ";
  switch (status) {
    case RecordStatus::kRecord:
    case RecordStatus::kOver:
      return "";
    case RecordStatus::kTruncated:
      return at +
             "the file ends within a record: its writer was killed, or the disk was full; everything before it is "
             "intact";
    case RecordStatus::kCorrupt:
      return at + "a record is damaged: use another copy, or keep the records before it: head -c " +
             std::to_string(offset_) + " " + path_ + " > NEW";
    case RecordStatus::kFailed:
      break;
  }
  return at + "cannot be read: " + std::strerror(error_);
}

namespace {

class Summariser {
 public:
  explicit Summariser(const RecordingInfo& info) { summary_.info = info; }

  void Add(const RecordView& view) {
    ScanRecord scan;
    CommandRecord command;
    LossRecord loss;
    EndRecord end;
    if (DecodeRecord(view, scan)) Add(scan.scan);
    if (DecodeRecord(view, command)) {
      ++summary_.commands;
      if (command.sent == 0) ++summary_.refused_commands;
    }
    if (DecodeRecord(view, loss)) summary_.lost = loss.lost;
    summary_.ended = DecodeRecord(view, end);
    if (!summary_.ended) return;
    summary_.lost = end.lost;
    summary_.last_status = static_cast<ReadStatus>(std::min(end.last_status, std::uint32_t{3}));
  }
  RecordingSummary& summary() { return summary_; }

 private:
  void Add(const base::HallScan& scan) {
    if (summary_.scans == 0) first_ns_ = scan.t_ns;
    if (summary_.scans > 0) AddStep(scan);
    ++summary_.scans;
    summary_.duration_s = base::Elapsed_s(scan.t_ns, first_ns_);
    for (unsigned bit = 0; bit < summary_.faults.size(); ++bit) {
      if ((scan.device_faults >> bit & 1U) == 0) continue;
      RecordedFault& fault = summary_.faults[bit];
      if (fault.scans++ == 0) fault.first_s = summary_.duration_s;
    }
    for (const double current_A : scan.coil_current_A) {
      if (std::isfinite(current_A)) summary_.current_peak_A = std::max(summary_.current_peak_A, std::abs(current_A));
    }
    before_ = scan;
  }

  void AddStep(const base::HallScan& scan) {
    if (scan.sequence > before_.sequence) summary_.missed += scan.sequence - before_.sequence - 1;
    if (scan.t_ns <= before_.t_ns) ++summary_.backward;
    const double gap_s = base::Elapsed_s(scan.t_ns, before_.t_ns);
    if (gap_s <= summary_.longest_gap_s) return;
    summary_.longest_gap_s = gap_s;
    summary_.longest_gap_at_s = summary_.duration_s;
  }

  RecordingSummary summary_;
  base::HallScan before_;
  std::int64_t first_ns_ = 0;
};

}  // namespace

base::Result<RecordingSummary> SummariseRecording(const std::string& path) {
  auto reader = RecordingReader::Open(path);
  if (!reader.ok()) return base::Error{reader.error()};
  Summariser summariser((*reader)->info());
  RecordView view;
  RecordStatus status = RecordStatus::kRecord;
  while ((status = (*reader)->Next(view)) == RecordStatus::kRecord) summariser.Add(view);
  if (status == RecordStatus::kCorrupt || status == RecordStatus::kFailed) {
    return base::Error{(*reader)->Explain(status)};
  }
  RecordingSummary& summary = summariser.summary();
  summary.bytes = (*reader)->offset();
  summary.cut = (*reader)->Explain(status);
  if (summary.cut.empty() && !summary.ended) {
    summary.cut = path + ": at byte " + std::to_string(summary.bytes) +
                  ": no end record: its writer is still running or was killed; everything before it is intact";
  }
  return std::move(summary);
}

}  // namespace omni::device
