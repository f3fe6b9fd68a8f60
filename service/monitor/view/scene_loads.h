// Loads scene files for drawing on a thread of its own, one after another: the page goes on meanwhile.
#pragma once

#include <future>
#include <memory>
#include <optional>
#include <string>

#include "service/base/result.h"
#include "service/monitor/view/scene_view.h"

namespace omni::monitor {

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
