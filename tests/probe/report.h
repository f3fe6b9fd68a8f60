#pragma once
// What the application saw, counted as it goes and written as JSON at the end.

#include <openxr/openxr.h>

#include <string>
#include <vector>

#include "tests/probe/options.h"

namespace probe {

struct FailedCall {
  std::string call;
  std::string result;
  long count = 0;
};

struct Sample {
  double time_s;
  XrVector3f position_m;
};

struct Report {
  std::string profile;  // the last one that was not null
  std::vector<std::string> profiles_seen;
  long frames = 0;
  long locates = 0;
  long locates_after_first_valid = 0;
  long valid_after_first_valid = 0;
  long tracked_after_first_valid = 0;
  long pose_active_frames = 0;
  long select_edges = 0;
  long haptics_sent = 0;
  double max_speed_m_s = 0;
  double thumbstick_max = 0;
  double force_max = 0;
  double first_valid_s = -1;  // < 0: never
  std::vector<int64_t> locate_ns;
  std::vector<FailedCall> errors;
  std::string planted_error_result;  // empty: none was asked for
  std::vector<Sample> samples;

  // Every failed call is kept once, with how often it failed.
  void AddError(const std::string& call, const std::string& result);
  void AddProfile(const std::string& path);
  void AddLocation(double time_s, int64_t elapsed_ns, const XrSpaceLocation& location, const XrSpaceVelocity& velocity);
  double PoseValidFraction() const;
};

// Empty if a profile, a pose and a select press were seen, else what was missing.
std::string MissingFromPen(const Report& report);

// False when the file cannot be written.
bool WriteJson(const Options& options, const Report& report);

}  // namespace probe
