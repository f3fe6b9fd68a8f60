#include "service/base/eigen.h"
#include "service/tracker/solve/solver.h"
#include "service/tracker/solve/static_solve.h"
#include "tests/bench/tracking/solver.h"

namespace omni::bench {
namespace {

using tracker::Precision;
using tracker::Rung;

struct RungName {
  Rung rung;
  const char* name;
};
constexpr RungName kRungs[] = {{Rung::kDipole, "dipole"}, {Rung::kDipoleCore, "dipole-core"}, {Rung::kFull, "full"}};

const char* NameOf(Precision precision) { return precision == Precision::kFloat ? "float" : "double"; }

SolverAnswer Answer(const tracker::Pose& pose) {
  return {base::FromEigen(pose.position_base_m), base::FromEigen(pose.axis_base)};
}

// steps 0: until the solver converges.
SolverMethod Warm(const char* model_name, const std::shared_ptr<const tracker::Model>& model, Precision precision,
                  int steps) {
  tracker::SolveOptions options{.precision = precision};
  if (steps > 0) {
    options.iterations_max = steps;
    options.take_every_step = true;
  }
  return {.method = "omni",
          .model = model_name,
          .start = "warm",
          .precision = NameOf(precision),
          .variant = steps == 0   ? "n steps"
                     : steps == 1 ? "1 step"
                                  : std::to_string(steps) + " steps",
          .solve = [model, options](const SolverCase& one) -> std::optional<SolverAnswer> {
            const tracker::Fit fit = SolvePose(*model, one.measurement, one.warm, options);
            return Answer(fit.pose);
          }};
}

SolverMethod ProductWarm(const std::shared_ptr<const tracker::Config>& config) {
  const tracker::SolveOptions options{.precision = config->precision, .iterations_max = config->iterations_max};
  return {.method = "omni",
          .model = "default",
          .start = "warm",
          .precision = NameOf(config->precision),
          .variant = "n steps",
          .solve = [config, options](const SolverCase& one) -> std::optional<SolverAnswer> {
            const tracker::Fit fit = SolvePose(config->model, one.product, one.warm, options);
            return Answer(fit.pose);
          }};
}

constexpr double kColdDamping = 1e-2;
constexpr int kColdIterations = 30;
constexpr double kChi2Max = 80;

// The tick's search: the grid's best places in turn until a fit passes the gate.
std::optional<SolverAnswer> SolveCold(const tracker::Model& model, const tracker::Measurement& measurement,
                                      Precision precision) {
  const tracker::SolveOptions options{
      .precision = precision, .iterations_max = kColdIterations, .damping = kColdDamping};
  const tracker::ColdCandidates candidates = RankGrid(model, measurement, tracker::kColdCandidates);
  const double gate = tracker::ChiSquareGate(kChi2Max, measurement.axes - tracker::kParameters);
  for (std::size_t c = 0; c < static_cast<std::size_t>(candidates.count); ++c) {
    const tracker::Fit fit = SolvePose(model, measurement, candidates.poses[c], options);
    if (fit.converged && fit.chi2 <= gate) return Answer(fit.pose);
  }
  return std::nullopt;
}

SolverMethod Cold(const char* model_name, const std::shared_ptr<const tracker::Model>& model, Precision precision) {
  return {.method = "omni",
          .model = model_name,
          .start = "cold",
          .precision = NameOf(precision),
          .variant = "global",
          .solve = [model, precision](const SolverCase& one) { return SolveCold(*model, one.measurement, precision); }};
}

SolverMethod ProductCold(const std::shared_ptr<const tracker::Config>& config) {
  return {
      .method = "omni",
      .model = "default",
      .start = "cold",
      .precision = NameOf(config->precision),
      .variant = "global",
      .solve = [config](const SolverCase& one) { return SolveCold(config->model, one.product, config->precision); }};
}

}  // namespace

std::vector<SolverMethod> OmniSolvers(const base::Calibration& calibration, const tracker::Config& product) {
  const auto config = std::make_shared<const tracker::Config>(product);
  const auto full = std::make_shared<const tracker::Model>(tracker::MakeModel(calibration));
  std::vector<SolverMethod> methods{ProductWarm(config), ProductCold(config)};
  for (const RungName& rung : kRungs) {
    const auto model = std::make_shared<const tracker::Model>(tracker::MakeModel(calibration, rung.rung));
    for (const Precision precision : {Precision::kFloat, Precision::kDouble}) {
      for (const int steps : {1, 2, 0}) methods.push_back(Warm(rung.name, model, precision, steps));
    }
  }
  for (const Precision precision : {Precision::kFloat, Precision::kDouble}) {
    methods.push_back(Cold("full", full, precision));
  }
  return methods;
}

}  // namespace omni::bench
