#include "service/daemon/service.h"

#include <algorithm>
#include <ctime>
#include <type_traits>
#include <utility>
#include <variant>

#include <spdlog/spdlog.h>

#include "service/base/clock.h"
#include "service/daemon/clients/status.h"
#include "service/haptics/scene/scene.h"
#include "service/protocol/text.h"

namespace omni::daemon {
namespace {

constexpr std::size_t kMaxProblems = 20;  // the oldest goes when full

std::uint32_t TrianglesOf(const haptics::Scene& scene) { return scene.empty() ? 0 : scene.header().triangle_count; }

std::uint32_t SculptedOf(const haptics::Scene& scene) {
  return scene.live() == nullptr ? 0 : scene.live()->sculpt_session_count();
}

protocol::HandSetting HandOf(const std::string& name) {
  if (name == "left") return protocol::HandSetting::kLeft;
  return name == "right" ? protocol::HandSetting::kRight : protocol::HandSetting::kUnset;
}

}  // namespace

Service::Service(ServiceOptions options)
    : options_(std::move(options)),
      start_ns_(base::MonotonicNow_ns()),
      builder_(options_.hull_radius_m, options_.cache_folder, options_.soft_tets),
      app_scenes_(builder_, options_.hull_radius_m, retired_,
                  [this](ipc::ClientId id, const std::string& message) {
                    return server_ != nullptr && server_->SendBytes(id, message);
                  }),
      force_({.owner = [this](ipc::ClientId id, const protocol::ForceOwner& owner) { return server_->Send(id, owner); },
              .properties =
                  [this](ipc::ClientId id, const protocol::ForceProperties& properties) {
                    return server_->Send(id, properties);
                  }}),
      base_pose_writer_([this](ipc::ClientId id, std::uint32_t number, bool done, const std::string& text) {
        protocol::BasePoseReply reply;
        reply.number = number;
        reply.done = done ? 1 : 0;
        protocol::SetField(reply.text, text);
        Send(id, reply);
      }),
      base_poses_(options_.alignment_path, base_pose_writer_.write()),
      followed_base_(options_.base_follows),
      stop_(options_.stop_path),
      busy_ns_(start_ns_),
      calibration_(options_.calibration),
      surfaces_(
          options_.instance, [this](loop::SurfaceSnapshot& snapshot) { return ReadSnapshot(snapshot); },
          [this](ipc::ClientId id, const protocol::Surfaces& surfaces, int fd) {
            return server_ != nullptr && server_->Send(id, surfaces, {}, fd);
          }) {
  for (const std::string& problem : options_.apps.problems) Problem(0, 1, problem);
  if (!base_poses_.problem().empty()) spdlog::warn("{}", base_poses_.problem());
  if (stop_.on()) spdlog::warn("{}", stop_.Problem());
  base_poses_.SetFollowed(followed_base_.headset(), followed_base_.seen());
  if (options_.inputs.devices.empty()) return;
  keys_ =
      std::make_unique<KeyThread>(KeyThreadOptions{.devices = options_.inputs.devices, .codes = options_.inputs.slots},
                                  MakeEvdevPorts(), [this](const base::KeyStates& keys) { SetKeys(keys); });
}

Service::~Service() = default;

void Service::OnClient(const ipc::ClientInfo& client) {
  owners_.Add(client.id, client.role);
  clients_[client.id] = {.info = client, .app = config::FindApp(options_.apps, client.application), .scene = nullptr};
  if (client.role != protocol::ClientRole::kApplication) return;
  force_.Add(client.id);
  SendForceProperties();
  spdlog::info("client {}: application \"{}\" (pid {})", client.id, client.application, client.pid);
  Send(client.id, SettingsFor(clients_[client.id].app));
}

protocol::AppSettings Service::SettingsFor(const config::AppEntry* app) const {
  protocol::AppSettings settings;
  settings.hand = HandOf(app != nullptr && app->hand != "auto" ? app->hand : options_.hand);
  if (app == nullptr) return settings;
  settings.rest_after_s = static_cast<float>(app->rest_after_s);
  protocol::SetField(settings.profile, app->profile);
  return settings;
}

void Service::OnGone(ipc::ClientId id) {
  const auto found = clients_.find(id);
  if (found == clients_.end()) return;
  if (id == owners_.owner()) CloseGate();
  const bool application = found->second.info.role == protocol::ClientRole::kApplication;
  if (application) spdlog::info("client {} is gone", id);
  DropScene(found->second);
  app_scenes_.Remove(id);
  clients_.erase(found);
  owners_.Remove(id);
  surfaces_.Remove(id);
  force_.Remove(id);
  base_poses_.Remove(id, static_cast<std::int64_t>(std::time(nullptr)));
  PublishBase(followed_base_.Remove(id, base::MonotonicNow_ns()));
  if (application) WriteCommands(base::MonotonicNow_ns());
}

void Service::SetSession(ipc::ClientId id, protocol::SessionState state) {
  const auto found = clients_.find(id);
  if (found == clients_.end() || found->second.info.role != protocol::ClientRole::kApplication) return;
  Client& client = found->second;
  const bool began = owners_.session(id) == protocol::SessionState::kNone && state != protocol::SessionState::kNone;
  const std::uint64_t owner_before = owners_.owner();
  owners_.SetSession(id, state);
  client.session_seen = client.session_seen || state != protocol::SessionState::kNone;
  if (owners_.owner() != owner_before) vibration_.Stop();
  if (began && client.app != nullptr && !client.app->scene.empty()) builder_.Request(id, *client.app);
  if (began && client.app == nullptr) {
    Problem(id, 0, "no scene for application \"" + client.info.application + "\": add a file to apps.d to give it one");
  }
  if (state == protocol::SessionState::kNone) DropScene(client);
  WriteCommands(base::MonotonicNow_ns());
}

struct Service::RequestHandler {
  Service& service;
  const ipc::ClientId id;
  base::UniqueFd& file;

