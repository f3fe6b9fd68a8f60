// Edits a closed mesh by strokes, each of which can be undone; publishes what the tick reads. One thread of its own,
// never the tick. docs/theory/sculpting.md.
#pragma once

#include <functional>
#include <string>
#include <utility>

#include "service/haptics/sculpt/mesh/check_manifold.h"
#include "service/haptics/sculpt/mesh/remesh.h"
#include "service/haptics/sculpt/stroke.h"

namespace omni::haptics::sculpt {

struct SculptOptions {
  double detail_m = 0;       // target edge length; 0: the mean edge of the mesh as it was loaded
  double grid_step_m = 0;    // offsets end on multiples of it; 0: no grid
  std::uint32_t object = 0;  // index of the object in its scene, goes into each triangle
};

struct StrokeReport {
  std::size_t vertices = 0;   // that move
  std::size_t triangles = 0;  // at those
  std::size_t held_back = 0;  // times a vertex was kept from turning a triangle over
  RemeshCounts remesh;
};

// A finished edit, and what it changed.
enum class EditKind : std::uint8_t { kStroke, kUndo, kRedo };
using EditLog = std::function<void(EditKind kind, const UndoStep& step)>;

// Edits of another editor of an equal mesh.
struct EditHistory {
  UndoStep base;                // cannot be undone
  std::vector<UndoStep> steps;  // the first `done` are applied, the others can be redone
  std::size_t done = 0;

  // Another one is done: what was undone cannot be redone any more.
  void Push(UndoStep step) {
    steps.resize(done++);
    steps.push_back(std::move(step));
  }
};

// Pages as plain lists: neighbours and components filled, in the order of pages.
Mesh SnapshotOf(const PageView& pages, std::uint32_t page_count);

class SculptEditor {
 public:
  static constexpr double kLeastRadius_m = 1e-4;  // of a brush
  static constexpr double kLargestRadius_m = 1;
  static constexpr double kLargestOffset_m = 1;  // of one stroke
  static constexpr double kLeastEdge_m = 2e-5;   // no stroke makes the mesh finer than this

  // Fails with a reason if the mesh is not closed or too large, or an option is out of range.
  static base::Result<std::unique_ptr<SculptEditor>> Make(const Mesh& mesh, const SculptOptions& options);

  // A stroke: Begin, any number of MoveTo, End. `at`: on the surface (Locate). Begin refines the mesh under the brush
  // (which moves nothing) and fails with a reason if the brush is out of range or its region holds no free vertex;
  // nothing is changed then.
  base::Status Begin(const SurfacePoint& at, const Brush& brush);
  // Absolute offset along the region's mean normal since Begin, clamped to +-kLargestOffset_m; not a number: ignored.
  // No stroke: ignored.
  void MoveTo(double offset_m);
  // Snaps the offset to the grid and closes the undo step.
  void End();
  // All three in one.
  base::Status Stroke(const SurfacePoint& at, const Brush& brush, double offset_m);
  bool in_stroke() const noexcept { return mesh_->recording(); }
  const StrokeReport& report() const noexcept { return report_; }  // of the newest stroke
  double offset_m() const noexcept { return offset_m_; }

  // One step back or forward; false: there is none, or a stroke is open. The number of steps has no limit: a step takes
  // undo_bytes() / steps, typically 5 to 50 kB.
  bool Undo();
  bool Redo();
  std::size_t undo_steps() const noexcept { return done_; }
  std::size_t redo_steps() const noexcept { return steps_.size() - done_; }
  std::size_t undo_bytes() const noexcept { return undo_bytes_; }

  // Is called with every edit from now on, on the editor's thread.
  void SetLog(EditLog log) { log_ = std::move(log); }
  // What the open stroke has changed so far; empty: none is open.
  UndoStep OpenStep() const { return in_stroke() && moved_ ? mesh_->StepSoFar() : UndoStep(); }
  // Before the first edit. The history may come from a file: where it does not lead to a surface that every reader can
  // use, it fails with a reason and changes nothing. Undo and Redo refuse steps that would.
  base::Status Restore(EditHistory history);

  // Nearest point of the surface being edited within `reach_m` of `p`; triangle kNoIndex: none.
  SurfacePoint Locate(const Vec3& p, double reach_m) const;

  // Makes the present state visible to the next tick.
  PublishReport Publish() { return mesh_->Publish(); }
  SculptPublisher& publisher() noexcept { return mesh_->publisher(); }
  const PagedMesh& mesh() const noexcept { return *mesh_; }
  double detail_m() const noexcept { return options_.detail_m; }
  const SculptOptions& options() const noexcept { return options_; }

  // The surface, for saving.
  Mesh Snapshot() const { return SnapshotOf(mesh_->View(), mesh_->page_count()); }

 private:
  explicit SculptEditor(std::unique_ptr<PagedMesh> mesh) : mesh_(std::move(mesh)) {}
  base::Status CheckBrush(const Brush& brush) const;
  void AddPart(const SurfacePoint& at, const Brush& brush, double long_m, Vec3& normal, double& mean_edge_m);
  void Step(double offset_m);
  void CloseStep();
  bool Apply(std::size_t step);
  std::string ProblemWithMesh() const;

  std::unique_ptr<PagedMesh> mesh_;
  SculptOptions options_;
  Region region_;
  Patch patch_;  // of region_
  EdgeRange edges_;
  double offset_m_ = 0;           // applied in this stroke
  bool moved_ = false;            // something was
  double remeshed_offset_m_ = 0;  // at the last Remesh
  StrokeReport report_;
  std::vector<UndoStep> steps_;  // the first done_ are applied
  std::size_t done_ = 0;
  std::size_t undo_bytes_ = 0;
  std::size_t restored_ = 0;  // so many of the first steps come from a history
  PageLimits limits_;         // of the mesh as it was restored
  EditLog log_;
};

}  // namespace omni::haptics::sculpt
