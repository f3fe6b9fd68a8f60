// omni calibrate: the session's steps, what it shows, and the whole of it on the twin.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "firmware/wire/messages.h"
#include "service/config/files/device_file.h"
#include "service/config/files/twin_file.h"
#include "service/tools/calibrate/calibrate_session.h"
#include "service/tools/calibrate/calibrate_twin.h"
#include "service/tools/common/terminal.h"
#include "service/tools/hand/touch_places.h"
#include "tests/support/process/omni_command.h"
#include "tests/support/process/scoped_variable.h"
#include "tests/support/process/temp_folder.h"
#include "tests/support/rig/calibration_error.h"
#include "tests/support/rig/rig.h"

namespace omni::tools {
namespace test_tools_calibrate {

base::HallScan ScanAt(int tick, sim::Rig& rig, const sim::MagnetPose* pose, const sim::CoilArray& current_A,
                      sim::Random& random) {
  base::HallScan scan = rig.Scan(pose, current_A, random);
  scan.t_ns = 1'000'000'000LL + 1'000'000LL * tick;
  return scan;
}

TEST(ToolsCalibrate, WaitsForPenRemovalAndRejectsSweepWithoutCurrents) {
  sim::Rig rig(config::DefaultDevice(), {.seed = 3, .noise = sim::NoiseMode::kLowPower});
  sim::Random random(4);
  CalibrationSession session(config::DefaultDevice(), {});
  const sim::MagnetPose near{{0, 0, 0.05}, {0, 0, -1}};
  int tick = 0;
  for (; tick < 500; ++tick) session.Add(ScanAt(tick, rig, &near, {}, random));
  EXPECT_EQ(session.step(), CalibrationStep::kClear);
  EXPECT_EQ(session.progress(), 0);
  bool asked = false;
  for (; tick < 10000 && session.step() != CalibrationStep::kDone; ++tick) {
    const base::CoilCurrents wanted = session.Add(ScanAt(tick, rig, nullptr, {}, random));
    for (const double current_A : wanted.current_A) asked = asked || std::abs(current_A) > 1;
  }
  EXPECT_TRUE(asked);
  ASSERT_EQ(session.step(), CalibrationStep::kDone);
  EXPECT_NE(session.problem().find("coil x carried"), std::string::npos) << session.problem();
  EXPECT_FALSE(session.Finish().ok());
}

TEST(ToolsCalibrate, AScriptedHandCalibratesTheTwin) {
  const base::DeviceGeometry& device = config::DefaultDevice();
  base::TruthParameters truth = config::IdealTwin();
  truth.imperfections = sim::UncalibratedImperfections();
  CalibrationStep last = CalibrationStep::kClear;
  const auto done = CalibrateTwin(device, 5, truth, {.wave_s = 6, .touches = 20}, [&](const CalibrationSession& now) {
    EXPECT_GE(static_cast<int>(now.step()), static_cast<int>(last));
    last = now.step();
    EXPECT_GE(now.progress(), 0);
    EXPECT_LE(now.progress(), 1);
  });
  ASSERT_TRUE(done.ok()) << done.error();
  EXPECT_EQ(last, CalibrationStep::kDone);
  EXPECT_EQ(done->outcome.report.touches, 20);
  sim::Rig rig(device, {.seed = 5, .sizes = truth.imperfections});
  const auto after = test::MeasureCalibrationError(rig, done->outcome.calibration, {.poses = 200, .swept = true});
  ASSERT_TRUE(after.ok()) << after.error();
  EXPECT_LT(after->raw_mm, 0.6);
  EXPECT_LT(after->orientation_deg, 0.6);
}

// A base whose core has hysteresis, its pen, and their surroundings during one calibration.
base::TruthParameters UncalibratedTruth(double remanence_Am2) {
  base::TruthParameters truth = config::IdealTwin();
  const double nonlinearity = truth.imperfections.sensor_nonlinearity;
  truth.imperfections = sim::UncalibratedImperfections();
  truth.imperfections.sensor_nonlinearity = nonlinearity;
  truth.effects.remanence_Am2 = remanence_Am2;
  return truth;
}

// Before the wipe went on until it no longer turned the core over, a moment of .9 of the greatest stayed and was taken
// for background.
TEST(ToolsCalibrate, SweepDemagnetisesTheCore) {
  const base::DeviceGeometry& device = config::DefaultDevice();
  const auto background_T = [&](double remanence_Am2) {
    std::vector<base::Vec3> all;
    const auto done = CalibrateTwin(device, 21, UncalibratedTruth(remanence_Am2), {.wave_s = 3, .touches = 20},
                                    [&](const CalibrationSession& now) {
                                      if (!all.empty()) return;
                                      for (const calibration::CoilResponse& response : now.recording().responses) {
                                        all.push_back(response.background_sensor_T);
                                      }
                                    });
    EXPECT_FALSE(all.empty());
    return all;
  };
  constexpr double kRemanence_Am2 = 4e-3;
  const auto with_T = background_T(kRemanence_Am2), without_T = background_T(0);
  ASSERT_EQ(with_T.size(), without_T.size());
  for (std::size_t i = 0; i < with_T.size(); ++i) {
    const base::Vec3& place_m = device.sensors[i].position_base_m;
    const double r_m = base::Norm(place_m);
    const double greatest_T = 2e-7 * kRemanence_Am2 / (r_m * r_m * r_m);
    EXPECT_LT(base::Norm(
                  base::Vec3{with_T[i].x - without_T[i].x, with_T[i].y - without_T[i].y, with_T[i].z - without_T[i].z}),
              0.1 * greatest_T)
        << i;
  }
}

// The core's hysteresis under a waved pen must not be mistaken for errors of the array: .097 mm on these before it was
// followed along its way, .03 to .04 mm on an exactly known array, which the bent sensors cost.
TEST(ToolsCalibrate, CoreHysteresisBarelyAffectsCalibration) {
  const base::DeviceGeometry& device = config::DefaultDevice();
  const base::TruthParameters truth = UncalibratedTruth(4e-3);
  double found_mm = 0, best_mm = 0;
  for (const std::uint64_t seed : {21U, 22U, 23U}) {
    const auto done = CalibrateTwin(device, seed, truth);
    ASSERT_TRUE(done.ok()) << done.error();
    sim::Rig rig(device, {.seed = seed, .sizes = truth.imperfections});
    const test::ErrorOptions judge{.poses = 300, .noise = false, .swept = true};
    const auto found = test::MeasureCalibrationError(rig, done->outcome.calibration, judge);
    const auto best = test::MeasureCalibrationError(rig, rig.ExactCalibration(), {.poses = 300, .noise = false});
    ASSERT_TRUE(found.ok() && best.ok());
    found_mm += found->aligned_mm / 3;
    best_mm += best->aligned_mm / 3;
  }
  EXPECT_LT(found_mm, 2.2 * best_mm);
}

TEST(ToolsCalibrate, ShowsProgressCoverageAndResult) {
  EXPECT_EQ(ProgressBar(0.5, 10), "[#####.....]  50 %");
  EXPECT_EQ(ProgressBar(-1, 4), "[....]   0 %");
  EXPECT_EQ(ProgressBar(7, 4), "[####] 100 %");
  TimeLeft left;
  EXPECT_EQ(left.Text(0, 10), "");
  EXPECT_EQ(left.Text(0.2, 10.9), "") << "too early";
  EXPECT_EQ(left.Text(0.25, 12), ", about 6 s left");
  EXPECT_EQ(left.Text(0.5, 18), ", about 8 s left");
  EXPECT_EQ(left.Text(0.5, 60), ", about 50 s left");
  EXPECT_EQ(left.Text(1, 60), "");
  EXPECT_EQ(left.Text(0.1, 61), "") << "something else has begun";
  EXPECT_EQ(left.Text(0.2, 63), ", about 8 s left");
  calibration::Coverage coverage;
  EXPECT_EQ(CoverageText(coverage), "...... ...... ...... ......");
  coverage.Add({0.001, 0.0001, 0.1});
  EXPECT_EQ(CoverageText(coverage), "+..... ...... ...... ......");
  for (int i = 0; i < 5; ++i) coverage.Add({0.1, -0.01, 0.001});
  EXPECT_EQ(CoverageText(coverage), "+..... ...... ...... .....#");
  EXPECT_NE(StepText(CalibrationStep::kTouch, {.touches = 42}).find("42 places"), std::string::npos);
  calibration::Report report;
  report.expected_error_m = 0.09e-3;
  report.sensors.resize(2);
  report.unfixed.push_back({"sensor 1 gain x", 1.4, 1.5, "%"});
  const std::string text = ReportText(report);
  for (const char* part : {"excellent: 0.09 mm", "sensor 1 ", "sensor 1 gain x", "tolerance 1.5"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part << " not in:\n" << text;
  }
  EXPECT_EQ(QualityWord(0.15e-3), "good");
  EXPECT_EQ(QualityWord(0.4e-3), "fair");
  EXPECT_EQ(QualityWord(std::nan("")), "poor");
}

// A base that sends the rig's readings until it fails.
class FailingBase final : public device::Transport {
 public:
  explicit FailingBase(int good_scans) : good_scans_(good_scans) {}
  device::ReadStatus Read(base::HallScan& scan, std::int64_t /*timeout_ns*/) noexcept override {
    if (tick_ >= good_scans_) return end;
    scan = ScanAt(tick_++, rig_, pen, {}, random_);
    return device::ReadStatus::kScan;
  }
  bool Write(const base::CoilCurrents& currents) noexcept override {
    last = currents;
    return true;
  }
  const device::TransportInfo& info() const noexcept override { return info_; }
  device::TransportCounters counters() const noexcept override { return {}; }
  device::TransportState state() const noexcept override { return says; }

  device::ReadStatus end = device::ReadStatus::kGone;
  device::TransportState says;
  const sim::MagnetPose* pen = nullptr;
  base::CoilCurrents last{{1, 1, 1}};

 private:
  int good_scans_, tick_ = 0;
  sim::Rig rig_{config::DefaultDevice(), {.seed = 3, .noise = sim::NoiseMode::kLowPower}};
  sim::Random random_{4};
  device::TransportInfo info_{.name = "failing (a simulation)", .serial = "x", .simulation = true};
};

TEST(ToolsCalibrate, FailureNamesCauseAndLeavesCoilsAtZero) {
  constexpr int kLong = 200'000;
  const sim::MagnetPose near{{0, 0, 0.05}, {0, 0, -1}};
  const auto state = [](wire::State is, bool waits) {
    return device::TransportState{.state = static_cast<std::uint8_t>(is), .waits_for_person = waits};
  };
  struct Row {
    int good_scans;
    device::ReadStatus end;
    device::TransportState says;
    const sim::MagnetPose* pen;
    std::vector<const char*> mentions;
  };
  using device::ReadStatus;
  const Row rows[] = {
      {500, ReadStatus::kGone, {}, nullptr, {"the base was disconnected", "cable"}},
      {500, ReadStatus::kTimeout, {}, nullptr, {"sends nothing", "plug it in"}},
      {500, ReadStatus::kEnd, {}, nullptr, {"ended before this step was done", "coils are swept"}},
      {kLong, ReadStatus::kGone, state(wire::State::kFault, true), nullptr, {"fault", "selftest"}},
      {kLong, ReadStatus::kGone, state(wire::State::kIdle, false), nullptr, {"does not switch its coils"}},
      {kLong, ReadStatus::kGone, {}, &near, {"two minutes", "metre away", "Sensor", "uT"}}};
  for (const Row& row : rows) {
    FailingBase failing(row.good_scans);
    failing.end = row.end;
    failing.says = row.says;
    failing.pen = row.pen;
    CalibrationSession session(config::DefaultDevice(), {});
    const base::Status ran = RunSession(failing, session, {});
    ASSERT_FALSE(ran.ok());
    for (const char* words : row.mentions) EXPECT_NE(ran.error().find(words), std::string::npos) << ran.error();
    for (const double current_A : failing.last.current_A) EXPECT_EQ(current_A, 0);
  }
}

TEST(ToolsCalibrate, CachesCalibrationOfSimulatedBase) {
  const test::TempFolder folder;
  const test::ScopedVariable cache("XDG_CACHE_HOME", folder.Path("cache"));
  const std::string twin = folder.Write("short.toml", "based_on = \"ideal\"\n");
  const auto made = KeptTwinCalibration(config::DefaultDevice(), 4, twin);
  ASSERT_TRUE(made.ok()) << made.error();
  const auto kept = KeptTwinCalibration(config::DefaultDevice(), 4, twin);
  ASSERT_TRUE(kept.ok()) << kept.error();
  EXPECT_NEAR(kept->moment_Am2, made->moment_Am2, 1e-9 * made->moment_Am2);
  EXPECT_NEAR(kept->sensors[5].position_base_m.x, made->sensors[5].position_base_m.x, 1e-9);
  const std::filesystem::directory_iterator files(folder.Path("cache/omni/twins"));
  EXPECT_EQ(std::distance(begin(files), end(files)), 1);
  EXPECT_FALSE(KeptTwinCalibration(config::DefaultDevice(), 4, folder.Path("none.toml")).ok());
}

TEST(ToolsCalibrate, HandScriptRoundTripsThroughFile) {
  const test::TempFolder folder;
  const sim::HandScript hand = MakeCalibratingHand(config::DefaultDevice(), {.wave_s = 3, .touches = 4});
  const auto read = sim::LoadHandScript(folder.Write("hand.json", WriteHandScript(hand)));
  ASSERT_TRUE(read.ok()) << read.error();
  ASSERT_EQ(read->waypoints.size(), hand.waypoints.size());
  for (std::size_t i = 0; i < hand.waypoints.size(); ++i) {
    EXPECT_EQ(read->waypoints[i].present, hand.waypoints[i].present) << i;
    EXPECT_EQ(read->waypoints[i].duration_s, hand.waypoints[i].duration_s) << i;
  }
  EXPECT_EQ(read->stiffness_N_m, hand.stiffness_N_m);
  EXPECT_EQ(read->damping_Ns_m, hand.damping_Ns_m);
  EXPECT_EQ(read->mass_kg, hand.mass_kg);
  EXPECT_EQ(read->tremor_m, hand.tremor_m);
}

// The desk's frame 400 mm below does not reveal its depth. This seed's search for the depth once did not converge.
TEST(ToolsCalibrate, UnmeasurablyDistantSteelDoesNotFailCalibration) {
  const auto done = CalibrateTwin(config::DefaultDevice(), 2, config::RoomTwin());
  ASSERT_TRUE(done.ok()) << done.error();
  EXPECT_LT(done->outcome.report.expected_error_m, 0.3e-3);
  EXPECT_LT(done->outcome.report.steel.strength, 0.01);  // as good as none
}

std::string ContentOf(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

test::Outcome CalibrateTo(const std::string& path, std::vector<std::string> more) {
  more.insert(more.begin(), {"calibrate", "--device", "twin", "--twin", "ideal", "--wave-seconds", "6", "--touches",
                             "20", "-o", path});
  return test::RunOmni(more);
}

void ExpectMentions(const std::string& text, std::initializer_list<std::string> words) {
  for (const std::string& word : words) EXPECT_NE(text.find(word), std::string::npos) << word << " not in: " << text;
}

// A person waves and touches for two minutes: an unwritable result is reported before that.
TEST(ToolsCalibrate, FailsBeforeMeasuringWhenOutputCannotBeWritten) {
  const test::TempFolder folder;
  const std::string there = folder.Write("calibration.toml", "precious");
  const test::Outcome refused = CalibrateTo(there, {});
  EXPECT_EQ(refused.status, 1);
  EXPECT_EQ(refused.out, "") << "not one step of it";
  ExpectMentions(refused.err, {there + ": already exists", "--replace", "calibration.previous.toml", "-o FILE"});
  EXPECT_EQ(ContentOf(there), "precious");
  const test::Outcome nowhere = CalibrateTo(there + "/calibration.toml", {"--replace"});
  EXPECT_EQ(nowhere.status, 1);
  EXPECT_EQ(nowhere.out, "");
  ExpectMentions(nowhere.err, {"cannot be written", "there is no folder"});
}

TEST(ToolsCalibrate, ReplaceAndRestoreSwapCalibrationFiles) {
  const test::TempFolder folder;
  const std::string path = folder.Path("below/calibration.toml"),
                    previous = folder.Path("below/calibration.previous.toml");
  const test::Outcome none = CalibrateTo(path, {"--restore"});
  EXPECT_EQ(none.status, 1);
  ExpectMentions(none.err, {"calibration.previous.toml", "cannot be read"});
  const test::Outcome first = CalibrateTo(path, {});
  ASSERT_EQ(first.status, 0) << first.err;
  const std::string first_text = ContentOf(path);
  ExpectMentions(first_text, {"checksum = ", "serial = \"twin-1\""});
  const test::Outcome second = CalibrateTo(path, {"--replace", "--seed", "2"});
  ASSERT_EQ(second.status, 0) << second.err;
  const std::string second_text = ContentOf(path);
  ExpectMentions(second_text, {"serial = \"twin-2\""});
  EXPECT_EQ(ContentOf(previous), first_text);
  const test::Outcome back = CalibrateTo(path, {"--restore"});
  ASSERT_EQ(back.status, 0) << back.err;
  ExpectMentions(back.out, {"restored", path, previous});
  EXPECT_EQ(ContentOf(path), first_text);
  EXPECT_EQ(ContentOf(previous), second_text);
  EXPECT_EQ(CalibrateTo(path, {"--restore", "--replace"}).status, 2) << "one or the other";
}

}  // namespace test_tools_calibrate
}  // namespace omni::tools