  // Passes changes on to the tick now: an application does not wait for the next period.
  void Commit(bool changed = true) const {
    if (changed) service.WriteCommands(base::MonotonicNow_ns());
  }
  bool IsOwner() const { return id == service.owners_.owner(); }  // only the owner may push

  void operator()(const protocol::Session& session) const { service.SetSession(id, session.state); }
  void operator()(const protocol::Haptic& haptic) const {
    if (!IsOwner()) return;
    service.vibration_.Tone(haptic);
    Commit();
  }
  void operator()(const protocol::ShapedHaptic& haptic) const {
    if (!IsOwner()) return;
    service.vibration_.Shape(haptic, base::MonotonicNow_ns());
    Commit();
  }
  void operator()(const protocol::HapticStop& /*stop*/) const {
    if (!IsOwner()) return;
    service.vibration_.Stop();
    Commit();
  }

  template <class M>
  requires std::is_constructible_v<protocol::ForceRequest, const M&>
  void operator()(const M& force) const {
    const std::int64_t now_ns = base::MonotonicNow_ns();
    if (service.force_.Handle(id, force, now_ns)) service.WriteCommands(now_ns);
    if (std::is_same_v<M, protocol::ForceClaim>) service.SendForceProperties();
  }

  void operator()(const protocol::EmergencyStop& stop) const {
    const auto found = service.clients_.find(id);
    const std::string who = found == service.clients_.end() ? "a client" : found->second.info.application;
    const bool on = stop.on != 0;
    if (on == service.stop_.on()) return;
    if (on) service.CloseGate();
    on ? service.stop_.Press(who) : service.stop_.Release();
    service.vibration_.Stop();
    Commit();
    spdlog::warn("emergency stop: {} by {}", on ? "pressed" : "released", who);
  }
  void operator()(const protocol::SurfaceRequest& request) const {
    if (service.clients_.count(id) != 0) service.surfaces_.Request(id, request.wanted != 0);
  }
  void operator()(const protocol::SceneCommand& command) const {
    constexpr SculptAction kActions[] = {SculptAction::kEdits, SculptAction::kUndo, SculptAction::kRedo,
                                         SculptAction::kSave};
    service.sculpt_.Request({.asker = id,
                             .number = command.number,
                             .client = command.client_id,
                             .action = kActions[static_cast<std::size_t>(command.action) - 1],
                             .object = command.object},
                            service.owners_.owner());
  }

