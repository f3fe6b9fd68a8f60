// The factorisation: L D L^T is the matrix, whatever its pattern; it stops on request; matrices that are not positive
// definite are rejected.
#include <gtest/gtest.h>

#include <cmath>

#include "service/haptics/deformable/build/ldlt.h"
#include "tests/haptics/scenario.h"

namespace omni::haptics {
namespace test_deformable_ldlt {

struct Dense {
  std::size_t n = 0;
  std::vector<double> a;
  double& At(std::size_t i, std::size_t j) { return a[i * n + j]; }
};

// Symmetric, diagonally dominant, with about `share` of the entries.
Dense RandomMatrix(std::size_t n, double share, Random& random) {
  Dense m{n, std::vector<double>(n * n, 0)};
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (random.Uniform(0, 1) < share) m.At(i, j) = m.At(j, i) = random.Uniform(-1, 1);
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    double sum = random.Uniform(0.01, 1);
    for (std::size_t j = 0; j < n; ++j) sum += j == i ? 0 : std::abs(m.At(i, j));
    m.At(i, i) = sum;
  }
  return m;
}

struct Columns {
  std::vector<int> first{0}, row;
  std::vector<double> value;
  explicit Columns(Dense& m) {
    for (std::size_t j = 0; j < m.n; ++j) {
      for (std::size_t i = 0; i <= j; ++i) {
        if (m.At(i, j) == 0) continue;
        row.push_back(static_cast<int>(i));
        value.push_back(m.At(i, j));
      }
      first.push_back(static_cast<int>(row.size()));
    }
  }
  UpperColumns view() const { return {first, row, value}; }
};

TEST(LdltTest, ProductReproducesTheMatrix) {
  Random random(5);
  for (int round = 0; round < 60; ++round) {
    const auto n = static_cast<std::size_t>(random.Uniform(1, 60));
    Dense m = RandomMatrix(n, random.Uniform(0, 0.5), random);
    const Columns columns(m);
    LdltFactor f;
    ASSERT_EQ(FactoriseLdlt(columns.view(), {}, f), LdltOutcome::kDone);
    Dense l{n, std::vector<double>(n * n, 0)};
    for (std::size_t j = 0; j < n; ++j) {
      l.At(j, j) = 1;
      for (std::size_t p = f.first[j]; p < f.first[j + 1]; ++p) {
        EXPECT_GT(f.row[p], j);
        if (p > f.first[j]) {
          EXPECT_GT(f.row[p], f.row[p - 1]);
        }
        l.At(f.row[p], j) = f.value[p];
      }
    }
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j <= i; ++j) {
        double sum = 0;
        for (std::size_t k = 0; k < n; ++k) sum += l.At(i, k) * f.diagonal[k] * l.At(j, k);
        EXPECT_NEAR(sum, m.At(i, j), 1e-12 * m.At(i, i) + 1e-12 * m.At(j, j));
      }
    }
  }
}

TEST(LdltTest, RejectsIndefiniteAndNonFiniteMatrices) {
  Random random(6);
  Dense m = RandomMatrix(20, 0.3, random);
  m.At(13, 13) = -1;
  LdltFactor f;
  EXPECT_EQ(FactoriseLdlt(Columns(m).view(), {}, f), LdltOutcome::kNotPositive);
  m.At(13, 13) = std::nan("");
  EXPECT_EQ(FactoriseLdlt(Columns(m).view(), {}, f), LdltOutcome::kNotPositive);
}

TEST(LdltTest, ReportsProgressAndStopsWhenCancelled) {
  Random random(7);
  Dense m = RandomMatrix(500, 0.9, random);  // 40 million multiplications
  const Columns columns(m);
  LdltFactor f;
  std::vector<double> reported;
  EXPECT_EQ(FactoriseLdlt(
                columns.view(),
                [&](double done) {
                  reported.push_back(done);
                  return true;
                },
                f),
            LdltOutcome::kDone);
  EXPECT_GT(reported.size(), 4U);
  for (std::size_t k = 0; k < reported.size(); ++k)
    EXPECT_TRUE(reported[k] > (k == 0 ? 0 : reported[k - 1]) && reported[k] <= 1);
  int asked = 0;
  EXPECT_EQ(FactoriseLdlt(
                columns.view(), [&](double) { return ++asked < 2; }, f),
            LdltOutcome::kStopped);
  EXPECT_EQ(asked, 2);
}

}  // namespace test_deformable_ldlt
}  // namespace omni::haptics
