#include "service/haptics/deformable/build/build_soft_body.h"

#include <algorithm>
#include <chrono>
#include <string>

#include "service/haptics/deformable/build/fem.h"
#include "service/haptics/deformable/build/soft_grid.h"

namespace omni::haptics {
namespace {

// Radius of the pressure a column answers to. The nodes of the quadratic elements are half a cell apart.
constexpr double kPatch_cells = 1.25;
constexpr double kMostExtrapolated = 0.15;  // of the flat displacement
constexpr double kCurvature_cells = 1.7;    // radius of the neighbourhood curvature is fitted in
constexpr double kFlatMean = 0.6;       // mean displacement of a half-space under a Hertz pressure, times M rho   (4.2)
constexpr double kFlatMiddle = 0.75;    // ... and that at its middle
constexpr double kLatticeShare = 0.05;  // of the progress bar ...
constexpr double kFactorShare = 0.4;    // ... with what comes before

using Clock = std::chrono::steady_clock;

double MillisecondsSince(Clock::time_point& start) {
  const Clock::time_point now = Clock::now();
  const double ms = std::chrono::duration<double, std::milli>(now - start).count();
  start = now;
  return ms;
}

base::Status CheckSoftOptions(const SoftBodyOptions& o) {
  const base::Status moduli = CheckModuli(o.moduli);
  if (!moduli.ok()) return moduli;
  struct Range {
    const char* name;
    double value, lower, upper;
  };
  const Range ranges[] = {{"clamped share", o.clamped_share, 1e-6, 0.9},
                          {"hardening", o.hardening, 0, 20},
                          {"relaxing share", o.relaxing_share, 0, 5},
                          {"relaxation time", o.relaxation_time_s, 0, 100}};
  for (const Range& r : ranges) {
    if (r.value >= r.lower && r.value <= r.upper) continue;
    return base::Error{std::string("soft body: ") + r.name + " " + std::to_string(r.value) + " is outside [" +
                       std::to_string(r.lower) + ", " + std::to_string(r.upper) + "]"};
  }
  if (!IsWithin(o.fibre, 1e6)) return base::Error{"soft body: the fibre direction is not a number"};
  return base::Ok{};
}

Float3 ToFloat3(const Vec3& v) { return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)}; }

// One build, step by step.
class SoftBuilder {
 public:
  SoftBuilder(std::span<const Vec3> vertices, std::span<const std::array<std::uint32_t, 3>> triangles,
              const SoftBodyOptions& options, SoftBuildReport& report)
      : vertices_(vertices), triangles_(triangles), options_(options), report_(report) {}

  base::Result<SoftBody> Run() {
    if (!Progress(0)) return base::Error{"cancelled"};
    auto lattice = BuildTetLattice(vertices_, triangles_, options_.lattice,
                                   [this](double done) { return Progress(kLatticeShare * done); });
    if (!lattice.ok()) return base::Error{lattice.error()};
    mesh_ = MakeQuadratic(*lattice);
    report_.tets = static_cast<std::uint32_t>(lattice->tets.size());
    report_.nodes = static_cast<std::uint32_t>(mesh_.nodes_base_m.size());
    cell_m_ = lattice->cell_m;
    radius_m_ = kPatch_cells * cell_m_;
    report_.lattice_ms = MillisecondsSince(start_);
    if (!Progress(kLatticeShare)) return base::Error{"cancelled"};
    auto fem = ElasticFem::Build(
        mesh_, [this](const Vec3& p) { return StiffnessAt(p); }, ClampedNodes(),
        [this](double done) { return Progress(kLatticeShare + (kFactorShare - kLatticeShare) * done); });
    if (!fem.ok()) return base::Error{fem.error()};
    report_.factor_ms = MillisecondsSince(start_);
    if (!Progress(kFactorShare)) return base::Error{"cancelled"};
    FindSurfaceNodes();
    MakeNodes();
    if (!SolveColumns(*fem)) return base::Error{"cancelled"};
    MakeSkin();
    FillHeader();
    const std::vector<std::byte> block = LayOutSoftBody(parts_);
    report_.columns_ms = MillisecondsSince(start_);
    report_.bytes = block.size();
    return SoftBody::Load(block);
  }

 private:
  bool Progress(double done) const { return !options_.progress || options_.progress(done); }

  Stiffness6 StiffnessAt(const Vec3& p) const {
    return MakeStiffness(options_.moduli, options_.fibre_field ? options_.fibre_field(p) : options_.fibre);
  }

