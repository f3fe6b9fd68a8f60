#include "layer/src/service_link.h"

#include <utility>

#include "layer/src/tool_motion.h"

namespace omni::layer {
namespace {
constexpr std::int64_t kPollInterval_ns = 5'000'000;
}

ServiceLink::ServiceLink(client::ConnectionInfo info, Log& log) : connection_(std::move(info)), log_(log) {}

void ServiceLink::Poll(std::int64_t now_ns) {
  if (now_ns < next_poll_ns_.load(std::memory_order_relaxed)) return;
  const std::unique_lock lock(mutex_, std::try_to_lock);
  if (!lock.owns_lock()) return;
  next_poll_ns_.store(now_ns + kPollInterval_ns, std::memory_order_relaxed);
  connection_.Poll(now_ns);
  PublishReader();
  const bool connected = connection_.connected();
  for (const protocol::Notice& notice : connection_.TakeNotices())
    log_.Line(std::string("service says: ") + notice.text);
  if (connected != was_connected_) log_.Line(connected ? "connected to omnid" : "connection to omnid lost");
  if (!connected && connection_.last_error() != last_error_) {
    last_error_ = connection_.last_error();
    if (!last_error_.empty()) log_.Line(last_error_);
  }
  was_connected_ = connected;
}

void ServiceLink::PublishReader() {
  std::shared_ptr<const client::StateReader> now = connection_.state();
  if (now == reader_) return;  // only written under mutex_, which we hold
  const std::unique_lock lock(reader_mutex_);
  reader_.swap(now);
}

void ServiceLink::SetSession(protocol::SessionState state) {
  const std::lock_guard lock(mutex_);
  if (state == session_) return;
  session_ = state;
  connection_.SendSession(state);  // the connection repeats what did not get through
}

void ServiceLink::Haptic(std::int64_t duration_ns, float amplitude, float frequency_Hz) {
  const std::lock_guard lock(mutex_);
  connection_.SendHaptic(duration_ns, amplitude, frequency_Hz);
}

void ServiceLink::HapticStop() {
  const std::lock_guard lock(mutex_);
  connection_.SendHapticStop();
}

bool ServiceLink::Waveform(const protocol::Waveform& waveform, const std::vector<float>& samples) {
  const std::lock_guard lock(mutex_);
  return connection_.SendWaveform(waveform, samples);
}

std::shared_ptr<const client::StateReader> ServiceLink::reader() const {
  const std::shared_lock lock(reader_mutex_);
  return reader_;
}

PenSnapshot ServiceLink::Read(std::int64_t now_ns) const {
  PenSnapshot pen;
  const std::shared_ptr<const client::StateReader> state = reader();
  if (!state || !state->Newest(pen.sample) || !state->Inputs(pen.inputs)) return pen;
  pen.service_instance = state->service_instance();
  pen.present = now_ns - pen.sample.t_ns <= kPresenceTimeout_ns && (pen.sample.flags & protocol::kToolPoseValid) != 0;
  return pen;
}

}  // namespace omni::layer
