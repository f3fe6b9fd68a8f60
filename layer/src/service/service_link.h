// The one connection to omnid of an XrInstance: who may call what, and when.
//
// Poll and the sends take a mutex; SignalAlive and reader() may be called from any thread at any time. Only
// AwaitForceProperties blocks: every socket call below is non-blocking, and Poll returns when another thread is already
// polling.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <shared_mutex>
#include <string>
#include <utility>
#include <vector>

#include "layer/src/actions/test_device.h"
#include "layer/src/instance/log.h"
#include "service/client/connection.h"

namespace omni::layer {

class ServiceLink {
 public:
  ServiceLink(client::ConnectionInfo info, Log& log);

  void SignalAlive() noexcept {
    connection_.SignalAlive();
    if (test_) test_->RefreshSample();
  }
  void Poll(std::int64_t now_ns);
  // The same, however recent the last poll was.
  void PollNow(std::int64_t now_ns) {
    next_poll_ns_.store(0, std::memory_order_relaxed);
    Poll(now_ns);
  }

  void SetSession(protocol::SessionState state);
  void SendHaptic(std::int64_t duration_ns, float amplitude, float frequency_Hz);
  void HapticStop();
  // False: not sent.
  bool SendWaveform(const protocol::Waveform& waveform, const std::vector<float>& samples);

  // Before this link is shared: a pen that a conformance test may take over.
  void UseTestDevice(std::unique_ptr<TestDevice> device) { test_ = std::move(device); }
  // The same: what the environment sets, whatever the service says. Empty: nothing.
  void Fix(std::optional<Hand> hand, std::string profile) {
    fixed_hand_ = hand;
    fixed_profile_ = std::move(profile);
  }
  // Null: no test mode.
  TestDevice* test() const { return test_.get(); }
  void ClaimForce(bool wanted);
  void SendForce(const protocol::ForceApply& apply);
  bool SendConstraints(const protocol::ForceConstraints& constraints);  // false: not sent
  void StopForce();
  protocol::ForceStanding force_standing() const;
  protocol::ForceProperties force_properties() const;
  // Polls the socket. If the service is connected but has not reported its device's properties yet, the first call
  // waits for them, at most kDevicePatience_ns; no other call waits, and none without a service.
  void AwaitForceProperties();
  static constexpr std::int64_t kDevicePatience_ns = 100'000'000;
  // Counts connections from 1: a new one knows nothing that was sent over an earlier one.
  std::uint64_t connection_number() const { return connection_number_.load(std::memory_order_relaxed); }
  // Calls use(connection) exclusively; must be short and call no runtime function.
  template <class Use>
  auto WithConnection(Use use) {
    const std::lock_guard lock(mutex_);
    return use(connection_);
  }
  // Requests where the base stands; repeated after a lost connection.
  void RequestBasePose(const protocol::BasePoseRequest& request);
  // The newest answer since the last call. No lock where there is none.
  std::optional<protocol::BasePose> PopBasePose();
  void SendSpaceChange(const protocol::SpaceChange& change);

  std::shared_ptr<const client::StateReader> reader() const;
  // `before`: what was read last. It stands when the service was interrupted while it wrote, for as long as its sample
  // is recent: a pen is not put down because of that.
  PenSnapshot ReadPen(std::int64_t now_ns, const PenSnapshot& before) const;
  // The service's settings for this application; defaults until it has sent them.
  protocol::AppSettings settings() const;
  // The pen's hand and preferred profile: from the environment, else from the service.
  PenChoice choice() const;

 private:
  void PublishReader();
  bool AwaitsForceProperties() const;

  client::Connection connection_;
  std::unique_ptr<TestDevice> test_;
  std::optional<Hand> fixed_hand_;
  std::string fixed_profile_;
  Log& log_;
  mutable std::mutex mutex_;  // of connection_ (except SignalAlive) and of what follows
  protocol::SessionState session_ = protocol::SessionState::kNone;
  bool was_connected_ = false;
  std::string last_error_;
  bool base_pose_asked_ = false;
  std::optional<protocol::BasePose> base_pose_;
  std::atomic<bool> base_pose_came_{false};
  // Until then the pen is absent for a session that waits for its base pose: it would jump. 0: no session waits.
  std::atomic<std::int64_t> base_pose_patience_ns_{0};
  std::atomic<std::int64_t> next_poll_ns_{0};
  std::atomic<std::uint64_t> connection_number_{0};
  std::atomic<bool> force_properties_awaited_{false};

  mutable std::shared_mutex reader_mutex_;
  std::shared_ptr<const client::StateReader> reader_;
  protocol::AppSettings settings_;
};

}  // namespace omni::layer
