// The service's status as JSON text, for `omni status` and the monitor.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "service/config/files/alignment_file.h"
#include "service/config/files/calibration_file.h"
#include "service/daemon/clients/emergency_stop.h"
#include "service/daemon/keys/key_thread.h"
#include "service/daemon/scenes/scene_builder.h"
#include "service/device/transport.h"
#include "service/loop/tick_thread.h"
#include "service/protocol/control.h"
#include "service/room/room_finding.h"
#include "service/scene/scene_file.h"

namespace omni::daemon {

struct StatusInput {
  struct ClientRow {
    std::uint64_t id = 0;
    int pid = 0;
    std::string application;
    bool monitor = false;
    protocol::SessionState session = protocol::SessionState::kNone;
    bool owner = false;
    std::string scene;
    SoftProgress soft;
    std::uint32_t sculpted = 0;  // objects
    bool aligned = false;
    std::string runtime, system;  // its headset; empty: not reported
  };
  std::string version;
  std::uint64_t instance = 0;
  double uptime_s = 0;
  EmergencyStop::State stop;
  std::vector<std::string> problems;
  config::CalibrationChoice calibration;
  std::string misfit;                   // Service::SetMisfit
  std::vector<room::RoomFinding> room;  // Service::SetRoom
  bool aligned = false;
  config::AlignmentFile alignments;
  std::vector<ClientRow> clients;
  std::string scene_file;
  std::optional<scene::LoadOptions> scene_load;  // how it was read; none: there is no file
  std::uint64_t scene_generation = 0;
  std::uint32_t scene_triangles = 0;
  SoftProgress scene_soft;
  std::uint32_t scene_sculpted = 0;
  const base::InputMapping* mapping = nullptr;  // in force
  const std::vector<std::uint16_t>* key_slots = nullptr;
  std::vector<KeyThread::DeviceStatus> key_devices;
  const loop::TickThread* loop = nullptr;  // null: no device
  const device::Transport* transport = nullptr;
  std::string device_absent_why;
};

std::string WriteStatus(const StatusInput& input);

}  // namespace omni::daemon
