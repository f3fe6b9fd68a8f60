// omni calibrate on a base on USB: the unmodified program on the emulated plug, a scripted hand doing what a person
// would.
#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "service/config/calibration_file.h"
#include "service/config/device_file.h"
#include "service/config/twin_file.h"
#include "service/magnetics/nominal.h"
#include "service/tools/calibrate_hand.h"
#include "service/tools/hand_path.h"
#include "tests/support/calibration_error.h"
#include "tests/support/child_process.h"
#include "tests/support/temp_folder.h"

namespace omni::hil {
namespace {

constexpr std::uint64_t kSeed = 7;

// omni_hil with `omni calibrate --device usb` on its base, and a hand that waves for 7 s and touches.
class HilCalibrate : public testing::Test {
 protected:
  int Run(int touches, const std::string& asked) {
    const auto hand = tools::MakeCalibratingHand(config::DefaultDevice(),
                                                 {.away_s = 12, .wave_s = 6.5, .touches = touches, .seed = kSeed + 1});
    folder_.Write("hand.json", tools::WriteHandScript(hand));
    const std::string bin = std::string(OMNI_BINARY_DIR) + "/bin/";
    auto started = test::ChildProcess::Start({bin + "omni_hil",
                                              "--fast",
                                              "--twin",
                                              "room",
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
                                              "--wave-seconds",
                                              "5",
                                              "--touches",
                                              asked,
                                              "-o",
                                              Calibration()},
                                             {"XDG_CONFIG_HOME=" + folder_.Path("config")});
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

 private:
  const test::TempFolder folder_;
};

TEST_F(HilCalibrate, MeasuresTheBaseThatIsPluggedIn) {
  ASSERT_EQ(Run(31, "20"), 0);
  const base::DeviceGeometry& device = config::DefaultDevice();
  const auto file = config::LoadCalibrationFile(
      Calibration(), {.device = device, .drawing = magnetics::NominalCalibration(device), .serial = "omni"});
  ASSERT_TRUE(file.ok()) << file.error();
  const base::TruthParameters& room = config::RoomTwin();
  sim::Rig rig(device, {.seed = kSeed, .sizes = room.imperfections, .effects = room.effects, .sensor = room.sensor});
  const auto before = test::MeasureCalibrationError(rig, magnetics::NominalCalibration(device), {.poses = 100});
  const auto after = test::MeasureCalibrationError(rig, file->calibration, {.poses = 100});
  ASSERT_TRUE(after.ok()) << after.error();
  std::printf("[ figure   ] calibrated over USB: mean error %.2f mm\n", after->raw_mm);
  EXPECT_LT(after->raw_mm, 0.6);
  if (before.ok()) {
    EXPECT_LT(after->raw_mm, 0.5 * before->raw_mm);
  }
}

}  // namespace
}  // namespace omni::hil
