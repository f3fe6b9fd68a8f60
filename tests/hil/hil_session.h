// The whole chain as real processes: omni_hil with an unmodified omnid on its emulated base, and an application that
// uses force, while a scenario runs.
#pragma once

#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "service/base/clock.h"
#include "tests/support/process/child_process.h"
#include "tests/support/process/temp_folder.h"

namespace omni::hil {

class HilSession {
 public:
  HilSession() {
    std::filesystem::create_directories(folder_.Path("run"));
    std::filesystem::permissions(folder_.Path("run"), std::filesystem::perms::owner_all);
    folder_.Write("config/omni/apps.d/test.toml",
                  "application = \"hil_test\"\nscene = \"" OMNI_SOURCE_DIR "/scenes/extrusion.glb\"\n");
    // Down onto the block's top, then pressing for as long as it takes.
    folder_.Write("hand.json", R"({"name": "press", "repeat": false, "waypoints": [
      {"s": 0, "tip_m": [0.008, 0.004, 0.085], "axis": [0, 0, -1]},
      {"s": 0.5, "tip_m": [0.008, 0.004, 0.080], "axis": [0, 0, -1]},
      {"s": 0.8, "tip_m": [0.008, 0.004, 0.0415], "axis": [0, 0, -1]},
      {"s": 60, "tip_m": [0.008, 0.004, 0.0415], "axis": [0, 0, -1]}]})");
  }

  // Runs the scenario to its end with an application that is focused and alive; its summary. Null: there is none.
  nlohmann::json Run(const std::string& scenario, const std::vector<std::string>& options = {}) {
    const std::string bin = std::string(OMNI_BINARY_DIR) + "/bin/";
    std::vector<std::string> arguments{bin + "omni_hil", "--twin",     "ideal",     "--fast",
                                       "--scenario",     scenario,     "--script",  folder_.Path("hand.json"),
                                       "--record",       truth_path(), "--summary", folder_.Path("summary.json")};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const std::vector<std::string> programs{"--",   bin + "omnid", "--device",      "usb",     "--log-level",
                                            "warn", "--",          bin + "hil_app", "hil_test"};
    arguments.insert(arguments.end(), programs.begin(), programs.end());
    const std::int64_t began_ns = base::MonotonicNow_ns();
    auto started = test::ChildProcess::Start(
        arguments, {"OMNI_SOCKET=" + folder_.Path("run/omnid.sock"), "XDG_CONFIG_HOME=" + folder_.Path("config"),
                    "XDG_STATE_HOME=" + folder_.Path("state")});
    if (!started.ok()) {
      ADD_FAILURE() << started.error();
      return nullptr;
    }
    EXPECT_EQ(started->Wait(), 0);
    wall_s_ = static_cast<double>(base::MonotonicNow_ns() - began_ns) * 1e-9;
    std::ifstream file(folder_.Path("summary.json"));
    return nlohmann::json::parse(file, nullptr, false);
  }

  double wall_s() const { return wall_s_; }
  std::string truth_path() const { return folder_.Path("truth.csv"); }

 private:
  const test::TempFolder folder_;
  double wall_s_ = 0;
};

}  // namespace omni::hil
