// omni rehearse-controller: speaks as omni_align_probe does (layer/examples/align/main.cc), with a simulated headset
// and a simulated controller that touches the marks of the base. For `omni setup --rehearse`.
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "service/alignment/kabsch.h"
#include "service/alignment/rigid.h"
#include "service/base/clock.h"
#include "service/base/eigen.h"
#include "service/config/files/marks_file.h"
#include "service/tools/common/command_line.h"
#include "service/tools/common/commands.h"

namespace omni::tools {
namespace {

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr int kStage = 3;  // XR_REFERENCE_SPACE_TYPE_STAGE
constexpr int kPeriod_ms = 20;
constexpr double kSwing_s = 10, kMove_s = 0.8, kRest_s = 1.2;
const Vector3d kTip_m(0.02, -0.01, -0.11);  // the controller's point that touches, in its own frame

// On a table before the person.
alignment::Rigid SimulatedBase() { return alignment::Nudged(alignment::LevelBase(), 0.3, {0.1, 0.75, -0.45}); }

struct Grip {
  Vector3d position_m;
  Quaterniond orientation;
};

// Swings about the first mark, then rests on each of the others, the last one for ever.
Grip GripAt(double t_s) {
  std::vector<Vector3d> marks;
  for (const config::Mark& mark : config::DefaultMarks()) {
    marks.push_back(base::ToEigen(alignment::Apply(SimulatedBase(), mark.position_base_m)));
  }
  Vector3d at = marks.front();
  double swing_rad = 0.5;
  if (t_s > kSwing_s && marks.size() > 1) {
    const double along = (t_s - kSwing_s) / (kMove_s + kRest_s);
    const std::size_t leg = std::min(static_cast<std::size_t>(along), marks.size() - 2);
    const double u = std::min(1.0, (along - static_cast<double>(leg)) * (kMove_s + kRest_s) / kMove_s);
    at = marks[leg] + u * (marks[leg + 1] - marks[leg]) + Vector3d(0, 0.05 * std::sin(std::numbers::pi * u), 0);
    swing_rad = 0.1;
  }
  const Vector3d turn = swing_rad * Vector3d(std::sin(2.1 * t_s), std::sin(1.7 * t_s + 1), std::sin(2.7 * t_s + 2));
  const Quaterniond q(AngleAxisd(turn.norm(), turn.normalized()));
  return {at - q * kTip_m, q};
}

int Rehearse() {
  std::setvbuf(stdout, nullptr, _IOLBF, 1 << 16);
  std::printf("runtime rehearsal\nsystem simulated headset\nspace %d\n", kStage);
  const std::int64_t start_ns = base::MonotonicNow_ns();
  pollfd in{STDIN_FILENO, POLLIN, 0};
  while (::poll(&in, 1, kPeriod_ms) == 0) {  // its end, or a byte: whoever started us is done
    const std::int64_t now_ns = base::MonotonicNow_ns();
    const auto [p, q] = GripAt(1e-9 * static_cast<double>(now_ns - start_ns));
    std::printf("pose %lld right %.7g %.7g %.7g %.7g %.7g %.7g %.7g\n", static_cast<long long>(now_ns), p.x(), p.y(),
                p.z(), q.x(), q.y(), q.z(), q.w());
  }
  return kExitOk;
}

}  // namespace

void AddRehearseController(Command& app) { app.AddHidden("rehearse-controller").Run(Rehearse); }

}  // namespace omni::tools
