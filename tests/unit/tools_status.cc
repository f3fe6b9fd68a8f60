// What `omni status` says of inputs.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "service/tools/status_text.h"

namespace omni::tools {
namespace {

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
        "/dev/input/by-id/x: cannot be opened\n", "*Keyboard*: not there\n"}) {
    EXPECT_NE(text.find(line), std::string::npos) << line << "not in:\n" << text;
  }
  EXPECT_EQ(StatusText(nlohmann::json::object()).find("inputs"), std::string::npos) << "of an older omnid";
}

}  // namespace
}  // namespace omni::tools
