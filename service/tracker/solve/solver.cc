#include "service/tracker/solve/solver.h"

#include <algorithm>
#include <cmath>

#include "service/magnetics/disc_magnet.h"
#include "service/tracker/kernel/cholesky.h"

namespace omni::tracker {
namespace {

constexpr double kStepMax_m = 0.03;  // of one iteration
constexpr double kTurnMax_rad = 0.7;
constexpr double kDecrementDone = 0.04;  // d^T JtJ d: the last step is 20 % of a standard deviation
constexpr double kDampingFirst = 1e-4;   // after the first refused step
constexpr double kDampingNewton = 1e-3;  // below this a step counts as a Gauss-Newton step
constexpr double kDampingMax = 1e8;
constexpr double kChordMove = 0.02;  // of the distance from the base
constexpr double kChordTurn_rad = 0.02;
constexpr double kChordDone = 2.5e-3;  // d^T JtJ d of the step that is not taken: 5 % of a standard deviation
constexpr double kChordShrink = 0.1;   // of d^T JtJ d, from one step to the next

void Store(const Eigen::Vector3d& v, std::array<double, 3>& out) noexcept { out = {v.x(), v.y(), v.z()}; }

template <int kCount>
using Step = std::array<double, kCount>;

template <int kCount>
double MovedSquare_m2(const Step<kCount>& d) noexcept {
  return d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
}
template <int kCount>
double TurnedSquare_rad2(const Step<kCount>& d) noexcept {
  if constexpr (kCount == kParameters) {
    return d[3] * d[3] + d[4] * d[4];
  } else {
    return 0;
  }
}

// Keeps a step within what the linearisation can mean.
template <int kCount>
void Shorten(Step<kCount>& d) noexcept {
  const double excess = std::max(MovedSquare_m2<kCount>(d) / (kStepMax_m * kStepMax_m),
                                 TurnedSquare_rad2<kCount>(d) / (kTurnMax_rad * kTurnMax_rad));
  if (!(excess > 1)) return;
  for (double& x : d) x /= std::sqrt(excess);
}

// A step so short that the derivatives before it still hold to a few per cent.
template <int kCount>
bool IsShort(const Step<kCount>& d, const Eigen::Vector3d& position_base_m) noexcept {
  return MovedSquare_m2<kCount>(d) < kChordMove * kChordMove * position_base_m.squaredNorm() &&
         TurnedSquare_rad2<kCount>(d) < kChordTurn_rad * kChordTurn_rad;
}

// p + dp; u + a e1 + b e2, normalised: a step on the sphere without a singular direction.
template <int kCount>
Pose Retract(const Pose& pose, const PosePoint& point, const Step<kCount>& d) noexcept {
  Pose next{pose.position_base_m + Eigen::Vector3d(d[0], d[1], d[2]), pose.axis_base};
  if constexpr (kCount == kParameters) {
    const Eigen::Map<const Eigen::Vector3d> e1(point.tangent_1_base.data());
    const Eigen::Map<const Eigen::Vector3d> e2(point.tangent_2_base.data());
    next.axis_base = (pose.axis_base + d[3] * e1 + d[4] * e2).normalized();
  }
  return next;
}

template <int kCount>
double Quadratic(const NormalEquations& equations, const Step<kCount>& d) noexcept {
  double sum = 0;
  for (std::size_t i = 0; i < kCount; ++i) {
    double row = 0;
    for (std::size_t j = 0; j < kCount; ++j) row += equations.JtJ[kParameters * i + j] * d[j];
    sum += d[i] * row;
  }
  return sum;
}

// One scan's problem with a place to evaluate it.
template <class Real, int kCapacity, int kCount>
class Search {
 public:
  Search(const Model& model, const BasicMeasurement<kCapacity>& measurement, const SolveOptions& options) noexcept
      : measurement_(measurement),
        options_(options),
        kernel_(options.kernel != nullptr ? *options.kernel : ActiveKernel()),
        unknowns_{kCount, measurement.nuisances, false},
        task_(options.sums == nullptr ? unknowns_ : KernelTask{kCount, measurement.columns, true}) {
    PackProblem(model, measurement, problem_);
    keeps_jacobian_ = options.chord && !options.take_every_step && options.damping == 0;
  }

  Fit Run(const Pose& start) noexcept {
    Fit fit;
    fit.pose = start;
    PosePoint point = MakePosePoint(start);
    NormalEquations current = Evaluate(point);
    fit.iterations = 1;
    fit.chi2 = current.chi2;
    double lambda = options_.damping;
    while (std::isfinite(current.chi2)) {
      SmallCholesky<kCount> factors;
      if (!factors.Factor(current.JtJ.data(), kParameters, lambda)) break;
      Step<kCount> g{};
      for (std::size_t i = 0; i < kCount; ++i) g[i] = -current.Jtr[i];
      Step<kCount> d = factors.Solve(g);
      Shorten<kCount>(d);
      const double decrement = Quadratic<kCount>(current, d);
      if (!(decrement <= 1e300)) break;
      const Pose candidate = Retract<kCount>(fit.pose, point, d);
      const bool last = fit.iterations >= options_.iterations_max;
      const bool small = decrement < kDecrementDone && lambda <= kDampingNewton;
      if (options_.take_every_step ? last : small) {
        Finish(current, d, decrement, lambda, candidate, factors, fit);
        break;
      }
      if (last) break;
      const PosePoint next_point = MakePosePoint(candidate);
      if (keeps_jacobian_ && lambda == 0 && IsShort<kCount>(d, fit.pose.position_base_m)) {
        ++fit.iterations;
        if (FinishByChord(candidate, next_point, current.chi2, decrement, factors, fit)) break;
      }
      const NormalEquations next = Evaluate(next_point);
      ++fit.iterations;
      if (next.chi2 <= current.chi2 || options_.take_every_step) {  // false for NaN
        current = next;
        point = next_point;
        fit.pose = candidate;
        fit.chi2 = next.chi2;
        lambda = lambda > 1e-9 ? lambda * 0.1 : 0;
      } else {
        lambda = std::max(kDampingFirst, lambda * 10);
        if (!(lambda < kDampingMax)) break;
      }
    }
    return fit;
  }

