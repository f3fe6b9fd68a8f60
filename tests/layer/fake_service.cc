#include "tests/layer/fake_service.h"

#include <time.h>

#include <algorithm>
#include <stdexcept>

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

FakeService::FakeService() {
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

void FakeService::Set(protocol::InputIndex index, float value) {
  protocol::InputValue& input = inputs_.components[static_cast<std::size_t>(index)];
  if (input.value <= 0.5f && value > 0.5f) ++input.press_count;
  if (input.value > 0.5f && value <= 0.5f) ++input.release_count;
  input.value = value;
  input.t_change_ns = Now_ns();
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
    inputs_.t_ns = last_t_ns_;
    publisher_->Publish(sample, inputs_);
  }
}

Heard FakeService::heard() const {
  const std::lock_guard lock(mutex_);
  return heard_;
}

void FakeService::OnClient(const ipc::ClientInfo& client) {
  const std::lock_guard lock(mutex_);
  heard_.applications.push_back(client.application);
  client_ = client.id;
}

void FakeService::OnGone(ipc::ClientId) {
  const std::lock_guard lock(mutex_);
  ++heard_.gone;
}

void FakeService::OnSession(ipc::ClientId, protocol::SessionState state) {
  const std::lock_guard lock(mutex_);
  heard_.sessions.push_back(state);
}

void FakeService::OnHaptic(ipc::ClientId, const protocol::Haptic& haptic) {
  const std::lock_guard lock(mutex_);
  heard_.haptics.push_back(haptic);
}

void FakeService::OnHapticStop(ipc::ClientId) {
  const std::lock_guard lock(mutex_);
  ++heard_.haptic_stops;
}

void FakeService::OnWaveform(ipc::ClientId, const protocol::ShapedHaptic& haptic) {
  Heard::Shaped shaped{haptic.waveform, {}};
  for (std::uint32_t i = 0; i < haptic.waveform.count; ++i) shaped.samples.push_back(haptic.sample(i));
  const std::lock_guard lock(mutex_);
  heard_.waveforms.push_back(std::move(shaped));
}

void FakeService::OnPeriod(std::int64_t) {
  const std::lock_guard lock(mutex_);
  if (client_ != 0) last_beat_ns_ = server_->LastBeat_ns(client_);
}

}  // namespace omni::test
