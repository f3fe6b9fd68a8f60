// omni calibrate --tip: the pen's tip, found by tilting the pen about it, on the twin.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "service/base/eigen.h"
#include "service/config/files/calibration_file.h"
#include "service/config/files/device_file.h"
#include "service/config/files/twin_file.h"
#include "service/loop/tick_config.h"
#include "service/magnetics/nominal.h"
#include "service/sim/twin/twin.h"
#include "service/tools/calibrate/calibrate_session.h"
#include "service/tools/calibrate/calibrate_twin.h"
#include "tests/support/process/omni_command.h"
#include "tests/support/process/temp_folder.h"
#include "tests/support/rig/rig.h"

namespace omni::tools {
namespace test_tools_calibrate_tip {

constexpr double kDuration_s = 60;

// A base in this room whose pen is a millimetre longer or shorter than nominal, 1 sigma.
struct Held {
  Held(const base::TruthParameters& in, std::uint64_t of_seed) : truth(in), seed(of_seed) {
    truth.imperfections.tip_offset_m = 1e-3;
    true_m = WithHeldTip(device, seed, truth).magnet.tip_offset_m;
    calibration =
        sim::Rig(device, {.seed = seed, .sizes = truth.imperfections, .effects = truth.effects}).ExactCalibration();
    EXPECT_EQ(calibration.magnet.tip_offset_m, true_m);
    calibration.magnet.tip_offset_m = device.magnet.tip_offset_m;
    calibration.expected_error_m = 0.1e-3;
  }
  std::unique_ptr<device::Transport> Twin(const sim::HandScript& hand) const {
    return sim::MakeVirtualTwin(device, {.seed = seed, .script = hand, .truth = truth}, kDuration_s);
  }

  base::DeviceGeometry device = config::DefaultDevice();
  base::TruthParameters truth;
  std::uint64_t seed;
  double true_m = 0;
  base::Calibration calibration;
};

base::Result<calibration::Tip> TipOf(const Held& held, const sim::HandScript& hand) {
  const auto twin = held.Twin(hand);
  TipSession session(held.calibration, held.device.magnet.tip_offset_m);
  TipStep last = TipStep::kRest;
  const base::Status ran = RunSession(*twin, session, [&] {
    EXPECT_GE(session.step_number(), static_cast<int>(last));
    EXPECT_GE(session.progress(), 0);
    EXPECT_LE(session.progress(), 1);
    last = session.step();
  });
  if (!ran.ok()) return base::Error{ran.error()};
  return session.Finish();
}

void ExpectFound(const base::TruthParameters& in, const char* where, double limit_m) {
  double most_m = 0, sigma_m = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const Held held(in, seed);
    const auto tip = TipOf(held, MakePivotingHand({.seed = seed + 50}));
    ASSERT_TRUE(tip.ok()) << seed << ": " << tip.error();
    const double error_m = std::abs(tip->tip_offset_m - held.true_m);
    EXPECT_LE(error_m, limit_m) << seed;
    EXPECT_LE(error_m, 3 * tip->sigma_m) << seed;
    most_m = std::max(most_m, error_m);
    sigma_m = std::max(sigma_m, tip->sigma_m);
  }
  std::printf("[ figure   ] tip of six pens, %s: error at most %.3f mm, sigma at most %.3f mm\n", where, 1e3 * most_m,
              1e3 * sigma_m);
}

TEST(ToolsCalibrateTip, FindsTipThatDiffersFromNominal) { ExpectFound(config::IdealTwin(), "ideal", 0.15e-3); }
TEST(ToolsCalibrateTip, FindsTipWithRoomDisturbances) { ExpectFound(config::RoomTwin(), "room", 0.3e-3); }

// From its third second on the pen's tip is in the dimple.
sim::HandScript Slides(double by_m) {
  sim::HandScript hand = MakePivotingHand({});
  for (std::size_t i = 10; i < hand.waypoints.size(); ++i) hand.waypoints[i].tip_base_m.x += by_m;
  return hand;
}

sim::HandScript Leaves() {
  sim::HandScript hand = MakePivotingHand({.swing_s = 4});
  hand.waypoints.push_back(hand.waypoints.back());
  hand.waypoints.back().duration_s = 20;
  hand.waypoints.back().present = false;
  return hand;
}

TEST(ToolsCalibrateTip, RejectsPenThatIsNotTiltedSlidesOrIsLost) {
  const Held held(config::RoomTwin(), 2);
  const auto expect = [&](const sim::HandScript& hand, std::initializer_list<const char*> mentions) {
    const auto tip = TipOf(held, hand);
    ASSERT_FALSE(tip.ok()) << *mentions.begin();
    for (const char* words : mentions) EXPECT_NE(tip.error().find(words), std::string::npos) << tip.error();
  };
  expect(MakePivotingHand({.tilt_rad = 0.04}), {"tip not measured", "leaned by", "further"});
  expect(Slides(2e-3), {"tip not measured", "moved by", "slid"});
  expect(Leaves(), {"tip not measured", "tracked for", "of the 10 s"});
  expect({}, {"ended before this step was done", "dimple"});
}

// A computer that is busy for a while, again and again: it misses half of the samples.
class Starved final : public GuidedSession {
 public:
  explicit Starved(TipSession& session) : session_(session) {}
  base::CoilCurrents Add(const base::HallScan& scan) override {
    constexpr std::uint64_t kPeriod = 40, kAwake = 20;  // scans
    return scan.sequence % kPeriod < kAwake ? session_.Add(scan) : base::CoilCurrents{};
  }
  bool done() const override { return session_.done(); }
  int step_number() const override { return session_.step_number(); }
  double progress() const override { return session_.progress(); }
  std::string Instruction() const override { return session_.Instruction(); }
  std::string Hint() const override { return session_.Hint(); }

