// The editor's side of a sculpted mesh: writing copies a page the first time after a publish (copy on write), and what
// a stroke changed can be taken back bit by bit. One thread. docs/theory/sculpting.md, section 1.
#pragma once

#include <cstring>
#include <deque>
#include <memory>
#include <vector>

#include "service/base/result.h"
#include "service/haptics/geometry/mesh.h"
#include "service/haptics/sculpt/mesh/edit_step.h"
#include "service/haptics/sculpt/mesh/page.h"
#include "service/haptics/sculpt/publisher.h"

namespace omni::haptics::sculpt {

// Pages of one editor: taken, retired while a reader may still see them, and used again.
class PagePool {
 public:
  // Contents undefined.
  Page* Take() {
    if (free_.empty()) Grow();
    Page* page = free_.back();
    free_.pop_back();
    return page;
  }
  // No reader uses it.
  void Give(Page* page) { free_.push_back(page); }
  // Readers of generations before `first_without` may still read it.
  void Retire(Page* page, std::uint64_t first_without) { retired_.push_back({page, first_without}); }
  // Nothing older than `oldest_in_use` is read any longer.
  void Release(std::uint64_t oldest_in_use) {
    while (!retired_.empty() && retired_.front().first_without <= oldest_in_use) {
      Give(retired_.front().page);
      retired_.pop_front();
    }
  }
  std::size_t bytes() const noexcept { return chunks_.size() * kChunk * sizeof(Page); }

 private:
  struct Retired {
    Page* page;
    std::uint64_t first_without;
  };
  static constexpr std::size_t kChunk = 16;

  void Grow() {
    chunks_.push_back(std::make_unique_for_overwrite<Page[]>(kChunk));
    for (std::size_t k = kChunk; k > 0; --k) free_.push_back(&chunks_.back()[k - 1]);
  }

  std::vector<std::unique_ptr<Page[]>> chunks_;
  std::vector<Page*> free_;
  std::deque<Retired> retired_;
};

struct PublishReport {
  bool published = false;   // false: nothing to publish, or the reader is too far behind; try again later
  std::uint32_t pages = 0;  // that went out new
};

class PagedMesh {
 public:
  // `mesh`: connected and oriented (ConnectAndOrient). Fails if it is empty, not closed, or too large. `object`: goes
  // into each triangle. Vertices where two fans of triangles meet in one point are doubled.
  static base::Result<std::unique_ptr<PagedMesh>> Make(const Mesh& mesh, std::uint32_t object);
  PagedMesh(const PagedMesh&) = delete;
  PagedMesh& operator=(const PagedMesh&) = delete;

  // Reading; a MeshView of the state being edited. References hold until the next write.
  Vec3 VertexPosition(std::uint32_t v) const noexcept { return View().VertexPosition(v); }
  const Triangle& GetTriangle(std::uint32_t t) const noexcept { return View().GetTriangle(t); }
  Corners TriangleCorners(std::uint32_t t) const noexcept { return View().TriangleCorners(t); }
  std::uint32_t FirstTriangle(std::uint32_t v) const noexcept {
    return pages_[PageOf(v)]->content.first_triangle[SlotOf(v)];
  }
  bool IsLive(std::uint32_t triangle) const noexcept {
    return PageOf(triangle) < pages_.size() && UsesTriangle(pages_[PageOf(triangle)]->content, SlotOf(triangle));
  }
  PageView View() const noexcept { return PageView(pages_.data()); }
  std::uint32_t page_count() const noexcept { return static_cast<std::uint32_t>(pages_.size()); }
  const Page& GetPage(std::uint32_t page) const noexcept { return *pages_[page]; }
  std::uint32_t triangle_count() const noexcept { return triangle_count_; }
  std::uint32_t vertex_count() const noexcept { return vertex_count_; }
  bool HasRoom() const noexcept { return pages_.size() < kMaxPages; }  // for any split

  // With the trees. Good until the next write. Precondition: FitTrees, since the last write or before those that may
  // be missed.
  SculptSurface SurfaceNow() const noexcept { return {pages_.data(), page_count(), top_.nodes().data()}; }
  void FitTrees();
  void FitChangedTrees();  // only those in which triangles were set; boxes of triangles that moved are as they were

