#include "service/tools/hand/person.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <nlohmann/json.hpp>

#include "service/tools/common/output.h"
#include "service/tools/common/service_link.h"
#include "service/tools/hand/race_task.h"
#include "service/tools/hand/touch_task.h"

namespace omni::tools {
namespace {

constexpr std::int64_t kForgotten_ns = 300'000'000;   // an older pose is no pen
constexpr std::int64_t kAskAgain_ns = 50'000'000;     // after an answer
constexpr std::int64_t kNoAnswer_ns = 1'000'000'000;  // it will not come

}  // namespace

Eyes::Eyes(const std::string& socket_path, const LookFor& look_for)
    : connection_({.role = protocol::ClientRole::kMonitor,
                   .application = "omni twin hand",
                   .engine = "",
                   .socket_path = socket_path,
                   .retry_interval_ns = 100'000'000}),
      look_for_(look_for) {
  if (look_for.soft) connection_.RequestSurfaces(true);
}

Perceived Eyes::Observe(std::int64_t now_ns) {
  connection_.Poll(now_ns);
  connection_.SignalAlive();
  seen_.t_s = static_cast<double>(now_ns) * 1e-9;
  SeePen(now_ns);
  if (look_for_.soft) SeeSoftBodies();
  if (look_for_.clay) AskForStrokes(now_ns);
  return seen_;
}

void Eyes::SeePen(std::int64_t now_ns) {
  const auto state = connection_.state();
  protocol::ToolSample sample;
  seen_.pen = state != nullptr && state->ReadNewest(sample) && (sample.flags & protocol::kToolTracked) != 0 &&
              now_ns - sample.t_ns < kForgotten_ns;
  if (!seen_.pen) return;
  const auto& p = sample.position_base_m;
  seen_.tip_base_m = {p[0], p[1], p[2]};
  protocol::ContactSnapshot contacts;
  if (state->ReadContacts(contacts)) {
    seen_.press_N = 0;
    for (std::uint32_t i = 0; i < contacts.count; ++i) seen_.press_N += contacts.contacts[i].normal_force_N;
  }
  protocol::InputSnapshot inputs;
  if (state->ReadInputs(inputs)) {
    seen_.select_presses = inputs.components[static_cast<std::size_t>(protocol::InputIndex::kSelect)].press_count;
  }
  protocol::VehicleSnapshot car;
  if (!state->ReadVehicle(car)) return;
  const auto& c = car.position_base_m;
  seen_.car = {car.on != 0, {c[0], c[1], c[2]}, car.heading_rad, car.speed_m_s, car.laps, car.hits};
}

void Eyes::SeeSoftBodies() {
  if (connection_.surfaces() != surfaces_) {
    surfaces_ = connection_.surfaces();
    copies_.clear();
    if (surfaces_ != nullptr) copies_.resize(surfaces_->object_count());
  }
  seen_.soft = false;
  seen_.dent_m = 0;
  for (std::size_t i = 0; i < copies_.size(); ++i) {
    if ((surfaces_->object(i).flags & protocol::kSurfaceSoft) == 0) continue;
    seen_.soft = true;
    surfaces_->Read(i, copies_[i]);
    seen_.dent_m = std::max(seen_.dent_m, copies_[i].frame.largest_displacement_m);
  }
}

void Eyes::AskForStrokes(std::int64_t now_ns) {
  if (const auto answer = connection_.PopSceneAnswer(); answer && answer->number == asked_) {
    asked_ = 0;
    const nlohmann::json edits = ParseJsonOrNull(answer->text);
    seen_.clay = answer->done && edits.is_object();
    seen_.strokes = 0;
    seen_.stroke_open = false;
    for (const nlohmann::json& object : ArrayAt(edits, "/objects")) {
      seen_.strokes += static_cast<std::uint32_t>(std::max(0.0, NumberAt(object, "/strokes")));
      seen_.stroke_open |= TrueAt(object, "/stroke_open");
    }
  }
  if (now_ns - asked_ns_ < (asked_ == 0 ? kAskAgain_ns : kNoAnswer_ns)) return;
  asked_ = connection_.SendSceneCommand(protocol::SceneAction::kEdits, 0, "");
  asked_ns_ = now_ns;
}

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
