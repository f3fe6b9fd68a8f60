#include "service/alignment/fit.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>

#include "service/alignment/problem.h"
#include "service/base/eigen.h"

namespace omni::alignment {
namespace {

using base::ToEigen;
using Eigen::Vector3d;

constexpr double kDegree_rad = 0.017453292519943295;
constexpr double kWrongBy_m = 6e-3;  // a touch that the others contradict by less is not called wrong
constexpr double kWrongBySigmas = 4;
constexpr double kRunnerUpRatio = 2;  // leaving out any other one must be so much worse
constexpr int kGroupsToNameOne = 4;

std::string Millimetres(double metres) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f mm", metres * 1e3);
  return text;
}

std::string Degrees(double radians) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f deg", radians / kDegree_rad);
  return text;
}

std::set<int> Groups(const std::vector<Sample>& samples) {
  std::set<int> groups;
  for (const Sample& sample : samples) groups.insert(sample.group);
  return groups;
}

std::vector<Sample> Without(const std::vector<Sample>& samples, int group) {
  std::vector<Sample> rest;
  std::copy_if(samples.begin(), samples.end(), std::back_inserter(rest),
               [group](const Sample& sample) { return sample.group != group; });
  return rest;
}

// 1 sigma of where X_LB takes the working point: d = w x (R p) + dp.
double ExpectedError(const Problem& problem, const Normal& covariance) {
  const Vector3d arm = problem.unknowns().R_LB * ToEigen(kWorkingPoint_base_m);
  Eigen::Matrix<double, 3, 6> G;
  G.leftCols<3>() << 0, arm.z(), -arm.y(), -arm.z(), 0, arm.x(), arm.y(), -arm.x(), 0;
  G.rightCols<3>().setIdentity();
  return std::sqrt(std::max(0.0, (G * covariance.topLeftCorner<6, 6>() * G.transpose()).trace()));
}

Outcome ToOutcome(const std::vector<Sample>& samples, const Problem& problem) {
  const Unknowns& x = problem.unknowns();
  const Normal covariance = problem.Covariance();
  Outcome outcome;
  outcome.base_space = {.orientation = base::FromEigen(Eigen::Quaterniond(x.R_LB).normalized()),
                        .position_m = base::FromEigen(x.p_LB)};
  outcome.tip_controller_m = base::FromEigen(x.l);
  outcome.time_offset_s = x.tau_s;
  outcome.correlation = problem.correlation();
  outcome.samples = static_cast<int>(samples.size());
  outcome.groups = static_cast<int>(Groups(samples).size());
  double sum = 0, weight = 0;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const double r_m = problem.residuals()[k].norm();
    outcome.residual_m.push_back(r_m);
    sum += problem.weights()[k] * r_m * r_m;
    weight += problem.weights()[k];
  }
  outcome.rms_m = std::sqrt(sum / weight);
  outcome.expected_error_m = ExpectedError(problem, covariance);
  outcome.rotation_sigma_rad = std::sqrt(std::max(0.0, covariance.topLeftCorner<3, 3>().trace()));
  outcome.tip_sigma_m = std::sqrt(std::max(0.0, covariance.block<3, 3>(6, 6).trace()));
  for (std::size_t k = 0; k < 36; ++k) {
    outcome.covariance[k] = covariance(static_cast<Eigen::Index>(k / 6), static_cast<Eigen::Index>(k % 6));
  }
  return outcome;
}

base::Status Judge(const Outcome& outcome, const Limits& limits) {
  if (!(outcome.rms_m <= limits.rms_max_m)) {
    return base::Error{"the places differ from the base by " + Millimetres(outcome.rms_m) + " rms, the limit is " +
                       Millimetres(limits.rms_max_m) +
                       "; check their order, keep the controller in the cameras' view and measure again"};
  }
  if (!(outcome.tip_sigma_m <= limits.tip_sigma_max_m)) {
    return base::Error{"the controller was turned too little to find its tip (known to " +
                       Millimetres(outcome.tip_sigma_m) + "); turn it about two axes by 30 degrees or more"};
  }
  if (!(outcome.expected_error_m <= limits.expected_error_max_m)) {
    return base::Error{"the expected error is " + Millimetres(outcome.expected_error_m) + ", the limit is " +
                       Millimetres(limits.expected_error_max_m) + "; take more places, further apart"};
  }
  if (!(outcome.rotation_sigma_rad <= limits.rotation_sigma_max_rad)) {
    return base::Error{"the base's direction is known to " + Degrees(outcome.rotation_sigma_rad) + ", the limit is " +
                       Degrees(limits.rotation_sigma_max_rad) + "; take places further apart"};
  }
  return base::Ok{};
}

bool Finite(const Sample& sample) {
  const auto& q = sample.controller_space.orientation;
  const auto& p = sample.controller_space.position_m;
  const auto& b = sample.point_base_m;
  const auto& v = sample.velocity_base_m_s;
  for (const double x : {sample.t_s, q.w, q.x, q.y, q.z, p.x, p.y, p.z, b.x, b.y, b.z, v.x, v.y, v.z}) {
    if (!(std::abs(x) <= 1e6)) return false;
  }
  return std::abs(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z - 1) < 1e-2;
}

struct Solved {
  Outcome outcome;
  base::Status judged = base::Ok{};
};

base::Result<Solved> SolveAll(const std::vector<Sample>& samples, const Prior& prior, const Limits& limits) {
  Problem problem(samples, prior);
  if (!problem.Solve()) return base::Error{"the places fit no position of the base; measure again"};
  Solved solved{.outcome = ToOutcome(samples, problem)};
  solved.judged = Judge(solved.outcome, limits);
  return solved;
}

