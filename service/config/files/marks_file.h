// manifests/device/marks.toml: points of the base that a controller can touch. Errors name file, key, value and range.
#pragma once

#include <string>
#include <vector>

#include "service/base/result.h"
#include "service/base/vec.h"

namespace omni::config {

inline constexpr std::size_t kMinMarks = 3;
inline constexpr std::size_t kMaxMarks = 12;

struct Mark {
  std::string name;
  base::Vec3 position_base_m;
};

base::Result<std::vector<Mark>> LoadMarksFile(const std::string& path);
// `name` stands for the file in messages.
base::Result<std::vector<Mark>> ParseMarks(const std::string& text, const std::string& name);
// Those built into the binary.
const std::vector<Mark>& DefaultMarks();

}  // namespace omni::config
