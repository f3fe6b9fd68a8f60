// Is a paged mesh what every reader relies on: closed, oriented, 2-manifold, positive areas? Checks everything; for
// pages that come from a file, tests and benchmarks.
#pragma once

#include <string>
#include <vector>

#include "service/haptics/sculpt/mesh/page.h"

namespace omni::haptics::sculpt {

struct ManifoldReport {
  bool ok() const noexcept { return problem.empty(); }
  std::string problem;  // the first one found; empty: none
  std::uint32_t triangles = 0, vertices = 0;
  double least_area_m2 = 0;
  double least_shape = 0;  // 2 area / longest edge^2 of the worst triangle; equilateral: 0.87
};

ManifoldReport CheckManifold(const Page* const* pages, std::uint32_t page_count);

// What triangles may say besides where they are; of the mesh that is sculpted.
struct PageLimits {
  std::uint32_t object = 0;
  std::uint32_t components = 0;
  std::vector<std::uint16_t> materials;  // sorted, each once
};
PageLimits LimitsOf(const Page* const* pages, std::uint32_t page_count);

// Why these pages, whatever their bytes are, must not be used by the editor or the tick; empty: they may.
std::string ProblemWithPages(const Page* const* pages, std::uint32_t page_count, const PageLimits& limits);

// For whatever has GetPage() and page_count().
template <class M>
std::vector<const Page*> TableOf(const M& mesh) {
  std::vector<const Page*> pages;
  for (std::uint32_t page = 0; page < mesh.page_count(); ++page) pages.push_back(&mesh.GetPage(page));
  return pages;
}
template <class M>
ManifoldReport CheckManifold(const M& mesh) {
  return CheckManifold(TableOf(mesh).data(), mesh.page_count());
}

}  // namespace omni::haptics::sculpt
