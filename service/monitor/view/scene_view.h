// A scene file as the page draws it: what there is to see, and which of it is touched.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "service/base/material.h"
#include "service/base/result.h"
#include "service/monitor/page/page_messages.h"
#include "service/scene/scene_file.h"

namespace omni::monitor {

struct ViewPart {
  std::string name;            // of the node
  std::int32_t object = -1;    // of the scene that is touched; -1: only to be seen
  std::uint32_t material = 0;  // of that object
  DrawnShape shape;
};

struct ViewMaterial {
  std::string name;  // of the objects that have it
  base::MaterialParameters values;
};

struct SceneView {
  std::string name;  // for people: "dragon.glb"
  std::string path;
  bool touch_untagged = false;  // how it was read
  std::vector<ViewPart> parts;
  std::vector<ViewMaterial> materials;
  // Where `options` have put it: x_base = scale x + offset_m, x: as authored, in the base frame.
  double scale = 1;
  base::Vec3 offset_m;
};

// As omnid loads it with the same options. `fit_untagged`: a file without haptic tags is touched as a whole, scaled and
// moved into reach. Errors: "<file>: <JSON pointer>: what, limit, what to do". Takes as long as
// the file is large.
base::Result<SceneView> LoadSceneView(const std::string& path, const std::string& name,
                                      const scene::LoadOptions& options, bool fit_untagged = false);

}  // namespace omni::monitor
