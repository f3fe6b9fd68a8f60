#include "service/haptics/deformable/build/fem.h"

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <unordered_map>

#include "service/haptics/deformable/build/ldlt.h"

namespace omni::haptics {
namespace {

constexpr std::size_t kTetEdge[6][2] = {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}};
constexpr std::uint32_t kNotFree = 0xFFFFFFFF;

using Sparse = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;
using Element = Eigen::Matrix<double, 30, 30, Eigen::RowMajor>;

// Gradients of the barycentric coordinates, and the volume.
struct TetGradients {
  std::array<Vec3, 4> of;
  double volume_m3;
};

TetGradients GradientsOf(const std::array<Vec3, 4>& x) {
  const double volume = TetVolume(x[0], x[1], x[2], x[3]);
  const double scale = 1 / (6 * volume);
  TetGradients g{{}, volume};
  g.of[1] = scale * Cross(x[2] - x[0], x[3] - x[0]);
  g.of[2] = scale * Cross(x[3] - x[0], x[1] - x[0]);
  g.of[3] = scale * Cross(x[1] - x[0], x[2] - x[0]);
  g.of[0] = -(g.of[1] + g.of[2] + g.of[3]);
  return g;
}

// N_i = l_i (2 l_i - 1) at corners, 4 l_i l_j on edges.
std::array<Vec3, 10> ShapeGradients(const TetGradients& g, const std::array<double, 4>& l) {
  std::array<Vec3, 10> d;
  for (std::size_t i = 0; i < 4; ++i) d[i] = (4 * l[i] - 1) * g.of[i];
  for (std::size_t e = 0; e < 6; ++e) {
    const auto [i, j] = kTetEdge[e];
    d[4 + e] = 4 * l[i] * g.of[j] + 4 * l[j] * g.of[i];
  }
  return d;
}

std::vector<std::vector<std::uint32_t>> NeighboursOf(const QuadraticMesh& mesh) {
  std::vector<std::vector<std::uint32_t>> neighbours(mesh.nodes_base_m.size());
  for (const auto& tet : mesh.tets) {
    for (const std::uint32_t a : tet) {
      for (const std::uint32_t b : tet) {
        if (a != b) neighbours[a].push_back(b);
      }
    }
  }
  for (auto& list : neighbours) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }
  return neighbours;
}

// Upper triangle in the order of elimination.
Sparse AssembleStiffness(const QuadraticMesh& mesh, const std::function<Stiffness6(const Vec3&)>& stiffness,
                         const std::vector<std::uint32_t>& rank, int size) {
  std::vector<Eigen::Triplet<double, int>> entries;
  entries.reserve(mesh.tets.size() * 480);
  for (const auto& tet : mesh.tets) {
    const std::array<Vec3, 4> x{mesh.nodes_base_m[tet[0]], mesh.nodes_base_m[tet[1]], mesh.nodes_base_m[tet[2]],
                                mesh.nodes_base_m[tet[3]]};
    const auto k = ElementStiffness(x, stiffness(0.25 * (x[0] + x[1] + x[2] + x[3])));
    for (std::size_t i = 0; i < 30; ++i) {
      const std::uint32_t row_node = rank[tet[i / 3]];
      if (row_node == kNotFree) continue;
      const int row = static_cast<int>(3 * row_node + i % 3);
      for (std::size_t j = 0; j < 30; ++j) {
        const std::uint32_t column_node = rank[tet[j / 3]];
        if (column_node == kNotFree) continue;
        const int column = static_cast<int>(3 * column_node + j % 3);
        if (row <= column) entries.emplace_back(row, column, k[30 * i + j]);
      }
    }
  }
  Sparse matrix(size, size);
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

}  // namespace

QuadraticMesh MakeQuadratic(const TetLattice& lattice) {
  QuadraticMesh mesh;
  mesh.nodes_base_m = lattice.vertices_base_m;
  std::unordered_map<std::uint64_t, std::uint32_t> middle;
  const auto middle_of = [&](std::uint32_t a, std::uint32_t b) {
    const std::uint64_t key = (static_cast<std::uint64_t>(std::min(a, b)) << 32) | std::max(a, b);
    const auto [found, fresh] = middle.try_emplace(key, static_cast<std::uint32_t>(mesh.nodes_base_m.size()));
    if (fresh) mesh.nodes_base_m.push_back(0.5 * (mesh.nodes_base_m[a] + mesh.nodes_base_m[b]));
    return found->second;
  };
  for (const auto& t : lattice.tets) {
    std::array<std::uint32_t, 10> tet{t[0], t[1], t[2], t[3]};
    for (std::size_t e = 0; e < 6; ++e) tet[4 + e] = middle_of(t[kTetEdge[e][0]], t[kTetEdge[e][1]]);
    mesh.tets.push_back(tet);
  }
  for (const auto& t : lattice.surface) {
    mesh.surface.push_back({t[0], t[1], t[2], middle_of(t[0], t[1]), middle_of(t[1], t[2]), middle_of(t[2], t[0])});
  }
  return mesh;
}