  std::vector<bool> ClampedNodes() const {
    double lower = mesh_.nodes_base_m[0].z;
    double upper = lower;
    for (const Vec3& p : mesh_.nodes_base_m) {
      lower = std::min(lower, p.z);
      upper = std::max(upper, p.z);
    }
    std::vector<bool> clamped;
    for (const Vec3& p : mesh_.nodes_base_m) clamped.push_back(p.z <= lower + options_.clamped_share * (upper - lower));
    return clamped;
  }

  // Corner nodes of the surface, in the order of the mesh; the coarse triangles between them.
  void FindSurfaceNodes() {
    std::vector<std::uint32_t> renamed(mesh_.nodes_base_m.size(), kNoSoftTriangle);
    for (const auto& t : mesh_.surface) {
      for (std::size_t k = 0; k < 3; ++k) renamed[t[k]] = 0;
    }
    for (std::uint32_t n = 0; n < renamed.size(); ++n) {
      if (renamed[n] == kNoSoftTriangle) continue;
      renamed[n] = static_cast<std::uint32_t>(surface_nodes_.size());
      surface_nodes_.push_back(n);
    }
    report_.surface_nodes = static_cast<std::uint32_t>(surface_nodes_.size());
    for (const auto& t : mesh_.surface) parts_.triangles.push_back({{renamed[t[0]], renamed[t[1]], renamed[t[2]]}, {}});
    ConnectSoftTriangles(parts_.triangles);
  }

  void MakeNodes() {
    const auto patches = MeasurePatches(mesh_, surface_nodes_, kCurvature_cells * cell_m_);
    for (const SurfacePatch& patch : patches) {
      loads_.push_back(SpreadLoad(mesh_, patch, radius_m_));
      const double nu = options_.moduli.poisson_ratio;
      const double modulus = options_.moduli.fibre_ratio == 1
                                 ? options_.moduli.young_modulus_Pa / (1 - nu * nu)
                                 : IndentationModulus(StiffnessAt(patch.point_base_m), patch.normal);
      parts_.nodes.push_back({ToFloat3(patch.point_base_m), ToFloat3(patch.normal), 0, static_cast<float>(modulus),
                              static_cast<float>(patch.curvature_1_m)});
    }
  }

  // Columns U_j = K^-1 b_j at the nodes and C_ij = b_i . U_j   (4.1)
  bool SolveColumns(const ElasticFem& fem) {
    const std::size_t n = surface_nodes_.size();
    parts_.columns.resize(n * n);
    parts_.compliance.resize(n * (n + 1) / 2);
    for (std::size_t first = 0; first < n; first += kSolveWidth) {
      if (!Progress(kFactorShare + (1 - kFactorShare) * static_cast<double>(first) / static_cast<double>(n)))
        return false;
      LoadBlock block(3 * mesh_.nodes_base_m.size());
      const std::size_t width = std::min(kSolveWidth, n - first);
      for (std::size_t c = 0; c < width; ++c) {
        const PatchLoad& load = loads_[first + c];
        for (const auto& [node, share] : load.shares) {
          block[3 * node][c] -= share * load.normal.x;
          block[3 * node + 1][c] -= share * load.normal.y;
          block[3 * node + 2][c] -= share * load.normal.z;
        }
      }
      fem.Solve(block);
      for (std::size_t c = 0; c < width; ++c) StoreColumn(first + c, c, block);
    }
    return true;
  }

