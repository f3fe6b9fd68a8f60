// A service for the layer's tests: the real socket and state memory, a pen that does what the test says.
// Samples are published when the test asks for it, up to the present, one per millisecond: no thread races the test.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "service/ipc/server.h"
#include "service/ipc/state_publisher.h"

namespace omni::test {

std::int64_t Now_ns();

struct Heard {
  std::vector<std::string> applications;
  std::vector<protocol::SessionState> sessions;
  std::vector<protocol::Haptic> haptics;
  struct Shaped {
    protocol::Waveform waveform;
    std::vector<float> samples;
  };
  std::vector<Shaped> waveforms;
  int haptic_stops = 0;
  int gone = 0;
  // Empty: no session was ever reported.
  std::optional<protocol::SessionState> last_session() const {
    return sessions.empty() ? std::nullopt : std::optional(sessions.back());
  }
};

class FakeService : private ipc::ServerHandler {
 public:
  using Trajectory = std::function<void(protocol::ToolSample&)>;  // fills the sample of its t_ns

  FakeService();  // on $OMNI_SOCKET
  ~FakeService() override;

  void SetTrajectory(Trajectory trajectory) { trajectory_ = std::move(trajectory); }
  // A component moves now.
  void Set(protocol::InputIndex index, float value);

  // Publishes samples up to now.
  void Fill();
  // A pen that is seen no more, or not seen.
  void SetFlags(std::uint32_t flags) { flags_ = flags; }

  Heard heard() const;
  std::int64_t last_beat_ns() const { return last_beat_ns_; }

 private:
  void OnClient(const ipc::ClientInfo& client) override;
  void OnGone(ipc::ClientId id) override;
  void OnSession(ipc::ClientId id, protocol::SessionState state) override;
  void OnHaptic(ipc::ClientId id, const protocol::Haptic& haptic) override;
  void OnHapticStop(ipc::ClientId id) override;
  void OnWaveform(ipc::ClientId id, const protocol::ShapedHaptic& haptic) override;
  void OnSceneCommand(ipc::ClientId /*id*/, const protocol::SceneCommand& /*command*/) override {}
  void OnPeriod(std::int64_t now_ns) override;
  std::string StatusJson() override { return "{}"; }

  Trajectory trajectory_;
  std::uint32_t flags_ = protocol::kToolPoseValid | protocol::kToolTracked;
  protocol::InputSnapshot inputs_;
  std::int64_t last_t_ns_ = 0;
  mutable std::mutex mutex_;
  Heard heard_;
  ipc::ClientId client_ = 0;
  std::atomic<std::int64_t> last_beat_ns_{0};
  std::unique_ptr<ipc::StatePublisher> publisher_;
  std::unique_ptr<ipc::Server> server_;
};

}  // namespace omni::test