 private:
  TipSession& session_;
};

TEST(ToolsCalibrateTip, BusyComputerIsNotTakenForAWrongTip) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const Held held(config::RoomTwin(), seed);
    const auto twin = sim::MakeVirtualTwin(
        held.device,
        {.seed = seed, .script = MakePivotingHand({.rest_s = 4, .swing_s = 40, .seed = seed}), .truth = held.truth},
        95);
    TipSession session(held.calibration, held.device.magnet.tip_offset_m + 9e-3);  // a drawing of another pen
    Starved starved(session);
    const base::Status ran = RunSession(*twin, starved, [] {});
    ASSERT_TRUE(ran.ok()) << ran.error();
    const auto tip = session.Finish();
    ASSERT_FALSE(tip.ok()) << seed;
    EXPECT_NE(tip.error().find("this computer was busy and missed"), std::string::npos) << tip.error();
    EXPECT_NE(tip.error().find("close other programs"), std::string::npos) << tip.error();
  }
}

// Rms distance of the tick's device point from the dimple that the tip rests in.
double OffDimple_m(const Held& held, const base::Calibration& calibration) {
  const PivotingHand hand{.seed = 99};
  const auto twin = held.Twin(MakePivotingHand(hand));
  const loop::TickConfig config = loop::MakeTickConfig(held.device, calibration);
  tracker::State state;
  base::ToolState tool;
  base::HallScan scan;
  double sum_m2 = 0;
  int count = 0;
  for (int tick = 0; tick < 12'000 && twin->Read(scan, 0) == device::ReadStatus::kScan; ++tick) {
    twin->Write({});
    tracker::Update(config.tracker, scan, state, tool);
    if (tick < 3000 || tool.status != base::TrackingStatus::kTracking) continue;
    sum_m2 += (base::ToEigen(tool.device_point_base_m) - base::ToEigen(hand.dimple_base_m)).squaredNorm();
    ++count;
  }
  EXPECT_GT(count, 8000);
  return std::sqrt(sum_m2 / count);
}

