#include "service/loop/scene_motion.h"

#include <algorithm>
#include <cmath>

#include "service/base/clock.h"
#include "service/base/eigen.h"

namespace omni::loop {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kFarthestSample_m = 100;

// Rotation vector of a unit quaternion, at most pi long.
Vector3d LogRotation(const Quaterniond& q) noexcept {
  const Vector3d v = q.w() < 0 ? Vector3d(-q.vec()) : Vector3d(q.vec());
  const double sine = v.norm();
  if (!(sine > 1e-12)) return 2 * v;
  return (2 * std::atan2(sine, std::abs(q.w())) / sine) * v;
}

Quaterniond ExpRotation(const Vector3d& r) noexcept {
  const double angle = r.norm();
  const double scale = angle > 1e-8 ? std::sin(angle / 2) / angle : 0.5 - angle * angle / 48;
  return Quaterniond(std::cos(angle / 2), scale * r.x(), scale * r.y(), scale * r.z()).normalized();
}

// Cubic Hermite from 0 to `way` with these derivatives (per unit of s) at the ends, and its derivative.
struct Hermite {
  Vector3d way, slope_from, slope_to;
  Vector3d At(double s) const noexcept {
    const double s2 = s * s, s3 = s2 * s;
    return (s3 - 2 * s2 + s) * slope_from + (3 * s2 - 2 * s3) * way + (s3 - s2) * slope_to;
  }
  Vector3d Slope(double s) const noexcept {
    const double s2 = s * s;
    return (3 * s2 - 4 * s + 1) * slope_from + (6 * s - 6 * s2) * way + (3 * s2 - 2 * s) * slope_to;
  }
};

Vector3d Capped(const Vector3d& v, double most) noexcept {
  const double size = v.norm();
  return size > most ? Vector3d((most / size) * v) : v;
}

double Seconds(std::int64_t ns) noexcept { return 1e-9 * static_cast<double>(ns); }

// On with constant velocity.
TrackedPose Advanced(const TrackedPose& pose, double dt_s) noexcept {
  TrackedPose on = pose;
  on.position_m = base::FromEigen(Vector3d(base::ToEigen(pose.position_m) + dt_s * base::ToEigen(pose.velocity_m_s)));
  const Vector3d turn = dt_s * base::ToEigen(pose.angular_velocity_rad_s);
  on.rotation = base::FromEigen((ExpRotation(turn) * base::ToEigen(pose.rotation)).normalized());
  return on;
}

// Between `from` and `to`, s in [0, 1]   (15.4)
TrackedPose Between(const PoseTrack& track, double s) noexcept {
  const double T = Seconds(track.end_ns - track.begin_ns);
  const TrackedPose &a = track.from, &b = track.to;
  const Hermite path{base::ToEigen(b.position_m) - base::ToEigen(a.position_m), T * base::ToEigen(a.velocity_m_s),
                     T * base::ToEigen(b.velocity_m_s)};
  const Quaterniond q_a = base::ToEigen(a.rotation), q_b = base::ToEigen(b.rotation);
  // In the frame of the body at `a`, where its rotation vector starts from zero.
  const Hermite turn{LogRotation(q_a.conjugate() * q_b),
                     T * (q_a.conjugate() * base::ToEigen(a.angular_velocity_rad_s)),
                     T * (q_a.conjugate() * base::ToEigen(b.angular_velocity_rad_s))};
  TrackedPose pose;
  pose.position_m = base::FromEigen(Vector3d(base::ToEigen(a.position_m) + path.At(s)));
  pose.velocity_m_s = base::FromEigen(Vector3d((1 / T) * path.Slope(s)));
  pose.rotation = base::FromEigen((q_a * ExpRotation(turn.At(s))).normalized());
  pose.angular_velocity_rad_s = base::FromEigen(Vector3d((1 / T) * (q_a * turn.Slope(s))));
  return pose;
}

bool IsSample(const PoseSample& sample) noexcept {
  const base::Quat& q = sample.rotation;
  const double norm2 = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
  const auto within = [](const base::Vec3& v, double limit) {
    return std::abs(v.x) <= limit && std::abs(v.y) <= limit && std::abs(v.z) <= limit;
  };
  return std::abs(norm2 - 1) < 0.02 && within(sample.position_m, kFarthestSample_m) &&
         within(sample.velocity_m_s, 1e3) && within(sample.angular_velocity_rad_s, 1e3);
}

TrackedPose PoseOf(const PoseSample& sample) noexcept {
  TrackedPose pose;
  pose.rotation = base::FromEigen(base::ToEigen(sample.rotation).normalized());
  pose.position_m = sample.position_m;
  pose.velocity_m_s = base::FromEigen(Capped(base::ToEigen(sample.velocity_m_s), kFastestTrack_m_s));
  pose.angular_velocity_rad_s =
      base::FromEigen(Capped(base::ToEigen(sample.angular_velocity_rad_s), kFastestTurn_rad_s));
  return pose;
}

}  // namespace

