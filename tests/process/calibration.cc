// A calibration of another base is in use: omnid's log, `omni status` and `omni doctor` report it. As real processes.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "service/config/files/calibration_file.h"
#include "service/config/files/device_file.h"
#include "service/magnetics/nominal.h"
#include "tests/support/process/omni_command.h"
#include "tests/support/process/service_process.h"
#include "tests/support/rig/rig.h"

namespace omni::test {
namespace test_process_calibration {

constexpr const char* kNear = R"({"name": "near", "repeat": false, "waypoints": [
  {"s": 0, "tip_m": [0.01, 0, 0.06], "axis": [0, 0, -1]}, {"s": 60, "tip_m": [0.01, 0, 0.06], "axis": [0, 0, -1]}]})";
constexpr const char* kAway = R"({"name": "away", "repeat": false, "waypoints": [
  {"s": 0, "tip_m": [0, 0, 0.6], "axis": [0, 0, -1]}, {"s": 60, "tip_m": [0, 0, 0.6], "axis": [0, 0, -1]}]})";

// What a perfect calibration of a base with manufacturing tolerances would find, labelled as that of the twin with seed
// 1.
config::CalibrationFile CalibrationOf(const sim::ImperfectionSizes& sizes, std::uint64_t seed) {
  const sim::Rig rig(config::DefaultDevice(), {.seed = seed, .sizes = sizes});
  config::CalibrationFile file;
  file.calibration = rig.ExactCalibration();
  file.serial = "twin-1";
  file.date = "2026-11-21T09:00:00Z";
  file.quality.expected_error_mm = 0.1;
  return file;
}

// omnid on the twin with this calibration; its log in a file.
class ProcessCalibration : public testing::Test {
 protected:
  void Start(const config::CalibrationFile& calibration, const std::string& hand, const std::string& twin = {}) {
    const base::DeviceGeometry& device = config::DefaultDevice();
    const auto saved = config::SaveCalibrationFile(
        Calibration(), calibration, {.device = device, .drawing = magnetics::NominalCalibration(device), .serial = {}},
        false);
    ASSERT_TRUE(saved.ok()) << saved.error();
    Run(hand, twin);
  }
  void Run(const std::string& hand, const std::string& twin = {}) {
    const std::string in = " --twin " + (twin.empty() ? "ideal" : folder_.Write("twin.toml", twin));
    const std::string command =
        "exec \"$0\" --device twin --twin-script " + folder_.Write("hand.json", hand) + in + " 2>" + Log();
    auto started = test::ChildProcess::Start({"/bin/sh", "-c", command, std::string(OMNI_BINARY_DIR) + "/bin/omnid"},
                                             {"OMNI_SOCKET=" + Socket(), "XDG_CONFIG_HOME=" + folder_.Path("config"),
                                              "XDG_CACHE_HOME=" + folder_.Path("cache")});
    ASSERT_TRUE(started.ok()) << started.error();
    omnid_ = std::make_unique<test::ChildProcess>(std::move(*started));
  }

  std::string Calibration() const { return folder_.Path("config/omni/calibration.toml"); }
  std::string Socket() const { return folder_.Path("run/omnid.sock"); }
  std::string Log() const { return folder_.Path("omnid.log"); }
  std::string LogText() const {
    std::ifstream file(Log());
    return {std::istreambuf_iterator<char>(file), {}};
  }
  nlohmann::json Status() const {
    const Outcome said = RunOmni({"status", "--json", "--socket", Socket()});
    return said.status == 0 ? nlohmann::json::parse(said.out, nullptr, false) : nlohmann::json();
  }
  std::string Row(const std::string& name) const {
    const Outcome said = RunOmni({"doctor", "--json", "--socket", Socket()});
    const auto report = nlohmann::json::parse(said.out, nullptr, false);
    if (!report.is_object()) return "no report";
    for (const auto& row : report["diagnoses"]) {
      if (row["name"] == name) return row.dump();
    }
    return "no row";
  }
  bool WaitFor(double seconds, const std::function<bool(const nlohmann::json&)>& so) const {
    for (int i = 0; i < 10 * seconds; ++i) {
      if (const nlohmann::json status = Status(); status.is_object() && so(status)) return true;
      SleepMs(100);
    }
    return false;
  }

  ProcessCalibration() {
    std::filesystem::create_directories(folder_.Path("run"));
    std::filesystem::permissions(folder_.Path("run"), std::filesystem::perms::owner_all);
  }

  const TempFolder folder_;
  std::unique_ptr<test::ChildProcess> omnid_;
};

