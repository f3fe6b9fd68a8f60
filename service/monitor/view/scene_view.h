// A scene file as the page draws it: what there is to see, and which of it is touched.
#pragma once

#include <array>
#include <cstdint>
#include <future>
#include <memory>
#include <optional>
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
  bool touch_untagged = false, z_up = false;  // how it was read
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

// Loads scene files for drawing on a thread of its own, one after another: the page goes on meanwhile.
struct SceneFileRequest {
  std::uint32_t number = 0;  // comes back
  std::string path, name;
  scene::LoadOptions options;
  bool fit_untagged = false;  // as LoadSceneView's
};

struct LoadedView {
  std::uint32_t number = 0;
  std::shared_ptr<const SceneView> view;  // null: failed
  std::string error;
};

class SceneLoads {
 public:
  // Replaces a request that has not begun.
  void Request(SceneFileRequest request) { wanted_ = std::move(request); }
  // A finished one, if any; begins the next. Does not wait.
  std::optional<LoadedView> Poll();

 private:
  std::optional<SceneFileRequest> wanted_;
  std::future<LoadedView> running_;  // its destructor waits for the thread
};

}  // namespace omni::monitor
