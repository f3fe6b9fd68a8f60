// The finite elements and the material under them.
#include <cmath>
#include <random>

#include "service/haptics/deformable/build/fem.h"
#include "tests/deformable/scenario.h"

namespace omni::haptics {
namespace test_deformable_elements {

std::array<Vec3, 4> RandomTet(std::mt19937_64& rng) {
  std::uniform_real_distribution<double> side(-0.01, 0.01);
  for (;;) {
    std::array<Vec3, 4> x;
    for (Vec3& v : x) v = {side(rng), side(rng), side(rng)};
    if (TetVolume(x[0], x[1], x[2], x[3]) > 2e-8) return x;
  }
}

std::array<Vec3, 10> NodesOf(const std::array<Vec3, 4>& x) {
  return {x[0],
          x[1],
          x[2],
          x[3],
          0.5 * (x[0] + x[1]),
          0.5 * (x[1] + x[2]),
          0.5 * (x[0] + x[2]),
          0.5 * (x[0] + x[3]),
          0.5 * (x[1] + x[3]),
          0.5 * (x[2] + x[3])};
}

double Entry(const Vec3& v, std::size_t a) { return a == 0 ? v.x : (a == 1 ? v.y : v.z); }

TEST(SoftElement, StiffnessIsSymmetricAndRigidMotionIsForceFree) {
  std::mt19937_64 rng(3);
  const Stiffness6 d = MakeStiffness({2e5, 0.4, 6}, {1, 2, -1});
  for (int trial = 0; trial < 50; ++trial) {
    const auto x = RandomTet(rng);
    const auto k = ElementStiffness(x, d);
    const auto nodes = NodesOf(x);
    const Vec3 shift{0.3, -0.2, 0.9};
    const Vec3 turn{0.5, 1.1, -0.7};
    double scale = 0;
    for (std::size_t i = 0; i < 30; ++i) scale = std::max(scale, k[31 * i]);
    for (std::size_t i = 0; i < 30; ++i) {
      double force = 0;
      for (std::size_t j = 0; j < 30; ++j) {
        EXPECT_NEAR(k[30 * i + j], k[30 * j + i], 1e-12 * scale);
        const Vec3 u = shift + Cross(turn, 100 * nodes[j / 3]);
        force += k[30 * i + j] * Entry(u, j % 3);
      }
      EXPECT_NEAR(force, 0, 1e-10 * scale);
    }
  }
}

// Uniform strain: the energy of the element is exactly 1/2 e . D e times its volume.
TEST(SoftElement, UniformStrainHasItsExactEnergy) {
  std::mt19937_64 rng(4);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 50; ++trial) {
    const Stiffness6 d = MakeStiffness({1e5, 0.3, 3}, {normal(rng), normal(rng), normal(rng)});
    const auto x = RandomTet(rng);
    const auto k = ElementStiffness(x, d);
    const auto nodes = NodesOf(x);
    double h[3][3];
    for (auto& row : h) {
      for (double& v : row) v = normal(rng);
    }
    const double e[6] = {h[0][0], h[1][1], h[2][2], h[1][2] + h[2][1], h[0][2] + h[2][0], h[0][1] + h[1][0]};
    double exact = 0;
    for (std::size_t i = 0; i < 6; ++i) {
      for (std::size_t j = 0; j < 6; ++j) exact += 0.5 * e[i] * d[i][j] * e[j];
    }
    exact *= TetVolume(x[0], x[1], x[2], x[3]);
    std::array<double, 30> u;
    for (std::size_t i = 0; i < 30; ++i) {
      const Vec3& p = nodes[i / 3];
      u[i] = h[i % 3][0] * p.x + h[i % 3][1] * p.y + h[i % 3][2] * p.z;
    }
    double energy = 0;
    for (std::size_t i = 0; i < 30; ++i) {
      for (std::size_t j = 0; j < 30; ++j) energy += 0.5 * u[i] * k[30 * i + j] * u[j];
    }
    EXPECT_NEAR(energy / exact, 1, 1e-9);
  }
}

// A box on a clamped base in uniaxial strain: sides held, top pulled. Exact for quadratic elements whatever the
// lattice.
TEST(SoftFem, PassesTheUniaxialPatchTest) {
  const InputObject mesh = SoftBoxMesh();
  const auto lattice = BuildTetLattice(mesh.vertices_base_m, mesh.triangles, {.max_tets = 400});
  ASSERT_TRUE(lattice.ok());
  const QuadraticMesh quadratic = MakeQuadratic(*lattice);
  const Stiffness6 d = MakeStiffness({2e5, 0, 1}, {0, 0, 1});  // nu = 0: uniaxial stress is uniaxial strain
  std::vector<bool> clamped;
  for (const Vec3& p : quadratic.nodes_base_m) clamped.push_back(p.z < 2e-6);
  const auto fem = ElasticFem::Build(
      quadratic, [&](const Vec3&) { return d; }, clamped);
  ASSERT_TRUE(fem.ok()) << fem.error();
  LoadBlock block(3 * quadratic.nodes_base_m.size());
  double lowest = 1;
  for (const Vec3& p : quadratic.nodes_base_m) lowest = std::min(lowest, p.z);
  // Traction along z on everything that faces up or down in proportion to n_z: that of the stress zz = 1 Pa.
  for (const auto& t : quadratic.surface) {
    const Vec3 area = 0.5 * Cross(quadratic.nodes_base_m[t[1]] - quadratic.nodes_base_m[t[0]],
                                  quadratic.nodes_base_m[t[2]] - quadratic.nodes_base_m[t[0]]);
    for (std::size_t k = 3; k < 6; ++k) block[3 * t[k] + 2][0] += area.z / 3;
  }
  fem->Solve(block);
  for (std::size_t n = 0; n < quadratic.nodes_base_m.size(); ++n) {
    if (clamped[n]) continue;
    const double stretch = (quadratic.nodes_base_m[n].z - std::max(lowest, 0.0)) / 2e5;
    EXPECT_NEAR(block[3 * n + 2][0], stretch, 2e-4 * 0.03 / 2e5);
    EXPECT_NEAR(block[3 * n][0], 0, 2e-4 * 0.03 / 2e5);
  }
}

TEST(SoftFem, RejectsNoneOrAllNodesClamped) {
  const InputObject mesh = SoftBoxMesh();
  const auto lattice = BuildTetLattice(mesh.vertices_base_m, mesh.triangles, {.max_tets = 200});
  ASSERT_TRUE(lattice.ok());
  const QuadraticMesh quadratic = MakeQuadratic(*lattice);
  const Stiffness6 d = MakeStiffness({2e5, 0.3, 1}, {});
  const auto build = [&](bool all) {
    return ElasticFem::Build(
        quadratic, [&](const Vec3&) { return d; }, std::vector<bool>(quadratic.nodes_base_m.size(), all));
  };
  EXPECT_FALSE(build(false).ok());
  EXPECT_FALSE(build(true).ok());
}

TEST(SoftMaterial, IndentationModulusMatchesKnownSolids) {
  for (const double nu : {0.0, 0.25, 0.4, 0.49}) {
    const double exact = 2e5 / (1 - nu * nu);
    EXPECT_NEAR(IndentationModulus(MakeStiffness({2e5, nu, 1}, {1, 0, 1}), {0.2, 0.5, 0.8}) / exact, 1, 1e-9);
  }
  // Along the axis of a transversely isotropic solid [Delafargue & Ulm 2004, 43].
  for (const double ratio : {2.0, 5.0, 20.0}) {
    const Vec3 fibre = base::Normalized({1, -2, 0.5});
    const Stiffness6 c = MakeStiffness({2e5, 0.4, ratio}, {0, 0, 1});
    const double c11 = c[0][0], c33 = c[2][2], c13 = c[0][2], c44 = c[3][3];
    const double exact = 2 * std::sqrt((c11 * c33 - c13 * c13) / c11 / (1 / c44 + 2 / (std::sqrt(c11 * c33) + c13)));
    EXPECT_NEAR(IndentationModulus(MakeStiffness({2e5, 0.4, ratio}, fibre), fibre) / exact, 1, 1e-4);
  }
}

TEST(SoftMaterial, FibreRatioOneIsIsotropic) {
  const Stiffness6 a = MakeStiffness({3e5, 0.35, 1}, {0, 0, 1});
  const Stiffness6 b = MakeStiffness({3e5, 0.35, 1}, {1, 2, 3});
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t j = 0; j < 6; ++j) EXPECT_NEAR(a[i][j], b[i][j], 1e-9 * a[0][0]);
  }
}

}  // namespace test_deformable_elements
}  // namespace omni::haptics
