// The service's status as JSON text, for `omni status` and the monitor.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "service/daemon/clients/base_poses.h"
#include "service/daemon/clients/clients.h"
#include "service/daemon/clients/emergency_stop.h"
#include "service/daemon/clients/followed_base.h"
#include "service/daemon/devices/attached_device.h"
#include "service/daemon/keys/key_thread.h"
#include "service/daemon/scenes/client_scenes.h"

namespace omni::daemon {

struct StatusInput {
  const std::string& version;
  std::uint64_t instance;
  double uptime_s;
  const Clients& clients;
  const ClientScenes& scenes;
  AttachedDevice& device;
  const EmergencyStop& stop;
  const BasePoses& base_poses;
  const FollowedBase& followed_base;
  bool aligned;
  const base::InputMapping& mapping;  // in force
  const std::vector<std::uint16_t>& key_slots;
  const KeyThread* keys;              // null: none are read
  std::vector<std::string> problems;  // that no part knows of itself
};

std::string WriteStatus(const StatusInput& input);

}  // namespace omni::daemon
