#include "service/haptics/deformable/build/lattice.h"

#include <string>
#include <unordered_map>

#include "service/haptics/geometry/winding_number.h"

namespace omni::haptics {
namespace {

using Triangles = std::span<const std::array<std::uint32_t, 3>>;

// A cut nearer than this share of the edge to a vertex pulls the vertex onto the surface   [Labelle & Shewchuk 2007]
constexpr double kWarpLong = 0.24999;
constexpr double kWarpShort = 0.41189;
constexpr int kBisections = 13;
constexpr double kFlatShare = 1e-5;  // of a cell: pieces thinner than this are dropped
constexpr int kCellTrials = 6;
constexpr double kGridPointsPerTet = 100;  // a body that fills its box worse gets a coarser lattice
constexpr double kThinnest = 1e-4;         // extent over the largest one

std::uint64_t EdgeKey(std::uint32_t a, std::uint32_t b) {
  return (static_cast<std::uint64_t>(std::min(a, b)) << 32) | std::max(a, b);
}

// The BCC grid: corners of cubes, then centres of cubes.
struct BccGrid {
  Vec3 origin;
  double cell_m;
  std::uint32_t nx, ny, nz;  // cubes

  std::uint32_t Corners() const { return (nx + 1) * (ny + 1) * (nz + 1); }
  std::uint32_t Points() const { return Corners() + nx * ny * nz; }
  std::uint32_t Corner(std::uint32_t i, std::uint32_t j, std::uint32_t k) const {
    return (k * (ny + 1) + j) * (nx + 1) + i;
  }
  std::uint32_t Centre(std::uint32_t i, std::uint32_t j, std::uint32_t k) const {
    return Corners() + (k * ny + j) * nx + i;
  }
  Vec3 Position(std::uint32_t point) const {
    const bool centre = point >= Corners();
    const std::uint32_t n = centre ? point - Corners() : point;
    const std::uint32_t sx = centre ? nx : nx + 1;
    const std::uint32_t sy = centre ? ny : ny + 1;
    const double half = centre ? 0.5 : 0;
    const std::uint32_t i = n % sx, j = n / sx % sy, k = n / (sx * sy);
    return origin + cell_m * Vec3{i + half, j + half, k + half};
  }
  std::vector<TetCorners> Tets() const;
};

// Two neighbouring centres and each edge of the square between them.
std::vector<TetCorners> BccGrid::Tets() const {
  std::vector<TetCorners> tets;
  const auto around = [&](std::uint32_t a, std::uint32_t b, const TetCorners& square) {
    for (std::size_t k = 0; k < 4; ++k) tets.push_back({a, b, square[k], square[(k + 1) % 4]});
  };
  for (std::uint32_t k = 1; k < nz; ++k) {
    for (std::uint32_t j = 1; j < ny; ++j) {
      for (std::uint32_t i = 1; i < nx; ++i) {
        const std::uint32_t here = Centre(i, j, k);
        around(Centre(i - 1, j, k), here,
               {Corner(i, j, k), Corner(i, j + 1, k), Corner(i, j + 1, k + 1), Corner(i, j, k + 1)});
        around(Centre(i, j - 1, k), here,
               {Corner(i, j, k), Corner(i + 1, j, k), Corner(i + 1, j, k + 1), Corner(i, j, k + 1)});
        around(Centre(i, j, k - 1), here,
               {Corner(i, j, k), Corner(i + 1, j, k), Corner(i + 1, j + 1, k), Corner(i, j + 1, k)});
      }
    }
  }
  return tets;
}

class Stuffer {
 public:
  Stuffer(const BccGrid& grid, const WindingTree& field) : grid_(grid), field_(field), tets_(grid.Tets()) {
    position_.reserve(grid.Points());
    side_.reserve(grid.Points());
    for (std::uint32_t p = 0; p < grid.Points(); ++p) {
      position_.push_back(grid.Position(p));
      side_.push_back(field.IsInside(position_[p]) ? 1 : -1);
    }
  }

  TetLattice Run() {
    FindCuts();
    Warp();
    std::vector<TetCorners> pieces;
    const auto cut = [this](std::uint32_t in, std::uint32_t out) { return CutVertex(in, out); };
    for (const TetCorners& tet : tets_) {
      CutTet(tet, {side_[tet[0]], side_[tet[1]], side_[tet[2]], side_[tet[3]]}, cut, pieces);
    }
    return Compact(pieces);
  }