// k = sum over 4 points of V / 4 B^T D B, exact for straight edges   (3.1)
std::array<double, 900> ElementStiffness(const std::array<Vec3, 4>& corners, const Stiffness6& stiffness) {
  constexpr double kNear = 0.58541019662496845;  // Gauss points of degree 2 [Keast 1986]
  constexpr double kFar = 0.13819660112501052;
  const TetGradients g = GradientsOf(corners);
  Eigen::Matrix<double, 6, 6> d;
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) d(i, j) = stiffness[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
  }
  Element sum = Element::Zero();
  for (std::size_t q = 0; q < 4; ++q) {
    std::array<double, 4> l{kFar, kFar, kFar, kFar};
    l[q] = kNear;
    const auto dn = ShapeGradients(g, l);
    Eigen::Matrix<double, 6, 30> b = Eigen::Matrix<double, 6, 30>::Zero();
    for (int n = 0; n < 10; ++n) {
      const Vec3& v = dn[static_cast<std::size_t>(n)];
      b.block<6, 3>(0, 3 * n) << v.x, 0, 0, 0, v.y, 0, 0, 0, v.z, 0, v.z, v.y, v.z, 0, v.x, v.y, v.x, 0;
    }
    sum += (0.25 * g.volume_m3) * (b.transpose() * (d * b));
  }
  std::array<double, 900> k;
  Eigen::Map<Element>(k.data()) = sum;
  return k;
}

struct ElasticFem::Factor {
  std::vector<std::uint32_t> rank;  // of every node, or kNotFree
  LdltFactor ldlt;
};

ElasticFem::ElasticFem(std::unique_ptr<Factor> factor) : factor_(std::move(factor)) {}
ElasticFem::ElasticFem(ElasticFem&&) noexcept = default;
ElasticFem& ElasticFem::operator=(ElasticFem&&) noexcept = default;
ElasticFem::~ElasticFem() = default;

base::Result<ElasticFem> ElasticFem::Build(const QuadraticMesh& mesh,
                                           const std::function<Stiffness6(const Vec3&)>& stiffness,
                                           const std::vector<bool>& clamped, const std::function<bool(double)>& go_on) {
  std::vector<std::uint32_t> free;
  for (std::uint32_t n = 0; n < mesh.nodes_base_m.size(); ++n) {
    if (!clamped[n]) free.push_back(n);
  }
  if (free.size() == mesh.nodes_base_m.size()) {
    return base::Error{"soft body: nothing is clamped; give it a base that reaches the lowest part of the mesh"};
  }
  if (free.empty()) return base::Error{"soft body: all of it is clamped; lower the clamped height, or make it rigid"};
  auto factor = std::make_unique<Factor>();
  factor->rank.assign(mesh.nodes_base_m.size(), kNotFree);
  const std::vector<std::uint32_t> order = DissectionOrder(mesh.nodes_base_m, free, NeighboursOf(mesh));
  for (std::uint32_t k = 0; k < order.size(); ++k) factor->rank[order[k]] = k;
  const Sparse matrix = AssembleStiffness(mesh, stiffness, factor->rank, static_cast<int>(3 * order.size()));
  const auto columns = static_cast<std::size_t>(matrix.cols()), entries = static_cast<std::size_t>(matrix.nonZeros());
  const LdltOutcome outcome =
      FactoriseLdlt({std::span(matrix.outerIndexPtr(), columns + 1), std::span(matrix.innerIndexPtr(), entries),
                     std::span(matrix.valuePtr(), entries)},
                    go_on, factor->ldlt);
  if (outcome == LdltOutcome::kStopped) return base::Error{"cancelled"};
  if (outcome == LdltOutcome::kNotPositive) {
    return base::Error{
        "soft body: the stiffness matrix is singular; a part of the body is not connected to the clamped base"};
  }
  return ElasticFem(std::move(factor));
}

// L D L^T x = f, once through L for all columns.
void ElasticFem::Solve(LoadBlock& block) const {
  const LdltFactor& l = factor_->ldlt;
  const std::size_t size = l.diagonal.size();
  LoadBlock x(size);
  for (std::size_t n = 0; n < factor_->rank.size(); ++n) {
    if (factor_->rank[n] == kNotFree) continue;
    for (std::size_t a = 0; a < 3; ++a) x[3 * factor_->rank[n] + a] = block[3 * n + a];
  }
  for (std::size_t j = 0; j < size; ++j) {
    const auto xj = x[j];
    for (std::size_t p = l.first[j]; p < l.first[j + 1]; ++p) {
      auto& row = x[l.row[p]];
      for (std::size_t c = 0; c < kSolveWidth; ++c) row[c] -= l.value[p] * xj[c];
    }
  }
  for (std::size_t j = size; j-- > 0;) {
    auto xj = x[j];
    for (double& v : xj) v /= l.diagonal[j];
    for (std::size_t p = l.first[j]; p < l.first[j + 1]; ++p) {
      const auto& row = x[l.row[p]];
      for (std::size_t c = 0; c < kSolveWidth; ++c) xj[c] -= l.value[p] * row[c];
    }
    x[j] = xj;
  }
  for (std::size_t n = 0; n < factor_->rank.size(); ++n) {
    for (std::size_t a = 0; a < 3; ++a) {
      block[3 * n + a] = factor_->rank[n] == kNotFree ? std::array<double, kSolveWidth>{} : x[3 * factor_->rank[n] + a];
    }
  }
}

std::size_t ElasticFem::factor_entries() const { return factor_->ldlt.row.size(); }

}  // namespace omni::haptics
