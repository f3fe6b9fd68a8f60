// Parts of `omni surfaces`.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "service/client/surface_reader.h"
#include "service/haptics/scene/scene_input.h"

namespace omni::tools {

// What `omni surfaces` shows: a pure function of what was read.
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

// omni surfaces --save: what omnid publishes for drawing, as a .glb file.
struct SurfacesSaveArguments {
  std::string socket;    // empty: the user's
  std::string file;      // NAME.glb
  bool largest = false;  // watch, and write the moment of the largest displacement
  bool force = false;    // replace an existing file
  double seconds = 10;   // largest: so long, or until Ctrl-C or the service's end
};

// The surfaces of one moment.
struct PublishedSurfaces {
  struct Object {
    std::string name;
    client::SurfaceCopy copy;
  };
  std::vector<Object> objects;

  // Number of the object that is displaced most; objects.size(): there is none.
  std::size_t MostDisplaced() const noexcept;
  double LargestDisplacement_m() const noexcept;
};

// As a scene of solids in the base frame, each at the pose set by its application, all of the default material. Objects
// that are published only as a pose have no surface and are omitted.
haptics::SceneInput SceneOfSurfaces(const PublishedSurfaces& surfaces);

// "1 object, 14000 vertices; largest displacement 1.234 mm (dragon) at t_ns 123"; the stamp is that of the Hall sample
// that this followed from, as in recordings.
std::string SavedText(const PublishedSurfaces& surfaces);

// The command; its exit status. Refuses, with the reason: no service, nothing published, nothing displaced (largest), a
// file that is there already. Writes all of the file or nothing.
int SaveSurfaces(const SurfacesSaveArguments& arguments);

}  // namespace omni::tools
