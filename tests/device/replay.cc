// Replays: every scan once, in order and in time; what the host writes is compared, never applied.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "service/base/clock.h"
#include "service/device/recording/replay_transport.h"
#include "tests/support/process/temp_folder.h"
#include "tests/support/rig/device_recording.h"
#include "tests/support/same_bits.h"

namespace omni::device {
namespace test_device_replay {

constexpr std::int64_t kMillisecond_ns = 1'000'000;

std::unique_ptr<ReplayTransport> Replay(const std::string& path, ReplayPace pace) {
  auto replay = OpenReplay(path, pace);
  EXPECT_TRUE(replay.ok());
  return replay.ok() ? std::move(*replay) : nullptr;
}

// As RecordTwin commanded after scan `i`.
base::CoilCurrents Commanded(std::size_t i) { return {{0.25, -0.5, 1e-3 * static_cast<double>(i + 1)}}; }

TEST(Replay, FastPaceReproducesScansBitForBit) {
  const test::TempFolder folder;
  const std::string path = folder.Path("device.rec");
  const std::vector<base::HallScan> scans = support::RecordTwin(path, 500);
  const auto replay = Replay(path, ReplayPace::kFast);
  EXPECT_TRUE(replay->info().virtual_time);
  EXPECT_NE(replay->info().name.find("replay " + path), std::string::npos);
  base::HallScan scan;
  for (std::size_t i = 0; i < scans.size(); ++i) {
    ASSERT_EQ(replay->Read(scan, 0), ReadStatus::kScan);
    ASSERT_TRUE(support::SameBits(scan, scans[i])) << i;
    ASSERT_TRUE(replay->Write(Commanded(i)));
  }
  EXPECT_EQ(replay->Read(scan, 0), ReadStatus::kEnd);
  EXPECT_EQ(replay->Read(scan, 0), ReadStatus::kEnd) << "and stays there";
  EXPECT_EQ(replay->comparison().same, 500U);
  EXPECT_EQ(replay->comparison().different + replay->comparison().extra + replay->comparison().missing, 0U);
  EXPECT_EQ(replay->counters().received, 500U);
}

TEST(Replay, ComparesCommandsWithTheRecording) {
  const test::TempFolder folder;
  const std::string path = folder.Path("device.rec");
  support::RecordTwin(path, 4);
  const auto replay = Replay(path, ReplayPace::kFast);
  base::HallScan scan;
  replay->Read(scan, 0);
  EXPECT_TRUE(replay->Write(Commanded(0)));
  EXPECT_TRUE(replay->Write(Commanded(0))) << "one more than recorded";
  replay->Read(scan, 0);
  EXPECT_TRUE(replay->Write({{0.25, -0.5, 1.002}}));
  replay->Read(scan, 0);
  replay->Read(scan, 0);  // nothing written between the two
  EXPECT_FALSE(replay->Write({{NAN, 0, 0}}));
  EXPECT_FALSE(replay->Write({{15.1, 0, 0}})) << "the recorded base accepted at most 15 A";
  EXPECT_EQ(replay->Read(scan, 0), ReadStatus::kEnd);
  const ReplayComparison comparison = replay->comparison();
  EXPECT_EQ(comparison.same, 1U);
  EXPECT_EQ(comparison.extra, 1U);
  EXPECT_EQ(comparison.different, 1U);
  EXPECT_EQ(comparison.missing, 1U) << "after the last scan it may still come";
  EXPECT_NEAR(comparison.largest_difference_A, 1, 1e-9);
  EXPECT_EQ(replay->counters().sent, 3U);
  EXPECT_EQ(replay->counters().send_failed, 2U);
}

// Scans at 0, 5, 5 and 205 ms, recorded with a delay of 2 ms.
std::string RecordedAtIntervals(const test::TempFolder& folder) {
  const std::string path = folder.Path("paced.rec");
  auto recorder = DeviceRecorder::Open(path, {.name = "hand made", .current_max_A = 15});
  EXPECT_TRUE(recorder.ok());
  ScanRecord record;
  for (const std::int64_t ms : {0, 5, 5, 205}) {
    record.scan.t_ns = (7000 + ms) * kMillisecond_ns;
    record.read_ns = record.scan.t_ns + 2 * kMillisecond_ns;
    record.scan.sequence += ms == 205 ? 40 : 1;
    (*recorder)->Add(record);
  }
  return path;
}

TEST(Replay, RecordedPaceKeepsIntervalsAndDelays) {
  const test::TempFolder folder;
  const std::string path = RecordedAtIntervals(folder);
  const auto replay = Replay(path, ReplayPace::kRecorded);
  EXPECT_FALSE(replay->info().virtual_time);
  base::HallScan first;
  ASSERT_EQ(replay->Read(first, 0), ReadStatus::kScan);
  const std::int64_t begin_ns = base::MonotonicNow_ns();
  EXPECT_GE(begin_ns - first.t_ns, 2 * kMillisecond_ns) << "stamped 2 ms before it came, as recorded";
  EXPECT_LT(begin_ns - first.t_ns, 1'000 * kMillisecond_ns);
  base::HallScan scan;
  ASSERT_EQ(replay->Read(scan, 1'000 * kMillisecond_ns), ReadStatus::kScan);
  EXPECT_EQ(scan.t_ns - first.t_ns, 5 * kMillisecond_ns);
  EXPECT_GE(base::MonotonicNow_ns() - first.t_ns, 7 * kMillisecond_ns) << "not before its time";
  ASSERT_EQ(replay->Read(scan, 0), ReadStatus::kScan) << "due already";
  EXPECT_EQ(scan.t_ns - first.t_ns, 5 * kMillisecond_ns);
  int timeouts = 0;
  while (replay->Read(scan, kMillisecond_ns) == ReadStatus::kTimeout) ++timeouts;
  EXPECT_GT(timeouts, 0);
  EXPECT_EQ(scan.t_ns - first.t_ns, 205 * kMillisecond_ns);
  EXPECT_GE(base::MonotonicNow_ns() - first.t_ns, 207 * kMillisecond_ns);
  EXPECT_EQ(replay->counters().missed, 39U);
  EXPECT_EQ(replay->Read(scan, 0), ReadStatus::kEnd);
}

TEST(Replay, RecordingOfAReplayEqualsTheOriginal) {
  const test::TempFolder folder;
  const std::string first = folder.Path("first.rec");
  const std::string second = folder.Path("second.rec");
  const std::vector<base::HallScan> scans = support::RecordTwin(first, 50);
  {
    auto inner = OpenReplay(first, ReplayPace::kFast);
    ASSERT_TRUE(inner.ok());
    auto recorder = DeviceRecorder::Open(second, DescribeForRecording((*inner)->info(), 15));
    ASSERT_TRUE(recorder.ok());
    RecordingTransport link(std::move(*inner), std::move(*recorder));
    base::HallScan scan;
    while (link.Read(scan, 0) == ReadStatus::kScan) link.Write({});
  }
  const auto replay = Replay(second, ReplayPace::kFast);
  base::HallScan scan;
  for (const base::HallScan& expected : scans) {
    ASSERT_EQ(replay->Read(scan, 0), ReadStatus::kScan);
    ASSERT_TRUE(support::SameBits(scan, expected));
  }
}

TEST(Replay, RejectsRecordingsWithoutScans) {
  const test::TempFolder folder;
  const std::string path = folder.Path("device.rec");
  ASSERT_TRUE(DeviceRecorder::Open(path, {}).ok());
  const auto replay = OpenReplay(path, ReplayPace::kFast);
  ASSERT_FALSE(replay.ok());
  EXPECT_NE(replay.error().find(path + ": at byte"), std::string::npos);
  EXPECT_NE(replay.error().find("holds no scan"), std::string::npos) << replay.error();
  EXPECT_FALSE(OpenReplay(folder.Path("nothing"), ReplayPace::kFast).ok());
}

}  // namespace test_device_replay
}  // namespace omni::device
