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

#include "service/alignment/rigid.h"
#include "service/base/clock.h"
#include "service/base/vec.h"
#include "service/config/files/device_file.h"
#include "service/tools/common/command_line.h"

namespace omni::tools {
namespace {

using base::Vec3;

constexpr int kStage = 3;  // XR_REFERENCE_SPACE_TYPE_STAGE
constexpr int kPeriod_ms = 20;
constexpr double kSwing_s = 10, kMove_s = 0.8, kRest_s = 1.2;
constexpr Vec3 kTip_m{0.02, -0.01, -0.11};  // the controller's point that touches, in its own frame

// On a table before the person.
alignment::Rigid SimulatedBase() { return alignment::NudgedPose(alignment::LevelBase(), 0.3, {0.1, 0.75, -0.45}); }

// About w by |w|.
base::Quat Turned(const Vec3& w) {
  const double angle_rad = base::Norm(w);
  const double s = angle_rad > 0 ? std::sin(angle_rad / 2) / angle_rad : 0.5;
  return {std::cos(angle_rad / 2), s * w.x, s * w.y, s * w.z};
}

// Where the controller's grip is: it swings about the first mark, then rests on each of the others, the last one for
// ever.
alignment::Rigid GripAt(double t_s) {
  std::vector<Vec3> marks;
  for (const config::Mark& mark : config::DefaultMarks()) {
    marks.push_back(alignment::TransformPoint(SimulatedBase(), mark.position_base_m));
  }
  Vec3 at = marks.front();
  double swing_rad = 0.5;
  if (t_s > kSwing_s && marks.size() > 1) {
    const double along = (t_s - kSwing_s) / (kMove_s + kRest_s);
    const std::size_t leg = std::min(static_cast<std::size_t>(along), marks.size() - 2);
    const double u = std::min(1.0, (along - static_cast<double>(leg)) * (kMove_s + kRest_s) / kMove_s);
    at = marks[leg] + u * (marks[leg + 1] - marks[leg]) + Vec3{0, 0.05 * std::sin(std::numbers::pi * u), 0};
    swing_rad = 0.1;
  }
  const Vec3 turn{swing_rad * std::sin(2.1 * t_s), swing_rad * std::sin(1.7 * t_s + 1),
                  swing_rad * std::sin(2.7 * t_s + 2)};
  alignment::Rigid grip;
  grip.orientation = Turned(turn);
  grip.position_m = at - alignment::TransformPoint(grip, kTip_m);
  return grip;
}

int Rehearse() {
  std::setvbuf(stdout, nullptr, _IOLBF, 1 << 16);
  std::printf("runtime rehearsal\nsystem simulated headset\nspace %d\n", kStage);
  const std::int64_t start_ns = base::MonotonicNow_ns();
  pollfd in{STDIN_FILENO, POLLIN, 0};
  while (::poll(&in, 1, kPeriod_ms) == 0) {  // its end, or a byte: whoever started us is done
    const std::int64_t now_ns = base::MonotonicNow_ns();
    const alignment::Rigid grip = GripAt(1e-9 * static_cast<double>(now_ns - start_ns));
    const Vec3& p = grip.position_m;
    const base::Quat& q = grip.orientation;
    std::printf("pose %lld right %.7g %.7g %.7g %.7g %.7g %.7g %.7g\n", static_cast<long long>(now_ns), p.x, p.y, p.z,
                q.x, q.y, q.z, q.w);
  }
  return kExitOk;
}

}  // namespace

void AddRehearseController(Command& app) { app.AddHidden("rehearse-controller").SetAction(Rehearse); }

}  // namespace omni::tools
