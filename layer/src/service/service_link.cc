#include "layer/src/service/service_link.h"

#include <cstring>
#include <ctime>
#include <utility>

#include "layer/src/spaces/tool_motion.h"
#include "service/base/clock.h"

namespace omni::layer {
namespace {
constexpr std::int64_t kPollInterval_ns = 5'000'000;
// A service answers at once; one without base poses never does.
constexpr std::int64_t kBasePosePatience_ns = 300'000'000;
}  // namespace

ServiceLink::ServiceLink(client::ConnectionInfo info, Log& log) : connection_(std::move(info)), log_(log) {}

void ServiceLink::Poll(std::int64_t now_ns) {
  if (now_ns < next_poll_ns_.load(std::memory_order_relaxed)) return;
  const std::unique_lock lock(mutex_, std::try_to_lock);
  if (!lock.owns_lock()) return;
  next_poll_ns_.store(now_ns + kPollInterval_ns, std::memory_order_relaxed);
  connection_.Poll(now_ns);
  PublishReader();
  // NOLINTNEXTLINE(bugprone-suspicious-memory-comparison): the same bits
  if (std::memcmp(&connection_.settings(), &settings_, sizeof(settings_)) != 0) {
    const std::unique_lock settings_lock(reader_mutex_);
    settings_ = connection_.settings();
  }
  const bool connected = connection_.connected();
  if (connected && !was_connected_ && base_pose_asked_) base_pose_patience_ns_ = now_ns + kBasePosePatience_ns;
  if (const auto base_pose = connection_.PopBasePose()) {
    base_pose_ = base_pose;
    base_pose_patience_ns_ = 0;
    base_pose_came_.store(true, std::memory_order_release);
  }
  for (const protocol::Notice& notice : connection_.PopNotices())
    log_.WriteLine(std::string("service says: ") + notice.text);
  if (connected && !was_connected_) connection_number_.fetch_add(1, std::memory_order_relaxed);
  if (connected != was_connected_) log_.WriteLine(connected ? "connected to omnid" : "connection to omnid lost");
  if (!connected && connection_.last_error() != last_error_) {
    last_error_ = connection_.last_error();
    if (!last_error_.empty()) log_.WriteLine(last_error_);
  }
  was_connected_ = connected;
}

void ServiceLink::PublishReader() {
  std::shared_ptr<const client::StateReader> now = connection_.state();
  if (now == reader_) return;  // only written under mutex_, which is held here
  const std::unique_lock lock(reader_mutex_);
  reader_.swap(now);
}

void ServiceLink::SetSession(protocol::SessionState state) {
  const std::lock_guard lock(mutex_);
  if (state == session_) return;
  session_ = state;
  connection_.SendSession(state);  // the connection retries what was not sent
}

void ServiceLink::SendHaptic(std::int64_t duration_ns, float amplitude, float frequency_Hz) {
  const std::lock_guard lock(mutex_);
  connection_.SendHaptic(duration_ns, amplitude, frequency_Hz);
}

void ServiceLink::HapticStop() {
  const std::lock_guard lock(mutex_);
  connection_.Send(protocol::HapticStop{});
}

void ServiceLink::ClaimForce(bool wanted) {
  const std::lock_guard lock(mutex_);
  connection_.ClaimForce(wanted);  // the connection retries what was not sent
}

void ServiceLink::SendForce(const protocol::ForceApply& apply) {
  const std::lock_guard lock(mutex_);
  connection_.Send(apply);
}

bool ServiceLink::SendConstraints(const protocol::ForceConstraints& constraints) {
  const std::lock_guard lock(mutex_);
  return connection_.Send(constraints);
}

void ServiceLink::StopForce() {
  const std::lock_guard lock(mutex_);
  connection_.Send(protocol::ForceStop{});
}

protocol::ForceStanding ServiceLink::force_standing() const {
  const std::lock_guard lock(mutex_);
  return connection_.force_standing();
}

protocol::ForceProperties ServiceLink::force_properties() const {
  const std::lock_guard lock(mutex_);
  return connection_.force_properties();
}

bool ServiceLink::AwaitsForceProperties() const {
  const std::lock_guard lock(mutex_);
  return connection_.awaits_force_properties();
}

void ServiceLink::AwaitForceProperties() {
  std::int64_t now_ns = base::MonotonicNow_ns();
  const std::int64_t end_ns = now_ns + kDevicePatience_ns;
  PollNow(now_ns);
  if (!AwaitsForceProperties() || force_properties_awaited_.exchange(true)) return;
  while (now_ns < end_ns && AwaitsForceProperties()) {
    constexpr timespec kPause{.tv_sec = 0, .tv_nsec = 1'000'000};
    nanosleep(&kPause, nullptr);
    now_ns = base::MonotonicNow_ns();
    PollNow(now_ns);
  }
}

void ServiceLink::RequestBasePose(const protocol::BasePoseRequest& request) {
  const std::lock_guard lock(mutex_);
  base_pose_asked_ = true;
  if (connection_.RequestBasePose(request)) base_pose_patience_ns_ = base::MonotonicNow_ns() + kBasePosePatience_ns;
}

std::optional<protocol::BasePose> ServiceLink::PopBasePose() {
  if (!base_pose_came_.load(std::memory_order_acquire)) return std::nullopt;
  const std::lock_guard lock(mutex_);
  base_pose_came_.store(false, std::memory_order_relaxed);
  return std::exchange(base_pose_, std::nullopt);
}

void ServiceLink::SendSpaceChange(const protocol::SpaceChange& change) {
  const std::lock_guard lock(mutex_);
  connection_.Send(change);
}

bool ServiceLink::SendWaveform(const protocol::Waveform& waveform, const std::vector<float>& samples) {
  const std::lock_guard lock(mutex_);
  return connection_.SendWaveform(waveform, samples);
}

std::shared_ptr<const client::StateReader> ServiceLink::reader() const {
  if (test_ && test_->in_control()) return test_->reader();
  const std::shared_lock lock(reader_mutex_);
  return reader_;
}

protocol::AppSettings ServiceLink::settings() const {
  const std::shared_lock lock(reader_mutex_);
  return settings_;
}

PenChoice ServiceLink::choice() const {
  const protocol::AppSettings wished = settings();
  return {.hand = fixed_hand_.value_or(wished.hand == protocol::HandSetting::kLeft ? Hand::kLeft : Hand::kRight),
          .profile = fixed_profile_.empty() ? std::string(wished.profile) : fixed_profile_};
}

PenSnapshot ServiceLink::ReadPen(std::int64_t now_ns, const PenSnapshot& before) const {
  PenSnapshot pen;
  const std::shared_ptr<const client::StateReader> state = reader();
  if (!state) return pen;
  pen.service_instance = state->service_instance();
  if (!state->ReadNewest(pen.sample) || !state->ReadInputs(pen.inputs)) {
    const bool stands = before.present && before.service_instance == pen.service_instance &&
                        now_ns - before.sample.t_ns <= kPresenceTimeout_ns;
    return stands ? before : pen;
  }
  const bool placed = now_ns >= base_pose_patience_ns_.load(std::memory_order_relaxed);
  pen.present =
      placed && now_ns - pen.sample.t_ns <= kPresenceTimeout_ns && (pen.sample.flags & protocol::kToolPoseValid) != 0;
  return pen;
}

}  // namespace omni::layer