TEST(ToolsCalibrateTip, CommandUpdatesFileAndDevicePointUsesIt) {
  const test::TempFolder folder;
  const Held held(config::IdealTwin(), 1);
  ASSERT_GT(std::abs(held.true_m - held.device.magnet.tip_offset_m), 0.5e-3) << "a seed that shows it";
  const config::ExpectedBase of{
      .device = held.device, .drawing = magnetics::NominalCalibration(held.device), .serial = "twin-1"};
  const std::string path = folder.Path("calibration.toml");
  const std::string twin = folder.Write("twin.toml", "based_on = \"ideal\"\n[imperfections]\ntip_offset_m = 1.0e-3\n");
  const std::vector<std::string> command{"calibrate", "--tip",  "--device", "twin", "--twin",
                                         twin,        "--seed", "1",        "-o",   path};
  const test::Outcome missing = test::RunOmni(command);
  EXPECT_EQ(missing.status, 1);
  EXPECT_NE(missing.err.find("--tip needs an existing calibration"), std::string::npos) << missing.err;

  config::CalibrationFile file;
  file.calibration = held.calibration;
  file.serial = "twin-1";
  file.date = "2026-11-21T09:00:00Z";
  file.quality.expected_error_mm = 0.1;
  ASSERT_TRUE(config::SaveCalibrationFile(path, file, of, false).ok());
  const test::Outcome measured = test::RunOmni(command);
  ASSERT_EQ(measured.status, 0) << measured.err;
  for (const char* words : {"1/2  Rest", "2/2  Leave", "tip          ", "from nominal", "written      "}) {
    EXPECT_NE(measured.out.find(words), std::string::npos) << words << " not in: " << measured.out;
  }
  const auto now = config::LoadCalibrationFile(path, of);
  ASSERT_TRUE(now.ok()) << now.error();
  EXPECT_TRUE(now->tip_measured);
  EXPECT_TRUE(now->has_checksum);
  EXPECT_NEAR(now->calibration.magnet.tip_offset_m, held.true_m, 0.15e-3);
  EXPECT_EQ(now->date, file.date);
  EXPECT_EQ(now->calibration.sensors[3].current_map_T_A, file.calibration.sensors[3].current_map_T_A);
  const auto kept = config::LoadCalibrationFile(config::PreviousCalibration(path), of);
  ASSERT_TRUE(kept.ok()) << kept.error();
  EXPECT_FALSE(kept->tip_measured);

  const double before_m = OffDimple_m(held, kept->calibration), after_m = OffDimple_m(held, now->calibration);
  std::printf("[ figure   ] device point off the tip: %.3f mm nominal, %.3f mm measured\n", 1e3 * before_m,
              1e3 * after_m);
  EXPECT_LT(after_m, 0.3e-3);
  EXPECT_GT(before_m, 0.5e-3);

  std::vector<std::string> both = command;
  both.push_back("--zero");
  EXPECT_EQ(test::RunOmni(both).status, 2);
}

TEST(ToolsCalibrateTip, RecalibratingTheBaseKeepsMeasuredTip) {
  const test::TempFolder folder;
  const Held held(config::IdealTwin(), 1);
  const config::ExpectedBase of{
      .device = held.device, .drawing = magnetics::NominalCalibration(held.device), .serial = "twin-1"};
  const std::string path = folder.Path("calibration.toml");
  config::CalibrationFile file;
  file.calibration = held.calibration;
  file.calibration.magnet.tip_offset_m = 0.0061;
  file.tip_measured = true;
  file.serial = "twin-1";
  file.date = "2026-11-21T09:00:00Z";
  ASSERT_TRUE(config::SaveCalibrationFile(path, file, of, false).ok());
  const test::Outcome again = test::RunOmni({"calibrate", "--device", "twin", "--twin", "ideal", "--seed", "1",
                                             "--wave-seconds", "6", "--touches", "20", "-o", path, "--replace"});
  ASSERT_EQ(again.status, 0) << again.err;
  EXPECT_NE(again.out.find("6.10 mm from the magnet's centre, as before"), std::string::npos) << again.out;
  const auto now = config::LoadCalibrationFile(path, of);
  ASSERT_TRUE(now.ok()) << now.error();
  EXPECT_TRUE(now->tip_measured);
  EXPECT_EQ(now->calibration.magnet.tip_offset_m, 0.0061);
  EXPECT_NE(now->calibration.moment_Am2, file.calibration.moment_Am2);
}

}  // namespace test_tools_calibrate_tip
}  // namespace omni::tools
