// The base on what carries it: where it is mounted, and from there its motion.
#pragma once

#include <cstdint>
#include <optional>

#include "service/alignment/rigid.h"
#include "service/base/result.h"
#include "service/protocol/base_pose.h"
#include "service/tools/align/align.h"

namespace omni::tools {

// The mean pose of a source that rests for a second. C: the source's grip pose, L: the headset's space.
class SourceAtRest {
 public:
  static constexpr std::int64_t kSpan_ns = 1'000'000'000;
  static constexpr int kLeastPoses = 20;
  static constexpr double kMostMotion_m = 0.003;  // from the first pose: trackers tremble by less
  static constexpr double kMostMotion_rad = 0.01;

  void Add(std::int64_t t_ns, const alignment::Rigid& X_LC);
  bool complete() const { return count_ >= kLeastPoses && last_ns_ - first_ns_ >= kSpan_ns; }
  // Error: it moved.
  base::Result<alignment::Rigid> Mean() const;

 private:
  std::int64_t first_ns_ = 0, last_ns_ = 0;
  int count_ = 0;
  alignment::Rigid first_;
  base::Vec3 sum_m_;
  base::Quat sum_q_{0, 0, 0, 0};
  double moved_m_ = 0, moved_rad_ = 0;
};

// The base in the source, from both in L.
alignment::Rigid MountOf(const alignment::Rigid& X_LC, const alignment::Rigid& X_LB);

// The motion of a base, pose by pose of its source. A source without velocities has those between its last two poses.
class CarriedBase {
 public:
  CarriedBase(const Headset& headset, const alignment::Rigid& X_CB);
  // `line`: kMotion.
  protocol::BaseMotion MotionAt(const ProbeLine& line);
  protocol::BaseMotion In(protocol::BaseState state) const;  // kLost, kStands

 private:
  static constexpr std::int64_t kLongestStep_ns = 100'000'000;

  Headset headset_;
  alignment::Rigid X_CB_;
  std::optional<ProbeLine> before_;
};

}  // namespace omni::tools
