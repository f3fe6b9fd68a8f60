#include "tests/layer/support/fake_service.h"

#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <variant>

namespace omni::test {
namespace {

constexpr std::int64_t kSamplePeriod_ns = 1'000'000;
constexpr std::int64_t kHistory_ns = 300'000'000;

std::uint64_t NextServiceInstance() {
  static std::uint64_t instance = 100;
  return ++instance;
}

}  // namespace

std::int64_t Now_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

protocol::BasePose InFrontOfLocal() {
  protocol::BasePose base_pose;
  const double h = std::sqrt(0.5);
  base_pose.known = 1;
  base_pose.base_space = {.position_m = {0, -0.35, -0.45}, .orientation_wxyz = {h, -h, 0, 0}};
  return base_pose;
}

FakeService::FakeService() : base_pose_(InFrontOfLocal()) {
  trajectory_ = [](protocol::ToolSample& sample) { sample.position_base_m = {0, 0, 0.06}; };
  const std::uint64_t instance = NextServiceInstance();
  auto publisher = ipc::StatePublisher::Create(instance);
  if (!publisher.ok()) throw std::runtime_error(publisher.error());
  publisher_ = std::move(publisher.value());
  Fill();
  ipc::ServerOptions options;
  options.service_instance = instance;
  options.state_fd = publisher_->fd();
  auto server = ipc::Server::Open(options, *this);
  if (!server.ok()) throw std::runtime_error(server.error());
  server_ = std::move(server.value());
  server_->Start();
}

FakeService::~FakeService() { server_->Stop(); }

std::int64_t FakeService::Set(protocol::InputIndex index, float value) {
  protocol::InputValue& input = inputs_.components[static_cast<std::size_t>(index)];
  if (input.value <= 0.5f && value > 0.5f) ++input.press_count;
  if (input.value > 0.5f && value <= 0.5f) ++input.release_count;
  input.value = value;
  input.t_change_ns = Now_ns();
  return input.t_change_ns;
}

void FakeService::Fill() {
  const std::int64_t now = Now_ns();
  last_t_ns_ = std::max(last_t_ns_, now - kHistory_ns);
  // One more at the end, so that what the test has just set is always seen.
  while (last_t_ns_ < now) {
    last_t_ns_ = std::min(last_t_ns_ + kSamplePeriod_ns, now);
    protocol::ToolSample sample;
    sample.t_ns = last_t_ns_;
    sample.flags = flags_;
    trajectory_(sample);
    inputs_.t_ns = contacts_.t_ns = last_t_ns_;
    publisher_->PublishContacts(contacts_);
    publisher_->Publish(sample, inputs_);
  }
  FillBase(now);
}

void FakeService::FillBase(std::int64_t now_ns) {
  if (!base_trajectory_) return;
  last_base_t_ns_ = std::max(last_base_t_ns_, now_ns - kHistory_ns);
  while (last_base_t_ns_ + kBasePeriod_ns <= now_ns) {
    protocol::BaseSample sample;
    sample.t_ns = last_base_t_ns_ += kBasePeriod_ns;
    sample.flags = protocol::kBaseSeen;
    base_trajectory_(sample);
    publisher_->PublishBase(sample);
  }
}

void FakeService::MoveBase(BaseTrajectory trajectory) {
  base_trajectory_ = std::move(trajectory);
  protocol::BasePose moving = InFrontOfLocal();
  moving.follows = 1;
  SetBasePose(moving);
}

// The publisher's own mapping is the only one of this memory that can be written.
void FakeService::StopWhileWriting(bool stop) {
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);) {
    if (line.find("rw-s") == std::string::npos || line.find("memfd:omni-state") == std::string::npos) continue;
    const std::uintptr_t address = std::stoull(line, nullptr, 16);
    auto& sequence = reinterpret_cast<protocol::StateMemory*>(address)->inputs.sequence;
    sequence.store(stop ? sequence.load() - 1 : sequence.load() + 1);
    return;
  }
  std::abort();
}

Heard FakeService::heard() const {
  const std::lock_guard lock(mutex_);
  return heard_;
}

void FakeService::OnClient(const ipc::ClientInfo& client) {
  const std::lock_guard lock(mutex_);
  heard_.applications.push_back(client.application);
  client_ = client.id;
  settings_due_ = !server_->Send(client_, settings_);  // before any answer, as omnid does
}

void FakeService::Wish(const protocol::AppSettings& settings) {
  const std::lock_guard lock(mutex_);
  settings_ = settings;
  settings_due_ = true;
}

void FakeService::OnGone(ipc::ClientId) {
  const std::lock_guard lock(mutex_);
  ++heard_.gone;
}

void FakeService::SetForce(bool available, protocol::ForceStanding standing) {
  const std::lock_guard lock(mutex_);
  properties_.emplace();
  if (available) {
    properties_->available = 1;
    properties_->max_force_N = 2;
    properties_->continuous_force_N = 0.5;
    properties_->max_stiffness_N_m = 1000;
    properties_->max_damping_Ns_m = 1;
    properties_->update_rate_Hz = 1000;
    properties_->inner_radius_m = 0.04;
    properties_->outer_radius_m = 0.15;
    properties_->reach_count = 2;
    properties_->reach[0] = {0.04, 1.5};
    properties_->reach[1] = {0.15, 0.1};
  }
  owner_.emplace();
  owner_->standing = standing;
}

