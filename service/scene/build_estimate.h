// How much memory a scene takes at most, from counts that the JSON of its file has (and the headers of the images that
// haptic tags name), before anything is decoded or built: for whoever reserves memory for a build, or refuses it.
#pragma once

#include <cstdint>
#include <vector>

namespace omni::scene {

// Of an object: a node with all its instances. Vertices as in the file, before equal ones are welded.
struct ObjectCounts {
  std::uint64_t triangles = 0, vertices = 0;
  std::uint64_t uv_triangles = 0;  // triangles, for each set of texture coordinates that is read
  bool soft = false, sculpted = false, car_wall = false;
};

struct SceneCounts {
  std::vector<ObjectCounts> objects;
  std::uint64_t json_bytes = 0, document_bytes = 0;     // text, and what it takes when parsed
  std::uint64_t nodes = 0, primitives = 0;              // reached; touched
  std::uint64_t mesh_bytes = 0;                         // stored, of touched meshes
  std::uint64_t mesh_triangles = 0, mesh_vertices = 0;  // each mesh once
  std::uint64_t mesh_uv_triangles = 0;                  // the same, for each set of texture coordinates
  std::uint64_t image_bytes = 0, texels = 0;            // stored; of all images
  std::uint64_t largest_image_samples = 0;              // texels times channels, of one image
  bool any_relief = false;
};

// Upper bounds. For some thousand triangles and more, of which repair drops few, less than twice what it is; a soft
// body is always taken for one of the largest.
struct BuildEstimate {
  std::uint64_t kept_bytes = 0;  // by the scene and its soft bodies and sculpted objects, while it is in use
  std::uint64_t peak_bytes = 0;  // while it is loaded and these are made, in addition to what the process had before
};

BuildEstimate EstimateBuild(const SceneCounts& counts);

}  // namespace omni::scene
