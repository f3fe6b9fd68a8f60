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

protocol::HandSetting HandOf(const std::string& name) {
  if (name == "left") return protocol::HandSetting::kLeft;
  return name == "right" ? protocol::HandSetting::kRight : protocol::HandSetting::kUnset;
}

// `hand`: of an application whose file names none.
protocol::AppSettings SettingsFor(const config::AppEntry* app, const std::string& hand) {
  protocol::AppSettings settings;
  settings.hand = HandOf(app != nullptr && app->hand != "auto" ? app->hand : hand);
  if (app == nullptr) return settings;
  settings.rest_after_s = static_cast<float>(app->rest_after_s);
  protocol::SetField(settings.profile, app->profile);
  return settings;
}

std::int64_t UnixNow_s() { return static_cast<std::int64_t>(std::time(nullptr)); }

}  // namespace

Service::Service(ServiceOptions options)
    : options_(std::move(options)),
      start_ns_(base::MonotonicNow_ns()),
      device_(options_.calibration),
      scenes_(
          {.hull_radius_m = options_.hull_radius_m,
           .tip_radius_m = options_.tip_radius_m,
           .cache_folder = options_.cache_folder,
           .journal_folder = options_.journal_folder,
           .soft_tets = options_.soft_tets,
           .way = options_.build_way,
           .refused = options_.builds_refused,
           .limits = {.builders = BuildersOfComputer()}},
          [this](ipc::ClientId id, int level, const std::string& text) { Problem(id, level, text); },
          [this](ipc::ClientId id, int level, const std::string& text) { Say(id, level, text); },
          [this](ipc::ClientId id, const std::string& message) {
            return server_ != nullptr && server_->SendBytes(id, message);
          }),
      commands_(device_, scenes_, options_.inputs.fallback.mapping),
      force_({.owner = [this](ipc::ClientId id, const protocol::ForceOwner& owner) { return Send(id, owner); },
              .properties = [this](ipc::ClientId id,
                                   const protocol::ForceProperties& properties) { return Send(id, properties); }}),
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
      surfaces_(
          options_.instance,
          [this](loop::SurfaceSnapshot& snapshot) {
            return device_.WithLoop([&](loop::TickThread& loop) { snapshot = loop.surfaces().Read(); });
          },
          [this](ipc::ClientId id, const protocol::Surfaces& surfaces, int fd) { return Send(id, surfaces, {}, fd); }) {
  for (const std::string& problem : options_.apps.problems) Problem(0, 1, problem);
  if (!options_.builds_refused.empty()) Problem(0, 1, options_.builds_refused);
  if (!base_poses_.problem().empty()) spdlog::warn("{}", base_poses_.problem());
  if (stop_.on()) spdlog::warn("{}", stop_.Problem());
  base_poses_.SetFollowed(followed_base_.headset(), followed_base_.seen());
  if (options_.inputs.devices.empty()) return;
  keys_ =
      std::make_unique<KeyThread>(KeyThreadOptions{.devices = options_.inputs.devices, .codes = options_.inputs.slots},
                                  MakeEvdevPorts(), [this](const base::KeyStates& keys) { device_.SetKeys(keys); });
}

Service::~Service() = default;

double Service::Idle_s() const { return 1e-9 * static_cast<double>(base::MonotonicNow_ns() - busy_ns_.load()); }

void Service::OnClient(const ipc::ClientInfo& client) {
  const config::AppEntry* app = config::FindApp(options_.apps, client.application);
  clients_.Add(client, app);
  if (client.role != protocol::ClientRole::kApplication) return;
  force_.Add(client.id);
  SendForceProperties();
  spdlog::info("client {}: application \"{}\" (pid {})", client.id, client.application, client.pid);
  Send(client.id, SettingsFor(app, options_.hand));
}

void Service::OnGone(ipc::ClientId id) {
  const Client* client = clients_.Find(id);
  if (client == nullptr) return;
  if (client == clients_.owner()) commands_.CloseGate();
  const bool application = client->is_application();
  if (application) spdlog::info("client {} is gone", id);
  scenes_.Remove(id);
  clients_.Remove(id);
  surfaces_.Remove(id);
  force_.Remove(id);
  base_poses_.Remove(id, UnixNow_s());
  PublishBase(followed_base_.Remove(id, base::MonotonicNow_ns()));
  if (application) WriteCommands(base::MonotonicNow_ns());
}

