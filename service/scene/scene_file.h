// glTF file -> haptics::SceneInput; only what haptics needs is read.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "service/base/result.h"
#include "service/base/vec.h"
#include "service/base/work_watch.h"
#include "service/haptics/scene/scene_input.h"

namespace omni::scene {

class FilesBeside {
 public:
  virtual ~FilesBeside() = default;
  // A descriptor for the caller, of the file with this name (IsPathBeneath). Throws LoadError.
  virtual int OpenBeside(const std::string& name) = 0;
};

struct LoadOptions {
  bool all_kinematic = false;   // every node may be moved, whatever its tag says
  int memory = -1;              // descriptor of the document, which must not change any more; stays the caller's. The
                                // path is its name then, for messages, and no file is opened by us. < 0: none
  bool touch_untagged = false;  // a file without any haptic tag is touched as a whole, with the default material
  bool z_up = false;            // the file's z axis is up, and its x axis to the right: not what glTF says
  bool fit = false;             // scale and move into reach: what is touched lies 5-30 mm above the hull
  base::Vec3 offset_base_m;
  double scale = 1;
  double hull_radius_m = 0.0375;
  double tip_radius_m = 0.0015;            // of the pen, where the scene does not say tip.radius; 0: a point
  const base::WorkWatch* watch = nullptr;  // outlives the load, which it can end: the error "cancelled"
  std::uint64_t max_file_bytes = 1ull << 30;
  FilesBeside* beside = nullptr;  // with `memory`: those beside the document; null: there are none
  std::uint32_t max_nodes = 100'000;
  std::uint32_t max_depth = 64;  // of the node hierarchy; deeper or cyclic: refused
  std::string tags_by_name;  // JSON, {"clay": {"stiffness": 300}}: haptic tags of nodes and materials of these names
};

// One row per item of the file, for `omni scene explain`.
struct ExplainRow {
  std::string pointer;  // JSON pointer, e.g. /meshes/0
  std::string name;
  bool loaded = false;
  std::string why;          // why it is on or off
  std::uint64_t bytes = 0;  // read from the file for it
};

// The node that an object comes from.
struct ObjectSource {
  std::int32_t node = -1;                                // index in the document; -1: several were joined
  std::array<double, 4> rest_rotation_wxyz{1, 0, 0, 0};  // node in the document's frame (y up), unit, without its scale
  std::array<double, 3> rest_position_m{};
};
// Which haptic material a primitive has at a node.
struct MaterialUse {
  std::uint32_t mesh = 0, primitive = 0;  // in the document
  std::uint16_t material = 0;             // of SceneInput::materials
};

struct LoadReport {
  std::vector<ObjectSource> objects;  // one per object of the scene
  std::vector<ExplainRow> rows;
  std::vector<std::string> warnings;  // unknown keys, clamped values: file, JSON pointer, value, range
  std::uint64_t file_bytes = 0;
  std::uint64_t bytes_read = 0;
  std::uint32_t images_decoded = 0;  // by this load: none when it came from the cache
  bool skipped = false;              // the file has no haptic tag: nothing is touched, only its JSON was read
  double fit_scale = 1;              // applied by `fit`
  double load_ms = 0;                // LoadScene: from the path to the scene
  bool cached = false;               // LoadScene: taken from the cache, not built
  std::string cache;                 // LoadScene: what the cache did, in words
  // LoadSceneFile: not kept in the cache.
  std::vector<MaterialUse> material_uses;  // of what is touched
  std::string vehicle;                     // name of the node that is the car; empty: there is none
  double placed_scale = 1;                 // by all options: x_base = placed_scale x + placed_offset_m, x: as authored
  base::Vec3 placed_offset_m;
};

// Frame: glTF is y up, right handed, metres; base frame is z up: (x, y, z)_B = (x, -z, y)_glTF. The glTF origin is the
// base's core centre. A file that is skipped (see LoadReport) gives an input without objects. Errors: "<file>: <JSON
// pointer>: what, limit, what to do".
base::Result<haptics::SceneInput> LoadSceneFile(const std::string& path, const LoadOptions& options,
                                                LoadReport& report);

}  // namespace omni::scene
