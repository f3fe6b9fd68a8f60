#include "service/tools/hand/person.h"

#include <algorithm>
#include <utility>

#include "service/tools/hand/race_task.h"
#include "service/tools/hand/touch_task.h"

namespace omni::tools {

base::Result<Intent> IntentFor(const haptics::Scene& scene, const PlaceOptions& options) {
  if (!scene.empty() && scene.header().has_vehicle != 0 && scene.header().has_joystick != 0) {
    auto line = TrackLine::Find(scene);
    if (!line.ok()) return base::Error{line.error()};
    return Intent{.task = std::make_unique<RaceTask>(scene.header(), std::move(*line))};
  }
  const std::vector<TouchPlace> places = FindTouchPlaces(scene, options);
  if (places.empty()) return base::Error{NothingWithinReach(options)};
  std::vector<Touch> touches = TouchesOf(scene, places);
  const auto has = [&touches](TouchKind kind) {
    return std::any_of(touches.begin(), touches.end(), [kind](const Touch& touch) { return touch.kind == kind; });
  };
  Intent intent{.soft = has(TouchKind::kSoft), .clay = has(TouchKind::kClay)};
  intent.task = std::make_unique<TouchTask>(std::move(touches));
  return intent;
}

}  // namespace omni::tools