void Service::SetSession(ipc::ClientId id, protocol::SessionState state) {
  const Client* client = clients_.Find(id);
  if (client == nullptr || !client->is_application()) return;
  const bool began = client->session == protocol::SessionState::kNone && state != protocol::SessionState::kNone;
  const Client* owner_before = clients_.owner();
  clients_.SetSession(id, state);
  if (clients_.owner() != owner_before) commands_.vibration().Stop();
  if (began && client->app != nullptr && !client->app->scene.empty()) {
    scenes_.Request(id, *client->app, client->info.application);
  }
  if (began && client->app == nullptr) {
    Problem(id, 0,
            "no scene for application \"" + client->info.application + "\": add a file to apps.d to give it one");
  }
  if (state == protocol::SessionState::kNone) scenes_.Drop(id);
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
  bool IsOwner() const { return id == service.clients_.owner_id(); }  // only the owner may push
  AppScenes& documents() const { return service.scenes_.documents(); }

  void operator()(const protocol::Session& session) const { service.SetSession(id, session.state); }
  void operator()(const protocol::Haptic& haptic) const {
    if (!IsOwner()) return;
    service.commands_.vibration().PlayTone(haptic);
    Commit();
  }
  void operator()(const protocol::ShapedHaptic& haptic) const {
    if (!IsOwner()) return;
    service.commands_.vibration().PlayShaped(haptic, base::MonotonicNow_ns());
    Commit();
  }
  void operator()(const protocol::HapticStop& /*stop*/) const {
    if (!IsOwner()) return;
    service.commands_.vibration().Stop();
    Commit();
  }

  template <class M>
  requires std::is_constructible_v<protocol::ForceRequest, const M&>
  void operator()(const M& force) const {
    const std::int64_t now_ns = base::MonotonicNow_ns();
    if (service.force_.HandleRequest(id, force, now_ns)) service.WriteCommands(now_ns);
    if (std::is_same_v<M, protocol::ForceClaim>) service.SendForceProperties();
  }

  void operator()(const protocol::EmergencyStop& stop) const {
    const Client* client = service.clients_.Find(id);
    const std::string who = client == nullptr ? "a client" : client->info.application;
    const bool on = stop.on != 0;
    if (on == service.stop_.on()) return;
    if (on) service.commands_.CloseGate();
    on ? service.stop_.Press(who) : service.stop_.Release();
    service.commands_.vibration().Stop();
    Commit();
    spdlog::warn("emergency stop: {} by {}", on ? "pressed" : "released", who);
  }
  void operator()(const protocol::SurfaceRequest& request) const {
    if (service.clients_.Find(id) != nullptr) service.surfaces_.HandleRequest(id, request.wanted != 0);
  }
  void operator()(const protocol::SceneCommand& command) const {
    constexpr SculptAction kActions[] = {SculptAction::kEdits, SculptAction::kUndo, SculptAction::kRedo,
                                         SculptAction::kSave, SculptAction::kRelease};
    service.scenes_.sculpt().Request({.asker = id,
                                      .number = command.number,
                                      .client = command.client_id,
                                      .action = kActions[static_cast<std::size_t>(command.action) - 1],
                                      .object = command.object},
                                     service.clients_.owner_id());
  }

  void operator()(const protocol::HapticSceneLoad& load) const {
    const Client* client = service.clients_.Find(id);
    if (client == nullptr) return;
    documents().Load(id, client->info.application, load, std::move(file));
    Commit();
  }
  void operator()(const protocol::HapticSceneEnd& end) const { Commit(documents().End(id, end.number)); }
  void operator()(const protocol::HapticScenePlace& place) const { Commit(documents().Place(id, place)); }
  void operator()(const protocol::HapticSceneEnable& enable) const { Commit(documents().Enable(id, enable)); }
  void operator()(const protocol::HapticNodes& nodes) const { Commit(documents().MoveNodes(id, nodes)); }
  void operator()(const protocol::HapticMaterial& material) const { Commit(documents().SetMaterial(id, material)); }

  void operator()(const protocol::BasePoseRequest& request) const {
    if (service.clients_.Find(id) == nullptr) return;
    service.base_poses_.HandleRequest(id, request, UnixNow_s());
    service.SendBasePoses();
  }
  void operator()(const protocol::SpaceChange& change) const {
    const Client* client = service.clients_.Find(id);
    if (client == nullptr || !client->session_seen) return;
    service.base_poses_.HandleSpaceChange(id, change, base::MonotonicNow_ns());
    service.SendBasePoses();
  }
  void operator()(const protocol::BasePoseCommand& command) const {
    service.base_pose_writer_.ReplyWhenWritten(id, command.number, service.base_poses_.Execute(command, UnixNow_s()));
    service.SendBasePoses();
  }
  void operator()(const protocol::BaseMotion& motion) const {
    const FollowedBase::Taken taken = service.followed_base_.HandleMotion(id, motion, base::MonotonicNow_ns());
    if (taken.problem != nullptr) service.Problem(id, 1, taken.problem);
    service.PublishBase(taken.sample);
    service.SendBasePoses();
  }
};

void Service::OnRequest(ipc::ClientId id, const protocol::Request& request, base::UniqueFd file) {
  std::visit(RequestHandler{*this, id, file}, request);
}

void Service::SendBasePoses() {
  base_poses_.Notify([this](ipc::ClientId id, const protocol::BasePose& base_pose) { return Send(id, base_pose); });
  if (options_.on_aligned) options_.on_aligned(Aligned());
}

