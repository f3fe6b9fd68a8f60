#pragma once
// What can be asked of this example on its command line.

#include <string>
#include <vector>

namespace probe {

struct Options {
  std::string name = "omni_probe";
  std::string hand = "right";
  std::vector<std::string> profiles = {"mx_ink", "touch", "simple"};
  double seconds = 10;
  double rate_Hz = 90;
  std::string json;  // file for the report; empty: none
  bool haptics = true;
  bool quiet = false;
  bool samples = false;      // put the path of the pose into the report
  bool expect_pen = false;   // fail unless profile, pose and select were seen
  bool plant_error = false;  // make one wrong call, to see whether a validation layer notices
};

// Empty on success, else what is wrong.
std::string Parse(int argc, char** argv, Options* options);

extern const char* const kUsage;

}  // namespace probe
