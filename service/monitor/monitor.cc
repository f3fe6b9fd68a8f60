#include "service/monitor/monitor.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>
#include <variant>

#include <nlohmann/json.hpp>

#include "service/base/clock.h"
#include "service/base/files/json_document.h"
#include "service/monitor/page/channels.h"
#include "service/monitor/web/access.h"

namespace omni::monitor {
namespace {

using nlohmann::json;

constexpr std::int64_t kStatusPeriod_ns = 500'000'000;
constexpr std::int64_t kSetupPeriod_ns = 2'000'000'000;

// How omnid has loaded its scene: /scene/load of its status.
scene::LoadOptions OptionsOf(const json& load, double hull_radius_m) {
  scene::LoadOptions options;
  options.hull_radius_m = hull_radius_m;
  options.touch_untagged = base::TrueAt(load, "/touch_untagged");
  options.tags_by_name = base::StringAt(load, "/tags");
  options.z_up = base::StringAt(load, "/up") == "z";
  options.fit = base::TrueAt(load, "/fit");
  const double scale = base::NumberAt(load, "/scale");
  if (!std::isnan(scale)) options.scale = scale;
  const base::Vec3 offset_m{base::NumberAt(load, "/offset_base_m/0"), base::NumberAt(load, "/offset_base_m/1"),
                            base::NumberAt(load, "/offset_base_m/2")};
  if (!std::isnan(base::Norm(offset_m))) options.offset_base_m = offset_m;
  return options;
}

}  // namespace

base::Result<std::unique_ptr<Monitor>> Monitor::Start(const MonitorOptions& options, std::unique_ptr<Trial> trial) {
  base::Result<std::string> token = MakeToken();
  if (!token.ok()) return base::Error{token.error()};
  base::Result<std::string> code = MakeToken();
  if (!code.ok()) return base::Error{code.error()};
  std::unique_ptr<Monitor> monitor(new Monitor(options, std::move(trial)));
  monitor->token_ = *token;
  monitor->code_ = *code;
  auto server = WebServer::Listen(
      {.port = options.port,
       .token = *token,
       .code = *code,
       .folder = options.page_folder,
       .max_message_bytes = options.hello.hand ? kMaxDroppedBytes + 1024 : std::size_t{kMaxRequestBytes}},
      *monitor);
  if (!server.ok()) return base::Error{server.error()};
  monitor->server_ = std::move(*server);
  return monitor;
}

Monitor::Monitor(const MonitorOptions& options, std::unique_ptr<Trial> trial)
    : options_(options),
      trial_(std::move(trial)),
      connection_({.role = protocol::ClientRole::kMonitor,
                   .application = "omni monitor",
                   .engine = "",
                   .socket_path = options.socket_path,
                   .retry_interval_ns = trial_ == nullptr ? 500'000'000 : 50'000'000}),
      hello_text_(HelloText(options.hello)),
      status_text_(StatusText(false, "not connected yet", nullptr, -1)) {}

Monitor::~Monitor() { server_.reset(); }

std::string Monitor::address() const {
  return "http://127.0.0.1:" + std::to_string(server_->port()) + "/#token=" + token_;
}

std::string Monitor::browser_address() const {
  return "http://127.0.0.1:" + std::to_string(server_->port()) + "/#code=" + code_;
}

std::string Monitor::HelloJson() {
  return json{{"protocol", kPageVersion}, {"version", options_.hello.version}}.dump();
}

void Monitor::Step() {
  const std::int64_t before_ns = base::MonotonicNow_ns();
  // A computer that slept, or a slow frame: the frames that were missed are not made up for.
  next_frame_ns_ = std::clamp(next_frame_ns_ + kFramePeriod_ns, before_ns, before_ns + kFramePeriod_ns);
  server_->RunUntil(next_frame_ns_);
  PollService(base::MonotonicNow_ns());
  FollowScene();
  SendFrame();
}

void Monitor::PollService(std::int64_t now_ns) {
  if (trial_ != nullptr) trial_->Poll(now_ns);
  connection_.Poll(now_ns);
  connection_.SignalAlive();
  if (surfaces_wanted_ != !pages_.empty()) {
    surfaces_wanted_ = !pages_.empty();
    connection_.RequestSurfaces(surfaces_wanted_);
  }
  for (const protocol::Notice& notice : connection_.PopNotices()) {
    for (const auto& [id, page] : pages_) Notice(id, static_cast<NoticeLevel>(std::min(notice.level, 2U)), notice.text);
  }
  HandleSceneAnswer();
  const bool changed = was_connected_ != connection_.connected();
  was_connected_ = connection_.connected();
  if (!was_connected_ && (changed || now_ns >= next_status_ns_)) {
    next_status_ns_ = now_ns + kStatusPeriod_ns;
    const std::string& why = connection_.last_error();
    status_text_ = StatusText(false, why.empty() ? "waiting for omnid" : why, nullptr, -1);
    SendAll(status_text_);
    FollowSetup(now_ns, nullptr);
  }
  if (!was_connected_) return;
  if ((changed || now_ns >= next_status_ns_) && connection_.Send(protocol::StatusRequest{})) {
    next_status_ns_ = now_ns + kStatusPeriod_ns;
  }
  const json status = base::ParseJsonOrNull(connection_.PopStatus());
  if (!status.is_object()) return;
  HandleStatus(status);
  FollowSetup(now_ns, status);
}

void Monitor::HandleStatus(const json& status) {
  status_text_ = StatusText(true, "", status, strokes_);
  SendAll(status_text_);
  if (!(base::NumberAt(status, "/scene/sculpted") > 0)) {
    strokes_ = -1;
  } else if (save_.command == 0) {  // its answer would take the place of the copy's
    edits_command_ = connection_.SendSceneCommand(protocol::SceneAction::kEdits, 0, "");
  }
  if (trial_ == nullptr) FollowOwner(status);
}

// Looks at files of the user and at USB, for pages only.
void Monitor::FollowSetup(std::int64_t now_ns, const json& status) {
  if (!options_.setup_steps || pages_.empty() || now_ns < next_setup_ns_) return;
  next_setup_ns_ = now_ns + kSetupPeriod_ns;
  std::string text = SetupText(options_.setup_steps(status));
  if (text == setup_text_) return;
  setup_text_ = std::move(text);
  SendAll(setup_text_);
}

// The scene of the application that has the pen.
void Monitor::FollowOwner(const json& status) {
  const std::string path = base::StringAt(status, "/scene/name");
  const json* load = base::ValueAt(status, "/scene/load");
  const double generation = base::NumberAt(status, "/scene/generation");
  owners_scene_.generation = generation > 0 ? static_cast<std::uint64_t>(generation) : 0;
  const std::string wanted = path + (load == nullptr ? std::string() : load->dump());
  if (wanted == followed_) return;
  followed_ = wanted;
  owners_scene_ = {.number = owners_scene_.number + 1,
                   .revision = owners_scene_.revision + 1,
                   .name = std::filesystem::path(path).filename(),
                   .state = path.empty() ? SceneState::kNone : SceneState::kLoading,
                   .generation = owners_scene_.generation};
  if (path.empty()) return;
  if (load == nullptr || load->is_null()) {
    owners_scene_.state = SceneState::kReady;
    owners_scene_.text = "the application has handed over this scene itself: only what changes in it is drawn";
    return;
  }
  loads_.Request({.number = ++load_requests_,
                  .path = path,
                  .name = owners_scene_.name,
                  .options = OptionsOf(*load, options_.hello.device.hull_radius_m)});
}

void Monitor::HandleSceneAnswer() {
  const std::optional<client::SceneAnswer> answer = connection_.PopSceneAnswer();
  if (!answer) return;
  if (answer->number == edits_command_) {
    strokes_ = answer->done ? StrokesOf(answer->text) : -1;
    return;
  }
  if (save_.command == 0 || answer->number != save_.command) {
    if (!answer->done) SendAll(NoticeText(NoticeLevel::kWarning, answer->text));
    return;
  }
  const Save save = std::exchange(save_, {});
  if (!answer->done || answer->file.empty()) return Send(save.page, AnswerText(save.number, false, answer->text));
  SendCopy(save, trial_ == nullptr ? base::Result<std::string>(answer->file) : trial_->MakeSceneFile(answer->file));
}

void Monitor::SendCopy(const Save& save, const base::Result<std::string>& copy) {
  if (!copy.ok()) return Send(save.page, AnswerText(save.number, false, copy.error()));
  const std::string name = "touched-" + shown().name;
  server_->Send(save.page, std::make_shared<const std::string>(FileMessage(save.number, name, *copy)), true);
  Send(save.page, AnswerText(save.number, true, name));
}

// The shapes of the scene that the pages show.
void Monitor::FollowScene() {
  if (auto loaded = loads_.Poll(); loaded && loaded->number == load_requests_) {
    ++owners_scene_.revision;
    owners_scene_.state = loaded->view == nullptr ? SceneState::kFailed : SceneState::kReady;
    owners_scene_.text = loaded->error;
    owners_scene_.view = loaded->view;
    if (loaded->view != nullptr) owners_scene_.materials = loaded->view->materials;
  }
  surfaces_.Update(connection_.surfaces());
  if (shapes_of_ == shown().view) return;
  shapes_of_ = shown().view;
  shapes_.clear();
  if (shapes_of_ == nullptr) return;
  for (std::size_t i = 0; i < shapes_of_->parts.size(); ++i) {
    shapes_.push_back(std::make_shared<const std::string>(
        ShapeMessage(shown().number, static_cast<std::uint32_t>(i), shapes_of_->parts[i].shape)));
  }
}

void Monitor::SendScene(PageId id, Page& page) {
  const ShownScene& scene = shown();
  if (page.scene_number != scene.number) {
    page.shapes_sent = 0;
    page.surfaces = {};
  }
  if (page.scene_number != scene.number || page.scene_revision != scene.revision) {
    page.scene_number = scene.number;
    page.scene_revision = scene.revision;
    Send(id, SceneText(scene, trial_ != nullptr));
  }
  while (page.shapes_sent < shapes_.size()) server_->Send(id, shapes_[page.shapes_sent++], true);
  if (surfaces_.scene_generation() == 0 || surfaces_.scene_generation() != scene.generation) return;
  for (const auto& message : surfaces_.NewsFor(scene.number, page.surfaces)) server_->Send(id, message, true);
}

LiveFrame Monitor::NewestFrame() const {
  LiveFrame frame;
  frame.aim.present = 0;
  const auto state = connection_.state();
  if (state == nullptr || !state->ReadNewest(frame.newest)) return frame;
  state->ReadContacts(frame.contacts);
  state->ReadVehicle(frame.vehicle);
  state->ReadInputs(frame.inputs);
  if (frame.contacts.scene_generation != shown().generation) frame.contacts.count = 0;
  return frame;
}

void Monitor::AddTicks(std::uint64_t from, LiveFrame& frame) const {
  const auto state = connection_.state();
  if (state == nullptr) return;
  const std::uint64_t end = state->published();
  for (std::uint64_t index = from; index < end; ++index) {
    protocol::ToolSample sample;
    protocol::TelemetrySample telemetry;
    if (!state->ReadAt(index, sample, telemetry)) {
      ++frame.lost;
      continue;
    }
    frame.times_s.push_back(static_cast<double>(sample.t_ns) * 1e-9);
    for (const Channel& channel : Channels()) frame.rows.push_back(channel.value(sample, telemetry));
  }
}

// A page that has not taken the last frame yet gets this one's ticks with the next that it can take.
void Monitor::SendFrame() {
  const auto state = connection_.state();
  if (pages_.empty()) return;
  LiveFrame newest = NewestFrame();
  if (trial_ != nullptr) {
    trial_->UpdateContacts(newest.newest, newest.contacts, base::MonotonicNow_ns());
    newest.aim = trial_->aim();
  }
  const std::uint64_t end = state == nullptr ? 0 : state->published();
  constexpr std::uint64_t kKept = protocol::kRingCapacity - 2;
  std::uint64_t made_from = end + 1;
  std::shared_ptr<const std::string> message;
  for (auto& [id, page] : pages_) {
    if (!server_->IsIdle(id)) continue;
    SendScene(id, page);
    if (state == nullptr) continue;
    if (page.next_index > end) page.next_index = end;  // omnid has started again
    const std::uint64_t oldest = end > kKept ? end - kKept : 0;
    const std::uint64_t from = std::max(page.next_index, oldest);
    if (from >= end) continue;
    const auto lost = static_cast<std::uint32_t>(from - page.next_index);
    if (message == nullptr || from != made_from || lost != 0) {
      LiveFrame frame = newest;
      frame.lost = lost;
      AddTicks(from, frame);
      message = std::make_shared<const std::string>(LiveMessage(frame));
      made_from = lost != 0 ? end + 1 : from;
    }
    server_->Send(id, message, true);
    page.next_index = end;
  }
}

void Monitor::OnPage(PageId page) {
  const auto state = connection_.state();
  pages_[page] = {.next_index = state == nullptr ? 0 : state->published()};
  Send(page, hello_text_);
  Send(page, status_text_);
  if (!setup_text_.empty()) Send(page, setup_text_);
  pages_[page].scene_revision = shown().revision + 1;  // any other: it is sent
}

void Monitor::OnPageGone(PageId page) { pages_.erase(page); }

struct Monitor::RequestHandler {
  Monitor& monitor;
  PageId page;