void ExpectMentions(const std::string& text, const std::vector<const char*>& words) {
  for (const char* word : words) EXPECT_NE(text.find(word), std::string::npos) << word << " not in: " << text;
}

bool IsMisfit(const nlohmann::json& status) { return status["calibration_misfit"].is_string(); }
bool IsTracked(const nlohmann::json& status) {
  return status.contains("tracking") && status["tracking"]["status"] == "tracking";
}

TEST_F(ProcessCalibration, ReportsMisfitOfAnotherBasesCalibration) {
  ASSERT_NO_FATAL_FAILURE(Start(CalibrationOf(sim::UncalibratedImperfections(), 77), kNear));
  ASSERT_TRUE(WaitFor(20, IsMisfit)) << LogText();
  const nlohmann::json status = Status();
  ExpectMentions(status["calibration_misfit"], {"calibration.toml does not fit this base", "no pose explains",
                                                "omni calibrate --replace", "omni calibrate --restore"});
  EXPECT_FALSE(status["problems"].empty());
  ExpectMentions(RunOmni({"status", "--socket", Socket()}).out,
                 {"does not fit this base (see problem)", "problem    calibration: "});
  ExpectMentions(Row("calibration"), {"\"fail\"", "does not fit this base", "omni calibrate --replace"});
  ExpectMentions(LogText(), {"does not fit this base"});
}

TEST_F(ProcessCalibration, ReportsNoMisfitWhilePenIsAway) {
  ASSERT_NO_FATAL_FAILURE(Start(CalibrationOf(sim::UncalibratedImperfections(), 77), kAway));
  EXPECT_FALSE(WaitFor(6, IsMisfit)) << LogText();
  EXPECT_EQ(LogText().find("does not fit"), std::string::npos);
}

TEST_F(ProcessCalibration, ReportsNoMisfitForMatchingCalibration) {
  ASSERT_NO_FATAL_FAILURE(Start(CalibrationOf(sim::NoImperfections(), 1), kNear));
  ASSERT_TRUE(WaitFor(20, IsTracked)) << LogText();
  EXPECT_FALSE(WaitFor(5, IsMisfit)) << LogText();
  ExpectMentions(Row("calibration"), {"\"ok\"", "calibration.toml"});
}

// [[...]] of a twin file, and the expected report.
struct RoomEvent {
  const char* name;
  const char* hand;
  const char* toml;
  const char* kind;
  std::vector<const char*> words;
};

void PrintTo(const RoomEvent& event, std::ostream* out) { *out << event.name; }

class ProcessRoom : public ProcessCalibration, public testing::WithParamInterface<RoomEvent> {};
INSTANTIATE_TEST_SUITE_P(
    Events, ProcessRoom,
    testing::Values(RoomEvent{"gain",
                              kNear,
                              "[[sensor_faults]]\nkind = \"gain\"\nsensor = 3\nvalue = 1.1\nfrom_s = 3",
                              "sensor-doubtful",
                              {"sensor 3, or a magnet near it", "take magnets and steel away"}},
                    RoomEvent{"stuck",
                              kAway,
                              "[[sensor_faults]]\nkind = \"stuck\"\nsensor = 5\nfrom_s = 3",
                              "sensor-repeats",
                              {"sensor 5 repeats itself", "omni device selftest"}},
                    RoomEvent{"swapped",
                              kNear,
                              "[[sensor_faults]]\nkind = \"swapped\"\nsensor = 1\nother = 6\nfrom_s = 3",
                              "sensors-swapped",
                              {"sensors 1 and 6 are swapped", "exchange their cables"}},
                    RoomEvent{
                        "second_pen",
                        kNear,
                        "[[magnets]]\nmoment_Am2 = [0.7, 0.5, 0.3]\nfrom_base_m = [1, 0, 0]\nto_base_m = [0.2, 0, 0]\n"
                        "leaves_s = 3\narrives_s = 4",
                        "magnet-near",
                        {"another magnet is near", "take it away"}},
                    RoomEvent{"other_pen",
                              kNear,
                              "[[pens]]\nmoment_scale = 1.1",
                              "other-pen",
                              {" % stronger than the one calibrated", "omni calibrate --replace"}},
                    RoomEvent{"turned",
                              kAway,
                              "[[field_steps]]\nchange_base_T = [4e-5, 3e-5, 3.3e-5]\nat_s = 3",
                              "field-changed",
                              {"uT: it was carried or turned", "omni calibrate --zero"}}),
    [](const auto& event) { return std::string(event.param.name); });