 private:
  KernelPose At(const PosePoint& point) const noexcept {
    return ToKernel(point, measurement_.velocity_base_m_s, measurement_.axis_rate_base_1_s);
  }

  NormalEquations Evaluate(const PosePoint& point) noexcept {
    KernelFor<Real>(kernel_).sum(problem_.places, problem_.blocks, problem_.block_count, problem_.tool, At(point),
                                 task_, keeps_jacobian_ ? jacobian_ : nullptr, sums_);
    NormalEquations equations;
    EliminateNuisances(unknowns_, sums_, measurement_.nuisance_covariance, equations);
    return equations;
  }

  // Newton's step with the derivatives and factors of the pose before: only the residuals are evaluated. Steps of this
  // kind shrink by a constant ratio, so the next one would be d'^2/d: ends the search if that is small; otherwise
  // nothing has happened. docs/theory/tracking.md, Solver
  bool FinishByChord(const Pose& pose, const PosePoint& point, double chi2_before, double decrement_before,
                     SmallCholesky<kCount>& factors, Fit& fit) noexcept {
    KernelFor<Real>(kernel_).residual(problem_.places, problem_.blocks, problem_.block_count, problem_.tool, At(point),
                                      task_, jacobian_, sums_);
    NormalEquations equations;
    EliminateNuisances(unknowns_, sums_, measurement_.nuisance_covariance, equations);
    if (!(equations.chi2 <= chi2_before)) return false;
    Step<kCount> g{};
    for (std::size_t i = 0; i < kCount; ++i) g[i] = -equations.Jtr[i];
    const Step<kCount> d = factors.Solve(g);
    const double decrement = Quadratic<kCount>(equations, d);
    if (!(decrement * decrement < kChordDone * decrement_before && decrement < kChordShrink * decrement_before)) {
      return false;
    }
    Finish(equations, d, decrement, 0, Retract<kCount>(pose, point, d), factors, fit);
    return true;
  }

  // The quadratic model is exact at this size: takes the step without another evaluation.
  void Finish(const NormalEquations& at, const Step<kCount>& d, double decrement, double lambda, const Pose& candidate,
              SmallCholesky<kCount>& factors, Fit& fit) noexcept {
    double gd = 0;
    for (std::size_t i = 0; i < kCount; ++i) gd += at.Jtr[i] * d[i];
    fit.pose = candidate;
    fit.chi2 = std::max(0.0, at.chi2 + 2 * gd + decrement);
    fit.has_sums = options_.sums != nullptr && lambda == 0;  // else the last evaluation may be of a refused step
    if (fit.has_sums) *options_.sums = sums_;
    if (lambda > 0 && !factors.Factor(at.JtJ.data(), kParameters, 0)) return;
    fit.converged = true;
    double inverse[kCount * kCount];
    factors.Invert(inverse, kCount);
    for (int row = 0; row < kCount; ++row) {
      for (int column = 0; column < kCount; ++column) fit.covariance(row, column) = inverse[kCount * row + column];
      const double variance = inverse[(kCount + 1) * row];
      fit.converged = fit.converged && variance > 0 && variance < 1e300;
    }
  }

  const BasicMeasurement<kCapacity>& measurement_;
  const SolveOptions& options_;
  const Kernel& kernel_;
  KernelTask unknowns_, task_;  // what the search solves for; what it sums
  Problem<Real, kCapacity> problem_;
  KernelSums sums_;
  bool keeps_jacobian_ = false;
  JacobianBlock<Real> jacobian_[kCapacity / kBlockSensors];
};

template <class Real, int kCapacity>
Fit SolveIn(const Model& model, const BasicMeasurement<kCapacity>& measurement, const Pose& start,
            const SolveOptions& options) noexcept {
  if (options.parameters == 3) return Search<Real, kCapacity, 3>(model, measurement, options).Run(start);
  return Search<Real, kCapacity, kParameters>(model, measurement, options).Run(start);
}

}  // namespace

PosePoint MakePosePoint(const Pose& pose) noexcept {
  const magnetics::TangentBasis basis = magnetics::MakeTangentBasis(pose.axis_base);
  PosePoint point;
  Store(pose.position_base_m, point.position_base_m);
  Store(pose.axis_base, point.axis_base);
  Store(basis.e1, point.tangent_1_base);
  Store(basis.e2, point.tangent_2_base);
  return point;
}

template <int kCapacity>
Fit SolvePose(const Model& model, const BasicMeasurement<kCapacity>& measurement, const Pose& start,
              const SolveOptions& options) noexcept {
  return options.precision == Precision::kFloat ? SolveIn<float>(model, measurement, start, options)
                                                : SolveIn<double>(model, measurement, start, options);
}
template Fit SolvePose(const Model&, const Measurement&, const Pose&, const SolveOptions&) noexcept;
template Fit SolvePose(const Model&, const ArrayMeasurement&, const Pose&, const SolveOptions&) noexcept;

}  // namespace omni::tracker
