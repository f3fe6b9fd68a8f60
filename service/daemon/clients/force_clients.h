// Applications that push the pen by themselves, and their forces. Only the focused owner that has claimed the pen is
// active; when the owner changes, falls silent or gives the pen up, everything that it requested ends. Control thread
// only.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>

#include "service/base/device_geometry.h"
#include "service/haptics/applied/applied.h"
#include "service/ipc/server.h"
#include "service/loop/tick.h"
#include "service/protocol/force_feedback.h"

namespace omni::daemon {

class ForceClients {
 public:
  struct Send {
    std::function<bool(ipc::ClientId, const protocol::ForceOwner&)> owner;
    std::function<bool(ipc::ClientId, const protocol::ForceProperties&)> properties;
  };
  explicit ForceClients(Send send);

  void Add(ipc::ClientId id);  // an application
  void Remove(ipc::ClientId id);

  // The focused application, 0: none. A new owner starts without forces and constraints.
  void SetOwner(ipc::ClientId owner);

  // False: the client is not active now, and nothing has changed.
  bool HandleRequest(ipc::ClientId id, const protocol::ForceRequest& request, std::int64_t now_ns);

  // For the tick, which suspends it while the owner is silent.
  haptics::AppliedCommand MakeCommand(std::int64_t now_ns) const;

  // Notifies every application of changes. Messages that could not be sent are retried by the next call.
  void Notify(const protocol::ForceProperties& properties);

  // The client whose requests take effect; 0: none.
  ipc::ClientId claimed_owner() const;

 private:
  struct Client {
    bool claimed = false;
    std::optional<protocol::ForceStanding> standing_reported;
    std::uint64_t properties_reported = 0;  // number of the last ones that were sent
  };
  void EndAll();

  const Send send_;
  std::map<ipc::ClientId, Client> clients_;
  ipc::ClientId owner_ = 0;
  haptics::AppliedCommand command_;
  protocol::ForceProperties properties_;
  std::uint64_t properties_number_ = 1;
};

// What forces a device can make, as reported to applications.

// Off the tick: some thousand evaluations of the force map.
protocol::ForceProperties DescribeForce(const loop::TickConfig& config, const base::DeviceGeometry& device);

}  // namespace omni::daemon
