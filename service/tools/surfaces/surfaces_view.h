// What `omni surfaces` shows: a pure function of what was read.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace omni::tools {

struct SurfaceRow {
  std::string name;
  std::uint32_t flags = 0;  // protocol::SurfaceFlag
  std::uint32_t vertices = 0, triangles = 0;
  double changes_Hz = 0;
  double largest_displacement_m = 0;
  double translation_m = 0;  // how far its application has moved it
};

struct SurfacesView {
  bool connected = false;
  std::string problem;    // why not, and what to do
  bool answered = false;  // by the service
  bool has_memory = false;
  std::uint64_t scene_generation = 0, memory_generation = 0, bytes = 0;
  double poll_Hz = 0;
  std::vector<SurfaceRow> rows;
};

// Lines, each ending with a newline.
std::string SurfacesText(const SurfacesView& view);
// The same of an answer; "objects" is empty where nothing changes.
nlohmann::ordered_json SurfacesJson(const SurfacesView& view);

}  // namespace omni::tools
