// What lies below an instance, the next layer or the runtime: its functions, extensions and paths.
#pragma once

#include <array>
#include <mutex>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "layer/src/entry/dispatch.h"

namespace omni::layer {

class Runtime {
 public:
  // `enabled`: the extensions that the application asked for, and "1.1" where it is such an application; `only_ours`:
  // those of them that are unknown below, and answered by us.
  Runtime(XrInstance instance, const Dispatch& functions, std::vector<std::string> enabled,
          std::vector<std::string> only_ours);

  const XrInstance handle;
  const Dispatch next;
  const std::array<XrPath, 2> hand_paths;  // by Hand

  // An extension that the application enabled, or "1.1".
  bool HasExtension(std::string_view extension) const;
  bool OnlyOurs(std::string_view extension) const;  // enabled, and unknown below
  // All that the application enabled, and those of them that the runtime knows.
  const std::vector<std::string>& enabled() const noexcept { return enabled_; }
  const std::vector<std::string>& enabled_below() const noexcept { return enabled_below_; }

  // Empty / XR_NULL_PATH where the runtime knows none.
  std::string PathText(XrPath path) const;
  XrPath PathOf(const std::string& text) const;

 private:
  const std::vector<std::string> enabled_;
  const std::vector<std::string> only_ours_;
  const std::vector<std::string> enabled_below_;  // enabled_ without only_ours_

  mutable std::mutex path_mutex_;
  mutable std::unordered_map<XrPath, std::string> path_texts_;
  mutable std::unordered_map<std::string, XrPath> paths_;
};

}  // namespace omni::layer
