// What the base follows, and where it is mounted on that: $XDG_CONFIG_HOME/omni/follow.toml, written by `omni follow`.
//
//   [base]
//   follows = "/user/hand/left"
//   position_source_m = [0.0, -0.1, 0.02]                    # the base in the grip pose of that path
//   orientation_source_wxyz = [0.7071, 0.7071, 0.0, 0.0]
#pragma once

#include <optional>
#include <string>

#include "service/base/result.h"
#include "service/base/vec.h"

namespace omni::config {

struct FollowSettings {
  std::string follows;  // an OpenXR path: /user/hand/left, or the role of a tracker
  base::Vec3 position_source_m;
  base::Quat orientation_source;
};

base::Result<FollowSettings> ParseFollow(const std::string& text, const std::string& name);
// None: there is no such file, the base stands.
base::Result<std::optional<FollowSettings>> LoadFollowFile(const std::string& path);
std::string WriteFollow(const FollowSettings& settings);

}  // namespace omni::config
