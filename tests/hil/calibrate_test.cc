// omni calibrate on a base on USB: the unmodified program on the emulated plug, with a scripted hand.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "service/config/files/calibration_file.h"
#include "service/config/files/device_file.h"
#include "service/config/files/twin_file.h"
#include "service/magnetics/nominal.h"
#include "service/tools/calibrate/calibrate_twin.h"
#include "service/tools/hand/touch_places.h"
#include "tests/support/process/child_process.h"
#include "tests/support/process/temp_folder.h"
#include "tests/support/rig/calibration_error.h"

namespace omni::hil {
namespace {

constexpr std::uint64_t kSeed = 7;

// omni_hil with `omni calibrate --device usb` on its base, and a hand that follows the instructions.
class HilCalibrate : public testing::Test {
 protected:
  int Run(const sim::HandScript& hand, const std::string& twin, const std::vector<std::string>& more) {
    folder_.Write("hand.json", tools::WriteHandScript(hand));
    const std::string bin = std::string(OMNI_BINARY_DIR) + "/bin/";
    std::vector<std::string> words{bin + "omni_hil",
                                   "--fast",
                                   "--twin",
                                   twin,
                                   "--seed",
                                   std::to_string(kSeed),
                                   "--script",
                                   folder_.Path("hand.json"),
                                   "--summary",
                                   folder_.Path("summary.json"),
                                   "--",
                                   bin + "omni",
                                   "calibrate",
                                   "--device",
                                   "usb",
                                   "-o",
                                   Calibration()};
    words.insert(words.end(), more.begin(), more.end());
    auto started = test::ChildProcess::Start(words, {"XDG_CONFIG_HOME=" + folder_.Path("config")});
    if (!started.ok()) {
      ADD_FAILURE() << started.error();
      return -1;
    }
    EXPECT_EQ(started->Wait(), 0);
    std::ifstream file(folder_.Path("summary.json"));
    const auto summary = nlohmann::json::parse(file, nullptr, false);
    EXPECT_EQ(summary.value("problem", "no summary"), "");
    EXPECT_EQ(summary.value("faults", 1U), 0U);
    return summary.value("host_status", -1);
  }
  std::string Calibration() const { return folder_.Path("calibration.toml"); }

  const test::TempFolder folder_;
};

TEST_F(HilCalibrate, CalibratesABaseOverUsb) {
  const base::DeviceGeometry& device = config::DefaultDevice();
  const auto hand = tools::MakeCalibratingHand(device, {.away_s = 12, .wave_s = 6.5, .touches = 31, .seed = kSeed + 1});
  ASSERT_EQ(Run(hand, "room", {"--wave-seconds", "5", "--touches", "20"}), 0);
  const auto file = config::LoadCalibrationFile(
      Calibration(), {.device = device, .drawing = magnetics::NominalCalibration(device), .serial = "omni"});
  ASSERT_TRUE(file.ok()) << file.error();
  const base::TruthParameters& room = config::RoomTwin();
  sim::Rig rig(device, {.seed = kSeed, .sizes = room.imperfections, .effects = room.effects, .sensor = room.sensor});
  const auto before = test::MeasureCalibrationError(rig, magnetics::NominalCalibration(device), {.poses = 100});
  const auto after = test::MeasureCalibrationError(rig, file->calibration, {.poses = 100, .swept = true});
  ASSERT_TRUE(after.ok()) << after.error();
  std::printf("[ figure   ] calibrated over USB: mean error %.2f mm\n", after->raw_mm);
  EXPECT_LT(after->raw_mm, 0.6);
  if (before.ok()) {
    EXPECT_LT(after->raw_mm, 0.5 * before->raw_mm);
  }
}

TEST_F(HilCalibrate, MeasuresTheTipOffsetOverUsb) {
  const base::DeviceGeometry& device = config::DefaultDevice();
  const config::ExpectedBase of{.device = device, .drawing = magnetics::NominalCalibration(device), .serial = "omni"};
  base::TruthParameters room = config::RoomTwin();
  room.imperfections.tip_offset_m = 1e-3;
  const sim::Rig rig(device, {.seed = kSeed, .sizes = room.imperfections, .effects = room.effects});
  config::CalibrationFile file;
  file.calibration = rig.ExactCalibration();
  file.serial = of.serial;
  file.date = "2026-11-21T09:00:00Z";
  file.quality.expected_error_mm = 0.1;
  const base::Status saved = config::SaveCalibrationFile(Calibration(), file, of, false);
  ASSERT_TRUE(saved.ok()) << saved.error();
  const std::string twin = folder_.Write("twin.toml", "based_on = \"room\"\n[imperfections]\ntip_offset_m = 1.0e-3\n");
  ASSERT_EQ(Run(tools::MakePivotingHand({.rest_s = 8, .swing_s = 14, .seed = kSeed}), twin, {"--tip"}), 0);
  const auto now = config::LoadCalibrationFile(Calibration(), of);
  ASSERT_TRUE(now.ok()) << now.error();
  ASSERT_TRUE(now->tip_measured);
  const double error_m =
      now->calibration.magnet.tip_offset_m - tools::WithHeldTip(device, kSeed, room).magnet.tip_offset_m;
  std::printf("[ figure   ] tip measured over USB: error %+.3f mm\n", 1e3 * error_m);
  EXPECT_LT(std::abs(error_m), 0.3e-3);
}

}  // namespace
}  // namespace omni::hil
