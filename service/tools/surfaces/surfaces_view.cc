#include "service/tools/surfaces/surfaces.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "service/protocol/surfaces/surface_memory.h"
#include "service/tools/common/output.h"

namespace omni::tools {
namespace {

struct FlagName {
  std::uint32_t flag;
  const char* name;
};
constexpr FlagName kFlagNames[] = {{protocol::kSurfaceSoft, "soft"},
                                   {protocol::kSurfaceSculpted, "sculpted"},
                                   {protocol::kSurfaceExtruded, "extruded"},
                                   {protocol::kSurfaceMoved, "moved"}};

std::string NamesOf(std::uint32_t flags) {
  std::string names;
  for (const FlagName& row : kFlagNames) {
    if ((flags & row.flag) != 0) names += (names.empty() ? "" : ", ") + std::string(row.name);
  }
  return names;
}

// A sculpted surface has no rest to be away from, and an object without vertices no shape.
bool HasRest(const SurfaceRow& row) { return row.vertices > 0 && (row.flags & protocol::kSurfaceSculpted) == 0; }

std::string DisplacementOf(const SurfaceRow& row) {
  return HasRest(row) ? Format("%.3f", row.largest_displacement_m * 1e3) : "-";
}

std::string RowText(const SurfaceRow& row, int width) {
  const bool moved = (row.flags & protocol::kSurfaceMoved) != 0;
  return Format("%-*s  %-18s  %9u  %9u  %9.1f  %10s  %8s\n", width, row.name.c_str(), NamesOf(row.flags).c_str(),
                row.vertices, row.triangles, row.changes_Hz, DisplacementOf(row).c_str(),
                moved ? Format("%.2f", row.translation_m * 1e3).c_str() : "-");
}

}  // namespace

nlohmann::ordered_json SurfacesJson(const SurfacesView& view) {
  using nlohmann::ordered_json;
  ordered_json objects = ordered_json::array();
  for (const SurfaceRow& row : view.rows) {
    ordered_json changes = ordered_json::array();
    for (const FlagName& name : kFlagNames) {
      if ((row.flags & name.flag) != 0) changes.push_back(name.name);
    }
    objects.push_back(
        {{"name", row.name},
         {"changes", std::move(changes)},
         {"vertices", row.vertices},
         {"triangles", row.triangles},
         {"changes_Hz", row.changes_Hz},
         {"largest_displacement_m", HasRest(row) ? ordered_json(row.largest_displacement_m) : ordered_json()},
         {"moved_m", row.translation_m}});
  }
  return {{"scene_generation", view.scene_generation},
          {"memory_generation", view.memory_generation},
          {"bytes", view.bytes},
          {"poll_Hz", view.poll_Hz},
          {"objects", std::move(objects)}};
}

std::string SurfacesText(const SurfacesView& view) {
  if (!view.connected) return "no service: " + view.problem + "\n";
  if (!view.answered) return "omnid has not answered yet\n";
  if (!view.has_memory) return "nothing to draw: no application's scene has a surface that changes\n";
  std::string text = Format("scene %llu, memory %llu of %.1f MB, checked %.1f times per second\n",
                            static_cast<unsigned long long>(view.scene_generation),
                            static_cast<unsigned long long>(view.memory_generation),
                            static_cast<double>(view.bytes) * 1e-6, view.poll_Hz);
  std::size_t longest = 6;
  for (const SurfaceRow& row : view.rows) longest = std::max(longest, row.name.size());
  const int width = static_cast<int>(longest);
  text += Format("%-*s  %-18s  %9s  %9s  %9s  %10s  %8s\n", width, "object", "changes", "vertices", "triangles",
                 "times/s", "largest mm", "moved mm");
  for (const SurfaceRow& row : view.rows) text += RowText(row, width);
  return text;
}

}  // namespace omni::tools
