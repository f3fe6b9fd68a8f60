#include "service/calibration/fit/adjust.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace omni::calibration {
namespace {

constexpr double kDampingFirst = 1e-4;
constexpr double kDampingMin = 1e-9;
constexpr double kDampingMax = 1e6;
constexpr double kDone = 0.02;        // expected decrease of the cost: far below what a parameter's deviation costs
constexpr double kEnough = 1e-3;      // of the cost: enough before the weights are settled
constexpr int kRoundsMax = 4;         // of weights
constexpr double kSettled = 0.1;      // largest change of a weight that needs no further round
constexpr double kTouchGate = 9;      // chi2 of a touch that keeps its full weight
constexpr double kTouchDoubt = 1e-6;  // weight of touches at first: a rest in the air must not bend the array
// Steel seen with less does not count; nor does a weaker plane, as one at kSteelDepth_m: it moves no pose by .05 mm,
// and sensors that are not straight pass for one.
constexpr double kSteelSigmas = 3, kSteelLeast = 0.008;
constexpr double kLeapMax_m = 0.02, kLeapMax_rad = 0.5;
constexpr int kStack = 32;  // samples eliminated at a time

Eigen::LLT<OwnMatrix> Factor(const SampleBlock& block, double damping) {
  OwnMatrix H = block.H;
  H.diagonal() *= 1 + damping;
  return H.llt();
}

struct Step {
  Eigen::VectorXd array;
  std::vector<OwnVector> own;
  double expected = 0;  // decrease of the cost that the array's step promises; a wild sample may wander for long
  bool finite = false;
};

// A sample does not jump: far from its place the linear model is meaningless.
OwnVector Shortened(const OwnVector& step) {
  const double shrink = std::max({1.0, step.head<3>().norm() / kLeapMax_m, step.segment<2>(3).norm() / kLeapMax_rad});
  return step / shrink;
}

// Back-substitution: own = -H^-1 (g + C dx).
Step MakeStep(const System& system, double damping) {
  const Reduced reduced = EliminateSamples(system, damping);
  Step step;
  step.array = -reduced.H.llt().solve(reduced.g);
  step.expected = -step.array.dot(reduced.g);
  for (const SampleBlock& block : system.samples) {
    const OwnVector right = block.g + block.C * step.array;
    step.own.push_back(Shortened(-Factor(block, damping).solve(right)));
  }
  step.finite = step.array.allFinite() && std::isfinite(step.expected);
  return step;
}

double PerDof(const SampleBlock& block, const Observation& observation) {
  return block.chi2 / std::max(1, observation.readings - 5);
}

double Quantile(double share, std::vector<double> values) {
  if (values.empty()) return 0;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size()));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

// w = min(1, gate / chi2): samples far beyond the usual misfit lose weight. The usual misfit is the median, so that
// nothing is thrown away while the array is still wrong; of touches it is the lower third's: a hand that hesitates
// rests above the hull more than once. (4.3)
double Reweigh(const System& system, std::vector<Observation>& observations) {
  std::vector<double> misfit, touch_misfit;
  for (std::size_t n = 0; n < observations.size(); ++n) {
    misfit.push_back(PerDof(system.samples[n], observations[n]));
    if (observations[n].touches_hull) touch_misfit.push_back(system.samples[n].touch_chi2);
  }
  const double usual = std::max(1.0, Quantile(0.5, misfit));
  const double touch_gate = kTouchGate * std::max(1.0, Quantile(0.3, touch_misfit));
  double change = 0;
  for (std::size_t n = 0; n < observations.size(); ++n) {
    Observation& observation = observations[n];
    const double gate = usual * (1 + 4 * std::sqrt(2.0 / std::max(1, observation.readings - 5)));
    const double weight = misfit[n] > gate ? gate / misfit[n] : 1.0;
    const double touch = system.samples[n].touch_chi2;
    const double touch_weight = touch > touch_gate ? touch_gate / touch : 1.0;
    change =
        std::max({change, std::abs(weight - observation.weight), std::abs(touch_weight - observation.touch_weight)});
    observation.weight = weight;
    observation.touch_weight = touch_weight;
  }
  return change;
}

// One round with fixed weights, until a step promises less than `enough` of the cost. True: converged.
bool Minimise(const Problem& problem, double enough, int iterations_max, Adjustment& state) {
  double damping = kDampingFirst;
  while (state.iterations < iterations_max) {
    const Step step = MakeStep(state.system, damping);
    if (step.finite && step.expected < std::max(kDone, enough * state.system.cost) && damping <= 1e-3) return true;
    if (step.finite) {
      Parameters parameters = state.parameters;
      parameters.x() += step.array;
      std::vector<Instant> instants;
      instants.reserve(step.own.size());
      for (std::size_t n = 0; n < step.own.size(); ++n)
        instants.push_back(MovedInstant(state.instants[n], step.own[n]));
      System next = problem.Linearise(parameters, instants);
      ++state.iterations;
      if (next.cost <= state.system.cost) {  // false for NaN
        state.parameters = std::move(parameters);
        state.instants = std::move(instants);
        state.system = std::move(next);
        damping = std::max(kDampingMin, damping * 0.1);
        continue;
      }
    }
    damping *= 10;
    if (!(damping < kDampingMax)) return false;
  }
  return false;
}

