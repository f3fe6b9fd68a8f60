// omni-bench kernels: the vector kernels of tracker, actuation and twin, by instruction set and precision; inverses.
#include <Eigen/Cholesky>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "service/actuation/force_kernel.h"
#include "service/sim/fields/charge_kernel.h"
#include "service/sim/fields/random.h"
#include "service/tracker/kernel/cholesky.h"
#include "tests/bench/harness/bench.h"
#include "tests/bench/harness/idle_timing.h"
#include "tests/support/rig/kernel_scene.h"

namespace omni::bench {
namespace {

constexpr int kBatches = 200, kBatch = 400, kGroup = 16;

struct Plan {
  int batches;
  BenchRows& rows;

  template <class Work>
  void Time(const char* part, const std::string& instructions, const char* precision, Work&& work) const {
    const IdleTiming timing = TimeWhenIdle(batches, kBatch, kGroup, work);
    rows.push_back({{"part", part},
                    {"instructions", instructions},
                    {"precision", precision},
                    {"us_median", timing.us_median},
                    {"us_p99", timing.us_p99}});
  }
};

// Eight sensors, five parameters, three currents and an ambient field: the fit of a scan.
template <class Real>
void TimeTracker(const Plan& plan, const tracker::Kernel& kernel, const char* precision) {
  const support::KernelScene<Real> scene(7, 1, true);
  const tracker::KernelIn<Real>& in = tracker::KernelFor<Real>(kernel);
  const tracker::KernelTask task{tracker::kParameters, 6, true};
  tracker::JacobianBlock<Real> jacobian[1];
  tracker::KernelSums sums{};
  plan.Time("tracker: sums of a scan", kernel.name, precision, [&](std::uint64_t) {
    in.sum(scene.places.data(), scene.blocks.data(), 1, scene.tool, scene.pose, task, jacobian, sums);
  });
  plan.Time("tracker: residuals of a scan", kernel.name, precision, [&](std::uint64_t) {
    in.residual(scene.places.data(), scene.blocks.data(), 1, scene.tool, scene.pose, task, jacobian, sums);
  });
}

void TimeSearch(const Plan& plan, const tracker::Kernel& kernel) {
  constexpr int kReadings = 24;
  sim::Random random(11);
  std::vector<float> field(3 * tracker::kGridLanes * kReadings), sigma(kReadings, 2e6f), whitened(kReadings);
  for (float& x : field) x = static_cast<float>(1e-4 * random.Normal());
  for (float& x : whitened) x = static_cast<float>(1e3 * random.Normal());
  tracker::ScoreTask task;
  task.readings = kReadings;
  task.inverse_sigma = sigma.data();
  task.whitened = whitened.data();
  tracker::PlaceScores scores;
  plan.Time("tracker: eight places of the search", kernel.name, "float",
            [&](std::uint64_t) { kernel.score(field.data(), task, scores); });
}

void TimeActuation(const Plan& plan, actuation::ForceKernelLevel level, const char* name) {
  const actuation::ForceKernel kernel = actuation::ForceKernelOf(level);
  if (kernel == nullptr) return;
  actuation::ForceTables tables;
  for (int i = 0; i < actuation::kForcePoints; ++i) {
    tables.ring_1_m[i] = 2e-3 * (i % 3);
    tables.axial_m[i] = 1e-3 * (i - 4);
    tables.moment_Am2[i] = 0.6;
  }
  for (int c = 0; c < actuation::kForceCoils; ++c) {
    tables.axis_base[c][c] = 1;
    tables.zonal[c][0] = 3;
  }
  tables.core_radius_m = 0.015;
  tables.core_kappa = 0.99;
  const actuation::ForcePose pose{{0.01, 0.02, 0.055}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  actuation::ForceSums sums;
  plan.Time("actuation: force map", name, "double", [&](std::uint64_t) { kernel(tables, pose, sums); });
}

void TimeTwin(const Plan& plan, sim::ChargeSum sum, const char* name) {
  constexpr std::size_t kCharges = 256;
  sim::Random random(5);
  std::vector<double> x(kCharges), y(kCharges), z(kCharges), q(kCharges);
  for (std::size_t i = 0; i < kCharges; ++i) {
    x[i] = 5e-3 * random.Normal();
    y[i] = 5e-3 * random.Normal();
    z[i] = 0.06 + 5e-3 * random.Normal();
    q[i] = random.Normal();
  }
  const double point[3] = {0.1, 0, 0};
  double out[3];
  plan.Time("twin: 256 charges at a point", name, "double",
            [&](std::uint64_t) { sum(x.data(), y.data(), z.data(), q.data(), kCharges, point, out); });
}

// The inverse of a symmetric positive definite matrix, as the tracker needs it in the tick: its own factorisation
// beside that of Eigen, of the size known when it is compiled.
template <int kSize>
void TimeInverse(const Plan& plan) {
  using Matrix = Eigen::Matrix<double, kSize, kSize, Eigen::RowMajor>;
  sim::Random random(3);
  Matrix root;
  for (double& x : root.reshaped()) x = random.Normal();
  const Matrix given = root * root.transpose() + Matrix::Identity();
  const std::string part = "tracker: inverse of " + std::to_string(kSize) + " x " + std::to_string(kSize);
  double sum = 0;
  plan.Time(part.c_str(), "own", "double", [&](std::uint64_t n) {
    Matrix inverse = given;
    inverse(0, 0) += 1e-9 * static_cast<double>(n);
    tracker::InvertPositive<kSize>(inverse.data(), kSize);
    sum += inverse(1, 0);
  });
  plan.Time(part.c_str(), "Eigen", "double", [&](std::uint64_t n) {
    Matrix matrix = given;
    matrix(0, 0) += 1e-9 * static_cast<double>(n);
    const Matrix inverse = matrix.llt().solve(Matrix::Identity());
    sum += inverse(1, 0);
  });
  if (!std::isfinite(sum)) std::abort();  // the results are used
}

}  // namespace

base::Result<BenchRows> BenchKernels(const BenchOptions& options) {
  BenchRows rows;
  const Plan plan{options.quick ? 2 : kBatches, rows};
  const tracker::KernelList kernels = tracker::RunnableKernels();
  for (int k = 0; k < kernels.count; ++k) {
    TimeTracker<float>(plan, *kernels.kernels[k], "float");
    TimeTracker<double>(plan, *kernels.kernels[k], "double");
    TimeSearch(plan, *kernels.kernels[k]);
  }
  TimeInverse<5>(plan);
  TimeInverse<7>(plan);
  TimeInverse<24>(plan);
  TimeActuation(plan, actuation::ForceKernelLevel::kBaseline, "baseline");
  TimeActuation(plan, actuation::ForceKernelLevel::kAvx2, "avx2");
  TimeTwin(plan, sim::ChargeSumBaseline, "baseline");
  if (sim::FastestChargeSum() != sim::ChargeSumBaseline) TimeTwin(plan, sim::FastestChargeSum(), "avx2");
  return rows;
}

}  // namespace omni::bench
