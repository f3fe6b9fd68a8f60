// Building a soft body: lattice, block, bad input.
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "tests/deformable/scenario.h"

namespace omni::haptics {
namespace test_deformable_build {

double VolumeOf(const TetLattice& lattice) {
  double sum = 0;
  for (const auto& t : lattice.tets) {
    const double volume = TetVolume(lattice.vertices_base_m[t[0]], lattice.vertices_base_m[t[1]],
                                    lattice.vertices_base_m[t[2]], lattice.vertices_base_m[t[3]]);
    EXPECT_GT(volume, 0);
    sum += volume;
  }
  return sum;
}

// Every edge of the lattice's surface is used once in each direction.
bool IsClosed(const TetLattice& lattice) {
  std::vector<SoftTriangle> triangles;
  for (const auto& t : lattice.surface) triangles.push_back({{t[0], t[1], t[2]}, {}});
  std::size_t matched = 0;
  for (const SoftTriangle& a : triangles) {
    for (int k = 0; k < 3; ++k) {
      for (const SoftTriangle& b : triangles) {
        for (int m = 0; m < 3; ++m) matched += b.node[m] == a.node[(k + 1) % 3] && b.node[(m + 1) % 3] == a.node[k];
      }
    }
  }
  return matched == 3 * triangles.size();
}

TEST(SoftLattice, FillsABallWithPositiveTetsAndAClosedSurface) {
  const InputObject mesh = SoftBallMesh();
  for (const std::uint32_t budget : {300U, 1200U}) {
    const auto lattice = BuildTetLattice(mesh.vertices_base_m, mesh.triangles, {.max_tets = budget});
    ASSERT_TRUE(lattice.ok()) << lattice.error();
    EXPECT_LE(lattice->tets.size(), budget);
    EXPECT_GT(lattice->tets.size(), budget / 2);
    const double exact = 4.0 / 3 * 3.14159265 * 0.03 * 0.03 * 0.03;
    EXPECT_NEAR(VolumeOf(*lattice) / exact, budget < 500 ? 0.93 : 0.96, 0.05);
    EXPECT_TRUE(IsClosed(*lattice));
    for (const auto& t : lattice->surface) {
      for (const std::uint32_t v : t) EXPECT_NEAR(Norm(lattice->vertices_base_m[v]), 0.03, 7e-4);
    }
  }
}

double OutsideBlock(const Vec3& p, const Vec3& half) {
  return std::max({std::abs(p.x) - half.x, std::abs(p.y) - half.y, std::abs(p.z) - half.z});
}

// A cut grid alone fills 0.922 to 0.954 of this block.
TEST(SoftLattice, KeepsSharpEdges) {
  std::mt19937_64 random(31);
  std::uniform_real_distribution<double> shift(0.05, 0.45);
  const Vec3 half{0.02, 0.014, 0.011};
  const InputObject mesh = Block(3, half);
  for (int k = 0; k < 12; ++k) {
    const LatticeOptions options{.max_tets = 900, .shift_cells = {shift(random), shift(random), shift(random)}};
    const auto lattice = BuildTetLattice(mesh.vertices_base_m, mesh.triangles, options);
    ASSERT_TRUE(lattice.ok()) << lattice.error();
    EXPECT_GT(VolumeOf(*lattice) / (8 * half.x * half.y * half.z), 0.957) << k;
    EXPECT_TRUE(IsClosed(*lattice));
    for (const auto& t : lattice->surface) {
      for (const std::uint32_t v : t) EXPECT_NEAR(OutsideBlock(lattice->vertices_base_m[v], half), 0, 2e-5);
    }
  }
}

TEST(SoftLattice, ToleratesMeshDefects) {
  InputObject mesh = SoftBallMesh();
  const auto whole = BuildTetLattice(mesh.vertices_base_m, mesh.triangles, {.max_tets = 500});
  ASSERT_TRUE(whole.ok());
  const double volume = VolumeOf(*whole);
  // Holes, a T-junction, a triangle without area, and a small second ball inside that overlaps nothing.
  mesh.triangles.erase(mesh.triangles.begin() + 100, mesh.triangles.begin() + 104);
  mesh.triangles.push_back({0, 0, 1});
  mesh.vertices_base_m.push_back(0.5 * (mesh.vertices_base_m[0] + mesh.vertices_base_m[1]));
  const auto broken = BuildTetLattice(mesh.vertices_base_m, mesh.triangles, {.max_tets = 500});
  ASSERT_TRUE(broken.ok()) << broken.error();
  EXPECT_NEAR(VolumeOf(*broken) / volume, 1, 0.04);
}

TEST(SoftLattice, RejectsMeshesWithoutAnInterior) {
  InputObject sheet = SoftBoxMesh();
  for (Vec3& v : sheet.vertices_base_m) v.z = 0;  // zero thickness
  const auto flat = BuildTetLattice(sheet.vertices_base_m, sheet.triangles, {});
  ASSERT_FALSE(flat.ok());
  EXPECT_NE(flat.error().find("inside"), std::string::npos) << flat.error();
  InputObject half = SoftBoxMesh();
  half.triangles.resize(half.triangles.size() / 6);  // one open side
  EXPECT_FALSE(BuildTetLattice(half.vertices_base_m, half.triangles, {}).ok());
  InputObject nan = SoftBoxMesh();
  nan.vertices_base_m[7].y = std::numeric_limits<double>::quiet_NaN();
  const auto refused = BuildTetLattice(nan.vertices_base_m, nan.triangles, {});
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().find("vertex 7"), std::string::npos) << refused.error();
  InputObject index = SoftBoxMesh();
  index.triangles[3][1] = 1'000'000;
  EXPECT_FALSE(BuildTetLattice(index.vertices_base_m, index.triangles, {}).ok());
  EXPECT_FALSE(BuildTetLattice({}, {}, {}).ok());
}

TEST(SoftBuild, ComplianceIsPositiveDefinite) {
  const SoftBodyView body = SoftBall().view();
  const std::uint32_t n = body.header().node_count;
  std::mt19937_64 rng(11);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<double> f(n);
    for (double& x : f) x = normal(rng);
    double energy = 0;
    double diagonal = 0;
    for (std::uint32_t i = 0; i < n; ++i) {
      diagonal += f[i] * f[i] * static_cast<double>(body.Compliance(i, i));
      for (std::uint32_t j = 0; j < n; ++j) energy += f[i] * f[j] * static_cast<double>(body.Compliance(i, j));
    }
    EXPECT_GT(energy, 1e-4 * diagonal);
  }
}

