// Every kernel that this processor runs gives the same bits, and single precision loses nothing that noise would show.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "service/tracker/kernel/kernel.h"
#include "tests/support/numeric.h"
#include "tests/support/rig/kernel_scene.h"
#include "tests/support/same_bits.h"

namespace omni::tracker {
namespace test_tracker_kernel {

using support::Rng;
using support::SameBits;
using support::Uniform;

template <class Real>
struct Scene : support::KernelScene<Real> {
  using support::KernelScene<Real>::KernelScene;

  KernelSums Sums(const Kernel& kernel, const KernelTask& task) const {
    KernelSums sums{};
    KernelFor<Real>(kernel).sum(this->places.data(), this->blocks.data(), static_cast<int>(this->blocks.size()),
                                this->tool, this->pose, task, nullptr, sums);
    return sums;
  }
};

template <class Real>
void ExpectEqualBits() {
  const KernelList list = RunnableKernels();
  for (const bool core : {false, true}) {
    for (const int blocks : {1, 2, 8}) {
      const Scene<Real> scene(static_cast<std::uint64_t>(blocks), blocks, core);
      for (const KernelTask task : {KernelTask{3, 0, false}, KernelTask{5, 3, false}, KernelTask{5, 6, true}}) {
        const KernelSums expected = scene.Sums(*list.kernels[0], task);
        ASSERT_TRUE(std::isfinite(expected.rtr) && expected.rtr > 0);
        for (int k = 1; k < list.count; ++k) {
          const KernelSums sums = scene.Sums(*list.kernels[k], task);
          ASSERT_TRUE(SameBits(sums, expected)) << list.kernels[k]->name << " core " << core << " blocks " << blocks;
        }
      }
    }
  }
}

TEST(TrackerKernel, AllVectorWidthsAreBitIdenticalInSinglePrecision) { ExpectEqualBits<float>(); }
TEST(TrackerKernel, AllVectorWidthsAreBitIdenticalInDoublePrecision) { ExpectEqualBits<double>(); }

TEST(TrackerKernel, SinglePrecisionAgreesWithDoublePrecision) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const Scene<double> exact(seed, 1, true);
    const Scene<float> rounded(seed, 1, true);
    const KernelTask task{5, 3, true};
    const KernelSums a = exact.Sums(ActiveKernel(), task), b = rounded.Sums(ActiveKernel(), task);
    EXPECT_NEAR(b.rtr / a.rtr, 1, 1e-4);
    EXPECT_NEAR(b.MtM / a.MtM, 1, 1e-4);
    for (int k = 0, e = 0; k < kParameters; ++k, e += k + 1) EXPECT_NEAR(b.JtJ[e] / a.JtJ[e], 1, 1e-4);
  }
}

// At the pose of the derivatives the residual kernel says what the sums said; elsewhere, J^T r with the old J.
template <class Real>
void ExpectResidualsOf(double tolerance) {
  const KernelList list = RunnableKernels();
  for (const int parameters : {3, 5}) {
    const Scene<Real> scene(7, 2, true);
    const KernelTask task{parameters, 4, true};
    KernelSums first{};
    for (int k = 0; k < list.count; ++k) {
      const KernelIn<Real>& kernel = KernelFor<Real>(*list.kernels[k]);
      JacobianBlock<Real> jacobian[2];
      KernelSums sums{}, renewed{};
      kernel.sum(scene.places.data(), scene.blocks.data(), 2, scene.tool, scene.pose, task, jacobian, sums);
      kernel.residual(scene.places.data(), scene.blocks.data(), 2, scene.tool, scene.pose, task, jacobian, renewed);
      EXPECT_NEAR(renewed.rtr / sums.rtr, 1, tolerance);
      EXPECT_NEAR(renewed.Mtr / sums.Mtr, 1, 1e3 * tolerance);
      for (int p = 0; p < parameters; ++p) EXPECT_NEAR(renewed.Jtr[p] / sums.Jtr[p], 1, 1e3 * tolerance) << p;
      for (int n = 0; n < 4; ++n) EXPECT_NEAR(renewed.Ctr[n] / sums.Ctr[n], 1, 1e3 * tolerance) << n;
      if (k == 0) first = renewed;
      EXPECT_TRUE(SameBits(renewed, first)) << list.kernels[k]->name;
    }
  }
}

TEST(TrackerKernel, ResidualKernelMatchesSumKernelInSinglePrecision) { ExpectResidualsOf<float>(1e-5); }
TEST(TrackerKernel, ResidualKernelMatchesSumKernelInDoublePrecision) { ExpectResidualsOf<double>(1e-13); }

TEST(TrackerKernel, ThreeParameterSumsMatchLeadingPartOfFive) {
  const Scene<double> scene(3, 1, true);
  const KernelSums three = scene.Sums(ActiveKernel(), {3, 3, true});
  Scene<double> still = scene;  // the axis' rates belong to the two parameters left out
  still.pose.rate_1_s[3] = still.pose.rate_1_s[4] = 0;
  const KernelSums five = still.Sums(ActiveKernel(), {5, 3, true});
  for (int e = 0; e < 6; ++e) EXPECT_EQ(three.JtJ[e], five.JtJ[e]);
  for (int k = 0; k < 3; ++k) EXPECT_DOUBLE_EQ(three.Jtr[k], five.Jtr[k]);
}

TEST(TrackerKernel, ScoresAreBitIdenticalAcrossVectorWidths) {
  Rng rng(5);
  constexpr int kCount = 24;
  std::vector<float> field(3 * kGridLanes * kCount), sigma(kCount), whitened(kCount), column(kCount);
  for (float& x : field) x = static_cast<float>(Uniform(rng, -1e-4, 1e-4));
  for (float& x : sigma) x = static_cast<float>(Uniform(rng, 1e6, 3e6));
  for (float& x : whitened) x = static_cast<float>(Uniform(rng, -1e3, 1e3));
  for (float& x : column) x = static_cast<float>(Uniform(rng, -300, 300));
  ScoreTask task;
  task.readings = kCount;
  task.nuisances = 1;
  task.inverse_sigma = sigma.data();
  task.whitened = whitened.data();
  task.nuisance[0] = column.data();
  task.nuisance_covariance[0] = 1e-7f;
  const KernelList list = RunnableKernels();
  PlaceScores expected;
  list.kernels[0]->score(field.data(), task, expected);
  for (int k = 1; k < list.count; ++k) {
    PlaceScores scores;
    list.kernels[k]->score(field.data(), task, scores);
    EXPECT_TRUE(SameBits(scores, expected)) << list.kernels[k]->name;
  }
}

}  // namespace test_tracker_kernel
}  // namespace omni::tracker