TEST_P(ProcessRoom, RoomFindingsAreReported) {
  const RoomEvent& event = GetParam();
  const std::string twin = std::string("based_on = \"ideal\"\n") + event.toml + "\n";
  ASSERT_NO_FATAL_FAILURE(Start(CalibrationOf(sim::NoImperfections(), 1), event.hand, twin));
  const auto is_reported = [&](const nlohmann::json& status) {
    return !status["room"].empty() && status["room"][0]["kind"] == event.kind;
  };
  ASSERT_TRUE(WaitFor(20, is_reported)) << LogText();
  ExpectMentions(Status()["room"].dump(), event.words);
  ExpectMentions(Status()["problems"].dump(), {"room: "});
  ExpectMentions(RunOmni({"status", "--socket", Socket()}).out, {"problem    room: "});
  ExpectMentions(Row("room"), event.words);
  ExpectMentions(LogText(), {"room: "});
  EXPECT_FALSE(IsMisfit(Status()));
}

// A pen that rests is known from one place only: what is reported of it says how far that can be trusted.
TEST_F(ProcessCalibration, MomentOfARestingPenIsReportedWithItsUncertainty) {
  ASSERT_NO_FATAL_FAILURE(
      Start(CalibrationOf(sim::NoImperfections(), 1), kNear, "based_on = \"ideal\"\n[[pens]]\nmoment_scale = 1.1\n"));
  const auto is_reported = [](const nlohmann::json& status) {
    return !status["room"].empty() && status["room"][0]["kind"] == "other-pen";
  };
  ASSERT_TRUE(WaitFor(20, is_reported)) << LogText();
  const std::string what = Status()["room"][0]["what"];
  int percent = 0, sigma = 0;
  ASSERT_EQ(std::sscanf(what.c_str(), "this magnet is %d +- %d %% stronger", &percent, &sigma), 2) << what;
  EXPECT_LE(std::abs(percent - 10), 2 * sigma) << what;
  EXPECT_LE(sigma, 3) << what;
}

TEST_F(ProcessCalibration, FallsBackToNominalGeometryWhenRejected) {
  ASSERT_NO_FATAL_FAILURE(Start(CalibrationOf(sim::NoImperfections(), 1), kNear));
  omnid_.reset();
  std::string text;
  {
    std::ifstream file(Calibration());
    text.assign(std::istreambuf_iterator<char>(file), {});
  }
  const std::size_t at = text.find("touches = 0");
  ASSERT_NE(at, std::string::npos);
  text.replace(at, 11, "touches = 9");
  folder_.Write("config/omni/calibration.toml", text);
  ASSERT_NO_FATAL_FAILURE(Run(kNear));
  ASSERT_TRUE(WaitFor(20, IsTracked)) << LogText();
  const nlohmann::json status = Status();
  EXPECT_TRUE(status["calibration"].is_null());
  ExpectMentions(status["calibration_refused"], {"calibration.toml:", "checksum", "nominal geometry"});
  ExpectMentions(RunOmni({"status", "--socket", Socket()}).out, {"calibrated no: the file was rejected"});
  ExpectMentions(Row("calibration"), {"\"warn\"", "checksum", "--restore"});
  ExpectMentions(LogText(), {"checksum"});
}

// The answer to a command waits for the disk; the control thread does not.
TEST_F(ProcessCalibration, ReportsAlignmentThatCannotBeSaved) {
  ASSERT_NO_FATAL_FAILURE(Run(kAway));
  ASSERT_TRUE(WaitFor(20, [](const nlohmann::json& status) { return status.is_object(); })) << LogText();
  const std::vector<std::string> off{"align", "--placement", "off", "--socket", Socket()};
  EXPECT_EQ(RunOmni(off).status, 0);
  const std::string file = folder_.Path("config/omni/alignments.toml");
  ASSERT_TRUE(std::filesystem::exists(file)) << "the answer comes when it is written";
  std::filesystem::remove(file);
  std::filesystem::create_directory(file);
  const Outcome refused = RunOmni(off);
  EXPECT_EQ(refused.status, 1);
  ExpectMentions(refused.out + refused.err, {"alignments.toml: cannot be written: it is a folder", "until omnid ends"});
  ExpectMentions(Status()["problems"].dump(), {"alignment: ", "it is a folder"});
  std::filesystem::remove(file);
  EXPECT_EQ(RunOmni(off).status, 0);
  EXPECT_TRUE(Status()["problems"].empty());
}

}  // namespace test_process_calibration
}  // namespace omni::test
