#include "service/device/recording/replay_transport.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <ctime>
#include <utility>

#include "service/base/clock.h"
#include "service/device/transport.h"

namespace omni::device {
namespace {

void SleepUntil(std::int64_t t_ns) noexcept {
  const timespec wake{t_ns / 1'000'000'000, t_ns % 1'000'000'000};
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &wake, nullptr);
}

class FileReplay final : public ReplayTransport {
 public:
  FileReplay(std::unique_ptr<RecordingReader> reader, RecordingSummary summary, ReplayPace pace)
      : reader_(std::move(reader)), summary_(std::move(summary)), pace_(pace) {
    info_ = {.name = "replay " + reader_->path() + " (" + summary_.info.name + ")",
             .serial = summary_.info.serial,
             .simulation = summary_.info.simulation,
             .virtual_time = pace == ReplayPace::kFast};
    Advance();
  }

  ReadStatus Read(base::HallScan& scan, std::int64_t timeout_ns) noexcept override {
    if (counters_.received.value() == summary_.scans) return ReadStatus::kEnd;  // last commands may still be written
    while (next_ == Next::kCommand) {                                           // recorded, but none written now
      ++missing_;
      Advance();
    }
    if (next_ == Next::kNothing) return ReadStatus::kEnd;
    if (pace_ == ReplayPace::kRecorded && !WaitForScan(timeout_ns)) return ReadStatus::kTimeout;
    scan = scan_.scan;
    if (pace_ == ReplayPace::kRecorded) scan.t_ns = base::StampAfter_ns(scan.t_ns, shift_ns_);
    ++counters_.received;
    if (sequence_ != 0 && scan.sequence > sequence_) {
      counters_.missed.Set(counters_.missed.value() + (scan.sequence - sequence_ - 1));
    }
    sequence_ = scan.sequence;
    Advance();
    return ReadStatus::kScan;
  }

  bool Write(const base::CoilCurrents& currents) noexcept override {
    for (const double current_A : currents.current_A) {
      if (std::abs(current_A) <= summary_.info.current_max_A) continue;
      ++counters_.send_failed;
      return false;
    }
    ++counters_.sent;
    if (next_ != Next::kCommand) {
      ++extra_;
      return true;
    }
    Compare(currents);
    Advance();
    return true;
  }

  const TransportInfo& info() const noexcept override { return info_; }
  TransportCounters counters() const noexcept override { return counters_.Snapshot(); }
  ReplayComparison comparison() const noexcept override {
    return {.same = same_.value(),
            .different = different_.value(),
            .extra = extra_.value(),
            .missing = missing_.value(),
            .largest_difference_A = largest_difference_A_.load(std::memory_order_relaxed)};
  }
  const RecordingSummary& summary() const noexcept override { return summary_; }

 private:
  enum class Next : std::uint8_t { kScan, kCommand, kNothing };

  // To the next scan or sent command.
  void Advance() noexcept {
    RecordView view;
    next_ = Next::kNothing;
    while (next_ == Next::kNothing && reader_->Next(view) == RecordStatus::kRecord) {
      if (DecodeRecord(view, scan_)) next_ = Next::kScan;
      if (DecodeRecord(view, command_) && command_.sent != 0) next_ = Next::kCommand;
    }
  }

  // False: the scan is not due within the time. Recorded delays are reproduced.
  bool WaitForScan(std::int64_t timeout_ns) noexcept {
    const std::int64_t came_ns = summary_.info.virtual_time ? scan_.scan.t_ns : scan_.read_ns;
    const std::int64_t now_ns = base::MonotonicNow_ns();
    if (!begun_) shift_ns_ = base::StampDifference_ns(now_ns, came_ns);
    begun_ = true;
    const std::int64_t due_ns = base::StampAfter_ns(came_ns, shift_ns_);
    const std::int64_t deadline_ns = base::StampAfter_ns(now_ns, timeout_ns);
    if (due_ns > now_ns) SleepUntil(std::min(due_ns, deadline_ns));
    return due_ns <= deadline_ns;
  }

  void Compare(const base::CoilCurrents& currents) noexcept {
    double difference_A = 0;
    for (std::size_t k = 0; k < base::kCoilCount; ++k) {
      difference_A = std::max(difference_A, std::abs(currents.current_A[k] - command_.currents.current_A[k]));
    }
    if (difference_A == 0) {
      ++same_;
    } else {
      ++different_;
    }
    largest_difference_A_.store(std::max(largest_difference_A_.load(std::memory_order_relaxed), difference_A),
                                std::memory_order_relaxed);
  }

  std::unique_ptr<RecordingReader> reader_;
  const RecordingSummary summary_;
  const ReplayPace pace_;
  TransportInfo info_;
  Counters counters_;
  Counter same_, different_, extra_, missing_;
  std::atomic<double> largest_difference_A_{0};
  ScanRecord scan_;
  CommandRecord command_;
  Next next_ = Next::kNothing;
  std::int64_t shift_ns_ = 0;
  std::uint64_t sequence_ = 0;
  bool begun_ = false;
};

}  // namespace

base::Result<std::unique_ptr<ReplayTransport>> OpenReplay(const std::string& path, ReplayPace pace) {
  base::Result<RecordingSummary> summary = SummariseRecording(path);
  if (!summary.ok()) return base::Error{summary.error()};
  if (summary->scans == 0) {
    return base::Error{path + ": at byte " + std::to_string(summary->bytes) +
                       ": the recording holds no scan: record again, for longer"};
  }
  auto reader = RecordingReader::Open(path);
  if (!reader.ok()) return base::Error{reader.error()};
  return std::unique_ptr<ReplayTransport>(std::make_unique<FileReplay>(std::move(*reader), std::move(*summary), pace));
}

}  // namespace omni::device
