#include "service/haptics/sculpt/mesh/check_manifold.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "service/haptics/geometry/topology.h"

namespace omni::haptics::sculpt {
namespace {

class Checker {
 public:
  Checker(const Page* const* pages, std::uint32_t page_count)
      : view_(pages), page_count_(page_count), uses_(page_count) {
    for (auto& uses : uses_) uses.fill(0);
  }

  ManifoldReport Run() {
    report_.least_area_m2 = report_.least_shape = std::numeric_limits<double>::infinity();
    for (std::uint32_t page = 0; page < page_count_ && report_.ok(); ++page) {
      const PageContent& content = view_.GetPage(page).content;
      std::uint32_t triangles = 0;
      for (std::uint32_t slot = 0; slot < kPageTriangles && report_.ok(); ++slot) {
        if (!UsesTriangle(content, slot)) continue;
        ++triangles;
        CheckTriangle(IndexOf(page, slot));
      }
      if (report_.ok() && triangles != content.triangle_count) Fail("triangle count of page", page);
      report_.triangles += triangles;
    }
    for (std::uint32_t page = 0; page < page_count_ && report_.ok(); ++page) CheckVertices(page);
    return report_;
  }

 private:
  void Fail(const char* what, std::uint32_t index) {
    if (report_.ok()) report_.problem = std::string(what) + " " + std::to_string(index);
  }
  bool LiveTriangle(std::uint32_t t) const {
    return PageOf(t) < page_count_ && UsesTriangle(view_.GetPage(PageOf(t)).content, SlotOf(t));
  }
  bool LiveVertex(std::uint32_t v) const {
    return PageOf(v) < page_count_ && UsesVertex(view_.GetPage(PageOf(v)).content, SlotOf(v));
  }

  void CheckTriangle(std::uint32_t t) {
    const Triangle& triangle = view_.GetTriangle(t);
    for (std::size_t k = 0; k < 3; ++k) {
      if (!LiveVertex(triangle.vertex[k])) return Fail("free vertex used by triangle", t);
      ++uses_[PageOf(triangle.vertex[k])][SlotOf(triangle.vertex[k])];
      if (!LiveTriangle(triangle.neighbour[k])) return Fail("free neighbour of triangle", t);
      // The neighbour holds this edge the other way round, and names us across it.
      const Triangle& other = view_.GetTriangle(triangle.neighbour[k]);
      const std::uint32_t a = triangle.vertex[k], b = triangle.vertex[(k + 1) % 3];
      const auto at = static_cast<std::size_t>(CornerOf(other, b));
      if (other.vertex[at] != b || other.vertex[(at + 1) % 3] != a || other.neighbour[at] != t) {
        return Fail("edge not shared with its neighbour: triangle", t);
      }
    }
    if (triangle.vertex[0] == triangle.vertex[1] || triangle.vertex[1] == triangle.vertex[2] ||
        triangle.vertex[2] == triangle.vertex[0]) {
      return Fail("vertex twice in triangle", t);
    }
    CheckShape(t);
  }

  void CheckShape(std::uint32_t t) {
    const Corners c = view_.TriangleCorners(t);
    const double longest = std::max({SquaredNorm(c[1] - c[0]), SquaredNorm(c[2] - c[1]), SquaredNorm(c[0] - c[2])});
    const double area_m2 = 0.5 * Norm(AreaVector(c));
    if (!(area_m2 > 0 && area_m2 < 1e6)) return Fail("no area: triangle", t);
    report_.least_area_m2 = std::min(report_.least_area_m2, area_m2);
    report_.least_shape = std::min(report_.least_shape, 2 * area_m2 / longest);
  }