TrackedPose PoseAt(const PoseTrack& track, std::int64_t t_ns) noexcept {
  if (t_ns < track.end_ns && track.end_ns > track.begin_ns) {
    const double whole = static_cast<double>(base::StampDifference_ns(track.end_ns, track.begin_ns));
    return Between(track,
                   std::clamp(static_cast<double>(base::StampDifference_ns(t_ns, track.begin_ns)) / whole, 0.0, 1.0));
  }
  const std::int64_t on_ns = base::StampDifference_ns(std::min(t_ns, track.rest_ns), track.end_ns);
  TrackedPose pose = on_ns > 0 ? Advanced(track.to, Seconds(on_ns)) : track.to;
  if (t_ns >= track.rest_ns) pose.velocity_m_s = pose.angular_velocity_rad_s = {};
  return pose;
}

bool AddPoseSample(const PoseSample& sample, std::int64_t t_ns, PoseTrack& track) noexcept {
  if (sample.number == 0 || sample.number == track.number || !IsSample(sample)) return false;
  const TrackedPose now = PoseAt(track, t_ns);
  track.number = sample.number;
  track.begin_ns = t_ns;
  // A sample of the past is extrapolated to now; one far ahead counts as sooner.
  const std::int64_t ahead_ns =
      std::clamp(base::StampDifference_ns(sample.t_ns, t_ns), -kExtrapolate_ns, kLongestTrack_ns);
  std::int64_t length_ns = std::max(ahead_ns, kShortestTrack_ns);
  track.to = Advanced(PoseOf(sample), Seconds(std::min(length_ns - ahead_ns, kExtrapolate_ns)));
  const double travel_m = (base::ToEigen(track.to.position_m) - base::ToEigen(now.position_m)).norm();
  const double turn_rad =
      LogRotation(base::ToEigen(now.rotation).conjugate() * base::ToEigen(track.to.rotation)).norm();
  const bool leaps = sample.leaps || !(travel_m <= kTrackLeap_m && turn_rad <= kTrackLeap_rad);
  if (leaps) {
    track.to = Advanced(PoseOf(sample), Seconds(std::clamp(-ahead_ns, std::int64_t{0}, kExtrapolate_ns)));
    length_ns = 0;
  } else {
    const double needed_s = std::max(travel_m / kFastestTrack_m_s, turn_rad / kFastestTurn_rad_s);
    length_ns = std::max(length_ns, static_cast<std::int64_t>(1e9 * needed_s));
  }
  track.from = leaps ? track.to : now;
  track.end_ns = base::StampAfter_ns(t_ns, length_ns);
  track.rest_ns = std::max(track.end_ns, base::StampAfter_ns(t_ns, ahead_ns + kExtrapolate_ns));
  return leaps;
}

}  // namespace omni::loop
