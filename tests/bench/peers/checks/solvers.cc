// The peers solve the tracker's problem: same minimum, same whitening, and a stopping rule that costs no accuracy.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <vector>

#include "service/base/eigen.h"
#include "service/config/files/device_file.h"
#include "service/tracker/solve/solver.h"
#include "service/tracker/tracker.h"
#include "tests/bench/peers/analytic.h"
#include "tests/bench/peers/peer.h"
#include "tests/support/rig/rig.h"

namespace omni::peers {
namespace test_peers_solvers {

struct Case {
  tracker::Pose truth;
  PeerPose start;
  tracker::Measurement measurement;
  PeerScan scan;
};

struct Problem {
  base::Calibration calibration;
  tracker::Config config;
  std::vector<Case> cases;
};

Problem MakeProblem(std::uint64_t seed, int count) {
  sim::Rig rig(config::DefaultDevice(), {.seed = seed, .sizes = sim::NoImperfections()});
  sim::Random random(seed);
  Problem problem{rig.ExactCalibration(), {}, {}};
  problem.config = tracker::MakeConfig(problem.calibration);
  for (int i = 0; i < count; ++i) {
    const sim::MagnetPose pose = rig.DrawPose({}, random);
    const base::HallScan scan = rig.Scan(&pose, {3, -2, 1}, random);
    Case one;
    one.truth = {base::ToEigen(pose.centre_base_m), base::ToEigen(pose.axis_base)};
    one.measurement = tracker::MakeMeasurement(problem.config.model, problem.config.trust, scan, {}, {});
    one.scan = MakePeerScan(one.measurement);
    const Eigen::Vector3d p = one.truth.position_base_m + base::ToEigen(random.NormalVector(0.3e-3));
    const Eigen::Vector3d u = (one.truth.axis_base + base::ToEigen(random.NormalVector(0.006))).normalized();
    one.start = {base::FromEigen(p), base::FromEigen(u)};
    problem.cases.push_back(one);
  }
  return problem;
}

struct Named {
  const char* name;
  std::unique_ptr<Peer> peer;
};

std::vector<Named> AllPeers(const Problem& problem, const PeerOptions& options) {
  const tracker::Model& model = problem.config.model;
  std::vector<Named> peers;
  peers.push_back({"analytic qr", MakeCeresAnalytic(model, PeerLinearSolver::kDenseQr, options)});
  peers.push_back({"analytic cholesky", MakeCeresAnalytic(model, PeerLinearSolver::kNormalCholesky, options)});
  peers.push_back({"autodiff", MakeCeresAutodiff(problem.calibration, PeerLinearSolver::kDenseQr, options)});
  peers.push_back({"tiny", MakeCeresTiny(model, options)});
  return peers;
}

// sqrt(d^T H d / 5): how many standard deviations apart, H the information at the tracker's own minimum.
double Sigmas(const tracker::Fit& ours, const PeerPose& theirs) {
  const tracker::PosePoint point = tracker::MakePosePoint(ours.pose);
  const Eigen::Vector3d du = base::ToEigen(theirs.axis_base) - ours.pose.axis_base;
  Eigen::Matrix<double, 5, 1> d;
  d.head<3>() = base::ToEigen(theirs.position_base_m) - ours.pose.position_base_m;
  d[3] = du.dot(Eigen::Map<const Eigen::Vector3d>(point.tangent_1_base.data()));
  d[4] = du.dot(Eigen::Map<const Eigen::Vector3d>(point.tangent_2_base.data()));
  return std::sqrt(d.dot(ours.covariance.inverse() * d) / 5);
}

TEST(PeersSolvers, FindTheTrackersMinimum) {
  const Problem problem = MakeProblem(1, 40);
  for (const Named& named : AllPeers(problem, {.function_tolerance = 1e-10})) {
    for (const Case& one : problem.cases) {
      const tracker::Pose start{base::ToEigen(one.start.position_base_m), base::ToEigen(one.start.axis_base)};
      const tracker::Fit ours = tracker::SolvePose(problem.config.model, one.measurement, start, {.chord = false});
      ASSERT_TRUE(ours.converged);
      const PeerFit theirs = named.peer->Solve(one.scan, one.start);
      EXPECT_TRUE(theirs.converged) << named.name;
      EXPECT_LT(Sigmas(ours, theirs.pose), 0.02) << named.name;
      EXPECT_NEAR(theirs.chi2, ours.chi2, 1e-3 * ours.chi2) << named.name;
    }
  }
}

TEST(PeersSolvers, WhiteningMatchesTracker) {
  const Problem problem = MakeProblem(2, 20);
  for (const Case& one : problem.cases) {
    ASSERT_EQ(one.scan.nuisances, 3U);
    tracker::NormalEquations normal;
    tracker::Linearise(problem.config.model, one.measurement, tracker::MakePosePoint(one.truth), normal);
    AnalyticResidual residual;
    EvaluateAnalytic(problem.config.model, one.scan, one.truth.position_base_m, one.truth.axis_base, residual);
    EXPECT_NEAR(residual.r.squaredNorm(), normal.chi2, 1e-6 * normal.chi2);
    const Eigen::Matrix<double, 5, 5> H = residual.J.transpose() * residual.J;
    const Eigen::Map<const Eigen::Matrix<double, 5, 5>> theirs(normal.JtJ.data());
    EXPECT_LT((H - theirs).norm(), 1e-6 * theirs.norm());
  }
}

TEST(PeersSolvers, StoppingRuleChangesErrorByUnder1Percent) {
  const Problem problem = MakeProblem(3, 150);
  const std::vector<Named> exact = AllPeers(problem, {.function_tolerance = 1e-12});
  const std::vector<Named> loose = AllPeers(problem, {});
  for (std::size_t p = 0; p < exact.size(); ++p) {
    double exact_square = 0, loose_square = 0;
    for (const Case& one : problem.cases) {
      const auto error = [&](const PeerFit& fit) {
        return (base::ToEigen(fit.pose.position_base_m) - one.truth.position_base_m).squaredNorm();
      };
      exact_square += error(exact[p].peer->Solve(one.scan, one.start));
      loose_square += error(loose[p].peer->Solve(one.scan, one.start));
    }
    EXPECT_NEAR(std::sqrt(loose_square / exact_square), 1, 0.01) << exact[p].name;
  }
}

}  // namespace test_peers_solvers
}  // namespace omni::peers
