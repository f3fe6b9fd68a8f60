// What tests of the service's record of base_poses share.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <initializer_list>
#include <map>
#include <string>
#include <vector>

#include "service/daemon/clients/base_poses.h"
#include "service/protocol/text.h"
#include "tests/support/process/temp_folder.h"

namespace omni::daemon {

using omni::test::TempFolder;
using protocol::kSpaceLocal;
using protocol::kSpaceStage;

inline protocol::HeadsetNames Headset(const std::string& runtime = "Monado(XRT)",
                                      const std::string& system = "A \"quoted\" \\ HMD") {
  protocol::HeadsetNames names;
  protocol::SetField(names.runtime, runtime);
  protocol::SetField(names.system, system);
  return names;
}

inline protocol::BasePoseRequest Request(std::initializer_list<std::int32_t> spaces) {
  protocol::BasePoseRequest request;
  request.headset = Headset();
  for (const std::int32_t space : spaces) request.spaces[request.space_count++] = space;
  return request;
}

inline protocol::BasePoseCommand Store(std::int32_t space, double x = 0.1) {
  protocol::BasePoseCommand command;
  command.headset = Headset();
  command.space = space;
  command.base_space = {.position_m = {x, 0.7, -0.5}, .orientation_wxyz = {0.6, -0.6, 0.4, 0.346410161513775}};
  command.rms_m = 1.1e-3;
  command.expected_error_m = 0.9e-3;
  command.samples = 5;
  protocol::SetField(command.method, "touch");
  return command;
}

struct Listener {
  std::map<ipc::ClientId, std::vector<protocol::BasePose>> reported;
  void Listen(BasePoses& base_poses) {
    base_poses.Notify([this](ipc::ClientId id, const protocol::BasePose& base_pose) {
      reported[id].push_back(base_pose);
      return true;
    });
  }
};

inline constexpr std::int64_t kNow_ns = 4'900'000'000;
inline constexpr std::int64_t kDate_s = 1'790'000'000;

// x metres along x, at that time.
inline protocol::SpaceChange Moved(double x, std::int64_t changes_at_ns) {
  protocol::SpaceChange change;
  change.pose_valid = 1;
  change.changes_at_ns = changes_at_ns;
  change.new_in_previous.position_m = {x, 0, 0};
  return change;
}

}  // namespace omni::daemon