// By Maxwell and Betti the push of i on j equals that of j on i; columns and compliance are stored apart.
TEST(SoftBuild, ColumnsAgreeWithTheCompliance) {
  const SoftBodyView body = SoftBall().view();
  const std::uint32_t n = body.header().node_count;
  double worst = 0;
  double typical = 0;
  for (std::uint32_t j = 0; j < n; j += 7) {
    for (std::uint32_t i = 0; i < n; i += 5) {
      const Vec3 far{body.Node(i).position_base_m.x - body.Node(j).position_base_m.x,
                     body.Node(i).position_base_m.y - body.Node(j).position_base_m.y,
                     body.Node(i).position_base_m.z - body.Node(j).position_base_m.z};
      const bool held =
          body.Node(i).position_base_m.z < -0.015F;  // a patch reaches out of the clamped part, a point not
      if (held || Norm(far) < 2.5 * body.header().patch_radius_m) continue;
      const Float3 u = body.Column(j)[i];
      const Float3 m = body.Node(i).normal;
      const double give = -static_cast<double>(u.x * m.x + u.y * m.y + u.z * m.z);
      worst = std::max(worst, std::abs(give - static_cast<double>(body.Compliance(i, j))));
      typical = std::max(typical, std::abs(give));
    }
  }
  EXPECT_LT(worst, 0.08 * typical);  // the one is taken at a point, the other over a patch
  EXPECT_GT(typical, 0);
}

