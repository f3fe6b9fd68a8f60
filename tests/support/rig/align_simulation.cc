#include "tests/support/rig/align_simulation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "service/alignment/rigid.h"
#include "service/base/eigen.h"
#include "service/sim/fields/random.h"

namespace omni::test {
namespace {

using alignment::Rigid;
using base::FromEigen;
using base::ToEigen;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kLook_s = 1.0 / 90;
constexpr double kMove_s = 1.3;
constexpr double kLift_m = 0.05;
constexpr double kApart_m = 0.05;   // from one place to the next
constexpr double kPatience_s = 90;  // then the person gives up

Quaterniond Turn(const Vector3d& w) {
  const double angle = w.norm();
  return angle > 0 ? Quaterniond(Eigen::AngleAxisd(angle, w / angle)) : Quaterniond::Identity();
}

// First-order Gauss-Markov: wanders with a time constant, keeps its variance.
class Wander {
 public:
  Wander(double sigma, double time_s, sim::Random& random)
      : sigma_(sigma), keep_(std::exp(-kLook_s / time_s)), x_(ToEigen(random.NormalVector(sigma))) {}
  const Vector3d& Next(sim::Random& random) {
    x_ = keep_ * x_ + std::sqrt(1 - keep_ * keep_) * ToEigen(random.NormalVector(sigma_));
    return x_;
  }

 private:
  double sigma_, keep_;
  Vector3d x_;
};

// Random parameters drawn once.
class Person {
 public:
  Person(const tools::AlignOptions& options, const AlignNoise& noise, std::uint64_t seed)
      : options_(options),
        noise_(noise),
        random_(seed),
        drift_(noise.slow_m, noise.slow_s, random_),
        turn_(noise.slow_rad, noise.slow_s, random_),
        tremor_(noise.tremor_m, 0.1, random_) {
    const double yaw = random_.Uniform(-std::numbers::pi, std::numbers::pi);
    const Vector3d tilt(noise.tilt_rad * random_.Normal(), 0, noise.tilt_rad * random_.Normal());
    const Quaterniond q = Turn(tilt) * Turn({0, yaw, 0}) * ToEigen(alignment::LevelBase().orientation);
    truth_ = {.orientation = FromEigen(q.normalized()),
              .position_m = {random_.Uniform(-2, 2), random_.Uniform(0.6, 1.0), random_.Uniform(-2, 2)}};
    const Vector3d way = Turn(Vector3d(random_.Uniform(-1, 1), random_.Uniform(-1, 1), 0)) * Vector3d(0, 0, -1);
    tip_ = (options.method == tools::AlignMethod::kFingertip ? 0.006 : random_.Uniform(0.06, 0.14)) * way;
    for (double& phase : phases_) phase = random_.Uniform(0, 2 * std::numbers::pi);
    hold_ = Turn({random_.Uniform(-0.5, 0.5), random_.Uniform(-3, 3), random_.Uniform(-0.5, 0.5)});
    if (random_.Uniform() < noise.wrong_touch) {
      const int places = TouchesMarks() ? static_cast<int>(options.marks.size()) - 1 : options.fingertips;
      const int first = TouchesMarks() ? 1 : 0;
      wrong_touch_ = first + static_cast<int>(random_.Bits() % static_cast<std::uint64_t>(places));
      wrong_by_ = random_.Uniform(0.015, 0.06) * ToEigen(random_.NormalVector(1)).normalized();
    }
    DrawTouch();
  }

  const Rigid& truth() const { return truth_; }
  int wrong_touch() const { return wrong_touch_; }

  void Look(double t_s, tools::AlignSession& session) {
    const Vector3d p_B = options_.method == tools::AlignMethod::kSweep ? SweepAt(t_s) : TouchAt(t_s, session);
    // The pose a little earlier, because it is late.
    const double then_s = t_s - noise_.late_s;
    const Vector3d p_then_B = options_.method == tools::AlignMethod::kSweep ? SweepAt(then_s) : p_B;
    const Quaterniond q_LC = HeldAt(then_s, session);
    const Vector3d at_L = ToEigen(alignment::TransformPoint(truth_, FromEigen(p_then_B)));
    Vector3d p_LC = at_L - q_LC * tip_ + drift_.Next(random_) + ToEigen(random_.NormalVector(noise_.white_m));
    const Quaterniond q_seen = Turn(turn_.Next(random_) + ToEigen(random_.NormalVector(noise_.white_rad))) * q_LC;
    if (random_.Uniform() < noise_.jumps) {
      p_LC += random_.Uniform(0.02, 0.1) * ToEigen(random_.NormalVector(1)).normalized();
    }
    std::optional<tools::PenSeen> pen;
    if (!TouchesMarks()) {
      const Vector3d v_B = options_.method == tools::AlignMethod::kSweep ? Vector3d((SweepAt(t_s + 1e-4) - p_B) / 1e-4)
                                                                         : Vector3d::Zero();
      // A finger touches the pen with its skin, not with the middle of the joint; the pen itself does not move.
      pen = {.position_base_m = FromEigen(Vector3d((options_.method == tools::AlignMethod::kSweep ? p_B : place_) +
                                                   ToEigen(random_.NormalVector(noise_.pen_m)))),
             .velocity_base_m_s = FromEigen(v_B)};
    }
    session.Add(t_s, {.orientation = FromEigen(q_seen.normalized()), .position_m = FromEigen(p_LC)}, pen);
  }

