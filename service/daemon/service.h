// The service: connects clients (ipc), scenes (builder) and the loop. All its state belongs to the control thread,
// except the loop, which the main thread attaches and detaches under a mutex when a device comes and goes.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "service/base/priority_mutex.h"
#include "service/config/files/app_file.h"
#include "service/config/files/calibration_file.h"
#include "service/config/inputs/input_settings.h"
#include "service/daemon/clients/base_pose_writer.h"
#include "service/daemon/clients/base_poses.h"
#include "service/daemon/clients/emergency_stop.h"
#include "service/daemon/clients/followed_base.h"
#include "service/daemon/clients/force_clients.h"
#include "service/daemon/clients/owner.h"
#include "service/daemon/clients/vibration.h"
#include "service/daemon/keys/key_thread.h"
#include "service/daemon/scenes/app_scenes.h"
#include "service/daemon/scenes/scene_builder.h"
#include "service/daemon/scenes/sculpt_thread.h"
#include "service/daemon/scenes/surface_clients.h"
#include "service/device/transport.h"
#include "service/ipc/server.h"
#include "service/loop/tick_thread.h"
#include "service/room/room_finding.h"

namespace omni::daemon {

struct ServiceOptions {
  std::string version;
  std::uint64_t instance = 0;
  config::AppTable apps;
  config::InputPlan inputs;  // of `apps`
  double hull_radius_m = 0;
  std::string cache_folder;               // of built scenes; empty: none
  config::CalibrationChoice calibration;  // until SetCalibration
  std::uint32_t soft_tets = scene::kSoftTets;
  std::string hand = "auto";               // "left", "right": of applications whose file names none
  std::string alignment_path;              // where bases stand in headsets' spaces; empty: nothing is stored
  std::string stop_path;                   // latch of an emergency stop; empty: none is kept
  bool base_follows = false;               // also before a tool reports where the base is
  std::function<void(bool)> on_aligned{};  // control thread: whether the owner's headset has a measured placement
  std::function<void(const protocol::BaseSample&)> on_base{};  // control thread: where a base that moves is
};

class Service : public ipc::ServerHandler {
 public:
  explicit Service(ServiceOptions options);
  ~Service() override;

  void SetServer(ipc::Server* server) { server_ = server; }  // before the server starts

  // Any thread. Both outlive the attachment. Detach stops the loop and returns when the service no longer uses either.
  void Attach(loop::TickThread& loop, const device::Transport& transport);
  void Detach(const std::string& why);
  // Any thread: takes the coils to zero while the process ends. Waits briefly for the loop.
  void CoilsToZero() noexcept;
  // Any thread: the calibration of the device that is being opened.
  void SetCalibration(config::CalibrationChoice choice);
  // Any thread: message that a magnet is near, but no pose explains the sensors' readings; empty: this is not the case.
  // Until the next SetCalibration.
  void SetMisfit(std::string misfit);
  // Any thread: that this computer does not keep up with the base; empty: it does. Until the next SetCalibration.
  void SetStarved(std::string starved);
  // Any thread: what is wrong with sensors or the room. Until the next SetCalibration.
  void SetRoom(std::vector<room::RoomFinding> findings);
  // Any thread: the field about the base, each second in which it is known.
  void SetField(const room::RoomField& field);
  // Any thread: what forces the device that is attached, or about to be, can make. Detach resets it.
  void SetForceProperties(const protocol::ForceProperties& properties);
  // Any thread: how long there has been neither a client nor an emergency stop.
  double Idle_s() const;
  // Any thread: keys have changed.
  void SetKeys(const base::KeyStates& keys);

  void OnClient(const ipc::ClientInfo& client) override;
  void OnGone(ipc::ClientId id) override;
  void OnRequest(ipc::ClientId id, const protocol::Request& request, base::UniqueFd file) override;
  void OnPeriod(std::int64_t now_ns) override;
  std::string StatusJson() override;

 private:
  struct Client {
    ipc::ClientInfo info;
    const config::AppEntry* app = nullptr;  // null: no entry matches
    std::shared_ptr<const BuiltScene> scene;
    bool session_seen = false;  // one has begun since it connected
  };
  struct RequestHandler;  // one call for each alternative of protocol::Request
  void SetSession(ipc::ClientId id, protocol::SessionState state);
  template <class M>
  void Send(ipc::ClientId id, const M& message, std::string_view tail = {}) {
    if (server_ != nullptr) server_->Send(id, message, tail);
  }
  void HandleBuiltScenes();
  void TakeAppScene(BuiltScene built);
  std::shared_ptr<const BuiltScene> SceneOf(ipc::ClientId id) const;  // that is active while this client owns the force
  void HandleSoftBodies();
  void HandleSculptResults();
  void ReleaseScenes();
  void ReleaseLives();
  void CloseGate();
  void WriteCommands(std::int64_t now_ns);
  void HandOverLife(ipc::ClientId owner);
  void UpdateSurfaces();
  void FeelField();
  void SendForceProperties();
  void SendBasePoses();
  void PublishBase(const std::optional<protocol::BaseSample>& sample);
  bool Aligned() const;
  bool ReadSnapshot(loop::SurfaceSnapshot& snapshot);  // on the surface thread
  protocol::AppSettings SettingsFor(const config::AppEntry* app) const;
  void DropScene(Client& client);
  const base::InputMapping& MappingOf(const Client* client) const;
  void Problem(ipc::ClientId id, int level, const std::string& text);

  const ServiceOptions options_;
  const std::int64_t start_ns_;
  ipc::Server* server_ = nullptr;
  OwnerTable owners_;
  std::map<ipc::ClientId, Client> clients_;
  SceneBuilder builder_;
  SculptThread sculpt_;
  std::shared_ptr<const BuiltScene> wanted_;                // of the owner; null: empty
  std::uint64_t generation_ = 0;                            // of `wanted_`: counts the hand-overs to the tick
  std::vector<std::shared_ptr<const BuiltScene>> retired_;  // until the tick has taken the newest hand-over
  std::shared_ptr<const protocol::LifePage> life_;          // of the owner; null: none
  std::uint64_t life_number_ = 0;                           // of `life_`: counts the hand-overs to the tick
  std::vector<std::shared_ptr<const protocol::LifePage>> retired_lives_;  // as retired_
  loop::Commands commands_;                                               // that the tick was given last
  AppScenes app_scenes_;
  Vibration vibration_;
  ForceClients force_;
  BasePoseWriter base_pose_writer_;
  BasePoses base_poses_;
  FollowedBase followed_base_;
  std::int64_t felt_second_ns_ = 0;  // of the field that it knows
  EmergencyStop stop_;
  std::atomic<std::int64_t> busy_ns_;  // newest period with a client, or with forces stopped
  std::vector<std::string> problems_;  // newest last, at most kMaxProblems

  base::PriorityMutex loop_mutex_;
  loop::TickThread* loop_ = nullptr;
  const device::Transport* transport_ = nullptr;
  config::CalibrationChoice calibration_;
  std::string misfit_, starved_;
  std::vector<room::RoomFinding> room_;
  room::RoomField field_;
  protocol::ForceProperties force_properties_;
  std::string device_absent_why_ = "not opened yet";
  base::KeyStates key_states_;
  std::unique_ptr<KeyThread> keys_;  // null: no device is to be read. Its thread uses the loop
  SurfaceClients surfaces_;          // last member: its thread uses the loop
};

}  // namespace omni::daemon