  void operator()(const protocol::HapticSceneLoad& load) const {
    const auto found = service.clients_.find(id);
    if (found == service.clients_.end()) return;
    service.app_scenes_.Load(id, found->second.info.application, load, std::move(file));
    Commit();
  }
  void operator()(const protocol::HapticSceneEnd& end) const { Commit(service.app_scenes_.End(id, end.number)); }
  void operator()(const protocol::HapticScenePlace& place) const { Commit(service.app_scenes_.Place(id, place)); }
  void operator()(const protocol::HapticSceneEnable& enable) const { Commit(service.app_scenes_.Enable(id, enable)); }
  void operator()(const protocol::HapticNodes& nodes) const { Commit(service.app_scenes_.MoveNodes(id, nodes)); }
  void operator()(const protocol::HapticMaterial& material) const {
    Commit(service.app_scenes_.SetMaterial(id, material));
  }

  void operator()(const protocol::BasePoseRequest& request) const {
    if (service.clients_.count(id) == 0) return;
    service.base_poses_.Request(id, request, static_cast<std::int64_t>(std::time(nullptr)));
    service.SendBasePoses();
  }
  void operator()(const protocol::SpaceChange& change) const {
    const auto found = service.clients_.find(id);
    if (found == service.clients_.end() || !found->second.session_seen) return;
    service.base_poses_.Change(id, change, base::MonotonicNow_ns());
    service.SendBasePoses();
  }
  void operator()(const protocol::BasePoseCommand& command) const {
    service.base_pose_writer_.Answer(
        id, command.number, service.base_poses_.Execute(command, static_cast<std::int64_t>(std::time(nullptr))));
    service.SendBasePoses();
  }
  void operator()(const protocol::BaseMotion& motion) const {
    const FollowedBase::Taken taken = service.followed_base_.Take(id, motion, base::MonotonicNow_ns());
    if (taken.problem != nullptr) service.Problem(id, 1, taken.problem);
    service.PublishBase(taken.sample);
    service.SendBasePoses();
  }
};

void Service::OnRequest(ipc::ClientId id, const protocol::Request& request, base::UniqueFd file) {
  std::visit(RequestHandler{*this, id, file}, request);
}

void Service::SendBasePoses() {
  base_poses_.Notify([this](ipc::ClientId id, const protocol::BasePose& base_pose) {
    return server_ != nullptr && server_->Send(id, base_pose);
  });
  if (options_.on_aligned) options_.on_aligned(Aligned());
}

void Service::PublishBase(const std::optional<protocol::BaseSample>& sample) {
  if (sample && options_.on_base) options_.on_base(*sample);
  base_poses_.SetFollowed(followed_base_.headset(), followed_base_.seen());
}

// Of the owner; without one, of any client.
bool Service::Aligned() const {
  if (owners_.owner() != 0) return base_poses_.Aligned(owners_.owner());
  return std::any_of(clients_.begin(), clients_.end(),
                     [this](const auto& client) { return base_poses_.Aligned(client.first); });
}

void Service::OnPeriod(std::int64_t now_ns) {
  // Who looks sees why there is no force, and the disk may have failed to keep the stop.
  if (!clients_.empty() || stop_.on()) busy_ns_.store(now_ns);
  if (const std::string news = stop_.Poll(now_ns); !news.empty()) spdlog::warn("emergency stop: {}", news);
  HandleBuiltScenes();
  HandleSoftBodies();
  HandleSculptResults();
  WriteCommands(now_ns);
  SendForceProperties();
  UpdateSurfaces();
  base_pose_writer_.HandleWritten(base_poses_);
  FeelField();
  SendBasePoses();
  ReleaseScenes();
  ReleaseLives();
  app_scenes_.Notify(owners_.owner(), generation_);
}

void Service::HandleBuiltScenes() {
  while (std::optional<BuiltScene> built = builder_.PopResult()) {
    if (AppScenes::IsJob(built->client)) {
      TakeAppScene(std::move(*built));
      continue;
    }
    const auto found = clients_.find(built->client);
    if (found == clients_.end()) continue;
    for (const std::string& warning : built->warnings) spdlog::warn("{}", warning);
    if (built->scene == nullptr) {
      Problem(built->client, 2, built->error);  // the client's previous scene, if any, stays
      continue;
    }
    if (built->load.skipped) {
      Problem(built->client, 0,
              built->file +
                  ": nothing to touch: the file has no haptic tag; tag the objects to touch (docs/scenes.md), or "
                  "write touch = \"all\" in the application's file");
    } else {
      spdlog::info("client {}: scene {} ({} triangles, {} in {:.1f} ms)", built->client, built->file,
                   TrianglesOf(*built->scene), built->load.cached ? "from the cache" : "built", built->load.load_ms);
    }
    if (found->second.scene != nullptr) retired_.push_back(found->second.scene);
    sculpt_.Add(built->client, built->file, built->scene);
    found->second.scene = std::make_shared<const BuiltScene>(std::move(*built));
  }
}

// Errors are reported to its client by its state, and logged here.
void Service::TakeAppScene(BuiltScene built) {
  const ipc::ClientId id = AppScenes::ClientOf(built.client);
  const std::string error = built.error;
  const std::shared_ptr<const BuiltScene> scene = app_scenes_.Accept(std::move(built));
  if (scene == nullptr) {
    if (!error.empty()) Problem(0, 1, error);
    return;
  }
  spdlog::info("client {}: {} ({} triangles in {:.1f} ms)", id, scene->file, TrianglesOf(*scene->scene),
               scene->load.load_ms);
  sculpt_.Add(id, scene->file, scene->scene);
}

void Service::HandleSoftBodies() {
  while (std::optional<SoftOutcome> soft = builder_.PopSoftOutcome()) {
    soft->client = AppScenes::ClientOf(soft->client);
    const std::string what = soft->file + ": " + soft->object + ": ";
    if (!soft->error.empty()) {
      Problem(soft->client, 1, what + soft->error + ": it stays a layer");
      continue;
    }
    spdlog::info("client {}: {}soft body with {} nodes, {:.1f} MB, {} in {:.0f} ms", soft->client, what,
                 soft->report.build.surface_nodes, static_cast<double>(soft->report.build.bytes) * 1e-6,
                 soft->report.cached ? "from the cache" : "computed", soft->report.load_ms);
  }
}

void Service::HandleSculptResults() {
  while (const std::optional<SculptProblem> problem = sculpt_.PopProblem()) {
    Problem(problem->client, 1, problem->text);
  }
  while (const std::optional<SculptAnswer> answer = sculpt_.PopAnswer()) {
    if (server_ == nullptr) continue;
    protocol::SceneReply reply;
    reply.number = answer->number;
    reply.done = answer->ok ? 1 : 0;
    reply.file_bytes = answer->ok ? answer->file_bytes : 0;
    server_->Send(answer->asker, reply, answer->text, reply.file_bytes > 0 ? answer->file.get() : -1);
  }
}

void Service::DropScene(Client& client) {
  builder_.Cancel(client.info.id);
  if (client.scene != nullptr) retired_.push_back(std::exchange(client.scene, nullptr));
}

std::shared_ptr<const BuiltScene> Service::SceneOf(ipc::ClientId id) const {
  if (app_scenes_.Stands(id)) return app_scenes_.Active(id);
  const auto found = clients_.find(id);
  return found == clients_.end() ? nullptr : found->second.scene;
}

const base::InputMapping& Service::MappingOf(const Client* client) const {
  const bool own = client != nullptr && client->app != nullptr && client->app->inputs;
  return own ? client->app->inputs->mapping : options_.inputs.fallback.mapping;
}

void Service::FeelField() {
  room::RoomField field;
  {
    const std::lock_guard lock(loop_mutex_);
    field = field_;
  }
  if (field.second_ns == felt_second_ns_) return;
  felt_second_ns_ = field.second_ns;
  base_poses_.Feel(field.field_base_T);
}

void Service::SendForceProperties() {
  if (server_ == nullptr) return;
  protocol::ForceProperties properties;
  {
    const std::lock_guard lock(loop_mutex_);
    properties = force_properties_;
  }
  force_.Notify(properties);
}

void Service::UpdateSurfaces() {
  const std::string problem = surfaces_.Update(wanted_ == nullptr ? nullptr : wanted_->scene, generation_);
  if (!problem.empty()) Problem(0, 2, problem);
  const std::lock_guard lock(loop_mutex_);
  if (loop_ != nullptr) loop_->WantSurfaces(surfaces_.running());
}

void Service::Problem(ipc::ClientId id, int level, const std::string& text) {
  if (level == 0) {
    spdlog::info("{}", text);
  } else {
    spdlog::warn("{}", text);
    if (problems_.size() == kMaxProblems) problems_.erase(problems_.begin());
    problems_.push_back(text);
  }
  if (id == 0) return;
  protocol::Notice notice;
  notice.level = static_cast<std::uint32_t>(level);
  protocol::SetField(notice.text, text);
  Send(id, notice);
}

std::string Service::StatusJson() {
  StatusInput input{.version = options_.version,
                    .instance = options_.instance,
                    .uptime_s = static_cast<double>(base::MonotonicNow_ns() - start_ns_) * 1e-9,
                    .stop = stop_.state(),
                    .problems = problems_};
  if (const std::string problem = stop_.Problem(); !problem.empty()) input.problems.push_back(problem);
  for (const auto& [id, client] : clients_) {
    const std::shared_ptr<const BuiltScene> scene = SceneOf(id);
    input.clients.push_back({.id = id,
                             .pid = client.info.pid,
                             .application = client.info.application,
                             .monitor = client.info.role != protocol::ClientRole::kApplication,
                             .session = owners_.session(id),
                             .owner = id == owners_.owner(),
                             .scene = scene == nullptr ? "" : scene->file,
                             .soft = builder_.Progress(scene == nullptr ? id : scene->client),
                             .sculpted = scene == nullptr ? 0 : SculptedOf(*scene->scene),
                             .aligned = base_poses_.Aligned(id)});
    if (const protocol::BasePoseRequest* request = base_poses_.RequestOf(id)) {
      input.clients.back().runtime = request->headset.runtime;
      input.clients.back().system = request->headset.system;
    }
  }
  input.aligned = Aligned();
  input.alignments = base_poses_.file();
  if (!base_poses_.problem().empty()) input.problems.push_back("alignment: " + base_poses_.problem());
  if (followed_base_.headset() && !followed_base_.seen()) {
    input.problems.emplace_back(
        "base: no program reports where it is carried; run `omni follow`, or `omni follow --off` if it stands");
  }
  input.scene_generation = generation_;
  if (wanted_ != nullptr) {
    input.scene_file = wanted_->file;
    const auto loader = clients_.find(wanted_->client);  // a document's job is no client
    if (loader != clients_.end() && loader->second.app != nullptr) {
      input.scene_load = LoadOptionsOf(*loader->second.app, options_.hull_radius_m);
    }
    input.scene_triangles = TrianglesOf(*wanted_->scene);
    input.scene_soft = builder_.Progress(wanted_->client);
    input.scene_sculpted = SculptedOf(*wanted_->scene);
  }
  const auto owner = clients_.find(owners_.owner());
  input.mapping = &MappingOf(owner == clients_.end() ? nullptr : &owner->second);
  input.key_slots = &options_.inputs.slots;
  if (keys_ != nullptr) input.key_devices = keys_->Status();
  const std::lock_guard lock(loop_mutex_);
  input.calibration = calibration_;
  input.misfit = misfit_;
  input.room = room_;
  if (!calibration_.problem.empty()) input.problems.push_back("calibration: " + calibration_.problem);
  if (!misfit_.empty()) input.problems.push_back("calibration: " + misfit_);
  if (!starved_.empty()) input.problems.push_back("host: " + starved_);
  for (const room::RoomFinding& finding : room_) input.problems.push_back("room: " + RoomText(finding));
  input.loop = loop_;
  input.transport = transport_;
  input.device_absent_why = device_absent_why_;
  return WriteStatus(input);
}

}  // namespace omni::daemon
