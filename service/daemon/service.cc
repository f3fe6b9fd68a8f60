#include "service/daemon/service.h"

#include <algorithm>
#include <utility>

#include <spdlog/spdlog.h>

#include "service/base/clock.h"
#include "service/daemon/status.h"

namespace omni::daemon {
namespace {

constexpr std::size_t kMaxProblems = 20;  // the oldest goes when full

std::uint32_t TrianglesOf(const haptics::Scene& scene) { return scene.empty() ? 0 : scene.header().triangle_count; }

std::uint32_t SculptedOf(const haptics::Scene& scene) {
  return scene.live() == nullptr ? 0 : scene.live()->workshop_count();
}

}  // namespace

Service::Service(ServiceOptions options)
    : options_(std::move(options)),
      start_ns_(base::MonotonicNow_ns()),
      builder_(options_.hull_radius_m, options_.cache_folder, options_.soft_tets),
      calibration_(options_.calibration),
      surfaces_(
          options_.instance, [this](loop::SurfaceSnapshot& snapshot) { return ReadSnapshot(snapshot); },
          [this](ipc::ClientId id, const protocol::Surfaces& surfaces, int fd) {
            return server_ != nullptr && server_->SendSurfaces(id, surfaces, fd);
          }) {
  for (const std::string& problem : options_.apps.problems) Problem(0, 1, problem);
  if (options_.inputs.devices.empty()) return;
  keys_ =
      std::make_unique<KeyThread>(KeyThreadOptions{.devices = options_.inputs.devices, .codes = options_.inputs.slots},
                                  MakeEvdevPorts(), [this](const base::KeyStates& keys) { SetKeys(keys); });
}

Service::~Service() = default;

void Service::Attach(loop::TickThread& loop, const device::Transport& transport) {
  const std::lock_guard lock(loop_mutex_);
  loop_ = &loop;
  transport_ = &transport;
  loop.keys().Write(key_states_);
}

void Service::SetKeys(const base::KeyStates& keys) {
  const std::lock_guard lock(loop_mutex_);
  key_states_ = keys;
  if (loop_ != nullptr) loop_->keys().Write(keys);
}

void Service::Detach(const std::string& why) {
  loop::TickThread* loop = nullptr;
  {
    const std::lock_guard lock(loop_mutex_);
    loop = loop_;
  }
  if (loop != nullptr) loop->Stop();  // before its scenes may be freed
  const std::lock_guard lock(loop_mutex_);
  loop_ = nullptr;
  transport_ = nullptr;
  device_absent_why_ = why;
}

void Service::SetCalibration(config::CalibrationChoice choice) {
  const std::lock_guard lock(loop_mutex_);
  calibration_ = std::move(choice);
}

void Service::OnClient(const ipc::ClientInfo& client) {
  owners_.Add(client.id, client.role);
  clients_[client.id] = {.info = client, .app = config::FindApp(options_.apps, client.application), .scene = nullptr};
  if (client.role != protocol::ClientRole::kApplication) return;
  spdlog::info("client {}: application \"{}\" (pid {})", client.id, client.application, client.pid);
}

void Service::OnGone(ipc::ClientId id) {
  const auto found = clients_.find(id);
  if (found == clients_.end()) return;
  const bool application = found->second.info.role == protocol::ClientRole::kApplication;
  if (application) spdlog::info("client {} is gone", id);
  DropScene(found->second);
  clients_.erase(found);
  owners_.Remove(id);
  surfaces_.Remove(id);
  if (application) WriteCommands(base::MonotonicNow_ns());  // a dead owner's force goes now, not at the next period
}

void Service::OnSession(ipc::ClientId id, protocol::SessionState state) {
  const auto found = clients_.find(id);
  if (found == clients_.end() || found->second.info.role != protocol::ClientRole::kApplication) return;
  Client& client = found->second;
  const bool began = owners_.session(id) == protocol::SessionState::kNone && state != protocol::SessionState::kNone;
  const std::uint64_t owner_before = owners_.owner();
  owners_.SetSession(id, state);
  if (owners_.owner() != owner_before) vibration_.Stop();
  if (began && client.app != nullptr && !client.app->scene.empty()) builder_.Request(id, *client.app);
  if (began && client.app == nullptr) {
    Problem(id, 0, "no scene for application \"" + client.info.application + "\": add a file to apps.d to give it one");
  }
  if (state == protocol::SessionState::kNone) DropScene(client);
  WriteCommands(base::MonotonicNow_ns());
}

void Service::OnHaptic(ipc::ClientId id, const protocol::Haptic& haptic) {
  if (id != owners_.owner()) return;  // only the owner is felt
  vibration_.Tone(haptic);
  WriteCommands(base::MonotonicNow_ns());
}

void Service::OnWaveform(ipc::ClientId id, const protocol::ShapedHaptic& haptic) {
  if (id != owners_.owner()) return;
  const std::int64_t now_ns = base::MonotonicNow_ns();
  vibration_.Shape(haptic, now_ns);
  WriteCommands(now_ns);
}

void Service::OnHapticStop(ipc::ClientId id) {
  if (id != owners_.owner()) return;
  vibration_.Stop();
  WriteCommands(base::MonotonicNow_ns());
}

void Service::OnSurfaceRequest(ipc::ClientId id, bool wanted) {
  if (clients_.count(id) != 0) surfaces_.Ask(id, wanted);
}

void Service::OnSceneCommand(ipc::ClientId id, const protocol::SceneCommand& command) {
  constexpr SculptAction kActions[] = {SculptAction::kEdits, SculptAction::kUndo, SculptAction::kRedo,
                                       SculptAction::kSave};
  sculpt_.Ask({.asker = id,
               .number = command.number,
               .client = command.client_id,
               .action = kActions[static_cast<std::size_t>(command.action) - 1],
               .object = command.object},
              owners_.owner());
}

void Service::OnPeriod(std::int64_t now_ns) {
  TakeBuiltScenes();
  TakeSoftBodies();
  TakeSculptNews();
  WriteCommands(now_ns);
  UpdateSurfaces();
  ReleaseScenes();
}

void Service::TakeBuiltScenes() {
  while (std::optional<BuiltScene> built = builder_.TakeResult()) {
    const auto found = clients_.find(built->client);
    if (found == clients_.end()) continue;
    for (const std::string& warning : built->warnings) spdlog::warn("{}", warning);
    if (built->scene == nullptr) {
      Problem(built->client, 2, built->error);  // the client's previous scene, if any, lives on
      continue;
    }
    if (built->load.skipped) {
      Problem(built->client, 0,
              built->file +
                  ": nothing to touch: the file has no haptic tag; tag what is to be felt (docs/scenes.md), or "
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

void Service::TakeSoftBodies() {
  while (const std::optional<SoftOutcome> soft = builder_.TakeSoftOutcome()) {
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

void Service::TakeSculptNews() {
  while (const std::optional<SculptProblem> problem = sculpt_.TakeProblem()) {
    Problem(problem->client, 1, problem->text);
  }
  while (const std::optional<SculptAnswer> answer = sculpt_.TakeAnswer()) {
    if (server_ == nullptr) continue;
    server_->SendSceneReply(answer->asker, {.number = answer->number,
                                            .done = answer->ok,
                                            .text = answer->text,
                                            .file = answer->file.get(),
                                            .file_bytes = answer->file_bytes});
  }
}

void Service::DropScene(Client& client) {
  builder_.Cancel(client.info.id);
  if (client.scene != nullptr) retired_.push_back(std::exchange(client.scene, nullptr));
}

const base::InputMapping& Service::MappingOf(const Client* client) const {
  const bool own = client != nullptr && client->app != nullptr && client->app->inputs;
  return own ? client->app->inputs->mapping : options_.inputs.fallback.mapping;
}

void Service::WriteCommands(std::int64_t now_ns) {
  const std::uint64_t owner = owners_.owner();
  const auto found = clients_.find(owner);
  const Client* client = found == clients_.end() ? nullptr : &found->second;
  const std::shared_ptr<const BuiltScene> scene = client == nullptr ? nullptr : client->scene;
  if (wanted_ != scene) {
    if (wanted_ != nullptr) retired_.push_back(wanted_);
    wanted_ = scene;
    if (wanted_ != nullptr) sculpt_.Enter(*wanted_->scene);
    ++generation_;
  }
  const std::int64_t beat_ns = owner == 0 || server_ == nullptr ? 0 : server_->LastBeat_ns(owner);
  loop::Commands commands{.t_ns = now_ns,
                          .gate = owners_.Gate(now_ns, beat_ns),
                          .idle = owners_.empty(),
                          .scene_generation = generation_,
                          .force_scale = client == nullptr || client->app == nullptr ? 1.0 : client->app->force_scale,
                          .haptic = vibration_.waveform(),
                          .inputs = MappingOf(client)};
  const std::lock_guard lock(loop_mutex_);
  if (loop_ == nullptr) return;
  loop_->scenes().Write({.scene = scene == nullptr ? nullptr : scene->scene.get(), .generation = generation_});
  if (vibration_.TakeFresh()) loop_->vibration().Write(vibration_.samples());  // before what names them
  loop_->commands().Write(commands);
}

void Service::UpdateSurfaces() {
  const std::string problem = surfaces_.Update(wanted_ == nullptr ? nullptr : wanted_->scene, generation_);
  if (!problem.empty()) Problem(0, 2, problem);
  const std::lock_guard lock(loop_mutex_);
  if (loop_ != nullptr) loop_->WantSurfaces(surfaces_.running());
}

bool Service::ReadSnapshot(loop::SurfaceSnapshot& snapshot) {
  const std::lock_guard lock(loop_mutex_);
  if (loop_ == nullptr) return false;
  snapshot = loop_->surfaces().Read();
  return true;
}

// Frees retired scenes once the tick is known to hold the newest hand-over. Until then it may hold, or be about to
// take, any earlier one. A hand-over's number never comes again, so an old acknowledgement cannot be taken for a new
// one.
void Service::ReleaseScenes() {
  const std::lock_guard lock(loop_mutex_);
  const bool newest =
      loop_ == nullptr || loop_->statistics().scene_generation.load(std::memory_order_acquire) == generation_;
  if (!newest) return;
  for (const std::shared_ptr<const BuiltScene>& scene : retired_) {
    if (scene == wanted_) continue;  // it came back
    sculpt_.Leave(*scene->scene);
    const bool kept =
        std::any_of(clients_.begin(), clients_.end(), [&](const auto& client) { return client.second.scene == scene; });
    if (!kept) sculpt_.Remove(*scene->scene);
  }
  retired_.clear();
}

void Service::Problem(ipc::ClientId id, int level, const std::string& text) {
  if (level == 0) {
    spdlog::info("{}", text);
  } else {
    spdlog::warn("{}", text);
    if (problems_.size() == kMaxProblems) problems_.erase(problems_.begin());
    problems_.push_back(text);
  }
  if (id != 0 && server_ != nullptr) server_->SendNotice(id, level, text);
}

std::string Service::StatusJson() {
  StatusInput input{.version = options_.version,
                    .instance = options_.instance,
                    .uptime_s = static_cast<double>(base::MonotonicNow_ns() - start_ns_) * 1e-9,
                    .problems = problems_};
  for (const auto& [id, client] : clients_) {
    input.clients.push_back({.id = id,
                             .pid = client.info.pid,
                             .application = client.info.application,
                             .monitor = client.info.role == protocol::ClientRole::kMonitor,
                             .session = owners_.session(id),
                             .owner = id == owners_.owner(),
                             .scene = client.scene == nullptr ? "" : client.scene->file,
                             .soft = builder_.Progress(id),
                             .sculpted = client.scene == nullptr ? 0 : SculptedOf(*client.scene->scene)});
  }
  input.scene_generation = generation_;
  if (wanted_ != nullptr) {
    input.scene_file = wanted_->file;
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
  if (!calibration_.problem.empty()) input.problems.push_back("calibration: " + calibration_.problem);
  input.loop = loop_;
  input.transport = transport_;
  input.device_absent_why = device_absent_why_;
  return WriteStatus(input);
}

}  // namespace omni::daemon
