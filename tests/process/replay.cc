// omnid records its device, omni summarises the recording, and omnid replays it: real processes.
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "service/base/sanitized.h"
#include "service/device/recording/device_recorder.h"
#include "service/device/recording/recording_reader.h"
#include "tests/support/process/service_process.h"

namespace omni::test {
namespace test_process_replay {

const std::string kOmnid = OMNI_BINARY_DIR "/bin/omnid";
const std::string kOmni = OMNI_BINARY_DIR "/bin/omni";

class ProcessReplay : public testing::Test {
 protected:
  ProcessReplay() {
    std::filesystem::create_directories(folder_.Path("run"));
    std::filesystem::permissions(folder_.Path("run"), std::filesystem::perms::owner_all);
  }

  base::Result<test::ChildProcess> Start(const std::vector<std::string>& words, const std::string& output = {}) {
    return test::ChildProcess::Start(
        words, {"OMNI_SOCKET=" + folder_.Path("run/omnid.sock"), "XDG_CONFIG_HOME=" + folder_.Path("config")}, output);
  }

  // stdout of `words`, started and ended by itself; stderr is the test's.
  std::string OutputOf(const std::vector<std::string>& words, int status) {
    const std::string path = folder_.Path("output.txt");
    auto child = Start(words, path);
    if (!child.ok()) return "";
    EXPECT_EQ(child->Wait(), status);
    std::ifstream file(path);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  // Until the recording has several hundred scans, which takes a busy machine longer; then `signal`.
  void Record(int signal, int times = 1) {
    auto omnid = Start({kOmnid, "--device", "twin", "--twin", "ideal", "--record-device", recording_, "--twin-seed",
                        "3", "--log-level", "warn"});
    ASSERT_TRUE(omnid.ok()) << omnid.error();
    std::error_code error;
    for (int i = 0; i < 300 && !(std::filesystem::file_size(recording_, error) > 400'000 && !error); ++i) SleepMs(100);
    for (int i = 0; i < times; ++i) {
      kill(omnid->pid(), signal);
      SleepMs(3);
    }
    const int status = omnid->Wait();
    EXPECT_EQ(status, signal == SIGKILL ? 128 + signal : 0);
  }

  const TempFolder folder_;
  std::string recording_ = folder_.Path("device.rec");
};

TEST_F(ProcessReplay, RecordedShownAndPlayed) {
  Record(SIGTERM);
  const auto summary = device::SummariseRecording(recording_);
  ASSERT_TRUE(summary.ok()) << summary.error();
  EXPECT_EQ(summary->info.serial, "twin-3") << "so that a calibration of that base is taken again";
  EXPECT_TRUE(summary->info.simulation);
  EXPECT_GT(summary->scans, 500U);
  EXPECT_GT(summary->commands, 30U);
  EXPECT_TRUE(summary->ended);
  const std::string shown = OutputOf({kOmni, "replay", recording_}, 0);
  EXPECT_NE(shown.find("serial twin-3, a simulation"), std::string::npos) << shown;
  EXPECT_NE(shown.find("scans     " + std::to_string(summary->scans) + " in "), std::string::npos) << shown;
  EXPECT_NE(shown.find("end       closed by its writer"), std::string::npos) << shown;
  // Each ends by itself, at the end of the recording.
  EXPECT_EQ(OutputOf({kOmnid, "--device", "replay:" + recording_, "--replay-fast", "--log-level", "warn"}, 0), "");
  const std::int64_t begin_ns = base::MonotonicNow_ns();
  const std::string again = folder_.Path("again.rec");
  EXPECT_EQ(OutputOf({kOmnid, "--device", "replay:" + recording_, "--record-device", again, "--log-level", "warn"}, 0),
            "");
  // Scans come when they came, which is up to a tick after their stamps. A busy machine may start omnid late.
  const double took_s = static_cast<double>(base::MonotonicNow_ns() - begin_ns) * 1e-9;
  EXPECT_GE(took_s, summary->duration_s - 1e-3);
  if (!base::kSanitized) {  // in virtual time
    EXPECT_LE(took_s, 2 * summary->duration_s);
  }
  const auto second = device::SummariseRecording(again);
  ASSERT_TRUE(second.ok()) << second.error();
  EXPECT_EQ(second->scans, summary->scans);
  EXPECT_EQ(second->missed, summary->missed);
  EXPECT_NEAR(second->duration_s, summary->duration_s, 1e-9);
}

// A closed terminal, and a supervisor that signals the group of a program that passes signals on.
TEST_F(ProcessReplay, EverySignalToEndClosesTheRecording) {
  int n = 0;
  for (const int signal : {SIGHUP, SIGTERM, SIGINT}) {
    for (const int times : {1, 2, 3}) {
      SCOPED_TRACE(testing::Message() << "signal " << signal << ", " << times << " times");
      recording_ = folder_.Path(std::to_string(++n) + ".rec");
      Record(signal, times);
      const auto summary = device::SummariseRecording(recording_);
      ASSERT_TRUE(summary.ok()) << summary.error();
      EXPECT_TRUE(summary->ended);
    }
  }
}

// A name typed twice, and a link planted where a recording is expected.
TEST_F(ProcessReplay, RecordingsReplaceNothingUnasked) {
  const std::string precious = folder_.Write("precious", "a day's work"), link = folder_.Path("link");
  std::filesystem::create_symlink(precious, link);
  const auto content = [](const std::string& path) {
    std::ifstream file(path);
    return std::string{std::istreambuf_iterator<char>(file), {}};
  };
  for (const std::string& name : {precious, link}) {
    for (const char* option : {"--record", "--record-device", "--twin-record"}) {
      OutputOf({kOmnid, "--device", "twin", option, name}, 2);
    }
    OutputOf({kOmni, "record", name, "--device", "twin", "--seconds", "0.1"}, 1);
    OutputOf({kOmni, "twin", "run", "extrusion", "--seconds", "0.1", "--record", name}, 1);
    EXPECT_EQ(content(precious), "a day's work") << name;
  }
  OutputOf({kOmni, "twin", "run", "extrusion", "--seconds", "0.1", "--record", link, "--replace"}, 0);
  EXPECT_FALSE(std::filesystem::is_symlink(link)) << "the link itself is replaced";
  EXPECT_EQ(content(precious), "a day's work") << "and not what it named";
  OutputOf({kOmni, "twin", "run", "extrusion", "--seconds", "0.1", "--record", precious, "--replace"}, 0);
  EXPECT_NE(content(precious), "a day's work");
}

TEST_F(ProcessReplay, OmniRecordsABaseWithoutArmingIt) {
  const std::string shown = OutputOf({kOmni, "record", recording_, "--device", "twin", "--seconds", "1"}, 0);
  EXPECT_NE(shown.find("a simulation"), std::string::npos) << shown;
  const auto summary = device::SummariseRecording(recording_);
  ASSERT_TRUE(summary.ok()) << summary.error();
  EXPECT_GT(summary->scans, 300U);
  EXPECT_EQ(summary->commands, 0U);
  EXPECT_TRUE(summary->ended);
  EXPECT_LT(summary->current_peak_A, 0.05) << "a current sensor's offset";
  OutputOf({kOmni, "record", recording_, "--device", "toaster"}, 2);
  OutputOf({kOmni, "record", folder_.Path("again.rec"), "--device", "replay:" + recording_}, 1);
  OutputOf({kOmni, "record", folder_.Path("missing/device.rec"), "--device", "twin", "--seconds", "1"}, 1);
}

TEST_F(ProcessReplay, RejectsFilesThatAreNotRecordings) {
  const std::string text = folder_.Write("text.rec", "not a recording, but some words that are long enough for one");
  OutputOf({kOmnid, "--device", "replay:" + text}, 1);
  OutputOf({kOmnid, "--device", "replay:" + folder_.Path("missing")}, 1);
  OutputOf({kOmni, "replay", text}, 1);
  const std::string empty = folder_.Path("empty.rec");
  ASSERT_TRUE(device::DeviceRecorder::Open(empty, {}).ok());
  OutputOf({kOmnid, "--device", "replay:" + empty}, 1);
  OutputOf({kOmnid, "--device", "toaster"}, 2);
  OutputOf({kOmnid, "--replay-fast"}, 2);
}

// Killed in the middle: the written part is valid, and the summary names where it ends.
TEST_F(ProcessReplay, RecordingOfKilledServiceIsValidUpToTheCut) {
  Record(SIGKILL);
  const auto summary = device::SummariseRecording(recording_);
  ASSERT_TRUE(summary.ok()) << summary.error();
  EXPECT_GT(summary->scans, 500U);
  EXPECT_NE(summary->cut.find(recording_ + ": at byte "), std::string::npos);
  EXPECT_EQ(OutputOf({kOmnid, "--device", "replay:" + recording_, "--replay-fast", "--log-level", "error"}, 0), "");
}

}  // namespace test_process_replay
}  // namespace omni::test
