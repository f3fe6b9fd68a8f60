// A lap of a race: to the joystick, round the track, straight into a wall, then the stick pressed down until it clicks,
// and away.
#pragma once

#include <string>

#include "service/haptics/scene/scene.h"
#include "service/tools/hand/car_driver.h"
#include "service/tools/hand/hand_task.h"

namespace omni::tools {

class RaceTask final : public HandTask {
 public:
  // Precondition: the scene has a vehicle and a joystick.
  RaceTask(const haptics::SceneHeader& scene, TrackLine line)
      : stick_(scene.joystick), driver_(scene.vehicle, std::move(line)) {}

  std::optional<sim::HandAim> NextAim(const Perceived& seen) override;
  bool done() const override { return phase_ == Phase::kDone; }
  std::string Summary() const override;

 private:
  enum class Phase { kReach, kDrive, kCrash, kStop, kPress, kPressed, kRelease, kLeave, kDone };
  void Enter(Phase phase) { phase_ = phase, phase_s_ = 0; }
  void Hold(const StickWish& wish, const base::Vec3& tip_base_m, double dt_s);

  const haptics::JoystickInput stick_;
  CarDriver driver_;
  Phase phase_ = Phase::kReach;
  double phase_s_ = 0;  // since it began
  Steps steps_;
  MovingAim aim_;
  base::Vec3 pushed_m_;  // how much further the hand pushes than the stick should move
  PerceivedCar car_;     // as seen last
  std::uint32_t laps_before_ = 0, hits_before_ = 0, presses_before_ = 0;
  int clicks_ = 0;
  bool pen_seen_ = false, clicked_ = false;
};

}  // namespace omni::tools