 private:
  double Wave(int i, double t_s, double Hz) const { return std::sin(2 * std::numbers::pi * Hz * t_s + phases_[i]); }

  // About the base, up and down, 0.15 m/s or so.
  Vector3d SweepAt(double t_s) const {
    return {0.055 * Wave(0, t_s, 0.37), 0.055 * Wave(1, t_s, 0.29), 0.075 + 0.022 * Wave(2, t_s, 0.43)};
  }

  Quaterniond HeldAt(double t_s, const tools::AlignSession& session) const {
    const bool swings = session.step() == tools::AlignStep::kPivot || options_.method == tools::AlignMethod::kSweep;
    const double size = swings ? 0.5 : 0.15;
    return hold_ * Turn(size * Vector3d(Wave(3, t_s, 0.31), Wave(4, t_s, 0.23), Wave(5, t_s, 0.41)));
  }

  // Intended place of the tip, and its deviation from it.
  void DrawTouch() {
    if (TouchesMarks()) {
      place_ = ToEigen(options_.marks[static_cast<std::size_t>(touch_)].position_base_m);
    } else {
      const Vector3d last = place_;
      do {
        place_ = Vector3d(random_.Uniform(-0.06, 0.06), random_.Uniform(-0.06, 0.06), random_.Uniform(0.05, 0.11));
      } while ((place_ - last).norm() < kApart_m);
    }
    miss_ = ToEigen(random_.NormalVector(TouchesMarks() ? noise_.contact_m : noise_.finger_m));
    if (touch_ == wrong_touch_) miss_ += wrong_by_;
  }

  Vector3d TouchAt(double t_s, const tools::AlignSession& session) {
    if (session.touched() != touch_ && session.touched() < Places()) {
      from_ = place_ + miss_;
      touch_ = session.touched();
      DrawTouch();
      moved_s_ = t_s;
    }
    const Vector3d to = place_ + miss_ + tremor_.Next(random_);
    const double s = touch_ == 0 ? 1 : std::clamp((t_s - moved_s_) / kMove_s, 0.0, 1.0);
    if (s >= 1) return to;
    const double smooth = s * s * s * (10 + s * (6 * s - 15));
    return from_ + smooth * (to - from_) + Vector3d(0, 0, kLift_m * std::sin(std::numbers::pi * smooth));
  }
  bool TouchesMarks() const {
    return options_.method == tools::AlignMethod::kTouch || options_.method == tools::AlignMethod::kCheck;
  }
  int Places() const { return TouchesMarks() ? static_cast<int>(options_.marks.size()) : options_.fingertips; }

  const tools::AlignOptions options_;
  const AlignNoise noise_;
  sim::Random random_;
  Wander drift_, turn_, tremor_;
  Rigid truth_;
  Vector3d tip_, place_ = Vector3d::Zero(), miss_, from_ = Vector3d::Zero(), wrong_by_ = Vector3d::Zero();
  Quaterniond hold_;
  double phases_[6] = {};
  double moved_s_ = 0;
  int touch_ = 0, wrong_touch_ = -1;
};

}  // namespace

AlignTrial SimulateAlignment(const tools::AlignOptions& options, const AlignNoise& noise, std::uint64_t seed) {
  tools::AlignSession session(options);
  Person person(options, noise, seed);
  AlignTrial trial{.truth = person.truth(), .wrong_touch = person.wrong_touch()};
  double t_s = 0;
  for (; t_s < kPatience_s; t_s += kLook_s) {
    person.Look(t_s, session);
    if (session.step() == tools::AlignStep::kDone || session.step() == tools::AlignStep::kRefused) break;
  }
  trial.seconds = t_s;
  trial.refused = session.step() != tools::AlignStep::kDone;
  trial.problem = session.step() == tools::AlignStep::kRefused ? session.problem() : session.hint();
  if (trial.refused) return trial;
  trial.outcome = session.outcome();
  if (options.method == tools::AlignMethod::kCheck) {
    const base::Vec3 mark_m = alignment::TransformPoint(trial.truth, options.marks[0].position_base_m);
    trial.error_m = base::Distance(session.mark_space_m(), mark_m);
    return trial;
  }
  trial.error_m = alignment::Distance_m(trial.outcome.base_space, trial.truth, alignment::kWorkingPoint_base_m);
  trial.error_rad = alignment::Angle_rad(trial.outcome.base_space, trial.truth);
  return trial;
}

}  // namespace omni::test