 private:
  struct Cut {
    std::uint32_t in, out;
    double t;  // from `in`
    Vec3 point;
  };

  void FindCuts() {
    for (const TetCorners& tet : tets_) {
      for (std::size_t a = 0; a < 4; ++a) {
        for (std::size_t b = 0; b < 4; ++b) {
          if (side_[tet[a]] <= 0 || side_[tet[b]] >= 0) continue;
          if (cut_of_.contains(EdgeKey(tet[a], tet[b]))) continue;
          cut_of_[EdgeKey(tet[a], tet[b])] = cuts_.size();
          cuts_.push_back(Bisect(tet[a], tet[b]));
        }
      }
    }
  }

  Cut Bisect(std::uint32_t in, std::uint32_t out) const {
    double lo = 0;
    double hi = 1;
    const Vec3 step = position_[out] - position_[in];
    for (int k = 0; k < kBisections; ++k) {
      const double middle = 0.5 * (lo + hi);
      (field_.IsInside(position_[in] + middle * step) ? lo : hi) = middle;
    }
    const double t = 0.5 * (lo + hi);
    return {in, out, t, position_[in] + t * step};
  }

  void Warp() {
    std::vector<double> nearest(position_.size(), 1e300);
    std::vector<Vec3> target(position_.size());
    for (const Cut& cut : cuts_) {
      const bool is_long = (cut.in >= grid_.Corners()) == (cut.out >= grid_.Corners());
      const double limit = is_long ? kWarpLong : kWarpShort;
      const double length = Norm(position_[cut.out] - position_[cut.in]);
      const auto pull = [&](std::uint32_t vertex, double share) {
        if (share > limit || share * length >= nearest[vertex]) return;
        nearest[vertex] = share * length;
        target[vertex] = cut.point;
      };
      pull(cut.in, cut.t);
      pull(cut.out, 1 - cut.t);
    }
    for (std::uint32_t p = 0; p < position_.size(); ++p) {
      if (nearest[p] > 1e299) continue;
      position_[p] = target[p];
      side_[p] = 0;
    }
  }

  std::uint32_t CutVertex(std::uint32_t in, std::uint32_t out) {
    const std::size_t index = cut_of_.at(EdgeKey(in, out));
    const auto [found, fresh] = cut_vertex_.try_emplace(index, static_cast<std::uint32_t>(position_.size()));
    if (fresh) position_.push_back(cuts_[index].point);
    return found->second;
  }

  TetLattice Compact(std::vector<TetCorners>& pieces) const {
    TetLattice lattice;
    lattice.cell_m = grid_.cell_m;
    std::vector<std::uint32_t> renamed(position_.size(), 0xFFFFFFFF);
    const double flat_m3 = kFlatShare * grid_.cell_m * grid_.cell_m * grid_.cell_m;
    for (TetCorners& tet : pieces) {
      const double volume = TetVolume(position_[tet[0]], position_[tet[1]], position_[tet[2]], position_[tet[3]]);
      if (!(std::abs(volume) > flat_m3)) continue;
      if (volume < 0) std::swap(tet[2], tet[3]);
      for (std::uint32_t& v : tet) {
        if (renamed[v] == 0xFFFFFFFF) {
          renamed[v] = static_cast<std::uint32_t>(lattice.vertices_base_m.size());
          lattice.vertices_base_m.push_back(position_[v]);
        }
        v = renamed[v];
      }
      lattice.tets.push_back(tet);
    }
    return lattice;
  }