TEST(SoftBlock, RoundTripsAndDetectsAnyDamage) {
  const auto bytes = SoftBall().bytes();
  const auto again = SoftBody::Load(bytes);
  ASSERT_TRUE(again.ok()) << again.error();
  ASSERT_EQ(again->bytes().size(), bytes.size());
  EXPECT_EQ(std::memcmp(again->bytes().data(), bytes.data(), bytes.size()), 0);
  std::mt19937_64 rng(5);
  std::vector<std::byte> copy(bytes.begin(), bytes.end());
  for (int trial = 0; trial < 300; ++trial) {
    const std::size_t at = trial < 150 ? rng() % sizeof(SoftHeader) : rng() % copy.size();
    const auto bit = static_cast<std::byte>(1U << (rng() % 8));
    copy[at] ^= bit;
    EXPECT_FALSE(SoftBody::Load(copy).ok()) << "byte " << at;
    copy[at] ^= bit;
  }
  for (const std::size_t size : {std::size_t{0}, std::size_t{10}, sizeof(SoftHeader), bytes.size() - 1}) {
    EXPECT_FALSE(SoftBody::Load(bytes.first(size)).ok());
  }
}

// The sides that begin at its edge say nothing about how a flat top is bent.
TEST(SoftBuild, FlatTopIsFlatUpToItsEdge) {
  const auto body = BuildSmall(SoftBoxMesh(), SmallOptions());
  ASSERT_TRUE(body.ok()) << body.error();
  const SoftHeader& h = body->view().header();
  int flat = 0;
  for (std::uint32_t n = 0; n < h.node_count; ++n) {
    const SoftNode& node = body->view().Node(n);
    if (!(node.normal.z > 0.9999F && node.position_base_m.z > 0.0299F)) continue;
    ++flat;
    EXPECT_LT(std::abs(static_cast<double>(node.curvature_1_m)) * h.cell_m, 0.02) << node.position_base_m.x;
  }
  EXPECT_GT(flat, 5);
}

TEST(SoftBuild, KeyDependsOnMeshAndOptions) {
  const InputObject mesh = SoftBallMesh();
  const auto key = [&](const InputObject& m, const SoftBodyOptions& o) {
    return SoftBodyKey(m.vertices_base_m, m.triangles, o);
  };
  const std::uint64_t original = key(mesh, SmallOptions());
  EXPECT_EQ(original, SoftBall().view().header().input_hash);
  SoftBodyOptions options = SmallOptions();
  options.moduli.fibre_ratio = 2;
  EXPECT_NE(key(mesh, options), original);
  options = SmallOptions();
  options.clamped_share = 0.06;
  EXPECT_NE(key(mesh, options), original);
  InputObject moved = mesh;
  moved.vertices_base_m[3].x += 1e-9;
  EXPECT_NE(key(moved, SmallOptions()), original);
}

TEST(SoftBuild, ReportsProgressAndStopsWhenCancelled) {
  SoftBodyOptions options = SmallOptions();
  double last = -1;
  int calls = 0;
  options.progress = [&](double done) {
    EXPECT_GE(done, last);
    EXPECT_LE(done, 1);
    last = done;
    return ++calls < 4;
  };
  const auto body = BuildSmall(SoftBallMesh(), options);
  ASSERT_FALSE(body.ok());
  EXPECT_EQ(body.error(), "cancelled");
  EXPECT_EQ(calls, 4);
}

TEST(SoftBuild, RejectsOptionsOutOfRange) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [&](auto change) {
    SoftBodyOptions options = SmallOptions();
    change(options);
    return !BuildSmall(SoftBallMesh(), options).ok();
  };
  EXPECT_TRUE(refused([](auto& o) { o.moduli.poisson_ratio = 0.5; }));
  EXPECT_TRUE(refused([&](auto& o) { o.moduli.young_modulus_Pa = nan; }));
  EXPECT_TRUE(refused([](auto& o) { o.moduli.fibre_ratio = 0.5; }));
  EXPECT_TRUE(refused([](auto& o) { o.clamped_share = 0; }));
  EXPECT_TRUE(refused([&](auto& o) { o.hardening = nan; }));
  EXPECT_TRUE(refused([](auto& o) { o.relaxation_time_s = -1; }));
  EXPECT_TRUE(refused([&](auto& o) { o.fibre.x = nan; }));
  EXPECT_TRUE(refused([](auto& o) { o.lattice.max_tets = 10; }));
  EXPECT_FALSE(refused([](auto&) {}));
}

}  // namespace test_deformable_build
}  // namespace omni::haptics
