// Inputs and calibration in `omni status`.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "service/tools/status/status.h"

namespace omni::tools {
namespace test_tools_status {

TEST(StatusText, InputsBySourceAndDevice) {
  const nlohmann::json status = {
      {"inputs",
       {{"mapping",
         {{"secondary", {"double_tap", "key:KEY_B"}}, {"menu", {"flick"}}, {"squeeze", nlohmann::json::array()}}},
        {"sources",
         {{{"name", "press"}, {"on", true}, {"times", 7}},
          {{"name", "tap"}, {"on", false}, {"times", 2}},
          {{"name", "flick"}, {"on", false}, {"times", 0}}}},
        {"devices",
         {{{"rule", "*Foot*"}, {"paths", "/dev/input/event5"}, {"problem", ""}},
          {{"rule", "/dev/input/by-id/x"}, {"paths", ""}, {"problem", "cannot be opened"}},
          {{"rule", "*Keyboard*"}, {"paths", ""}, {"problem", ""}}}}}}};
  const std::string text = StatusText(status);
  for (const char* line :
       {"menu: flick; secondary: double_tap, key:KEY_B\n", "press 7 (on), tap 2\n", "*Foot*: /dev/input/event5\n",
        "/dev/input/by-id/x: cannot be opened\n", "*Keyboard*: not connected\n"}) {
    EXPECT_NE(text.find(line), std::string::npos) << line << "not in:\n" << text;
  }
  EXPECT_EQ(StatusText(nlohmann::json::object()).find("inputs"), std::string::npos) << "of an older omnid";
}

TEST(StatusText, DescribesEachCalibrationState) {
  const auto line = [](const nlohmann::json& status) {
    const std::string text = StatusText(status);
    const std::size_t at = text.find("calibrated ");
    return text.substr(at, text.find('\n', at) - at);
  };
  EXPECT_EQ(line({}), "calibrated never: the base uses its nominal geometry; to calibrate it: `omni calibrate`");
  nlohmann::json status = {{"calibration", {{"file", "/c.toml"}, {"date", "2026"}, {"expected_error_mm", 0.1}}},
                           {"calibration_refused", nullptr},
                           {"calibration_misfit", nullptr}};
  EXPECT_EQ(line(status), "calibrated /c.toml of 2026, expected error 0.10 mm");
  status["calibration"]["shipped"] = true;
  EXPECT_EQ(line(status), "calibrated shipped with the twin: /c.toml of 2026, expected error 0.10 mm");
  status["calibration"].erase("shipped");
  status["calibration"]["note"] = "without a checksum";
  status["calibration_misfit"] = "it does not fit";
  EXPECT_EQ(
      line(status),
      "calibrated /c.toml of 2026, expected error 0.10 mm, without a checksum; does not fit this base (see problem)");
  status["calibration"] = nullptr;
  status["calibration_misfit"] = nullptr;
  status["calibration_refused"] = "/c.toml: no";
  EXPECT_EQ(line(status), "calibrated no: the file was rejected (see problem), the base uses its nominal geometry");
}

}  // namespace test_tools_status
}  // namespace omni::tools
