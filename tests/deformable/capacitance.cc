// Contact through the capacitance matrix against a plain solver, and its factor against a fresh one.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "service/haptics/deformable/capacitance.h"

namespace omni::haptics {
namespace test_deformable_capacitance {

using Rng = std::mt19937_64;

std::size_t N(int i) { return static_cast<std::size_t>(i); }

// Random, symmetric, positive definite, with a condition number up to about 1e4.
ContactMatrix RandomCompliance(Rng& rng) {
  std::normal_distribution<double> normal;
  ContactMatrix root{};
  for (auto& row : root) {
    for (double& x : row) x = normal(rng);
  }
  ContactMatrix a{};
  for (std::size_t i = 0; i < root.size(); ++i) {
    for (std::size_t j = 0; j < root.size(); ++j) {
      for (std::size_t k = 0; k < root.size(); ++k) a[i][j] += root[i][k] * root[j][k];
    }
    a[i][i] += 0.05;
  }
  return a;
}

ContactVector GaussSeidel(const ContactMatrix& a, int count, const ContactVector& d) {
  ContactVector f{};
  for (int sweep = 0; sweep < 200'000; ++sweep) {
    double change = 0;
    for (int i = 0; i < count; ++i) {
      double rest = d[N(i)];
      for (int j = 0; j < count; ++j) rest -= j == i ? 0 : a[N(i)][N(j)] * f[N(j)];
      const double next = std::max(0.0, rest / a[N(i)][N(i)]);
      change = std::max(change, std::abs(next - f[N(i)]));
      f[N(i)] = next;
    }
    if (change < 1e-14) break;
  }
  return f;
}

TEST(SoftCapacitance, SolvesTheComplementarityProblem) {
  Rng rng(21);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 300; ++trial) {
    const ContactMatrix a = RandomCompliance(rng);
    const int count = 1 + static_cast<int>(rng() % 16);
    ActiveFactor factor;
    ContactVector f{};
    ContactVector d{};
    for (int step = 0; step < 4; ++step) {  // warm starts, also from a wrong set
      for (int i = 0; i < count; ++i) d[N(i)] = step < 2 ? normal(rng) : d[N(i)] + 0.1 * normal(rng);
      ASSERT_TRUE(SolveContact(a, count, d, factor, f));
      double scale = 1e-300;
      for (const double x : f) scale = std::max(scale, x);
      for (int i = 0; i < count; ++i) {
        double gap = -d[N(i)];
        for (int j = 0; j < count; ++j) gap += a[N(i)][N(j)] * f[N(j)];
        EXPECT_GE(f[N(i)], 0);
        EXPECT_GE(gap, -1e-8 * (1 + scale));
        EXPECT_NEAR(f[N(i)] * gap, 0, 1e-8 * (1 + scale * scale));
      }
    }
    if (trial % 10 == 0) {
      const ContactVector plain = GaussSeidel(a, count, d);
      const double largest = *std::max_element(plain.begin(), plain.end());
      for (int i = 0; i < count; ++i) EXPECT_NEAR(f[N(i)], plain[N(i)], 1e-6 * (1e-3 + largest));
    }
  }
}

TEST(SoftCapacitance, UpdatedFactorMatchesAFreshOne) {
  Rng rng(22);
  const ContactMatrix a = RandomCompliance(rng);
  ActiveFactor factor;
  for (int change = 0; change < 100'000; ++change) {
    const bool add = factor.count == 0 || (factor.count < kMaxSoftContacts && rng() % 2 == 0);
    if (add) {
      int node = static_cast<int>(rng() % kMaxSoftContacts);
      while (std::find(factor.node.begin(), factor.node.begin() + factor.count, node) !=
             factor.node.begin() + factor.count) {
        node = (node + 1) % kMaxSoftContacts;
      }
      ASSERT_TRUE(AddNode(a, node, factor));
    } else {
      RemoveNode(static_cast<int>(rng() % N(factor.count)), factor);
    }
    if (change % 1000 != 999) continue;
    ActiveFactor fresh;
    for (int k = 0; k < factor.count; ++k) ASSERT_TRUE(AddNode(a, factor.node[N(k)], fresh));
    for (int i = 0; i < factor.count; ++i) {
      for (int j = 0; j <= i; ++j) {
        EXPECT_NEAR(factor.lower[N(i)][N(j)], fresh.lower[N(i)][N(j)], 1e-8 * std::sqrt(a[N(i)][N(i)] + 1));
      }
    }
  }
}

TEST(SoftCapacitance, InverseDiagonalMatchesSolves) {
  Rng rng(23);
  const ContactMatrix a = RandomCompliance(rng);
  ActiveFactor factor;
  for (const int node : {3, 9, 1, 14, 6}) ASSERT_TRUE(AddNode(a, node, factor));
  ContactVector diagonal{};
  InverseDiagonal(factor, diagonal);
  for (const int node : {3, 9, 1, 14, 6}) {
    ContactVector unit{};
    ContactVector x{};
    unit[N(node)] = 1;
    SolveActive(factor, unit, x);
    EXPECT_NEAR(diagonal[N(node)], x[N(node)], 1e-12 * x[N(node)]);
  }
}

TEST(SoftCapacitance, SolvesASingularMatrix) {
  ContactMatrix a{};
  for (auto& row : a) row.fill(1);  // rank one
  ContactVector d{};
  d.fill(1);
  ActiveFactor factor;
  ContactVector f{};
  EXPECT_TRUE(SolveContact(a, 16, d, factor, f));
  double sum = 0;
  for (const double x : f) {
    EXPECT_GE(x, 0);
    sum += x;
  }
  EXPECT_NEAR(sum, 1, 1e-9);
}

}  // namespace test_deformable_capacitance
}  // namespace omni::haptics
