#include "service/haptics/sculpt/sculpt_editor.h"

#include "service/haptics/sculpt/mesh/region.h"
#include "service/haptics/sculpt/sculpt_query.h"

namespace omni::haptics::sculpt {
namespace {

using base::Error;

constexpr double kEdgesPerRadius = 6;  // at least, so that the falloff has a shape
constexpr double kRemeshShare = 0.2;   // of the shortest edge: offset after which lengths are checked again
constexpr int kMaxSteps = 256;         // per MoveTo; the remainder is done by the next

std::string Millimetres(double m) { return std::to_string(1e3 * m) + " mm"; }

double MeanEdge(const PagedMesh& mesh) {
  double sum_m = 0;
  std::size_t count = 0;
  for (std::uint32_t page = 0; page < mesh.page_count(); ++page) {
    for (std::uint32_t slot = 0; slot < kPageTriangles; ++slot) {
      if (!UsesTriangle(mesh.GetPage(page).content, slot)) continue;
      const Corners c = mesh.TriangleCorners(IndexOf(page, slot));
      sum_m += Norm(c[1] - c[0]) + Norm(c[2] - c[1]) + Norm(c[0] - c[2]);
      count += 3;
    }
  }
  return sum_m / static_cast<double>(count);
}

Vec3 Mirrored(const SymmetryPlane& plane, const Vec3& v) {
  const Vec3 n = Normalized(plane.normal);
  return v - 2 * Dot(v, n) * n;
}

}  // namespace

base::Result<std::unique_ptr<SculptEditor>> SculptEditor::Make(const Mesh& mesh, const SculptOptions& options) {
  if (!(options.detail_m >= 0 && options.detail_m <= 1)) return Error{"sculpting: detail_m must be in [0, 1] m"};
  if (!(options.grid_step_m >= 0 && options.grid_step_m <= 0.1)) {
    return Error{"sculpting: grid_step_m must be in [0, 0.1] m"};
  }
  auto paged = PagedMesh::Make(mesh, options.object);
  if (!paged.ok()) return Error{paged.error()};
  std::unique_ptr<SculptEditor> editor(new SculptEditor(std::move(*paged)));
  editor->options_ = options;
  if (options.detail_m == 0) editor->options_.detail_m = MeanEdge(*editor->mesh_);
  return editor;
}

base::Status SculptEditor::CheckBrush(const Brush& brush) const {
  if (in_stroke()) return Error{"sculpting: a stroke is open, end it first"};
  if (!(brush.radius_m >= kLeastRadius_m && brush.radius_m <= kLargestRadius_m)) {
    return Error{"sculpting: brush radius " + Millimetres(brush.radius_m) + ", must be from " +
                 Millimetres(kLeastRadius_m) + " to " + Millimetres(kLargestRadius_m)};
  }
  const SymmetryPlane& plane = brush.symmetry;
  if (plane.enabled &&
      !(Norm(plane.normal) > 0 && IsWithin(plane.normal, 1e3) && IsWithin(plane.point_base_m, kMaxCoordinate_m))) {
    return Error{"sculpting: the symmetry plane needs a point within " + std::to_string(kMaxCoordinate_m) +
                 " m and a normal that is not zero"};
  }
  return base::Ok{};
}

// One side of the stroke. `normal` zero: take the region's own, else use it.
void SculptEditor::AddPart(const SurfacePoint& at, const Brush& brush, double long_m, Vec3& normal,
                           double& mean_edge_m) {
  SurfacePoint here = at;
  here.triangle = RefineBall(*mesh_, at, brush.radius_m, long_m, region_, report_.remesh);
  const Weighted ball = WeighBall(*mesh_, here, brush);
  if (normal == Vec3{}) normal = ball.mean_normal;
  mean_edge_m = ball.mean_edge_m;
  for (const GeodesicVertex& v : ball.vertices) region_.Add(v.vertex, v.distance_m, v.distance_m * normal);
}

base::Status SculptEditor::Begin(const SurfacePoint& at, const Brush& brush) {
  const base::Status checked = CheckBrush(brush);
  if (!checked.ok()) return checked;
  if (!mesh_->IsLive(at.triangle) || !IsWithin(at.position, kMaxCoordinate_m)) {
    return Error{"sculpting: no surface where the stroke begins"};
  }
  region_ = {};
  report_ = {};
  offset_m_ = remeshed_offset_m_ = 0;
  moved_ = false;
  const double target_m = std::max(kLeastEdge_m, std::min(options_.detail_m, brush.radius_m / kEdgesPerRadius));
  mesh_->BeginStep();
  Vec3 normal;
  double mean_edge_m = 0;
  const SymmetryPlane& plane = brush.symmetry;
  const Vec3 twin = plane.point_base_m + Mirrored(plane, at.position - plane.point_base_m);
  const SurfacePoint other = plane.enabled ? Locate(twin, brush.radius_m) : SurfacePoint{};
  AddPart(at, brush, kLongEdge * target_m, normal, mean_edge_m);
  Vec3 twin_normal = Mirrored(plane, normal);
  if (other.triangle != kNoIndex) AddPart(other, brush, kLongEdge * target_m, twin_normal, mean_edge_m);
  edges_ = {kLongEdge * target_m, std::max(kTooShort_m, kShortEdge * std::min(target_m, mean_edge_m))};
  report_.vertices = region_.size();
  patch_ = PatchOf(*mesh_, region_);
  if (region_.size() > 0) return base::Ok{};
  mesh_->Apply(mesh_->EndStep());  // takes the refinement back
  return Error{"sculpting: no vertex within " + Millimetres(brush.radius_m) + " would move, or more than " +
               std::to_string(kMaxRegionVertices) + "; change the radius"};
}

void SculptEditor::Step(double offset_m) {
  moved_ = true;
  report_.held_back += DisplaceVertices(*mesh_, region_, patch_, offset_m - offset_m_);
  offset_m_ = offset_m;
  if (std::abs(offset_m_ - remeshed_offset_m_) < kRemeshShare * edges_.short_m) return;
  Remesh(*mesh_, edges_, region_, patch_, report_.remesh);
  remeshed_offset_m_ = offset_m_;
}

void SculptEditor::MoveTo(double offset_m) {
  if (!in_stroke() || !(std::abs(offset_m) < 1e9)) return;
  offset_m = std::clamp(offset_m, -kLargestOffset_m, kLargestOffset_m);
  for (int k = 0; k < kMaxSteps && offset_m_ != offset_m; ++k) {
    const double most_m = std::max(LongestStep(*mesh_, region_, patch_), kRemeshShare * edges_.short_m);
    Step(offset_m_ + std::clamp(offset_m - offset_m_, -most_m, most_m));
  }
}

void SculptEditor::End() {
  if (!in_stroke()) return;
  if (options_.grid_step_m > 0) MoveTo(options_.grid_step_m * std::round(offset_m_ / options_.grid_step_m));
  if (!moved_) {
    mesh_->Apply(mesh_->EndStep());  // takes the refinement back
    return;
  }
  report_.vertices = region_.size();
  report_.triangles = patch_.size();
  CoarsenStroke(*mesh_, 2 * options_.detail_m, region_, report_.remesh);
  CloseStep();
}

void SculptEditor::CloseStep() {
  for (std::size_t i = done_; i < steps_.size(); ++i) undo_bytes_ -= steps_[i].bytes();
  steps_.resize(done_);
  restored_ = std::min(restored_, done_);
  steps_.push_back(mesh_->EndStep());
  undo_bytes_ += steps_.back().bytes();
  ++done_;
  if (log_) log_(EditKind::kStroke, steps_.back());
}

base::Status SculptEditor::Stroke(const SurfacePoint& at, const Brush& brush, double offset_m) {
  const base::Status begun = Begin(at, brush);
  if (!begun.ok()) return begun;
  MoveTo(offset_m);
  End();
  return base::Ok{};
}

// False: a step of a history that leads nowhere; it is taken back.
bool SculptEditor::Apply(std::size_t step) {
  mesh_->Apply(steps_[step]);
  if (step >= restored_ || ProblemWithMesh().empty()) return true;
  mesh_->Apply(steps_[step]);
  return false;
}

bool SculptEditor::Undo() {
  if (in_stroke() || done_ == 0 || !Apply(done_ - 1)) return false;
  --done_;
  if (log_) log_(EditKind::kUndo, steps_[done_]);
  return true;
}

bool SculptEditor::Redo() {
  if (in_stroke() || done_ == steps_.size() || !Apply(done_)) return false;
  ++done_;
  if (log_) log_(EditKind::kRedo, steps_[done_ - 1]);
  return true;
}

std::string SculptEditor::ProblemWithMesh() const {
  return ProblemWithPages(TableOf(*mesh_).data(), mesh_->page_count(), limits_);
}

base::Status SculptEditor::Restore(EditHistory history) {
  if (in_stroke() || !steps_.empty()) return Error{"sculpting: edits are restored before the first one"};
  std::uint32_t pages = mesh_->page_count();
  bool well_formed = history.done <= history.steps.size() && IsWellFormed(history.base, pages);
  for (const UndoStep& step : history.steps) well_formed = well_formed && IsWellFormed(step, pages);
  if (!well_formed) return Error{"sculpting: a kept edit names pages that there are not"};
  limits_ = LimitsOf(TableOf(*mesh_).data(), mesh_->page_count());
  const auto apply = [&] {
    mesh_->Apply(history.base);
    for (std::size_t i = 0; i < history.done; ++i) mesh_->Apply(history.steps[i]);
  };
  apply();
  if (const std::string problem = ProblemWithMesh(); !problem.empty()) {
    apply();  // exclusive-or: in any order it is its own inverse
    return Error{"sculpting: the kept edits do not lead to a surface: " + problem};
  }
  steps_ = std::move(history.steps);
  done_ = history.done;
  restored_ = steps_.size();
  for (const UndoStep& step : steps_) undo_bytes_ += step.bytes();
  return base::Ok{};
}

SurfacePoint SculptEditor::Locate(const Vec3& p, double reach_m) const {
  if (!IsWithin(p, kMaxCoordinate_m)) return {};
  mesh_->FitTrees();
  const NearestResult nearest = NearestInTree(mesh_->SurfaceNow(), 0, p, reach_m);
  return {nearest.triangle, nearest.closest.point};
}

Mesh SnapshotOf(const PageView& pages, std::uint32_t page_count) {
  Mesh mesh;
  IndexMap vertex, triangle;
  for (std::uint32_t page = 0; page < page_count; ++page) {
    const PageContent& content = pages.GetPage(page).content;
    for (std::uint32_t slot = 0; slot < kPageVertices; ++slot) {
      if (!UsesVertex(content, slot)) continue;
      vertex.Set(IndexOf(page, slot), static_cast<std::uint32_t>(mesh.vertices.size()));
      mesh.vertices.push_back(content.vertex[slot]);
    }
    for (std::uint32_t slot = 0; slot < kPageTriangles; ++slot) {
      if (!UsesTriangle(content, slot)) continue;
      const Triangle& t = content.triangle[slot];
      triangle.Set(IndexOf(page, slot), static_cast<std::uint32_t>(mesh.triangles.size()));
      mesh.triangles.push_back({t.vertex[0], t.vertex[1], t.vertex[2]});
      mesh.neighbours.push_back({t.neighbour[0], t.neighbour[1], t.neighbour[2]});
      mesh.material.push_back(static_cast<std::uint16_t>(t.material));
      mesh.component.push_back(t.component);
    }
  }
  for (auto& t : mesh.triangles) {
    for (std::uint32_t& v : t) v = vertex.Find(v);
  }
  for (auto& neighbours : mesh.neighbours) {
    for (std::uint32_t& t : neighbours) t = triangle.Find(t);
  }
  return mesh;
}

}  // namespace omni::haptics::sculpt