  // All triangles that use the vertex lie in one closed fan.
  void CheckVertices(std::uint32_t page) {
    const PageContent& content = view_.GetPage(page).content;
    for (std::uint32_t slot = 0; slot < kPageVertices && report_.ok(); ++slot) {
      if (!UsesVertex(content, slot)) continue;
      ++report_.vertices;
      const std::uint32_t v = IndexOf(page, slot), start = content.first_triangle[slot];
      if (!LiveTriangle(start)) return Fail("no triangle at vertex", v);
      std::uint32_t fan = 0, current = start;
      do {
        const Triangle& t = view_.GetTriangle(current);
        const auto corner = static_cast<std::size_t>(CornerOf(t, v));
        if (t.vertex[corner] != v || fan > uses_[page][slot]) return Fail("broken fan at vertex", v);
        ++fan;
        current = t.neighbour[corner];
      } while (current != start);
      if (fan != uses_[page][slot]) return Fail("more than one fan at vertex", v);
    }
  }

  PageView view_;
  std::uint32_t page_count_;
  std::vector<std::array<std::uint32_t, kPageVertices>> uses_;
  ManifoldReport report_;
};

// Slots that are in use, counted.
template <std::size_t N>
std::uint32_t CountUsed(const std::uint64_t (&used)[N]) {
  int count = 0;
  for (const std::uint64_t word : used) count += std::popcount(word);
  return static_cast<std::uint32_t>(count);
}

bool KeepsLimits(const PageContent& content, const PageLimits& limits) {
  for (std::uint32_t slot = 0; slot < kPageTriangles; ++slot) {
    if (!UsesTriangle(content, slot)) continue;
    const Triangle& t = content.triangle[slot];
    if (t.object != limits.object || t.component >= limits.components ||
        !std::binary_search(limits.materials.begin(), limits.materials.end(), t.material)) {
      return false;
    }
  }
  std::uint32_t vertices = 0;
  for (std::uint32_t slot = 0; slot < kPageVertices; ++slot) {
    if (!UsesVertex(content, slot)) continue;
    if (!IsWithin(content.vertex[slot], kMaxCoordinate_m)) return false;
    ++vertices;
  }
  // Bits beyond the last vertex count too.
  return vertices == content.vertex_count && vertices == CountUsed(content.vertex_used);
}

// The editor follows spill links until it finds room.
bool SpillsEnd(const Page* const* pages, std::uint32_t page_count) {
  std::vector<std::uint32_t> seen_from(page_count, kNoIndex);
  for (std::uint32_t start = 0; start < page_count; ++start) {
    for (std::uint32_t page = start; page != kNoIndex; page = pages[page]->content.spill) {
      if (page >= page_count || seen_from[page] == start) return false;
      if (seen_from[page] != kNoIndex) break;
      seen_from[page] = start;
    }
  }
  return true;
}

}  // namespace

PageLimits LimitsOf(const Page* const* pages, std::uint32_t page_count) {
  PageLimits limits;
  for (std::uint32_t page = 0; page < page_count; ++page) {
    for (std::uint32_t slot = 0; slot < kPageTriangles; ++slot) {
      if (!UsesTriangle(pages[page]->content, slot)) continue;
      const Triangle& t = pages[page]->content.triangle[slot];
      limits.object = t.object;
      limits.components = std::max(limits.components, t.component + 1);
      limits.materials.push_back(t.material);
    }
  }
  std::sort(limits.materials.begin(), limits.materials.end());
  limits.materials.erase(std::unique(limits.materials.begin(), limits.materials.end()), limits.materials.end());
  return limits;
}

std::string ProblemWithPages(const Page* const* pages, std::uint32_t page_count, const PageLimits& limits) {
  const ManifoldReport manifold = CheckManifold(pages, page_count);
  if (!manifold.ok()) return manifold.problem;
  if (manifold.triangles == 0) return "no triangles";
  for (std::uint32_t page = 0; page < page_count; ++page) {
    if (!KeepsLimits(pages[page]->content, limits)) return "a value out of range in page " + std::to_string(page);
  }
  return SpillsEnd(pages, page_count) ? std::string() : "links between pages in a circle";
}

ManifoldReport CheckManifold(const Page* const* pages, std::uint32_t page_count) {
  return Checker(pages, page_count).Run();
}

}  // namespace omni::haptics::sculpt