void FakeService::SetBasePose(const protocol::BasePose& base_pose) {
  const std::lock_guard lock(mutex_);
  base_pose_ = base_pose;
  base_pose_changed_ = true;
}

void FakeService::SetSurfaces(std::shared_ptr<const ipc::SurfacePublisher> surfaces) {
  const std::lock_guard lock(mutex_);
  surfaces_ = std::move(surfaces);
  surfaces_due_ = true;
}

struct FakeService::RequestHandler {
  FakeService& service;
  const ipc::ClientId id;
  base::UniqueFd& file;

  void operator()(const protocol::Session& session) const { service.Hear(service.heard_.sessions, session.state); }
  void operator()(const protocol::Haptic& haptic) const { service.Hear(service.heard_.haptics, haptic); }
  void operator()(const protocol::HapticStop& /*stop*/) const {
    const std::lock_guard lock(service.mutex_);
    ++service.heard_.haptic_stops;
  }
  void operator()(const protocol::ShapedHaptic& haptic) const {
    Heard::Shaped shaped{haptic.waveform, {}};
    for (std::uint32_t i = 0; i < haptic.waveform.count; ++i) shaped.samples.push_back(haptic.sample(i));
    service.Hear(service.heard_.waveforms, std::move(shaped));
  }
  template <class M>
  requires std::is_constructible_v<protocol::ForceRequest, const M&>
  void operator()(const M& force) const { service.Hear(service.heard_.forces, protocol::ForceRequest(force)); }
  void operator()(const protocol::EmergencyStop& /*stop*/) const {}
  void operator()(const protocol::SurfaceRequest& request) const {
    const std::lock_guard lock(service.mutex_);
    service.surfaces_wanted_ = service.surfaces_due_ = request.wanted != 0;
  }
  void operator()(const protocol::HapticSceneLoad& load) const {
    std::string bytes(load.bytes, '\0');
    if (::pread(file.get(), bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) bytes.clear();
    const std::lock_guard lock(service.mutex_);
    service.heard_.scene_loads.push_back(load);
    service.heard_.scene_documents.push_back(bytes);
    if (!service.scene_answer_) return;
    for (std::string& message : service.scene_answer_(load)) service.to_say_.push_back(std::move(message));
  }
  void operator()(const protocol::HapticSceneEnd& end) const { service.Hear(service.heard_.scene_ends, end.number); }
  void operator()(const protocol::HapticScenePlace& place) const { service.Hear(service.heard_.scene_places, place); }
  void operator()(const protocol::HapticSceneEnable& on) const { service.Hear(service.heard_.scene_enables, on); }
  void operator()(const protocol::HapticNodes& nodes) const { service.Hear(service.heard_.scene_nodes, nodes); }
  void operator()(const protocol::HapticMaterial& m) const { service.Hear(service.heard_.scene_materials, m); }
  void operator()(const protocol::BasePoseRequest& request) const {
    const std::lock_guard lock(service.mutex_);
    service.heard_.base_pose_requests.push_back(request);
    service.placed_.push_back(id);
    service.server_->Send(id, service.base_pose_);
  }
  void operator()(const protocol::SpaceChange& change) const { service.Hear(service.heard_.space_changes, change); }
  void operator()(const protocol::SceneCommand& /*command*/) const {}
  void operator()(const protocol::BasePoseCommand& /*command*/) const {}
  void operator()(const protocol::BaseMotion& /*motion*/) const {}
};

void FakeService::OnRequest(ipc::ClientId id, const protocol::Request& request, base::UniqueFd file) {
  std::visit(RequestHandler{*this, id, file}, request);
}

void FakeService::OnPeriod(std::int64_t) {
  const std::lock_guard lock(mutex_);
  if (base_pose_changed_) {
    for (const ipc::ClientId id : placed_) server_->Send(id, base_pose_);
    base_pose_changed_ = false;
  }
  if (client_ == 0) return;
  if (const auto life = server_->LifePageOf(client_)) beats_ = life->beat.load();
  if (settings_due_) server_->Send(client_, settings_);
  settings_due_ = false;
  if (properties_ && server_->Send(client_, *properties_)) properties_.reset();
  if (owner_ && server_->Send(client_, *owner_)) owner_.reset();
  if (surfaces_ && surfaces_wanted_ && surfaces_due_) {
    protocol::Surfaces announced;
    announced.total_bytes = surfaces_->bytes();
    announced.memory_generation = surfaces_->id().memory_generation;
    surfaces_due_ = !server_->Send(client_, announced, {}, surfaces_->fd());
  }
  while (!to_say_.empty() && server_->SendBytes(client_, to_say_.front())) {
    to_say_.erase(to_say_.begin());
  }
}

void FakeService::Say(const std::string& message) {
  const std::lock_guard lock(mutex_);
  to_say_.push_back(message);
}

void FakeService::AnswerScenes(SceneAnswer answer) {
  const std::lock_guard lock(mutex_);
  scene_answer_ = std::move(answer);
}

}  // namespace omni::test