Eigen::MatrixXd Covariance(const System& system) {
  const Eigen::Index size = system.H.rows();
  return EliminateSamples(system, 0).H.llt().solve(Eigen::MatrixXd::Identity(size, size));
}

bool SettleWeights(Problem& problem, int iterations_max, Adjustment& state) {
  state.system = problem.Linearise(state.parameters, state.instants);
  for (int round = 0; round < kRoundsMax; ++round) {
    if (!Minimise(problem, round == 0 ? kEnough : 0.0, iterations_max, state)) return false;
    if (Reweigh(state.system, problem.observations()) < kSettled && round > 0) break;
    problem.FollowCore(state.parameters, state.instants);
    state.system = problem.Linearise(state.parameters, state.instants);
    ++state.iterations;
  }
  return true;
}

// From `state`, in so many more iterations. True: converged, and steel is seen.
bool Settle(Problem& problem, SteelFit steel, int iterations_max, Adjustment& state) {
  state.parameters.SetSteelFit(steel);
  state.converged = SettleWeights(problem, state.iterations + iterations_max, state);
  state.covariance = Covariance(state.system);
  return state.converged && SeesSteel(state);
}

}  // namespace

// S = H - sum C^T H_n^-1 C, s = g - sum C^T H_n^-1 g_n, with H_n = L L^T and V = L^-1 C.
Reduced EliminateSamples(const System& system, double damping) {
  Reduced reduced{system.H, system.g};
  reduced.H.diagonal() *= 1 + damping;
  const Eigen::Index size = system.H.rows();
  Eigen::MatrixXd V(kOwn * kStack, size);
  Eigen::VectorXd v(kOwn * kStack);
  for (std::size_t first = 0; first < system.samples.size(); first += kStack) {
    const std::size_t count = std::min<std::size_t>(kStack, system.samples.size() - first);
    for (std::size_t n = 0; n < count; ++n) {
      const SampleBlock& block = system.samples[first + n];
      const Eigen::LLT<OwnMatrix> L = Factor(block, damping);
      const Eigen::Index row = kOwn * static_cast<Eigen::Index>(n);
      V.middleRows<kOwn>(row) = L.matrixL().solve(block.C);
      v.segment<kOwn>(row) = L.matrixL().solve(block.g);
    }
    const auto rows = kOwn * static_cast<Eigen::Index>(count);
    reduced.H.selfadjointView<Eigen::Lower>().rankUpdate(V.topRows(rows).transpose(), -1);
    reduced.g -= V.topRows(rows).transpose() * v.head(rows);
  }
  reduced.H.triangularView<Eigen::StrictlyUpper>() = reduced.H.transpose();
  return reduced;
}

bool SeesSteel(const Adjustment& adjustment) {
  const int at = adjustment.parameters.shared_at() + kSteelAt;
  const base::SteelPlane steel = adjustment.parameters.Steel();
  const double as_near = std::abs(steel.strength) * std::pow(kSteelDepth_m / std::abs(steel.height_base_m), 3);
  return as_near > kSteelLeast &&
         std::abs(adjustment.parameters.x()[at]) > kSteelSigmas * std::sqrt(adjustment.covariance(at, at));
}

Adjustment AdjustOnce(const Problem& problem, Parameters parameters, std::vector<Instant> instants,
                      int iterations_max) {
  Adjustment state{std::move(parameters), std::move(instants), {}, {}, 0, false};
  state.system = problem.Linearise(state.parameters, state.instants);
  state.converged = Minimise(problem, 0.0, iterations_max, state);
  return state;
}

// With the steel's depth free the search may end in a valley in which a weak plane has no depth; with it held, far from
// a plane that is near: the result that sees steel counts. If none does, all else is fitted without steel.
Adjustment Adjust(Problem& problem, Parameters parameters, std::vector<Instant> instants, int iterations_max) {
  Adjustment state{std::move(parameters), std::move(instants), {}, {}, 0, false};
  problem.FollowCore(state.parameters, state.instants);
  for (Observation& observation : problem.observations()) observation.touch_weight = kTouchDoubt;
  if (Settle(problem, SteelFit::kStrengthAndDepth, iterations_max / 2, state)) return state;
  if (!Settle(problem, SteelFit::kStrength, iterations_max, state)) {
    if (state.converged) Settle(problem, SteelFit::kNone, iterations_max, state);
    return state;
  }
  const Adjustment held = state;
  const std::vector<Observation> weights = problem.observations();
  if (Settle(problem, SteelFit::kStrengthAndDepth, iterations_max, state)) return state;
  problem.observations() = weights;
  return held;
}

}  // namespace omni::calibration
