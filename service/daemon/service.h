// The service: connects clients (ipc), scenes and the loop. It takes what clients send and passes it on to the part
// that it is about. All its state belongs to the control thread, except the device, which the main thread attaches and
// detaches when one comes and goes.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "service/base/threads/realtime_threads.h"
#include "service/config/files/app_file.h"
#include "service/config/files/calibration_file.h"
#include "service/config/inputs/input_settings.h"
#include "service/daemon/clients/base_poses.h"
#include "service/daemon/clients/clients.h"
#include "service/daemon/clients/emergency_stop.h"
#include "service/daemon/clients/followed_base.h"
#include "service/daemon/clients/force_clients.h"
#include "service/daemon/clients/tick_commands.h"
#include "service/daemon/devices/attached_device.h"
#include "service/daemon/keys/key_thread.h"
#include "service/daemon/scenes/client_scenes.h"
#include "service/daemon/scenes/surface_clients.h"
#include "service/ipc/server.h"

namespace omni::daemon {

struct ServiceOptions {
  std::string version;
  std::uint64_t instance = 0;
  config::AppTable apps;
  config::InputPlan inputs;  // of `apps`
  double hull_radius_m = 0;
  double tip_radius_m = scene::LoadOptions{}.tip_radius_m;  // of the pen
  std::string cache_folder;                                 // of built scenes; empty: none
  config::CalibrationChoice calibration;                    // until AttachedDevice::SetCalibration
  std::uint32_t soft_tets = scene::kSoftTets;
  std::string hand = "auto";   // "left", "right": of applications whose file names none
  std::string alignment_path;  // where bases stand in headsets' spaces; empty: nothing is stored
  std::string journal_folder;  // of sculpted strokes; empty: they are not kept
  std::string stop_path;       // latch of an emergency stop; empty: none is kept
  std::shared_ptr<const BuildWay> build_way = std::make_shared<const BuildHere>();
  std::string builds_refused;              // why no scene is built; empty: they are
  bool base_follows = false;               // also before a tool reports where the base is
  std::function<void(bool)> on_aligned{};  // control thread: whether the owner's headset has a measured base pose
  std::function<void(const protocol::BaseSample&)> on_base{};  // control thread: where a base that moves is
};

class Service : public ipc::ServerHandler {
 public:
  explicit Service(ServiceOptions options);
  ~Service() override;

  void SetServer(ipc::Server* server) { server_ = server; }  // before the server starts

  // Any thread.
  AttachedDevice& device() { return device_; }
  // Any thread: how long there has been neither a client nor an emergency stop.
  double Idle_s() const;

  void OnClient(const ipc::ClientInfo& client) override;
  void OnGone(ipc::ClientId id) override;
  void OnRequest(ipc::ClientId id, const protocol::Request& request, base::UniqueFd file) override;
  void OnPeriod(std::int64_t now_ns) override;
  std::string StatusJson() override;

 private:
  struct RequestHandler;  // one call for each alternative of protocol::Request
  void SetSession(ipc::ClientId id, protocol::SessionState state);
  template <class M>
  bool Send(ipc::ClientId id, const M& message, std::string_view tail = {}, int file = -1) {
    return server_ != nullptr && server_->Send(id, message, tail, file);
  }
  void WriteCommands(std::int64_t now_ns);
  void SendSculptAnswers();
  void Release();
  void UpdateSurfaces();
  void FeelField();
  void SendForceProperties();
  void SendBasePoses();
  void PublishBase(const std::optional<protocol::BaseSample>& sample);
  bool Aligned() const;
  void Problem(ipc::ClientId id, int level, const std::string& text);
  void Say(ipc::ClientId id, int level, const std::string& text);

  const ServiceOptions options_;
  const std::int64_t start_ns_;
  ipc::Server* server_ = nullptr;
  AttachedDevice device_;
  Clients clients_;
  ClientScenes scenes_;
  TickCommands commands_;
  ForceClients force_;
  BasePoseWriter base_pose_writer_;
  BasePoses base_poses_;
  FollowedBase followed_base_;
  std::int64_t felt_second_ns_ = 0;  // of the field that base_poses_ knows
  EmergencyStop stop_;
  std::atomic<std::int64_t> busy_ns_;  // newest period with a client, or with forces stopped
  std::vector<std::string> problems_;  // newest last, at most kMaxProblems
  std::unique_ptr<KeyThread> keys_;    // null: no keys are to be read. Its thread uses the device
  SurfaceClients surfaces_;            // last member: its thread uses the device
};

}  // namespace omni::daemon
