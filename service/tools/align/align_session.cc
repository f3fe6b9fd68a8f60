#include "service/tools/align/align.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "service/alignment/rigid.h"

namespace omni::tools {
namespace {

using alignment::Rigid;
using alignment::Sample;

constexpr double kPivotWindow_s = 8;
constexpr double kPivotLeast_s = 3, kCheckLeast_s = 5;  // a check has no other marks to average with
constexpr double kPivotGood_m = 2e-3;
constexpr double kTryEvery_s = 0.5;
constexpr double kStill_s = 0.5;
constexpr double kSweepLeast_s = 8;
constexpr double kSweepGood_m = 1.2e-3;
constexpr double kSweepSpacing_s = 1.0 / 31;
constexpr double kFingerApart_m = 0.03;
constexpr double kHandStill_m = 3e-3, kFingerStill_m = 5e-3;
constexpr double kTipFloor_m = 0.8e-3;  // per axis: what a pivot does not know of its own error

alignment::DwellOptions DwellOf(AlignMethod method) {
  return {.still_s = kStill_s,
          .still_m = method == AlignMethod::kFingertip ? kFingerStill_m : kHandStill_m,
          .apart_m = kFingerApart_m};
}

}  // namespace

const char* AlignMethodName(AlignMethod method) {
  constexpr const char* kNames[] = {"touch", "sweep", "fingertip", "check"};
  return kNames[static_cast<std::size_t>(method)];
}

alignment::Prior PriorOf(AlignMethod method, bool level) {
  alignment::Prior prior;
  prior.level = level;
  if (method == AlignMethod::kSweep) {
    prior.time_offset = true;
    prior.robust = true;
  } else if (method == AlignMethod::kFingertip) {
    prior.tip_sigma_m = 8e-3;  // the joint is inside of the finger
    prior.noise_m = 4e-3;
    prior.noise_weight = 8;
  }
  return prior;
}

alignment::Limits LimitsOf(AlignMethod method) {
  alignment::Limits limits;
  if (method == AlignMethod::kSweep) {
    limits.samples_min = 60;
    limits.plane_ratio_min = 0.05;
  } else if (method == AlignMethod::kFingertip) {
    limits.samples_min = 4;
    limits.rms_max_m = 15e-3;
    limits.expected_error_max_m = 15e-3;
    limits.rotation_sigma_max_rad = 0.2;
    limits.tip_sigma_max_m = 0.02;  // the prior's: it need not be found
  }
  return limits;
}

AlignSession::AlignSession(AlignOptions options) : options_(std::move(options)), dwell_(DwellOf(options_.method)) {
  Restart();
}

void AlignSession::Restart() {
  constexpr AlignStep kFirst[] = {AlignStep::kPivot, AlignStep::kSweep, AlignStep::kFingertip, AlignStep::kPivot};
  step_ = kFirst[static_cast<std::size_t>(options_.method)];
  recent_.clear();
  samples_.clear();
  dwell_ = alignment::DwellDetector(DwellOf(options_.method));
  started_ = false;
  touched_ = 0;
  quality_ = 0;
  hint_.clear();
  problem_.clear();
}

double AlignSession::progress() const {
  if (step_ == AlignStep::kDone) return 1;
  return step_ == AlignStep::kTouch || step_ == AlignStep::kFingertip ? dwell_.progress() : quality_;
}

void AlignSession::Add(double t_s, const Rigid& controller_space, const std::optional<PenSeen>& pen) {
  if (step_ == AlignStep::kDone || step_ == AlignStep::kRefused) return;
  if (!recent_.empty() && !(t_s > recent_.back().t_s)) return;
  if (!started_) start_s_ = next_try_s_ = t_s;
  started_ = true;
  recent_.push_back({.t_s = t_s, .pose = controller_space, .pen = pen});
  while (recent_.front().t_s < t_s - kPivotWindow_s) recent_.pop_front();
  if (step_ == AlignStep::kPivot) {
    AddPivot();
  } else if (step_ == AlignStep::kTouch) {
    AddTouch();
  } else if (step_ == AlignStep::kSweep) {
    AddSweep();
  } else {
    AddFingertip();
  }
}

// The last seconds, once they are a good swing about one place.
void AlignSession::AddPivot() {
  const double now_s = recent_.back().t_s;
  if (now_s < next_try_s_ + kTryEvery_s) return;
  next_try_s_ = now_s;
  const double span_s = now_s - recent_.front().t_s;
  const double least_s = options_.method == AlignMethod::kCheck ? kCheckLeast_s : kPivotLeast_s;
  quality_ = std::min(0.9, span_s / least_s);
  if (span_s < least_s) return;
  std::vector<Rigid> poses;
  for (const Posed& posed : recent_) poses.push_back(posed.pose);
  const base::Result<alignment::Pivot> pivot = alignment::SolvePivot(poses);
  hint_ = pivot.ok() ? std::string() : pivot.error();
  if (!pivot.ok() || pivot->tip_sigma_m > kPivotGood_m) return;
  pivot_ = *pivot;
  if (options_.method == AlignMethod::kCheck) {
    step_ = AlignStep::kDone;
    return;
  }
  // Mark 1 as one touch: a pose that puts the tip where the swing found it.
  const Rigid& mean = poses.back();
  const base::Vec3 tip = alignment::TransformPoint(mean, pivot_.tip_controller_m);
  const base::Vec3& c = pivot_.centre_space_m;
  const Rigid at{.orientation = mean.orientation,
                 .position_m = {mean.position_m.x + c.x - tip.x, mean.position_m.y + c.y - tip.y,
                                mean.position_m.z + c.z - tip.z}};
  samples_.push_back(
      {.t_s = now_s, .controller_space = at, .point_base_m = options_.marks[0].position_base_m, .group = 0});
  dwell_.MarkTouched(c);
  touched_ = 1;
  step_ = AlignStep::kTouch;
}

std::vector<AlignSession::Posed> AlignSession::Dwelt() const {
  std::vector<Posed> dwelt;
  for (const Posed& posed : recent_) {
    if (posed.t_s >= recent_.back().t_s - kStill_s) dwelt.push_back(posed);
  }
  return dwelt;
}

void AlignSession::AddTouch() {
  const Posed& now = recent_.back();
  if (!dwell_.Add(now.t_s, alignment::TransformPoint(now.pose, pivot_.tip_controller_m))) return;
  std::vector<Rigid> poses;
  for (const Posed& posed : Dwelt()) poses.push_back(posed.pose);
  samples_.push_back({.t_s = now.t_s,
                      .controller_space = alignment::MeanPose(poses),
                      .point_base_m = options_.marks[static_cast<std::size_t>(touched_)].position_base_m,
                      .group = touched_});
  if (++touched_ < static_cast<int>(options_.marks.size())) return;
  alignment::Prior prior = PriorOf(options_.method, options_.level);
  prior.tip_controller_m = pivot_.tip_controller_m;
  prior.tip_sigma_m = std::hypot(pivot_.tip_sigma_m / std::sqrt(3.0), kTipFloor_m);
  Finish(alignment::FitTouches(samples_, prior, LimitsOf(options_.method)));
}

void AlignSession::AddSweep() {
  const Posed& now = recent_.back();
  if (!now.pen) {
    hint_ = "the pen is not tracked: stay within 10 cm of the base";
    return;
  }
  if (samples_.empty()) start_s_ = now.t_s;
  if (!samples_.empty() && now.t_s < samples_.back().t_s + kSweepSpacing_s) return;
  samples_.push_back({.t_s = now.t_s,
                      .controller_space = now.pose,
                      .point_base_m = now.pen->position_base_m,
                      .velocity_base_m_s = now.pen->velocity_base_m_s});
  const double span_s = now.t_s - start_s_;
  quality_ = std::min(0.99, span_s / kSweepLeast_s);
  hint_.clear();
  if (span_s < kSweepLeast_s || now.t_s < next_try_s_ + 2 * kTryEvery_s) return;
  next_try_s_ = now.t_s;
  auto outcome = alignment::FitBasePose(samples_, PriorOf(options_.method, options_.level), LimitsOf(options_.method));
  const bool last = span_s >= options_.sweep_s_max;
  if (!outcome.ok()) {
    hint_ = outcome.error();
    if (last) Finish(std::move(outcome));
  } else if (last || outcome->expected_error_m <= kSweepGood_m) {
    Finish(std::move(outcome));
  } else {
    hint_ = "keep going: more places and angles make it more precise";
  }
}

void AlignSession::AddFingertip() {
  const Posed& now = recent_.back();
  if (!now.pen) {
    hint_ = "the pen is not tracked: hold it within 10 cm of the base";
    dwell_.Reset();
    return;
  }
  hint_.clear();
  if (!dwell_.Add(now.t_s, now.pose.position_m)) return;
  std::vector<Rigid> poses;
  base::Vec3 sum;
  int seen = 0;
  for (const Posed& posed : Dwelt()) {
    if (!posed.pen) continue;
    poses.push_back(posed.pose);
    const base::Vec3& p = posed.pen->position_base_m;
    sum = {sum.x + p.x, sum.y + p.y, sum.z + p.z};
    ++seen;
  }
  samples_.push_back({.t_s = now.t_s,
                      .controller_space = alignment::MeanPose(poses),
                      .point_base_m = {sum.x / seen, sum.y / seen, sum.z / seen},
                      .group = touched_});
  if (++touched_ < options_.fingertips) return;
  Finish(alignment::FitTouches(samples_, PriorOf(options_.method, options_.level), LimitsOf(options_.method)));
}

void AlignSession::Finish(base::Result<alignment::Outcome> outcome) {
  step_ = outcome.ok() ? AlignStep::kDone : AlignStep::kRefused;
  if (outcome.ok()) {
    outcome_ = std::move(*outcome);
    hint_.clear();
  } else {
    problem_ = outcome.error();
  }
}

}  // namespace omni::tools
