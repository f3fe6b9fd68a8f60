// Touches a scene at some places, one after another, until it has done what there is to do: clay is pulled out and
// pushed in, a soft body dented, anything else pressed. If a place does not work, it moves on to the next one.
#pragma once

#include <string>
#include <vector>

#include "service/haptics/scene/scene.h"
#include "service/tools/hand/hand_task.h"
#include "service/tools/hand/touch_places.h"

namespace omni::tools {

enum class TouchKind { kFirm, kSoft, kClay };

struct Touch {
  base::Vec3 place_base_m;  // on the surface
  TouchKind kind = TouchKind::kFirm;
  double press_N = 0.5;  // force to press with
};

// What the places of a scene are made of.
std::vector<Touch> TouchesOf(const haptics::Scene& scene, const std::vector<TouchPlace>& places);

class TouchTask final : public HandTask {
 public:
  // Precondition: there are some.
  explicit TouchTask(std::vector<Touch> touches);

  std::optional<sim::HandAim> NextAim(const Perceived& seen) override;
  bool done() const override { return phase_ == Phase::kDone; }
  std::string Summary() const override;

  int succeeded() const { return succeeded_; }

 private:
  enum class Phase { kTravel, kWait, kLower, kHold, kShape, kRest, kLift, kJudge, kLeave, kDone };
  void Enter(Phase phase) { phase_ = phase, phase_s_ = 0; }
  void Act(const Perceived& seen, double dt_s);
  void Lower(const Perceived& seen, double dt_s);
  void HoldDown(const Perceived& seen, double dt_s);
  void Shape(const Perceived& seen, double dt_s);
  void Judge(const Perceived& seen);
  bool There(const Perceived& seen) const;  // the object to be touched is present and ready
  bool Enough() const;

  const Touch& touch() const { return touches_[next_ % touches_.size()]; }
  base::Vec3 Above(double height_m) const;
  bool Sink(double speed_m_s, double dt_s);

  const std::vector<Touch> touches_;
  double safe_z_m_ = 0;  // over everything
  std::size_t next_ = 0;
  int tried_ = 0, succeeded_ = 0;
  Phase phase_ = Phase::kTravel;
  double phase_s_ = 0;  // since it began
  Steps steps_;
  MovingAim aim_;
  bool pen_seen_ = false, there_ = false, pressed_ = false, clicked_ = false;
  std::optional<std::uint32_t> presses_before_;
  std::optional<std::uint32_t> strokes_judged_;  // so many have been counted; one that is seen late counts for the next
  double grip_z_m_ = 0;                          // of the tip, where the clay was grabbed
  double dent_m_ = 0, deepest_dent_m_ = 0;
};

}  // namespace omni::tools