  const BccGrid& grid_;
  const WindingTree& field_;
  std::vector<TetCorners> tets_;
  std::vector<Vec3> position_;
  std::vector<int> side_;
  std::vector<Cut> cuts_;
  std::unordered_map<std::uint64_t, std::size_t> cut_of_;
  std::unordered_map<std::size_t, std::uint32_t> cut_vertex_;
};

// Faces of a tet, seen from outside counter-clockwise.
constexpr std::size_t kFace[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};

struct FaceUse {
  std::array<std::uint32_t, 3> face;  // as seen from its first tet
  std::uint32_t tet;
  std::uint32_t other = 0xFFFFFFFF;
};

struct FaceHash {
  std::size_t operator()(const std::array<std::uint32_t, 3>& f) const {
    return (static_cast<std::size_t>(f[0]) * 73856093U) ^ (static_cast<std::size_t>(f[1]) * 19349663U) ^
           (static_cast<std::size_t>(f[2]) * 83492791U);
  }
};

std::vector<FaceUse> FindTetFaces(const TetLattice& lattice) {
  std::vector<FaceUse> uses;
  std::unordered_map<std::array<std::uint32_t, 3>, std::size_t, FaceHash> seen;
  for (std::uint32_t t = 0; t < lattice.tets.size(); ++t) {
    for (const auto& corner : kFace) {
      const TetCorners& tet = lattice.tets[t];
      const std::array<std::uint32_t, 3> face{tet[corner[0]], tet[corner[1]], tet[corner[2]]};
      auto key = face;
      std::sort(key.begin(), key.end());
      const auto [found, fresh] = seen.try_emplace(key, uses.size());
      if (fresh) {
        uses.push_back({face, t});
      } else {
        uses[found->second].other = t;
      }
    }
  }
  return uses;
}

// Keeps the largest part whose tets are connected by faces, and drops vertices that are no longer used.
void KeepLargestPart(TetLattice& lattice) {
  const std::vector<FaceUse> uses = FindTetFaces(lattice);
  std::vector<std::uint32_t> parent(lattice.tets.size());
  for (std::uint32_t t = 0; t < parent.size(); ++t) parent[t] = t;
  const auto root = [&](std::uint32_t t) {
    while (parent[t] != t) t = parent[t] = parent[parent[t]];
    return t;
  };
  for (const FaceUse& use : uses) {
    if (use.other != 0xFFFFFFFF) parent[root(use.tet)] = root(use.other);
  }
  std::vector<std::uint32_t> size(parent.size(), 0);
  for (std::uint32_t t = 0; t < parent.size(); ++t) ++size[root(t)];
  const auto largest = static_cast<std::uint32_t>(std::max_element(size.begin(), size.end()) - size.begin());
  TetLattice kept;
  kept.cell_m = lattice.cell_m;
  std::vector<std::uint32_t> renamed(lattice.vertices_base_m.size(), 0xFFFFFFFF);
  for (std::uint32_t t = 0; t < parent.size(); ++t) {
    if (root(t) != largest) continue;
    TetCorners tet = lattice.tets[t];
    for (std::uint32_t& v : tet) {
      if (renamed[v] == 0xFFFFFFFF) {
        renamed[v] = static_cast<std::uint32_t>(kept.vertices_base_m.size());
        kept.vertices_base_m.push_back(lattice.vertices_base_m[v]);
      }
      v = renamed[v];
    }
    kept.tets.push_back(tet);
  }
  lattice = std::move(kept);
}

void FindSurface(TetLattice& lattice) {
  lattice.surface.clear();
  for (const FaceUse& use : FindTetFaces(lattice)) {
    if (use.other == 0xFFFFFFFF) lattice.surface.push_back(use.face);
  }
}

std::uint32_t SurfaceVertexCount(const TetLattice& lattice) {
  std::vector<bool> used(lattice.vertices_base_m.size(), false);
  std::uint32_t count = 0;
  for (const auto& t : lattice.surface) {
    for (const std::uint32_t v : t) {
      count += used[v] ? 0 : 1;
      used[v] = true;
    }
  }
  return count;
}

struct MeshBounds {
  Vec3 lower, upper;
};

MeshBounds BoundsOf(std::span<const Vec3> vertices) {
  MeshBounds bounds{vertices[0], vertices[0]};
  for (const Vec3& v : vertices) {
    bounds.lower = Min(bounds.lower, v);
    bounds.upper = Max(bounds.upper, v);
  }
  return bounds;
}

double GridPoints(const MeshBounds& bounds, double cell_m) {
  const Vec3 e = bounds.upper - bounds.lower;
  return 2 * (e.x / cell_m + 4) * (e.y / cell_m + 4) * (e.z / cell_m + 4);
}

base::Status CheckLatticeInput(std::span<const Vec3> vertices, Triangles triangles, const LatticeOptions& options) {
  if (!(options.max_tets >= 100 && options.max_tets <= 400'000)) {
    return base::Error{"soft body: max_tets " + std::to_string(options.max_tets) + " is outside [100, 400000]"};
  }
  if (!(options.max_surface_vertices >= 50 && options.max_surface_vertices <= 1024)) {
    return base::Error{"soft body: max_surface_vertices " + std::to_string(options.max_surface_vertices) +
                       " is outside [50, 1024]"};
  }
  if (vertices.empty() || triangles.empty()) return base::Error{"soft body: the mesh is empty"};
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (!IsWithin(vertices[i], 1e3)) {
      return base::Error{"soft body: vertex " + std::to_string(i) + " is not finite or beyond 1 km"};
    }
  }
  for (const auto& t : triangles) {
    if (std::max({t[0], t[1], t[2]}) >= vertices.size()) {
      return base::Error{"soft body: a triangle names vertex " + std::to_string(std::max({t[0], t[1], t[2]})) + " of " +
                         std::to_string(vertices.size())};
    }
  }
  return base::Ok{};
}

}  // namespace

double TetVolume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return Dot(Cross(b - a, c - a), d - a) / 6;
}