// How far a touch is from where the base pose of the others puts it, and how far that may be.
struct Contradiction {
  double by_m = 0;
  double sigma_m = 0;
};
Contradiction Contradicts(const std::vector<Sample>& samples, int group, const Outcome& others, double noise_m) {
  const Eigen::Matrix3d R_LB = ToEigen(others.base_space.orientation).toRotationMatrix();
  Vector3d gap = Vector3d::Zero(), arm = Vector3d::Zero();
  int count = 0;
  for (const Sample& sample : samples) {
    if (sample.group != group) continue;
    const Eigen::Matrix3d R_LC = ToEigen(sample.controller_space.orientation).toRotationMatrix();
    arm += R_LB * ToEigen(sample.point_base_m);
    gap += R_LC * ToEigen(others.tip_controller_m) + ToEigen(sample.controller_space.position_m) -
           R_LB * ToEigen(sample.point_base_m) - ToEigen(others.base_space.position_m);
    ++count;
  }
  gap /= count;
  arm /= count;
  const double turned_m = others.rotation_sigma_rad * arm.norm();
  return {.by_m = gap.norm(), .sigma_m = std::hypot(std::sqrt(3.0) * noise_m, others.expected_error_m, turned_m)};
}

}  // namespace

base::Status CheckGeometry(const std::vector<Sample>& samples, const Limits& limits, const std::string& what) {
  if (!(static_cast<int>(samples.size()) >= limits.samples_min)) {
    return base::Error{std::to_string(samples.size()) + " " + what + ", at least " +
                       std::to_string(limits.samples_min) + " are needed; continue"};
  }
  Vector3d mean = Vector3d::Zero();
  for (std::size_t k = 0; k < samples.size(); ++k) {
    if (!Finite(samples[k])) return base::Error{"sample " + std::to_string(k) + " is not a valid pose; measure again"};
    mean += ToEigen(samples[k].point_base_m);
  }
  const auto count = static_cast<double>(samples.size());
  mean /= count;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Sample& sample : samples) {
    const Vector3d d = ToEigen(sample.point_base_m) - mean;
    scatter += d * d.transpose();
  }
  // Least first; rounding may take the least below zero.
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> spread(scatter / count, Eigen::EigenvaluesOnly);
  const Vector3d sigma = spread.eigenvalues().reverse().cwiseMax(0).cwiseSqrt();
  if (!(2 * sigma(0) >= limits.extent_min_m)) {
    return base::Error{"the " + what + " are within " + Millimetres(2 * sigma(0)) + " of each other, at least " +
                       Millimetres(limits.extent_min_m) + " is needed; take them further apart"};
  }
  if (!(sigma(1) >= limits.line_ratio_min * sigma(0))) {
    return base::Error{"the " + what + " lie on a line; take one beside it"};
  }
  if (!(sigma(2) >= limits.plane_ratio_min * sigma(0))) {
    return base::Error{"the " + what + " lie in a plane; move up and down as well"};
  }
  return base::Ok{};
}

base::Result<Outcome> FitBasePose(const std::vector<Sample>& samples, const Prior& prior, const Limits& limits) {
  if (auto checked = CheckGeometry(samples, limits, "places"); !checked.ok()) return base::Error{checked.error()};
  base::Result<Solved> solved = SolveAll(samples, prior, limits);
  if (!solved.ok()) return base::Error{solved.error()};
  if (!solved->judged.ok()) return base::Error{solved->judged.error()};
  return std::move(solved->outcome);
}

base::Result<Outcome> FitTouches(const std::vector<Sample>& samples, const Prior& prior, const Limits& limits) {
  if (auto checked = CheckGeometry(samples, limits, "marks"); !checked.ok()) return base::Error{checked.error()};
  base::Result<Solved> all = SolveAll(samples, prior, limits);
  if (!all.ok()) return base::Error{all.error()};
  const std::set<int> groups = Groups(samples);
  if (static_cast<int>(groups.size()) >= kGroupsToNameOne) {
    int wrong = -1;
    double best_m = all->outcome.rms_m, second_m = all->outcome.rms_m;
    for (const int group : groups) {
      const base::Result<Solved> rest = SolveAll(Without(samples, group), prior, limits);
      if (!rest.ok()) continue;
      const double rms_m = rest->outcome.rms_m;
      if (rms_m < best_m) {
        second_m = best_m;
        best_m = rms_m;
        wrong = group;
      } else if (rms_m < second_m) {
        second_m = rms_m;
      }
    }
    if (wrong >= 0) {
      const std::vector<Sample> kept = Without(samples, wrong);
      base::Result<Solved> rest = SolveAll(kept, prior, limits);
      const Contradiction contradiction = Contradicts(samples, wrong, rest->outcome, prior.noise_m);
      const double allowed_m = std::max(kWrongBy_m, kWrongBySigmas * contradiction.sigma_m);
      if (rest->judged.ok() && contradiction.by_m > allowed_m && second_m > kRunnerUpRatio * best_m &&
          CheckGeometry(kept, limits, "marks").ok()) {
        rest->outcome.wrong_group = wrong;
        rest->outcome.wrong_by_m = contradiction.by_m;
        return std::move(rest->outcome);
      }
    }
  }
  if (!all->judged.ok()) return base::Error{all->judged.error()};
  return std::move(all->outcome);
}

}  // namespace omni::alignment