  // As vertices are stored: in single precision, so that a file holds what is felt, bit by bit. By Veltkamp's splitting
  // of 53 bits into 24 and the rest: GCC 12 leaves out pairs of conversions to float and back where it vectorizes.
  static Vec3 AsStored(const Vec3& p) noexcept {
    const auto round = [](double x) {
      const double scaled = (0x1p29 + 1) * x;
      return scaled - (scaled - x);
    };
    return {round(p.x), round(p.y), round(p.z)};
  }

  // Writing. MoveVertex leaves it to the caller to call Moved for every triangle around the vertex.
  void MoveVertex(std::uint32_t v, const Vec3& position) { Write(PageOf(v)).vertex[SlotOf(v)] = AsStored(position); }
  void Moved(std::uint32_t triangle) { Write(PageOf(triangle)); }
  void SetTriangle(std::uint32_t t, const Triangle& triangle) {
    slots_[PageOf(t)].keep_order = false;
    Write(PageOf(t)).triangle[SlotOf(t)] = triangle;
  }
  void SetFirstTriangle(std::uint32_t v, std::uint32_t t) {
    if (FirstTriangle(v) != t) Write(PageOf(v)).first_triangle[SlotOf(v)] = t;
  }
  // In the same page as `near`, or where that one spills to. Precondition: HasRoom().
  std::uint32_t AddTriangle(std::uint32_t near, const Triangle& triangle);
  std::uint32_t AddVertex(std::uint32_t near, const Vec3& position);
  void RemoveTriangle(std::uint32_t t);
  void RemoveVertex(std::uint32_t v);

  // Between the two, what is written is remembered; End returns it.
  void BeginStep();
  UndoStep EndStep();
  bool recording() const noexcept { return recording_; }
  // What was written since BeginStep.
  UndoStep StepSoFar() const;
  // Undoes or redoes: the step's words turn either state into the other. Adds the pages it names. Precondition:
  // !recording(), IsWellFormed.
  void Apply(const UndoStep& step);

  // Fits the trees and makes the present state the newest generation.
  PublishReport Publish();
  SculptPublisher& publisher() noexcept { return publisher_; }
  const SculptPublisher& publisher() const noexcept { return publisher_; }

  // Of positions, connections and slots, for tests: equal states have equal hashes.
  std::uint64_t Hash() const noexcept;
  std::size_t page_bytes() const noexcept { return pool_.bytes(); }

 private:
  struct Slot {
    Page* before = nullptr;    // state at BeginStep; null: not written since
    bool before_seen = false;  // it was published
    bool writable = false;     // not published yet
    bool keep_order = false;   // the tree's grouping is still right
    bool fitted = false;       // the tree holds the triangles as they are
  };
  PagedMesh() = default;
  friend class PageBuilder;

  PageContent& Write(std::uint32_t page) {
    Slot& slot = slots_[page];
    if (!slot.writable || (recording_ && slot.before == nullptr)) MakeWritable(page);
    if (slot.fitted) unfitted_.push_back(page);
    slot.fitted = false;
    return pages_[page]->content;
  }
  void MakeWritable(std::uint32_t page);
  void FitTree(std::uint32_t page);
  std::uint32_t NewPage(std::uint32_t near_page);
  std::uint32_t EmptyPageFor(std::uint32_t near_page);
  template <class Full>
  std::uint32_t PageWithRoom(std::uint32_t page, Full full);
  void CountAgain(std::uint32_t page, int sign) noexcept;

  PagePool pool_;
  SculptPublisher publisher_;
  std::vector<Page*> pages_;
  std::vector<Slot> slots_;
  std::vector<std::uint32_t> dirty_;     // writable pages, each once
  std::vector<std::uint32_t> unfitted_;  // pages that are not fitted, each once
  std::vector<std::uint32_t> touched_;   // pages with a `before`, each once
  std::vector<std::uint32_t> empty_;     // pages that were empty when put here
  TopTree top_;
  bool recording_ = false;
  std::uint32_t triangle_count_ = 0, vertex_count_ = 0;
};

}  // namespace omni::haptics::sculpt