TetLattice StuffLattice(std::span<const Vec3> vertices, Triangles triangles, double cell_m, const Vec3& shift_cells) {
  const MeshBounds bounds = BoundsOf(vertices);
  const Vec3 extent = bounds.upper - bounds.lower;
  const auto cubes = [&](double length) { return static_cast<std::uint32_t>(length / cell_m) + 4; };
  const BccGrid grid{bounds.lower - cell_m * (Vec3{1.5, 1.5, 1.5} + shift_cells), cell_m, cubes(extent.x) + 1,
                     cubes(extent.y) + 1, cubes(extent.z) + 1};
  const WindingTree field(vertices, triangles);
  TetLattice lattice = Stuffer(grid, field).Run();
  if (lattice.tets.empty()) return lattice;
  KeepLargestPart(lattice);
  FindSurface(lattice);
  KeepSharpEdges(vertices, triangles, lattice);
  return lattice;
}

base::Result<TetLattice> BuildTetLattice(std::span<const Vec3> vertices, Triangles triangles,
                                         const LatticeOptions& options, const std::function<bool(double)>& progress) {
  const base::Status checked = CheckLatticeInput(vertices, triangles, options);
  if (!checked.ok()) return base::Error{checked.error()};
  const MeshBounds bounds = BoundsOf(vertices);
  const Vec3 extent = bounds.upper - bounds.lower;
  const double largest_m = std::max({extent.x, extent.y, extent.z});
  if (!(largest_m > 1e-6)) return base::Error{"soft body: the mesh is smaller than 1 um"};
  if (!(std::min({extent.x, extent.y, extent.z}) > kThinnest * largest_m)) {
    return base::Error{"soft body: the mesh is flat, nothing can be inside; thicken it, or make it rigid"};
  }
  const double most_points = kGridPointsPerTet * options.max_tets;
  // A cube holds 12 tets. Start as if half of the box were filled; then correct by what came out.
  double cell_m = std::max(std::cbrt(6 * extent.x * extent.y * extent.z / options.max_tets), largest_m / 60);
  while (GridPoints(bounds, cell_m) > most_points) cell_m *= 1.1;
  TetLattice best;
  for (int trial = 0; trial < kCellTrials; ++trial) {
    if (progress && !progress(static_cast<double>(trial) / kCellTrials)) return base::Error{"cancelled"};
    TetLattice lattice = StuffLattice(vertices, triangles, cell_m, options.shift_cells);
    const double tets = static_cast<double>(lattice.tets.size()) / options.max_tets;
    const double nodes = static_cast<double>(SurfaceVertexCount(lattice)) / options.max_surface_vertices;
    if (tets <= 1 && nodes <= 1 && lattice.tets.size() > best.tets.size()) best = std::move(lattice);
    const double fill = std::max(std::cbrt(tets), std::sqrt(nodes));
    if (fill <= 1 && fill > 0.95) break;
    cell_m *= std::clamp(fill * 1.025, 0.5, 2.0);
    if (GridPoints(bounds, cell_m) > most_points) break;
  }
  if (best.tets.empty()) {
    return base::Error{
        "soft body: nothing is inside this mesh (an open sheet, or thinner than the lattice can follow with " +
        std::to_string(options.max_tets) + " tetrahedra); close it, thicken it, or make it rigid"};
  }
  return best;
}

}  // namespace omni::haptics