  void Warn(std::string_view text) const { monitor.Notice(page, NoticeLevel::kWarning, text); }
  bool Lead(const protocol::HandAim& aim) const {
    if (monitor.trial_ == nullptr) return Warn("only omni try leads a simulated hand"), false;
    if (monitor.trial_->SendAim(aim)) return true;
    return Warn(monitor.trial_->problem()), false;
  }

  void operator()(const AimRequest& request) const {
    Lead({.tip_base_m = request.tip_base_m, .axis_base = request.axis_base});
  }
  void operator()(const LiftRequest& /*lift*/) const {
    if (monitor.trial_ == nullptr) return;
    protocol::HandAim aim = monitor.trial_->aim();
    aim.present = 0;
    Lead(aim);
  }
  void operator()(const SceneRequest& request) const {
    const auto found = monitor.options_.scene_paths.find(request.name);
    if (monitor.trial_ == nullptr || found == monitor.options_.scene_paths.end()) return Warn("there is no such scene");
    monitor.trial_->ChooseScene(found->second, std::filesystem::path(found->second).filename(), true);
  }
  void operator()(const MaterialRequest& request) const {
    if (monitor.trial_ == nullptr || !monitor.trial_->SetMaterial(request)) {
      Warn("this material cannot be changed now");
    }
  }
  void operator()(const EditRequest& request) const { monitor.connection_.SendSceneCommand(request.action, 0, ""); }
  void operator()(const SaveRequest& request) const {
    if (monitor.save_.command != 0) {
      return monitor.Send(page, AnswerText(request.number, false, "another copy is being made; wait for it"));
    }
    if (monitor.trial_ != nullptr && monitor.strokes_ <= 0) {
      return monitor.SendCopy({.page = page, .number = request.number}, monitor.trial_->MakeSceneFile(""));
    }
    const std::uint32_t command = monitor.connection_.SendSceneCommand(protocol::SceneAction::kSave, 0, "");
    monitor.save_ = {.page = page, .number = request.number, .command = command};
    if (command == 0) monitor.Send(page, AnswerText(request.number, false, "omnid does not answer"));
  }
  void operator()(const StopRequest& request) const {
    protocol::EmergencyStop stop;
    stop.on = request.on ? 1 : 0;
    if (!monitor.connection_.Send(stop)) {
      monitor.Notice(page, NoticeLevel::kError,
                     request.on ? "NOT STOPPED: omnid does not answer; switch the supply off"
                                : "not released: omnid does not answer");
    }
    monitor.next_status_ns_ = 0;
  }
};

void Monitor::OnText(PageId page, std::string_view text) {
  if (text.size() > kMaxRequestBytes) {
    return server_->Close(page, CloseCode::kBadMessage, "a request is longer than 4096 bytes; reload the page");
  }
  const base::Result<PageRequest> request = ReadPageRequest(text);
  if (!request.ok()) return Notice(page, NoticeLevel::kWarning, request.error());
  const auto* stop = std::get_if<StopRequest>(&*request);
  if (!options_.control && (stop == nullptr || !stop->on)) {
    return Notice(page, NoticeLevel::kWarning,
                  "this page only looks; start `omni monitor --control` to change something");
  }
  std::visit(RequestHandler{*this, page}, *request);
}

void Monitor::OnBytes(PageId page, std::string_view bytes) {
  if (trial_ == nullptr) return Notice(page, NoticeLevel::kWarning, "only omni try takes files");
  const DroppedFile file = ReadDroppedFile(bytes);
  if (!file.problem.empty()) return Notice(page, NoticeLevel::kError, std::string(file.name) + ": " + file.problem);
  const base::Status dropped = trial_->LoadDropped(file.name, file.bytes);
  if (!dropped.ok()) Notice(page, NoticeLevel::kError, dropped.error());
}

void Monitor::Send(PageId page, std::string text) {
  server_->Send(page, std::make_shared<const std::string>(std::move(text)), false);
}

void Monitor::SendAll(const std::string& text) {
  const auto message = std::make_shared<const std::string>(text);
  for (const auto& [id, page] : pages_) server_->Send(id, message, false);
}

void Monitor::Notice(PageId page, NoticeLevel level, std::string_view text) { Send(page, NoticeText(level, text)); }

}  // namespace omni::monitor
