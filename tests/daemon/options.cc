// omnid's options are checked before anything starts.
#include <gtest/gtest.h>

#include <filesystem>

#include "service/daemon/run.h"
#include "tests/support/process/temp_folder.h"

namespace omni::daemon {
namespace test_daemon_options {

TEST(DaemonOptions, AcceptsDefaultsAndValidFiles) {
  const test::TempFolder folder;
  EXPECT_EQ(OptionsProblem({}), "");
  RunOptions options{.device = "twin"};
  options.twin_script = OMNI_SOURCE_DIR "/scenes/dragon.hand.json";
  options.device_file = OMNI_SOURCE_DIR "/manifests/device/omni.toml";
  options.alignment_path = folder.Path("not/yet/alignments.toml");
  options.record_path = options.record_device_path = options.twin_record = folder.Path("fresh.csv");
  EXPECT_EQ(OptionsProblem(options), "");
  EXPECT_FALSE(std::filesystem::exists(options.record_path)) << "only checked";
  options.record_path = "/dev/full";
  EXPECT_EQ(OptionsProblem(options), "");
}

TEST(DaemonOptions, ErrorsNameTheOptionAndTheFile) {
  const test::TempFolder folder;
  const std::string broken = folder.Write("broken.toml", "= no TOML"), gone = folder.Path("gone/file");
  const struct {
    const char* name;
    std::string RunOptions::*path;
    bool input;
  } rows[] = {{"--device-file: ", &RunOptions::device_file, true},
              {"--calibration: ", &RunOptions::calibration_path, true},
              {"--alignments: ", &RunOptions::alignment_path, true},
              {"--twin: ", &RunOptions::twin, true},
              {"--twin-script: ", &RunOptions::twin_script, true},
              {"--record: ", &RunOptions::record_path, false},
              {"--record-device: ", &RunOptions::record_device_path, false},
              {"--twin-record: ", &RunOptions::twin_record, false}};
  for (const auto& row : rows) {
    for (const std::string& path : {gone, row.input ? broken : folder.Path()}) {
      const bool may_be_missing = row.path == &RunOptions::alignment_path && path == gone;
      RunOptions options{.device = "twin"};
      options.*row.path = path;
      const std::string problem = OptionsProblem(options);
      EXPECT_EQ(problem.empty(), may_be_missing) << row.name << path;
      if (may_be_missing) continue;
      EXPECT_EQ(problem.find(row.name + path), 0U) << problem;
    }
  }
}

TEST(DaemonOptions, OptionsOfTheTwinNeedTheTwin) {
  RunOptions options{.device = "twin"};
  options.twin_script = OMNI_SOURCE_DIR "/scenes/dragon.hand.json";
  options.device = "twin";
  EXPECT_EQ(OptionsProblem(options), "");
  for (const char* device : {"usb", "usb:A17", "replay:file"}) {
    options.device = device;
    EXPECT_NE(OptionsProblem(options).find("--twin-script: needs --device twin"), std::string::npos) << device;
    RunOptions ideal{.device = device};
    EXPECT_EQ(OptionsProblem(ideal), "") << device;
    ideal.twin = "ideal";
    EXPECT_EQ(OptionsProblem(ideal), "--twin, --ideal: need --device twin") << device;
  }
}

}  // namespace test_daemon_options
}  // namespace omni::daemon
