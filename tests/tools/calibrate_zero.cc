// omni calibrate --zero: the background of a calibration measured again, on the twin.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "service/base/eigen.h"
#include "service/config/files/calibration_file.h"
#include "service/config/files/device_file.h"
#include "service/config/files/twin_file.h"
#include "service/magnetics/nominal.h"
#include "service/sim/twin/twin.h"
#include "service/tools/calibrate/calibrate_session.h"
#include "tests/support/process/omni_command.h"
#include "tests/support/process/temp_folder.h"
#include "tests/support/rig/rig.h"

namespace omni::tools {
namespace test_tools_calibrate_zero {

base::Calibration CalibratedIn(const base::TruthParameters& truth) {
  return sim::Rig(config::DefaultDevice(), {.seed = 4, .sizes = truth.imperfections, .effects = truth.effects})
      .ExactCalibration();
}

base::Result<calibration::Zeroed> ZeroIn(const base::TruthParameters& truth, const base::Calibration& before,
                                         const sim::HandScript& hand = {}) {
  const auto twin = sim::MakeVirtualTwin(config::DefaultDevice(), {.seed = 4, .script = hand, .truth = truth}, 20);
  ZeroSession session(before);
  if (const base::Status ran = RunSession(*twin, session, {}); !ran.ok()) return base::Error{ran.error()};
  return session.Finish();
}

// Greatest difference of two backgrounds.
double Apart_T(const base::Calibration& a, const base::Calibration& b) {
  double most_T = 0;
  for (std::size_t i = 0; i < a.sensors.size(); ++i) {
    const Eigen::Vector3d difference =
        base::ToEigen(a.sensors[i].background_sensor_T) - base::ToEigen(b.sensors[i].background_sensor_T);
    most_T = std::max(most_T, difference.norm());
  }
  return most_T;
}

sim::HandScript PenAt(const base::Vec3& tip_base_m) {
  sim::HandScript script;
  script.waypoints = {{.tip_base_m = tip_base_m}, {.duration_s = 10, .tip_base_m = tip_base_m}};
  return script;
}

TEST(ToolsCalibrateZero, CorrectsUniformFieldChangeOfATurnedBase) {
  base::TruthParameters truth = config::RoomTwin();
  const base::Calibration before = CalibratedIn(truth);
  truth.effects.earth_field_base_T = {-2.0e-5, 2.0e-5, 4.58e-5};  // laid on its side: by 100 uT
  const auto zeroed = ZeroIn(truth, before);
  ASSERT_TRUE(zeroed.ok()) << zeroed.error();
  EXPECT_NEAR(zeroed->uniform_T, 1.02e-4, 2e-6);
  EXPECT_LT(zeroed->own_T, 1e-6);
  const base::Calibration exact = CalibratedIn(truth);
  EXPECT_GT(Apart_T(before, exact), 5e-5);
  EXPECT_LT(Apart_T(zeroed->calibration, exact), 1e-6);
  EXPECT_EQ(zeroed->calibration.sensors[3].current_map_T_A, before.sensors[3].current_map_T_A);
}

TEST(ToolsCalibrateZero, CorrectsIndependentSensorDrift) {
  base::TruthParameters truth = config::RoomTwin();
  const base::Calibration before = CalibratedIn(truth);
  truth.imperfections.sensor_offset_T = 5e-6;
  const auto zeroed = ZeroIn(truth, before);
  ASSERT_TRUE(zeroed.ok()) << zeroed.error();
  EXPECT_GT(zeroed->own_T, 4e-6);
  EXPECT_LT(zeroed->uniform_T, 1e-5);
}

TEST(ToolsCalibrateZero, RejectsNearbyMagnetsAndChangingReadings) {
  const base::TruthParameters& truth = config::RoomTwin();
  const base::Calibration before = CalibratedIn(truth);
  const auto expect = [&](const base::TruthParameters& in, const sim::HandScript& hand, const char* words) {
    const auto zeroed = ZeroIn(in, before, hand);
    ASSERT_FALSE(zeroed.ok()) << words;
    EXPECT_EQ(zeroed.error().rfind("not zeroed: ", 0), 0U) << zeroed.error();
    EXPECT_NE(zeroed.error().find(words), std::string::npos) << zeroed.error();
  };
  expect(truth, PenAt({0, 0, 0.06}), "magnet");
  expect(truth, PenAt({0.1, 0, 0.3}), "the pen, another magnet or iron");
  expect(truth, PenAt({0.3, 0.2, 0.0}), "--replace");
  base::TruthParameters with_magnet = truth;
  with_magnet.effects.room.magnets = {
      {.moment_Am2 = {0, 0, 0.1}, .from_base_m = {0.13, 0, 0}, .to_base_m = {0.13, 0, 0}}};
  expect(with_magnet, {}, "magnet");
  base::TruthParameters turning = truth;
  turning.effects.room.turn_rate_rad_s = 0.1;
  turning.effects.room.turn_s = 20;
  expect(turning, {}, "meanwhile");
}

TEST(ToolsCalibrateZero, CommandUpdatesFileAndKeepsPreviousOne) {
  const test::TempFolder folder;
  const base::DeviceGeometry& device = config::DefaultDevice();
  const config::ExpectedBase of{.device = device, .drawing = magnetics::NominalCalibration(device), .serial = "twin-4"};
  const std::string path = folder.Path("calibration.toml");
  const std::vector<std::string> command{"calibrate", "--zero", "--device", "twin", "--twin",
                                         "room",      "--seed", "4",        "-o",   path};
  const test::Outcome missing = test::RunOmni(command);
  EXPECT_EQ(missing.status, 1);
  EXPECT_NE(missing.err.find("existing calibration"), std::string::npos) << missing.err;

  base::TruthParameters elsewhere = config::RoomTwin();
  elsewhere.effects.earth_field_base_T = {0, 3e-5, -4e-5};
  config::CalibrationFile file;
  file.calibration = CalibratedIn(elsewhere);
  file.serial = "twin-4";
  file.date = "2026-11-21T09:00:00Z";
  file.quality.expected_error_mm = 0.1;
  ASSERT_TRUE(config::SaveCalibrationFile(path, file, of, false).ok());
  const test::Outcome zeroed = test::RunOmni(command);
  ASSERT_EQ(zeroed.status, 0) << zeroed.err;
  EXPECT_NE(zeroed.out.find("zeroed"), std::string::npos) << zeroed.out;
  const auto now = config::LoadCalibrationFile(path, of);
  ASSERT_TRUE(now.ok()) << now.error();
  EXPECT_TRUE(now->has_checksum);
  EXPECT_EQ(now->date, file.date);
  EXPECT_EQ(now->quality.expected_error_mm, file.quality.expected_error_mm);
  EXPECT_LT(Apart_T(now->calibration, CalibratedIn(config::RoomTwin())), 1e-6);
  const auto kept = config::LoadCalibrationFile(config::PreviousCalibration(path), of);
  ASSERT_TRUE(kept.ok()) << kept.error();
  EXPECT_LT(Apart_T(kept->calibration, file.calibration), 1e-9);

  std::vector<std::string> of_another = command;
  of_another[7] = "5";
  const test::Outcome refused = test::RunOmni(of_another);
  EXPECT_EQ(refused.status, 1);
  EXPECT_NE(refused.err.find("another base"), std::string::npos) << refused.err;
}

}  // namespace test_tools_calibrate_zero
}  // namespace omni::tools