  void StoreColumn(std::size_t j, std::size_t c, const LoadBlock& block) {
    const std::size_t n = surface_nodes_.size();
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t row = 3 * static_cast<std::size_t>(surface_nodes_[i]);
      parts_.columns[j * n + i] = {static_cast<float>(block[row][c]), static_cast<float>(block[row + 1][c]),
                                   static_cast<float>(block[row + 2][c])};
    }
    for (std::size_t i = j; i < n; ++i)
      parts_.compliance[i * (i + 1) / 2 + j] = static_cast<float>(Give(loads_[i], c, block));
    SoftNode& node = parts_.nodes[j];
    const double flat = 1 / (static_cast<double>(node.modulus_Pa) * radius_m_);
    node.compliance_m_N = static_cast<float>(OwnCompliance(j, c, block, flat));
  }

  // What the body adds to a half-space, as the mean over the patch and at its middle. The former is off by twice as
  // much as the latter, from which the value of a patch without size follows.   (4.2), (4.4)
  double OwnCompliance(std::size_t j, std::size_t c, const LoadBlock& block, double flat) const {
    const double mean = Give(loads_[j], c, block) - kFlatMean * flat;
    const std::size_t row = 3 * static_cast<std::size_t>(surface_nodes_[j]);
    const double middle =
        -Dot(loads_[j].normal, {block[row][c], block[row + 1][c], block[row + 2][c]}) - kFlatMiddle * flat;
    return mean + std::clamp(2 * (middle - mean), -kMostExtrapolated * flat, kMostExtrapolated * flat);
  }

  // How far a patch goes in, weighted as its pressure.
  static double Give(const PatchLoad& load, std::size_t c, const LoadBlock& block) {
    double sum = 0;
    const Vec3& n = load.normal;
    for (const auto& [node, share] : load.shares) {
      const std::size_t row = 3 * static_cast<std::size_t>(node);
      sum -= share * (n.x * block[row][c] + n.y * block[row + 1][c] + n.z * block[row + 2][c]);
    }
    return sum;
  }

  void MakeSkin() {
    const SoftGridResult grid = MakeSoftGrid(parts_.nodes, parts_.triangles, cell_m_);
    parts_.grid = grid.seed;
    for (std::size_t a = 0; a < 3; ++a) parts_.header.grid_count[a] = grid.count[a];
    parts_.header.grid_lower_m[0] = grid.lower_m.x;
    parts_.header.grid_lower_m[1] = grid.lower_m.y;
    parts_.header.grid_lower_m[2] = grid.lower_m.z;
    parts_.header.grid_cell_m = grid.cell_m;
    parts_.header.cell_m = cell_m_;
    for (const Vec3& v : vertices_) parts_.skin.push_back(HangOnSurface(parts_.nodes, parts_.triangles, grid, v));
  }

  void FillHeader() {
    SoftHeader& h = parts_.header;
    h.input_hash = SoftBodyKey(vertices_, triangles_, options_);
    h.tet_count = report_.tets;
    h.patch_radius_m = radius_m_;
    h.poisson_ratio = options_.moduli.poisson_ratio;
    h.hardening = options_.hardening;
    h.relaxing_share = options_.relaxation_time_s > 0 ? options_.relaxing_share : 0;
    h.relaxation_time_s = options_.relaxation_time_s;
  }

  std::span<const Vec3> vertices_;
  std::span<const std::array<std::uint32_t, 3>> triangles_;
  const SoftBodyOptions& options_;
  SoftBuildReport& report_;
  Clock::time_point start_ = Clock::now();
  QuadraticMesh mesh_;
  double cell_m_ = 0, radius_m_ = 0;
  std::vector<std::uint32_t> surface_nodes_;
  std::vector<PatchLoad> loads_;
  SoftParts parts_;
};

}  // namespace

std::uint64_t SoftBodyKey(std::span<const Vec3> vertices, std::span<const std::array<std::uint32_t, 3>> triangles,
                          const SoftBodyOptions& o) {
  const double numbers[] = {static_cast<double>(kSoftVersion),
                            o.moduli.young_modulus_Pa,
                            o.moduli.poisson_ratio,
                            o.moduli.fibre_ratio,
                            o.fibre.x,
                            o.fibre.y,
                            o.fibre.z,
                            o.fibre_field ? 1.0 : 0.0,
                            static_cast<double>(o.lattice.max_tets),
                            static_cast<double>(o.lattice.max_surface_vertices),
                            o.lattice.shift_cells.x,
                            o.lattice.shift_cells.y,
                            o.lattice.shift_cells.z,
                            o.clamped_share,
                            o.hardening,
                            o.relaxing_share,
                            o.relaxation_time_s};
  std::uint64_t hash = SoftHash(std::as_bytes(std::span(numbers)));
  hash = SoftHash(std::as_bytes(std::span(&o.fibre_field_id, 1)), hash);
  hash = SoftHash(std::as_bytes(vertices), hash);
  return SoftHash(std::as_bytes(triangles), hash);
}

base::Result<SoftBody> BuildSoftBody(std::span<const Vec3> vertices,
                                     std::span<const std::array<std::uint32_t, 3>> triangles,
                                     const SoftBodyOptions& options, SoftBuildReport& report) {
  const base::Status checked = CheckSoftOptions(options);
  if (!checked.ok()) return base::Error{checked.error()};
  report = {};
  return SoftBuilder(vertices, triangles, options, report).Run();
}

}  // namespace omni::haptics
