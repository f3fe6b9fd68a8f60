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
#include <utility>
#include <vector>

#include "service/ipc/server.h"
#include "service/ipc/state_publisher.h"
#include "service/ipc/surface_publisher.h"

namespace omni::test {

std::int64_t Now_ns();

// The base as the layer guesses it: known, 0.45 m ahead of the origin of LOCAL and 0.35 m below it.
protocol::BasePose InFrontOfLocal();

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
  std::vector<protocol::ForceRequest> forces;
  std::vector<protocol::BasePoseRequest> base_pose_requests;
  std::vector<protocol::SpaceChange> space_changes;
  int gone = 0;
  // Of the scene that the application gave itself.
  std::vector<protocol::HapticSceneLoad> scene_loads;
  std::vector<std::string> scene_documents;  // as they came along
  std::vector<std::uint32_t> scene_ends;
  std::vector<protocol::HapticScenePlace> scene_places;
  std::vector<protocol::HapticSceneEnable> scene_enables;
  std::vector<protocol::HapticNodes> scene_nodes;
  std::vector<protocol::HapticMaterial> scene_materials;
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
  // A component moves now. Returns that time, of CLOCK_MONOTONIC.
  std::int64_t Set(protocol::InputIndex index, float value);

  // The force properties that it reports from now on, to every client.
  void SetForce(bool available, protocol::ForceStanding standing);

  // The base moves from the next Fill on, as BasePose says: a pose of it each kBasePeriod_ns. `trajectory` fills the
  // sample of its t_ns; flags say that it is seen.
  using BaseTrajectory = std::function<void(protocol::BaseSample&)>;
  static constexpr std::int64_t kBasePeriod_ns = 11'111'111;
  void MoveBase(BaseTrajectory trajectory);

  // Publishes samples up to now.
  void Fill();
  // Flags of the pen: lost, or never seen.
  void SetFlags(std::uint32_t flags) { flags_ = flags; }

  // It stands still in the middle of writing its inputs, as when another program has its processor; and goes on.
  void StopWhileWriting(bool stop);

  // Sends the service's settings to the layer: now, and to clients that connect later.
  void Wish(const protocol::AppSettings& settings);
  // Its replies to each document that it receives from now on, as whole messages; at first none.
  using SceneAnswer = std::function<std::vector<std::string>(const protocol::HapticSceneLoad&)>;
  void AnswerScenes(SceneAnswer answer);
  // A whole message to the newest client, within a period.
  void Say(const std::string& message);
  // What is touched, from now on.
  void SetContacts(const protocol::ContactSnapshot& contacts) { contacts_ = contacts; }
  // The surfaces that clients get, now and on request.
  void SetSurfaces(std::shared_ptr<const ipc::SurfacePublisher> surfaces);
  // Its answer to base_pose requests, also sent to clients that asked before. At first: known, in front
  // of the origin of LOCAL, where the layer also guesses it.
  void SetBasePose(const protocol::BasePose& base_pose);

  Heard heard() const;
  std::uint64_t beats() const { return beats_; }

 private:
  template <class T>
  void Hear(std::vector<T>& heard, T what) {
    const std::lock_guard lock(mutex_);
    heard.push_back(std::move(what));
  }

  void OnClient(const ipc::ClientInfo& client) override;
  void OnGone(ipc::ClientId id) override;
  void OnRequest(ipc::ClientId id, const protocol::Request& request, base::UniqueFd file) override;
  struct RequestHandler;
  void OnPeriod(std::int64_t now_ns) override;
  std::string StatusJson() override { return "{}"; }

  void FillBase(std::int64_t now_ns);

  Trajectory trajectory_;
  std::uint32_t flags_ = protocol::kToolPoseValid | protocol::kToolTracked;
  protocol::InputSnapshot inputs_;
  protocol::ContactSnapshot contacts_;
  std::vector<std::string> to_say_;
  std::shared_ptr<const ipc::SurfacePublisher> surfaces_;
  bool surfaces_wanted_ = false;
  bool surfaces_due_ = false;
  SceneAnswer scene_answer_;
  std::int64_t last_t_ns_ = 0;
  BaseTrajectory base_trajectory_;
  std::int64_t last_base_t_ns_ = 0;
  mutable std::mutex mutex_;
  Heard heard_;
  protocol::AppSettings settings_;
  bool settings_due_ = false;
  ipc::ClientId client_ = 0;
  std::optional<protocol::ForceProperties> properties_;  // to be sent; none: sent
  std::optional<protocol::ForceOwner> owner_;
  protocol::BasePose base_pose_;
  bool base_pose_changed_ = false;
  std::vector<ipc::ClientId> placed_;
  std::atomic<std::uint64_t> beats_{0};
  std::unique_ptr<ipc::StatePublisher> publisher_;
  std::unique_ptr<ipc::Server> server_;
};

}  // namespace omni::test
