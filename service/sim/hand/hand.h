// The hand: a mass on a spring-damper whose other end follows the script or a HandGuide. It carries the pen's weight,
// turns it as wanted, and yields to magnetic force. The pen never enters the hull.
#pragma once

#include <optional>
#include <vector>

#include "service/base/device_geometry.h"
#include "service/sim/fields/random.h"
#include "service/sim/fields/tremor.h"
#include "service/sim/fields/truth_model.h"
#include "service/sim/hand/hand_guide.h"
#include "service/sim/twin/twin.h"

namespace omni::sim {

// The script as a smooth function of time. Precondition: what CheckHandScript accepts, or no waypoints: no pen.
class HandPath {
 public:
  HandPath(const HandScript& script, double tip_offset_m, Random& random);

  HandTarget TargetAt(double t_s) const noexcept;
  HandTarget Start() const noexcept;  // the first waypoint, without tremor
  const Tremor& tremor() const noexcept { return tremor_; }

 private:
  struct Leg {
    double start_s = 0;
    double duration_s = 0;
    Vec3 from_tip, to_tip;
    Vec3 from_axis, turn_axis;  // axis(s) = cos(angle s) from_axis + sin(angle s) turn_axis
    double angle_rad = 0;
    bool present = true;
  };

  HandTarget Still(double t_s) const noexcept;  // without tremor
  void AddLeg(const HandWaypoint& from, const HandWaypoint& to, double duration_s);

  std::vector<Leg> legs_;  // by start; the last one of a repeating script leads back to the first waypoint
  double period_s_ = 0;    // 0: does not repeat
  double tip_offset_m_;
  Tremor tremor_;
};

class Hand {
 public:
  // `led`: of the script only the first waypoint counts, where the hand waits for its first aim.
  Hand(const HandScript& script, const base::DeviceGeometry& device, Random& random, bool led = false);

  // Precondition: led.
  void SetAim(const HandAim& aim) noexcept { led_->SetAim(aim); }

  // The next sub-step [t, t + dt] under `force_N` on the pen.
  void Step(double t_s, double dt_s, const Vec3& force_N) noexcept;

  // The pose expected at `t_s` if nothing but inertia acts until then.
  MagnetPose PredictedPose(double t_s) const noexcept;

  const MagnetPose& pose() const noexcept { return pose_; }
  const base::MagnetGeometry& magnet() const noexcept { return magnet_; }
  const Vec3& velocity_base_m_s() const noexcept { return velocity_; }
  bool present() const noexcept { return present_; }
  double gap_m() const noexcept { return GapToHull(magnet_, hull_radius_m_, pose_).gap_m; }

 private:
  HandTarget NextTarget(double t_s, double dt_s) noexcept;
  void KeepOutOfHull() noexcept;

  HandPath path_;
  std::optional<LedPath> led_;
  base::MagnetGeometry magnet_;
  double hull_radius_m_;
  double stiffness_N_m_, damping_Ns_m_, mass_kg_;
  MagnetPose pose_;
  Vec3 velocity_;
  double t_s_ = 0;
  bool present_ = true;
};

// First violation of the limits in hand_script.cc as a message that starts with the JSON pointer; empty if there is
// none.
std::string CheckHandScript(const HandScript& script);

}  // namespace omni::sim
