// A mesh into pages: triangles that lie together go together.
#include <algorithm>
#include <numeric>

#include "service/haptics/sculpt/mesh/paged_mesh.h"
#include "service/haptics/sculpt/mesh/trees.h"

namespace omni::haptics::sculpt {
namespace {

using base::Error;

base::Status CheckMesh(const Mesh& mesh) {
  const std::size_t n = mesh.triangles.size();
  if (n == 0) return Error{"sculpting: the mesh has no triangles"};
  if (n > kMaxTriangles) {
    return Error{"sculpting: " + std::to_string(n) + " triangles, the limit is " + std::to_string(kMaxTriangles)};
  }
  std::size_t open = 0;
  for (const auto& neighbours : mesh.neighbours) {
    for (const std::uint32_t other : neighbours) open += other == kNoIndex;
  }
  if (open == 0) return base::Ok{};
  return Error{"sculpting: " + std::to_string(open) +
               " edges have no second triangle; only closed meshes can be sculpted, close the holes"};
}

}  // namespace

// One vertex per fan: where two fans of triangles touch in one vertex, the later one gets a copy of it.
struct FanVertices {
  std::vector<Vec3> position;
  std::vector<std::array<std::uint32_t, 3>> corner;  // per triangle

  explicit FanVertices(const Mesh& mesh) : corner(mesh.triangles.size(), {kNoIndex, kNoIndex, kNoIndex}) {
    position.reserve(mesh.vertices.size());
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      for (std::size_t k = 0; k < 3; ++k) {
        if (corner[t][k] == kNoIndex) TakeFan(mesh, t, k);
      }
    }
    Store();
  }

 private:
  void TakeFan(const Mesh& mesh, std::uint32_t t, std::size_t k) {
    const std::uint32_t vertex = mesh.triangles[t][k];
    while (corner[t][k] == kNoIndex) {
      corner[t][k] = static_cast<std::uint32_t>(position.size());
      t = mesh.neighbours[t][k];
      const auto& v = mesh.triangles[t];
      k = v[0] == vertex ? 0 : (v[1] == vertex ? 1 : 2);
    }
    position.push_back(mesh.vertices[vertex]);
  }
  // As the editor stores them (PagedMesh::AsStored), but for the corners of needles that would lose their side by it.
  void Store() {
    std::vector<Vec3> exact(position);
    for (Vec3& p : position) p = PagedMesh::AsStored(p);
    for (const auto& t : corner) {
      const Corners before{exact[t[0]], exact[t[1]], exact[t[2]]};
      if (Dot(AreaVector(before), AreaVector({position[t[0]], position[t[1]], position[t[2]]})) > 0) continue;
      for (const std::uint32_t v : t) position[v] = exact[v];
    }
  }
};

// Halves along the longest side until each part fits a page; parts are filled evenly.
class Cutter {
 public:
  explicit Cutter(const Mesh& mesh) : order_(mesh.triangles.size()) {
    std::iota(order_.begin(), order_.end(), 0U);
    middle_.reserve(mesh.triangles.size());
    for (const auto& t : mesh.triangles) {
      middle_.push_back(mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]);
    }
    Cut(0, order_.size(), (order_.size() + kPageFill - 1) / kPageFill);
  }
  const std::vector<std::uint32_t>& order() const { return order_; }
  const std::vector<std::size_t>& ends() const { return ends_; }

 private:
  static double Along(const Vec3& v, int axis) { return axis == 0 ? v.x : (axis == 1 ? v.y : v.z); }

  void Cut(std::size_t begin, std::size_t end, std::size_t pages) {  // NOLINT(misc-no-recursion): log2(pages) deep
    if (pages <= 1) {
      ends_.push_back(end);
      return;
    }
    Vec3 lower = middle_[order_[begin]], upper = lower;
    for (std::size_t i = begin; i < end; ++i) {
      lower = Min(lower, middle_[order_[i]]);
      upper = Max(upper, middle_[order_[i]]);
    }
    const Vec3 d = upper - lower;
    const int axis = d.x >= d.y && d.x >= d.z ? 0 : (d.y >= d.z ? 1 : 2);
    const std::size_t left = pages / 2;
    const std::size_t middle = begin + (end - begin) * left / pages;
    const auto at = [this](std::size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
    std::nth_element(at(begin), at(middle), at(end), [&](std::uint32_t a, std::uint32_t b) {
      const double x = Along(middle_[a], axis), y = Along(middle_[b], axis);
      return x != y ? x < y : a < b;
    });
    Cut(begin, middle, left);
    Cut(middle, end, pages - left);
  }

  std::vector<std::uint32_t> order_;
  std::vector<Vec3> middle_;
  std::vector<std::size_t> ends_;
};

