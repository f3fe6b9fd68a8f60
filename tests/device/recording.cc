// Device recordings: what goes in comes out bit for bit, and everything that can be wrong with a file has its words.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cmath>
#include <csignal>
#include <limits>

#include "firmware/wire/frame.h"
#include "firmware/wire/messages.h"
#include "service/device/recording/recording_reader.h"
#include "tests/support/process/temp_folder.h"
#include "tests/support/rig/device_recording.h"
#include "tests/support/same_bits.h"

namespace omni::device {
namespace test_device_recording {

using support::FileBytes;

// The scans of a whole recording.
std::vector<ScanRecord> ScansOf(const std::string& path) {
  std::vector<ScanRecord> scans;
  auto reader = RecordingReader::Open(path);
  if (!reader.ok()) return scans;
  RecordView view;
  ScanRecord scan;
  while ((*reader)->Next(view) == RecordStatus::kRecord) {
    if (DecodeRecord(view, scan)) scans.push_back(scan);
  }
  return scans;
}

std::string Refusal(const std::string& path) {
  const auto summary = SummariseRecording(path);
  return summary.ok() ? "" : summary.error();
}

void PutU32(FileBytes& bytes, std::size_t at, std::uint32_t value) {
  for (std::size_t i = 0; i < 4; ++i) bytes[at + i] = static_cast<char>(value >> (8 * i));
}

// A valid CRC over the header's contents.
void SealHeader(FileBytes& bytes) {
  const auto* data = reinterpret_cast<const std::uint8_t*>(bytes.data());
  PutU32(bytes, kRecordingHeaderSize - 4, wire::Crc32c(data, kRecordingHeaderSize - 4));
}

TEST(DeviceRecording, ScansRoundTripBitForBit) {
  const test::TempFolder folder;
  const std::string path = folder.Path("device.rec");
  const std::vector<base::HallScan> scans = support::RecordTwin(path, 300);
  ASSERT_EQ(scans.size(), 300U);
  const std::vector<ScanRecord> back = ScansOf(path);
  ASSERT_EQ(back.size(), scans.size());
  for (std::size_t i = 0; i < scans.size(); ++i) ASSERT_TRUE(support::SameBits(scans[i], back[i].scan)) << i;
}

TEST(DeviceRecording, NonFiniteNumbersRoundTrip) {
  base::HallScan scan;
  scan.t_ns = std::numeric_limits<std::int64_t>::min();
  scan.sequence = ~std::uint64_t{0};
  scan.field_sensor_T[7].y = std::nan("7");
  scan.coil_current_A[1] = -INFINITY;
  scan.supply_V = -0.0;
  std::array<std::uint8_t, kRecordSizeMax> bytes{};
  const std::size_t size = EncodeRecord(ScanRecord{.read_ns = -1, .scan = scan}, bytes.data());
  RecordView view;
  ASSERT_EQ(ViewRecord(bytes.data(), size, view), ViewStatus::kOk);
  ScanRecord back;
  ASSERT_TRUE(DecodeRecord(view, back));
  EXPECT_TRUE(support::SameBits(back.scan, scan));
  EXPECT_EQ(back.read_ns, -1);
  CommandRecord command;
  EXPECT_FALSE(DecodeRecord(view, command)) << "another kind";
}

TEST(DeviceRecording, SummaryDescribesACompleteFile) {
  const test::TempFolder folder;
  const std::string path = folder.Path("device.rec");
  {
    const auto link = support::RecordedTwin(path, 0.2);
    base::HallScan scan;
    while (link->Read(scan, 0) == ReadStatus::kScan) link->Write({{0, 0, 1}});
    EXPECT_FALSE(link->Write({{NAN, 0, 0}}));
    link->recorder().Close();
    EXPECT_EQ(link->recorder().written(), 200U + 201U);
    EXPECT_EQ(link->recorder().lost(), 0U);
    EXPECT_EQ(link->recorder().problem(), "");
  }
  const auto summary = SummariseRecording(path);
  ASSERT_TRUE(summary.ok()) << summary.error();
  EXPECT_EQ(summary->info.name, "twin (simulation, virtual time)");
  EXPECT_EQ(summary->info.serial, "twin");
  EXPECT_TRUE(summary->info.simulation && summary->info.virtual_time);
  EXPECT_EQ(summary->info.current_max_A, support::NominalDevice().current_max_A);
  EXPECT_GT(summary->info.begun_unix_s, 1'500'000'000);
  EXPECT_EQ(summary->scans, 200U);
  EXPECT_EQ(summary->commands, 201U);
  EXPECT_EQ(summary->refused_commands, 1U);
  EXPECT_EQ(summary->missed + summary->lost + summary->backward, 0U);
  EXPECT_NEAR(summary->duration_s, 0.199, 1e-3);
  EXPECT_NEAR(summary->longest_gap_s, 1e-3, 1e-3);
  EXPECT_NEAR(summary->current_peak_A, 1, 0.05);
  EXPECT_GT(summary->faults[0].scans + summary->faults[1].scans, 0U) << "before the first command";
  EXPECT_TRUE(summary->ended);
  EXPECT_EQ(summary->last_status, ReadStatus::kEnd);
  EXPECT_EQ(summary->cut, "");
  EXPECT_EQ(summary->bytes, support::ReadBytes(path).size());
}

TEST(DeviceRecording, SummaryCountsGapsAndBackwardStamps) {
  const test::TempFolder folder;
  const std::string path = folder.Path("device.rec");
  {
    auto recorder = DeviceRecorder::Open(path, {.name = "hand made", .current_max_A = 15});
    ASSERT_TRUE(recorder.ok()) << recorder.error();
    ScanRecord record;
    for (const std::int64_t ms : {10, 11, 14, 13, 15}) {
      record.scan.t_ns = ms * 1'000'000;
      record.scan.sequence += ms == 14 ? 3 : 1;
      record.scan.device_faults = ms == 15 ? wire::kFaultFan : 0U;
      (*recorder)->Add(record);
    }
  }
  const auto summary = SummariseRecording(path);
  ASSERT_TRUE(summary.ok()) << summary.error();
  EXPECT_EQ(summary->missed, 2U);
  EXPECT_EQ(summary->backward, 1U);
  EXPECT_NEAR(summary->longest_gap_s, 3e-3, 1e-9);
  EXPECT_NEAR(summary->longest_gap_at_s, 1e-3, 1e-9);
  EXPECT_EQ(summary->faults[15].scans, 1U);
  EXPECT_NEAR(summary->faults[15].first_s, 5e-3, 1e-9);
}

// Cut anywhere: the records before the cut are read, and the message names the byte at which the file ends.
TEST(DeviceRecording, TruncatedFileIsReadableUpToTheCut) {
  const test::TempFolder folder;
  const std::string path = folder.Path("device.rec");
  support::RecordTwin(path, 3);
  const FileBytes whole = support::ReadBytes(path);
  const std::string cut = folder.Path("cut.rec");
  std::uint64_t scans_before = 0;
  for (std::size_t size = 0; size < whole.size(); ++size) {
    support::WriteBytes(cut, {whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)});
    const auto summary = SummariseRecording(cut);
    ASSERT_EQ(summary.ok(), size >= kRecordingHeaderSize) << size;
    if (!summary.ok()) {
      ASSERT_NE(summary.error().find(cut + ": at byte "), std::string::npos) << summary.error();
      continue;
    }
    ASSERT_FALSE(summary->ended);
    ASSERT_NE(summary->cut.find(cut + ": at byte " + std::to_string(summary->bytes)), std::string::npos);
    ASSERT_LE(summary->bytes, size);
    ASSERT_GE(summary->scans, scans_before);
    scans_before = summary->scans;
  }
  EXPECT_EQ(scans_before, 3U);
}

// Every damaged byte is detected; the message names the record that contains it.
TEST(DeviceRecording, DetectsDamageToAnyByte) {
  const test::TempFolder folder;
  const std::string path = folder.Path("device.rec");
  support::RecordTwin(path, 3);
  const FileBytes whole = support::ReadBytes(path);
  const std::string bad = folder.Path("bad.rec");
  for (std::size_t at = 0; at < whole.size(); ++at) {
    FileBytes damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
    support::WriteBytes(bad, damaged);
    const auto summary = SummariseRecording(bad);
    if (summary.ok()) {  // a size that now reaches beyond the end looks like a cut
      ASSERT_FALSE(summary->cut.empty()) << "byte " << at;
      ASSERT_LE(summary->bytes, at);
      continue;
    }
    ASSERT_NE(summary.error().find(bad), std::string::npos) << summary.error();
    if (at >= kRecordingHeaderSize) {
      ASSERT_NE(summary.error().find(": at byte "), std::string::npos) << summary.error();
      ASSERT_NE(summary.error().find("head -c "), std::string::npos) << summary.error();
    }
  }
}

TEST(DeviceRecording, RejectsOtherFilesAndFormatsWithRemedy) {
  const test::TempFolder folder;
  EXPECT_NE(Refusal(folder.Path("nothing")).find("No such file"), std::string::npos);
  EXPECT_NE(Refusal(folder.Path()).find("cannot be read"), std::string::npos) << "a folder";
  EXPECT_NE(Refusal(folder.Write("empty", "")).find("not a device recording"), std::string::npos);
  EXPECT_NE(Refusal(folder.Write("text", std::string(500, 'x'))).find("--record-device FILE creates one"),
            std::string::npos);
  const std::string path = folder.Path("device.rec");
  support::RecordTwin(path, 3);
  const FileBytes whole = support::ReadBytes(path);
  FileBytes newer = whole;
  newer[8] = 3;
  SealHeader(newer);
  support::WriteBytes(path, newer);
  EXPECT_NE(Refusal(path).find("of format 3, this program reads format 2: use the version of omni that made it"),
            std::string::npos)
      << Refusal(path);
  FileBytes other = whole;
  other[12] = 16;
  SealHeader(other);
  support::WriteBytes(path, other);
  EXPECT_NE(Refusal(path).find("another number of sensors"), std::string::npos) << Refusal(path);
  FileBytes damaged = whole;
  damaged[20] = static_cast<char>(damaged[20] ^ 1);
  support::WriteBytes(path, damaged);
  EXPECT_NE(Refusal(path).find("the header is damaged"), std::string::npos) << Refusal(path);
}

TEST(DeviceRecording, SkipsRecordsOfUnknownKind) {
  const test::TempFolder folder;
  const std::string path = folder.Path("device.rec");
  support::RecordTwin(path, 2);
  FileBytes bytes = support::ReadBytes(path);
  FileBytes newer{static_cast<char>(99), 0, 3, 0, 'a', 'b', 'c', 0, 0, 0, 0};
  PutU32(newer, 7, wire::Crc32c(reinterpret_cast<const std::uint8_t*>(newer.data()), 7));
  bytes.insert(bytes.begin() + kRecordingHeaderSize, newer.begin(), newer.end());
  support::WriteBytes(path, bytes);
  const auto summary = SummariseRecording(path);
  ASSERT_TRUE(summary.ok()) << summary.error();
  EXPECT_EQ(summary->scans, 2U);
  EXPECT_TRUE(summary->ended);
}

TEST(DeviceRecorder, OpenErrorNamesPathAndCause) {
  const auto missing = DeviceRecorder::Open("/nonexistent/device.rec", {});
  ASSERT_FALSE(missing.ok());
  EXPECT_NE(missing.error().find("/nonexistent/device.rec: cannot be written: there is no folder"), std::string::npos);
  const auto full = DeviceRecorder::Open("/dev/full", {});
  ASSERT_FALSE(full.ok());
  EXPECT_NE(full.error().find("No space left"), std::string::npos) << full.error();
}

// Faster than any writer: Add never waits, and every lost record is counted.
TEST(DeviceRecorder, CountsRecordsLostToAFullRing) {
  constexpr std::uint64_t kRecords = 200'000;
  const test::TempFolder folder;
  const std::string path = folder.Path("device.rec");
  auto recorder = DeviceRecorder::Open(path, {});
  ASSERT_TRUE(recorder.ok()) << recorder.error();
  ScanRecord record;
  for (std::uint64_t i = 1; i <= kRecords; ++i) {
    record.scan.sequence = i;
    (*recorder)->Add(record);
  }
  (*recorder)->Close();
  EXPECT_GT((*recorder)->lost(), 0U);
  EXPECT_EQ((*recorder)->written() + (*recorder)->lost(), kRecords);
  const auto summary = SummariseRecording(path);
  ASSERT_TRUE(summary.ok()) << summary.error();
  EXPECT_EQ(summary->scans, (*recorder)->written());
  EXPECT_EQ(summary->lost, (*recorder)->lost());
}

// A full disk, simulated by a limit on the size of files.
TEST(DeviceRecorder, FullDiskEndsTheRecordingWithAnError) {
  const test::TempFolder folder;
  const std::string path = folder.Path("device.rec");
  auto recorder = DeviceRecorder::Open(path, {});
  ASSERT_TRUE(recorder.ok()) << recorder.error();
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit small{10'000, before.rlim_max};
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  setrlimit(RLIMIT_FSIZE, &small);
  for (int i = 0; i < 1000; ++i) (*recorder)->Add(ScanRecord{});
  (*recorder)->Close();
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_NE((*recorder)->problem().find(path + ": the recording ends here: File too large"), std::string::npos)
      << (*recorder)->problem();
  EXPECT_LT((*recorder)->written(), 1000U);
  const auto summary = SummariseRecording(path);
  ASSERT_TRUE(summary.ok()) << summary.error();
  EXPECT_FALSE(summary->cut.empty());
  EXPECT_GT(summary->scans, 10U);
}

}  // namespace test_device_recording
}  // namespace omni::device
