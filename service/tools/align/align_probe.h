// The OpenXR half of `omni align` and `omni follow`: omni_align_probe (layer/examples/align) as a child, line by line.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "service/alignment/types.h"
#include "service/base/result.h"
#include "service/base/unique_fd.h"

namespace omni::tools {

enum class ProbeSays { kRuntime, kSystem, kSpace, kPose, kMotion, kLost, kMoved, kEnd };

struct ProbeLine {
  ProbeSays says = ProbeSays::kEnd;
  std::string text;       // kRuntime, kSystem: the name; kEnd: why; kPose: "left", "right_finger", ...
  int space = 0;          // kSpace: XrReferenceSpaceType
  std::int64_t t_ns = 0;  // kPose, kMotion: CLOCK_MONOTONIC
  alignment::Rigid pose;  // kPose, kMotion: X_LC
  bool moves = false;     // kMotion: its velocities are known
  base::Vec3 velocity_m_s, turn_rate_rad_s;
};

// Null: not a line of the probe (a runtime's library may print too).
std::optional<ProbeLine> ParseProbeLine(const std::string& line);

class AlignProbe {
 public:
  // Our own layer is disabled in the child: it must see the controller, not the pen in its place.
  static base::Result<std::unique_ptr<AlignProbe>> Start(const std::string& program,
                                                         const std::vector<std::string>& arguments);
  ~AlignProbe();  // ends the child
  AlignProbe(const AlignProbe&) = delete;
  AlignProbe& operator=(const AlignProbe&) = delete;

  // The next line, waited for `timeout_ms` at most. After the child has exited: always kEnd.
  std::optional<ProbeLine> Next(int timeout_ms);

 private:
  AlignProbe() = default;
  pid_t pid_ = -1;
  base::UniqueFd in_, out_;  // the child's standard input (it runs while this is open) and standard output
  std::string buffer_;
  bool ended_ = false;
};

// Beside this program.
std::string DefaultProbe();

}  // namespace omni::tools
