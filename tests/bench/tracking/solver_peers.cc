#include "service/base/eigen.h"
#include "tests/bench/tracking/solver.h"

namespace omni::bench {
namespace {

// Start of a peer without a hint: above the pole, pointing inwards.
constexpr peers::PeerPose kColdStart{{0, 0, 0.065}, {0, 0, -1}};

SolverMethod Wrap(const char* method, const char* start, const char* variant,
                  const std::shared_ptr<peers::Peer>& peer) {
  const bool warm = start == std::string_view("warm");
  return {.method = method,
          .model = "full",
          .start = start,
          .precision = "double",
          .variant = variant,
          .solve = [peer, warm](const SolverCase& one) -> std::optional<SolverAnswer> {
            const peers::PeerPose near{base::FromEigen(one.warm.position_base_m), base::FromEigen(one.warm.axis_base)};
            const peers::PeerFit fit = peer->Solve(one.peer, warm ? near : kColdStart);
            return SolverAnswer{fit.pose.position_base_m, fit.pose.axis_base};
          }};
}

}  // namespace

std::vector<SolverMethod> PeerSolvers(const base::Calibration& calibration) {
  using peers::PeerLinearSolver;
  const peers::PeerOptions options;
  const tracker::Model model = tracker::MakeModel(calibration);
  const std::shared_ptr<peers::Peer> analytic_qr = MakeCeresAnalytic(model, PeerLinearSolver::kDenseQr, options);
  const std::shared_ptr<peers::Peer> analytic_cholesky =
      MakeCeresAnalytic(model, PeerLinearSolver::kNormalCholesky, options);
  const std::shared_ptr<peers::Peer> autodiff_qr = MakeCeresAutodiff(calibration, PeerLinearSolver::kDenseQr, options);
  const std::shared_ptr<peers::Peer> autodiff_cholesky =
      MakeCeresAutodiff(calibration, PeerLinearSolver::kNormalCholesky, options);
  const std::shared_ptr<peers::Peer> tiny = MakeCeresTiny(model, options);
  std::vector<SolverMethod> methods;
  for (const char* start : {"warm", "cold"}) {
    methods.push_back(Wrap("ceres-analytic", start, "normal cholesky", analytic_cholesky));
    methods.push_back(Wrap("ceres-analytic", start, "dense qr", analytic_qr));
    methods.push_back(Wrap("ceres-autodiff", start, "normal cholesky", autodiff_cholesky));
    methods.push_back(Wrap("ceres-autodiff", start, "dense qr", autodiff_qr));
    methods.push_back(Wrap("ceres-tiny", start, "normal cholesky", tiny));
  }
  return methods;
}

}  // namespace omni::bench