void Service::PublishBase(const std::optional<protocol::BaseSample>& sample) {
  if (sample && options_.on_base) options_.on_base(*sample);
  base_poses_.SetFollowed(followed_base_.headset(), followed_base_.seen());
}

// Of the owner; without one, of any client.
bool Service::Aligned() const {
  if (clients_.owner() != nullptr) return base_poses_.IsAligned(clients_.owner_id());
  return std::any_of(clients_.all().begin(), clients_.all().end(),
                     [this](const auto& client) { return base_poses_.IsAligned(client.first); });
}

void Service::OnPeriod(std::int64_t now_ns) {
  // Who looks sees why there is no force, and the disk may have failed to keep the stop.
  if (!clients_.all().empty() || stop_.on()) busy_ns_.store(now_ns);
  if (const std::string news = stop_.Poll(now_ns); !news.empty()) spdlog::warn("emergency stop: {}", news);
  scenes_.HandleResults();
  SendSculptAnswers();
  WriteCommands(now_ns);
  SendForceProperties();
  UpdateSurfaces();
  base_pose_writer_.HandleWritten(base_poses_);
  FeelField();
  SendBasePoses();
  Release();
  scenes_.documents().Notify(clients_.owner_id(), scenes_.generation());
}

void Service::WriteCommands(std::int64_t now_ns) {
  const Client* owner = clients_.owner();
  const ipc::ClientId id = clients_.owner_id();
  scenes_.SetOwner(id);
  force_.SetOwner(id);
  std::shared_ptr<const protocol::LifePage> life =
      owner == nullptr || server_ == nullptr ? nullptr : server_->LifePageOf(id);
  const bool alive = life != nullptr || server_ == nullptr;
  commands_.Write(
      now_ns,
      {.owner = owner, .life = std::move(life), .allowed = alive && !stop_.on(), .applied = force_.MakeCommand(now_ns)},
      clients_.all().empty());
}

void Service::SendSculptAnswers() {
  while (const std::optional<SculptAnswer> answer = scenes_.sculpt().PopAnswer()) {
    protocol::SceneReply reply;
    reply.number = answer->number;
    reply.done = answer->ok ? 1 : 0;
    reply.file_bytes = answer->ok ? answer->file_bytes : 0;
    const bool sent = Send(answer->asker, reply, answer->text, reply.file_bytes > 0 ? answer->file.get() : -1);
    if (sent && reply.file_bytes > 0) scenes_.sculpt().ConfirmSaved(*answer);
  }
}

// What the tick has given up.
void Service::Release() {
  std::optional<std::uint64_t> scene, life;
  device_.WithLoop([&](loop::TickThread& loop) {
    scene = loop.statistics().scene_generation.load(std::memory_order_acquire);
    life = loop.statistics().owner_number.load(std::memory_order_acquire);
  });
  scenes_.Release(scene);
  commands_.Release(life);
}

void Service::FeelField() {
  const auto field = device_.With([](const AttachedDevice::State& state) { return state.field; });
  if (field.second_ns == felt_second_ns_) return;
  felt_second_ns_ = field.second_ns;
  base_poses_.UpdateField(field.field_base_T);
}

void Service::SendForceProperties() {
  if (server_ == nullptr) return;
  force_.Notify(device_.With([](const AttachedDevice::State& state) { return state.force_properties; }));
}

void Service::UpdateSurfaces() {
  const std::string problem = surfaces_.Update(scenes_.felt_scene(), scenes_.generation());
  if (!problem.empty()) Problem(0, 2, problem);
  device_.WithLoop([this](loop::TickThread& loop) { loop.WantSurfaces(surfaces_.running()); });
}

void Service::Problem(ipc::ClientId id, int level, const std::string& text) {
  if (level > 0) {
    if (problems_.size() == kMaxProblems) problems_.erase(problems_.begin());
    problems_.push_back(text);
  }
  Say(id, level, text);
}

void Service::Say(ipc::ClientId id, int level, const std::string& text) {
  level == 0 ? spdlog::info("{}", text) : spdlog::warn("{}", text);
  if (id == 0) return;
  protocol::Notice notice;
  notice.level = static_cast<std::uint32_t>(level);
  protocol::SetField(notice.text, text);
  Send(id, notice);
}

std::string Service::StatusJson() {
  return WriteStatus({.version = options_.version,
                      .instance = options_.instance,
                      .uptime_s = static_cast<double>(base::MonotonicNow_ns() - start_ns_) * 1e-9,
                      .clients = clients_,
                      .scenes = scenes_,
                      .device = device_,
                      .stop = stop_,
                      .base_poses = base_poses_,
                      .followed_base = followed_base_,
                      .aligned = Aligned(),
                      .mapping = commands_.MappingOf(clients_.owner()),
                      .key_slots = options_.inputs.slots,
                      .keys = keys_.get(),
                      .problems = problems_});
}

}  // namespace omni::daemon
