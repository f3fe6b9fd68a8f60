#include "service/monitor/trial/trial.h"

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <numbers>
#include <utility>

#include "service/base/clock.h"
#include "service/base/files/whole_file.h"
#include "service/base/sealed_memory.h"
#include "service/scene/material_copy.h"

namespace omni::monitor {
namespace {

// Only what a person may read in a list: no path, no control characters.
std::string ShownName(std::string_view name) {
  std::string shown;
  for (const char c : name.substr(name.find_last_of("/\\") + 1)) {
    shown += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? '_' : c;
  }
  return shown.empty() ? "dropped.glb" : shown;
}

bool SameNumbers(const base::MaterialParameters& a, const base::MaterialParameters& b) {
  return std::all_of(base::kLiveFields.begin(), base::kLiveFields.end(),
                     [&](const base::MaterialField* field) { return a.*field->live == b.*field->live; });
}

}  // namespace

Trial::Trial(const TrialOptions& options)
    : options_(options),
      connection_({.role = protocol::ClientRole::kApplication,
                   .application = kTrialName,
                   .engine = "omni",
                   .socket_path = options.socket_path,
                   .retry_interval_ns = 50'000'000}),
      hand_(options.hand_path),
      aim_limit_(options.aim_limit) {
  aim_.present = 0;
  connection_.SendSession(protocol::SessionState::kFocused);  // sent whenever it connects
}

void Trial::ChooseScene(const std::string& path, const std::string& name, bool shipped) {
  SceneFileRequest request{.number = ++requests_, .path = path, .name = name, .fit_untagged = !shipped};
  request.options.hull_radius_m = options_.hull_radius_m;
  request.options.z_up = options_.z_up && !shipped;
  loads_.Request(std::move(request));
  Lift();
  scene_ = {.number = scene_.number + 1, .revision = scene_.revision + 1, .name = name, .state = SceneState::kLoading};
}

base::Status Trial::LoadDropped(std::string_view name, std::string_view bytes) {
  const std::string path = options_.folder + "/dropped-" + std::to_string(++drops_) + ".glb";
  const base::Status written = base::WriteWholeFile(path, bytes);
  if (!written.ok()) return written;
  if (!dropped_path_.empty()) ::unlink(dropped_path_.c_str());
  dropped_path_ = path;
  ChooseScene(path, ShownName(name), false);
  return base::Ok{};
}

void Trial::Poll(std::int64_t now_ns) {
  connection_.Poll(now_ns);
  connection_.SignalAlive();
  if (const auto loaded = loads_.Poll(); loaded && loaded->number == requests_) Load(*loaded);
  if (welcomes_ != connection_.welcomes()) {
    welcomes_ = connection_.welcomes();
    SendScene();
  }
  HandleUpdates();
}

void Trial::Change(SceneState state, const std::string& text) {
  ++scene_.revision;
  scene_.state = state;
  scene_.text = text;
}

void Trial::Load(const LoadedView& loaded) {
  if (loaded.view == nullptr) return Change(SceneState::kFailed, loaded.error);
  scene_.view = loaded.view;
  scene_.materials = loaded.view->materials;
  ++scene_.revision;
  SendScene();
}

// A new document for omnid; the last one goes.
void Trial::SendScene() {
  if (scene_.view == nullptr || !connection_.connected()) return;
  const auto bytes = base::ReadFile(scene_.view->path, protocol::kMaxHapticSceneBytes);
  if (!bytes.ok()) return Change(SceneState::kFailed, bytes.error());
  const auto document = base::SealedCopy("omni-try-scene", *bytes);
  if (!document.ok()) return Change(SceneState::kFailed, document.error());
  protocol::HapticSceneLoad load;
  load.number = ++sent_number_;
  if (scene_.view->touch_untagged) load.flags = protocol::kSceneTouchUntagged;
  load.bytes = bytes->size();
  load.scale = scene_.view->scale;
  scene_.generation = 0;
  if (!connection_.Send(load, document->get())) {
    return Change(SceneState::kFailed, scene_.name + ": omnid does not take it; choose it again");
  }
  Place();
}

void Trial::Place() {
  protocol::HapticScenePlace place;
  place.number = sent_number_;
  place.flags = protocol::kPoseLeaps;
  place.t_ns = base::MonotonicNow_ns();
  place.scale = scene_.view->scale;
  const base::Vec3& offset_m = scene_.view->offset_m;
  place.pose.position_m = {offset_m.x, offset_m.y, offset_m.z};
  const bool z_up = scene_.view->z_up;  // omnid takes a document for y up: a quarter turn about x
  if (z_up) place.pose.rotation_wxyz = {std::numbers::sqrt2 / 2, -std::numbers::sqrt2 / 2, 0, 0};
  if (z_up || !(offset_m == base::Vec3{})) connection_.Send(place);
}

void Trial::HandleUpdates() {
  for (const client::HapticSceneUpdate& update : connection_.PopHapticSceneUpdates()) {
    if (update.is_table || update.state.number != sent_number_ || scene_.view == nullptr) continue;
    scene_.generation = update.state.generation;
    const SceneState state = update.state.status == protocol::HapticSceneStatus::kReady    ? SceneState::kReady
                             : update.state.status == protocol::HapticSceneStatus::kFailed ? SceneState::kFailed
                                                                                           : SceneState::kLoading;
    if (state != scene_.state || update.text != scene_.text) Change(state, update.text);
  }
}

bool Trial::SendAim(const protocol::HandAim& aim) {
  asked_aim_ = aim;
  aim_ = aim_limit_.LimitAim(aim);
  return hand_.Connect() && hand_.Send(aim_);
}

void Trial::Lift() {
  if (aim_.present == 0) return;
  asked_aim_.present = 0;
  SendAim(asked_aim_);
}

void Trial::UpdateContacts(const protocol::ToolSample& tool, const protocol::ContactSnapshot& contacts,
                           std::int64_t now_ns) {
  const double dt_s = felt_ns_ == 0 ? 0 : 1e-9 * static_cast<double>(now_ns - felt_ns_);
  felt_ns_ = now_ns;
  aim_limit_.Update(tool, contacts, std::clamp(dt_s, 0.0, 0.1));
  if (aim_.present != 0 && aim_limit_.LimitAim(asked_aim_).tip_base_m != aim_.tip_base_m) SendAim(asked_aim_);
}

bool Trial::SetMaterial(const MaterialRequest& request) {
  if (scene_.view == nullptr || scene_.state != SceneState::kReady || request.index >= scene_.materials.size() ||
      request.index >= protocol::kMaxHapticMaterials) {
    return false;
  }
  base::MaterialParameters& values = scene_.materials[request.index].values;
  for (std::size_t i = 0; i < base::kLiveFields.size(); ++i) {
    if (request.given[i]) values.*base::kLiveFields[i]->live = request.values.*base::kLiveFields[i]->live;
  }
  protocol::HapticMaterial message;
  message.number = sent_number_;
  message.material = request.index;
  message.parameters = values;
  return connection_.Send(message);
}

base::Result<std::string> Trial::MakeSceneFile(std::string_view sculpted) const {
  if (scene_.view == nullptr) return base::Error{"there is no scene"};
  std::string path = scene_.view->path;
  if (!sculpted.empty()) {
    path = options_.folder + "/copy.glb";
    const base::Status written = base::WriteWholeFile(path, sculpted);
    if (!written.ok()) return base::Error{written.error()};
  }
  scene::LoadReport report;
  const auto input = scene::LoadSceneFile(path, {.touch_untagged = scene_.view->touch_untagged}, report);
  if (!input.ok()) return base::Error{input.error()};
  // A sculpted copy numbers its materials in its own way: the same one has the same numbers.
  std::vector<scene::ChangedMaterial> changed;
  for (std::size_t i = 0; i < scene_.materials.size(); ++i) {
    const base::MaterialParameters& before = scene_.view->materials[i].values;
    if (SameNumbers(scene_.materials[i].values, before)) continue;
    for (std::size_t k = 0; k < input->materials.size(); ++k) {
      if (!SameNumbers(base::Clamped(base::ParametersOf(input->materials[k])), before)) continue;
      changed.push_back({.material = static_cast<std::uint16_t>(k), .values = scene_.materials[i].values});
    }
  }
  if (changed.empty()) return base::ReadFile(path, protocol::kMaxHapticSceneBytes);
  return scene::GlbWithMaterials(path, report.material_uses, changed);
}

std::string Trial::problem() const { return hand_.problem(); }

}  // namespace omni::monitor
