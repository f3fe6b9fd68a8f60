#include "service/monitor/view/scene_loads.h"

#include <chrono>
#include <utility>

namespace omni::monitor {
namespace {

LoadedView Load(const SceneFileRequest& request) {
  LoadedView loaded{.number = request.number};
  auto view = LoadSceneView(request.path, request.name, request.options, request.fit_untagged);
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