// Friend of PagedMesh: fills its pages directly.
class PageBuilder {
 public:
  PageBuilder(const Mesh& mesh, PagedMesh& paged) : mesh_(mesh), fans_(mesh), paged_(paged) {}

  void Run(std::uint32_t object) {
    PlaceTriangles();
    PlaceVertices();
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) FillTriangle(t, object);
    paged_.triangle_count_ = static_cast<std::uint32_t>(mesh_.triangles.size());
    paged_.vertex_count_ = static_cast<std::uint32_t>(fans_.position.size());
    std::vector<FloatBox> boxes;
    for (std::uint32_t page = 0; page < paged_.page_count(); ++page) {
      PageTree& tree = paged_.pages_[page]->tree;
      BuildPageTree(paged_.pages_.data(), page, false, tree);
      paged_.slots_[page].keep_order = paged_.slots_[page].fitted = true;
      boxes.push_back(BoxOf(tree));
    }
    paged_.top_.Build(boxes);
  }

 private:
  PageContent& Content(std::uint32_t page) { return paged_.pages_[page]->content; }

  void AddPage() {
    paged_.dirty_.push_back(paged_.page_count());
    paged_.pages_.push_back(paged_.pool_.Take());
    std::memcpy(static_cast<void*>(paged_.pages_.back()), &EmptyPage(), sizeof(Page));
    paged_.slots_.push_back({.writable = true});
  }

  void PlaceTriangles() {
    const Cutter cutter(mesh_);
    triangle_.resize(mesh_.triangles.size());
    order_ = cutter.order();
    std::size_t i = 0;
    for (const std::size_t end : cutter.ends()) {
      const std::uint32_t page = paged_.page_count();
      AddPage();
      std::sort(order_.begin() + static_cast<std::ptrdiff_t>(i), order_.begin() + static_cast<std::ptrdiff_t>(end));
      for (; i < end; ++i) {
        PageContent& content = Content(page);
        const std::uint32_t slot = content.triangle_count++;
        content.triangle_used[slot / 64] |= std::uint64_t{1} << (slot % 64);
        triangle_[order_[i]] = IndexOf(page, slot);
      }
    }
  }

  // In the first page that uses it and has room; the few that are left, where there is room at all.
  void PlaceVertices() {
    vertex_.assign(fans_.position.size(), kNoIndex);
    for (const std::uint32_t limit : {kPageVertexFill, kPageVertices}) {
      for (const std::uint32_t t : order_) {
        for (const std::uint32_t v : fans_.corner[t]) {
          if (vertex_[v] == kNoIndex && Content(PageOf(triangle_[t])).vertex_count < limit) {
            Place(v, PageOf(triangle_[t]));
          }
        }
      }
    }
    for (std::uint32_t v = 0; v < vertex_.size(); ++v) {
      if (vertex_[v] != kNoIndex) continue;
      if (Content(paged_.page_count() - 1).vertex_count == kPageVertices) AddPage();
      Place(v, paged_.page_count() - 1);
    }
  }

  void Place(std::uint32_t v, std::uint32_t page) {
    PageContent& content = Content(page);
    const std::uint32_t slot = content.vertex_count++;
    content.vertex_used[slot / 64] |= std::uint64_t{1} << (slot % 64);
    content.vertex[slot] = fans_.position[v];
    vertex_[v] = IndexOf(page, slot);
  }

  void FillTriangle(std::uint32_t t, std::uint32_t object) {
    Triangle triangle{};
    for (std::size_t k = 0; k < 3; ++k) {
      triangle.vertex[k] = vertex_[fans_.corner[t][k]];
      triangle.neighbour[k] = triangle_[mesh_.neighbours[t][k]];
      Content(PageOf(triangle.vertex[k])).first_triangle[SlotOf(triangle.vertex[k])] = triangle_[t];
    }
    triangle.object = static_cast<decltype(triangle.object)>(object);
    triangle.material = mesh_.material[t];
    triangle.component = mesh_.component[t];
    Content(PageOf(triangle_[t])).triangle[SlotOf(triangle_[t])] = triangle;
  }

  const Mesh& mesh_;
  const FanVertices fans_;
  PagedMesh& paged_;
  std::vector<std::uint32_t> order_;     // triangles of the mesh, page after page
  std::vector<std::uint32_t> triangle_;  // index in pages, per triangle of the mesh
  std::vector<std::uint32_t> vertex_;    // index in pages, per fan vertex
};

base::Result<std::unique_ptr<PagedMesh>> PagedMesh::Make(const Mesh& mesh, std::uint32_t object) {
  const base::Status checked = CheckMesh(mesh);
  if (!checked.ok()) return Error{checked.error()};
  std::unique_ptr<PagedMesh> paged(new PagedMesh());
  PageBuilder(mesh, *paged).Run(object);
  paged->Publish();
  return paged;
}

}  // namespace omni::haptics::sculpt
