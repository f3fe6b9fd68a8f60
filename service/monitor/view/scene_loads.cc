#include "service/monitor/view/scene_loads.h"

#include <chrono>
#include <utility>

namespace omni::monitor {
namespace {

LoadedView Load(const SceneFileRequest& request) {
  LoadedView loaded{.number = request.number};
  scene::LoadOptions options = request.options;
  if (request.fit_untagged) {
    scene::LoadReport report;
    const auto tagged = scene::LoadSceneFile(request.path, options, report);
    if (!tagged.ok()) {
      loaded.error = tagged.error();
      return loaded;
    }
    loaded.touch_untagged = options.touch_untagged = options.fit = report.skipped;
  }
  auto view = LoadSceneView(request.path, request.name, options);
  if (view.ok()) {
    loaded.view = std::make_shared<const SceneView>(std::move(*view));
  } else {
    loaded.error = view.error();
  }
  return loaded;
}

}  // namespace

std::optional<LoadedView> SceneLoads::Poll() {
  std::optional<LoadedView> finished;
  if (running_.valid()) {
    if (running_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return std::nullopt;
    finished = running_.get();
  }
  if (wanted_) {
    running_ = std::async(std::launch::async, Load, *std::exchange(wanted_, std::nullopt));
  }
  return finished;
}

}  // namespace omni::monitor
