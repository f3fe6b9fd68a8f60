#include "tests/support/hand/ordinary_hand.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "service/sim/fields/random.h"
#include "service/sim/fields/vec3.h"

namespace omni::sim {
namespace {

constexpr double kPeakOfMean = 1.875;  // speed of minimum jerk [Flash, Hogan 1985]
constexpr double kAbove_m = 0.084;     // of the magnet's centre
constexpr double kTap_m = 0.012, kTap_s = 0.06;
constexpr double kPress_m = 0.002;  // into the hull, against the hand's spring
constexpr double kTurn_rad_s = 5;   // greatest

struct Place {
  Vec3 centre_m, axis;
};

// In the upper hemisphere, the tip inwards, tilted by so much at most.
Place DrawPlace(double radius_min_m, double radius_max_m, double tilt_max_rad, Random& random) {
  const double z = random.Uniform();
  const double angle = 2 * std::numbers::pi * random.Uniform();
  const double rho = std::sqrt(1 - z * z);
  const Vec3 outwards{rho * std::cos(angle), rho * std::sin(angle), z};
  const double tilt = tilt_max_rad * random.Uniform();
  const double turn = 2 * std::numbers::pi * random.Uniform();
  const Vec3 across = Perpendicular(outwards);
  const Vec3 sideways = std::cos(turn) * across + std::sin(turn) * Cross(outwards, across);
  return {random.Uniform(radius_min_m, radius_max_m) * outwards,
          Normalized(-std::cos(tilt) * outwards + std::sin(tilt) * sideways)};
}

class Writer {
 public:
  Writer(const base::DeviceGeometry& device, const OrdinaryHandOptions& options)
      : device_(device), options_(options), random_(options.seed) {
    script_.name = "ordinary";
    script_.tremor_m = options.tremor_m;
    contact_m_ = device.hull_radius_m + std::hypot(device.magnet.half_height_m, device.magnet.radius_m);
  }

  HandScript Run() {
    if (options_.above_s > 0) {
      const Place above{{0, 0, kAbove_m}, {0, 0, -1}};
      Go(above, 0);
      Go(above, options_.above_s);
      MoveTo(Draw());
    } else {
      Go(Draw(), 0);
    }
    while (script_.duration_s() < options_.duration_s) {
      const double what = random_.Uniform();
      if (what < 0.70) {
        MoveTo(Draw());
      } else if (what < 0.85) {
        Go(place_, random_.Uniform(0.3, 2.0));  // stops
      } else if (what < 0.93) {
        Tap();
      } else if (what < 0.97) {
        Go(place_, random_.Uniform(2.0, 5.0));  // rests
      } else {
        LayDown();
      }
    }
    return script_;
  }

 private:
  Place Draw() { return DrawPlace(contact_m_, options_.radius_max_m, options_.tilt_max_rad, random_); }

  void Go(const Place& to, double duration_s) {
    script_.waypoints.push_back({.duration_s = duration_s,
                                 .tip_base_m = to.centre_m + device_.magnet.tip_offset_m * to.axis,
                                 .axis_base = to.axis});
    place_ = to;
  }

  void MoveTo(const Place& to) {
    const double speed_m_s = random_.Uniform(options_.speed_min_m_s, options_.speed_max_m_s);
    const double turn_rad = std::acos(std::clamp(Dot(place_.axis, to.axis), -1.0, 1.0));
    const double lever_m = device_.magnet.tip_offset_m * turn_rad;  // the centre turns about the tip's path
    Go(to, kPeakOfMean * std::max((Norm(to.centre_m - place_.centre_m) + lever_m) / speed_m_s, turn_rad / kTurn_rad_s));
  }

  // Down to the hull and back.
  void Tap() {
    const Place before = place_;
    const Vec3 outwards = Normalized(before.centre_m);
    Place above = before;
    above.centre_m = (contact_m_ + kTap_m) * outwards;
    MoveTo(above);
    const Place down{(contact_m_ - kPress_m) * outwards, before.axis};
    Go(down, kTap_s);
    Go(above, kTap_s);
    MoveTo(before);
  }

  // Its side on the hull.
  void LayDown() {
    const Place before = place_;
    const Vec3 outwards = Normalized(before.centre_m);
    const double lying_m = device_.hull_radius_m + device_.magnet.radius_m;
    MoveTo({lying_m * outwards, Perpendicular(outwards)});
    Go(place_, random_.Uniform(2.0, 4.0));
    MoveTo(before);
  }

  const base::DeviceGeometry& device_;
  OrdinaryHandOptions options_;
  Random random_;
  HandScript script_;
  Place place_;
  double contact_m_ = 0;
};

}  // namespace

HandScript MakeOrdinaryHand(const base::DeviceGeometry& device, const OrdinaryHandOptions& options) {
  return Writer(device, options).Run();
}

}  // namespace omni::sim
