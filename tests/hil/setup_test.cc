// omni setup on a base on USB: the unmodified programs on the emulated plug, and a simulated person; from nothing to a
// force, and each step once as it fails. Times are the base's own.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "service/config/files/device_file.h"
#include "service/tools/calibrate/calibrate_twin.h"
#include "service/tools/hand/touch_places.h"
#include "tests/support/process/child_process.h"
#include "tests/support/process/temp_folder.h"

namespace omni::hil {
namespace {

namespace fs = std::filesystem;

class HilSetup : public testing::Test {
 protected:
  HilSetup() {
    fs::create_directories(folder_.Path("run"));
    fs::permissions(folder_.Path("run"), fs::perms::owner_all);
    folder_.Write("hand.json", tools::WriteHandScript(tools::MakeCalibratingHand(config::DefaultDevice(), {})));
  }

  // `omni setup WORDS` with a person's answers, one a line; its exit status.
  int RunSetup(const std::string& words, const std::string& answers) {
    const std::string bin = OMNI_BINARY_DIR "/bin/";
    folder_.Write("answers", answers);
    fs::remove(folder_.Path("said"));
    std::vector<std::string> all{bin + "omni_hil",
                                 "--fast",
                                 "--ideal",
                                 "--script",
                                 Path("hand.json"),
                                 "--hand",
                                 Path("run/hand.sock"),
                                 "--summary",
                                 Path("summary.json"),
                                 "--clock",
                                 Path("clock")};
    const std::string command =
        "exec " + bin + "omni setup " + words + " <" + Path("answers") + " >" + Path("said") + " 2>&1";
    all.insert(all.end(), {"--", "sh", "-c", command});
    if (person_) all.insert(all.end(), {"--", bin + "hil_person", Path("said"), Path("run/hand.sock")});
    auto started = test::ChildProcess::Start(
        all, {"HOME=" + Path("home"), "XDG_CONFIG_HOME=" + Path("home/config"), "XDG_DATA_HOME=" + Path("home/data"),
              "XDG_CACHE_HOME=" + std::string(OMNI_BINARY_DIR) + "/tests/setup_cache",
              "OMNI_SOCKET=" + Path("run/omnid.sock"), "XDG_RUNTIME_DIR=", "DBUS_SESSION_BUS_ADDRESS=", "COLUMNS="});
    if (!started.ok()) {
      ADD_FAILURE() << started.error();
      return -1;
    }
    EXPECT_EQ(started->Wait(), 0);
    std::ifstream file(Path("summary.json"));
    summary_ = nlohmann::json::parse(file, nullptr, false);
    return summary_.value("host_status", -1);
  }

  std::string Path(const std::string& below) const { return folder_.Path(below); }
  std::string Said() const {
    std::ifstream in(Path("said"));
    return {std::istreambuf_iterator<char>(in), {}};
  }
  void ExpectSaid(const std::string& words) const {
    EXPECT_NE(Said().find(words), std::string::npos) << words << "\nis not in\n" << Said();
  }

  const test::TempFolder folder_;
  bool person_ = true;  // one who moves the pen
  nlohmann::json summary_;
};

// The steps that take no time.
TEST_F(HilSetup, FindsAndTestsTheBase) {
  EXPECT_EQ(RunSetup("device", ""), 0) << Said();
  ExpectSaid("done: base omni on USB port 1-1");
  EXPECT_EQ(RunSetup("selftest", "n\n"), 0) << Said();
  ExpectSaid("skipped: `omni device selftest` does it later");
  EXPECT_EQ(RunSetup("selftest", "y\n"), 0) << Said();
  ExpectSaid("done: the base passes its own test");
}

TEST_F(HilSetup, ABaseThatFailsItsTestIsNotUsed) {
  folder_.Write("hand.json", R"({"name": "pen beside a sensor", "repeat": false, "waypoints": [
    {"s": 0, "tip_m": [0.0, 0.045, -0.04], "axis": [0, 0, -1]}]})");
  EXPECT_EQ(RunSetup("selftest", "y\nq\n"), 1) << Said();
  ExpectSaid("FAIL  Hall sensors saturated: ");
  ExpectSaid("take the pen and other magnets away");
  ExpectSaid("\"Test the base\" failed, see above; `omni setup selftest` tries it again");
}

TEST_F(HilSetup, AHeadsetThatIsNotThereIsNamed) {
  EXPECT_EQ(RunSetup("align", "y\nq\n"), 1) << Said();
  ExpectSaid("FAILED: nothing was stored; docs/howto/align.md lists other methods");
}

// Minutes: not part of the tests (docs/CONTRIBUTING.md).
using HilSetupLong = HilSetup;

TEST_F(HilSetupLong, GoesFromNothingToAForce) {
  // Self-test: yes. Align: no headset. Hand: right. Layer: yes.
  const int status = RunSetup("", "y\nn\nright\ny\n");
  EXPECT_EQ(status, 0) << Said();
  ExpectSaid("done: the base passes its own test");
  ExpectSaid("done: calibrated: " + Path("home/config/omni/calibration.toml"));
  ExpectSaid("done: largest forces: extrusion ");
  ExpectSaid("Set up in ");
  EXPECT_TRUE(fs::exists(Path("home/config/omni/inputs.toml")));
  std::ifstream in(Path("said.hand"));
  const std::string hand(std::istreambuf_iterator<char>(in), {});
  std::printf("%s\nthe last hand: %s\n[ figure   ] %.0f s of the base's time\n", Said().c_str(), hand.c_str(),
              summary_.value("device_s", 0.0));
}

// Without a person at the pen.
TEST_F(HilSetupLong, StepsThatWaitForThePenEndAndSayWhatIsMissing) {
  person_ = false;
  for (const char* step : {"calibrate", "inputs", "scenes"}) {
    EXPECT_EQ(RunSetup(step, std::string(step) == "inputs" ? "right\nq\n" : "q\n"), 1) << Said();
    ExpectSaid("FAILED: ");
    ExpectSaid("`omni setup " + std::string(step) + "` tries it again");
    std::printf("%s\n", Said().c_str());
  }
}

}  // namespace
}  // namespace omni::hil
