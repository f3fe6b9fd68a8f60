// Who pushes the pen by itself, and with what. Only the focused owner that has claimed it is felt; when the owner
// changes, falls silent or gives it up, everything that it asked for ends. Control thread only.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>

#include "service/haptics/applied/applied.h"
#include "service/ipc/server.h"

namespace omni::daemon {

class ForceClients {
 public:
  static constexpr std::int64_t kSilent_ns = 50'000'000;  // no sign of life for this long: its forces rest

  struct Send {
    std::function<bool(ipc::ClientId, const protocol::ForceOwner&)> owner;
    std::function<bool(ipc::ClientId, const protocol::ForceProperties&)> properties;
  };
  explicit ForceClients(Send send);

  void Add(ipc::ClientId id);  // an application
  void Remove(ipc::ClientId id);

  // The focused application, 0: none. Another one than before starts with nothing.
  void SetOwner(ipc::ClientId owner);

  // False: it is not felt now, and nothing has changed.
  bool Take(ipc::ClientId id, const protocol::ForceRequest& request, std::int64_t now_ns);

  // For the tick. `last_beat_ns`: of the owner.
  haptics::AppliedCommand Command(std::int64_t now_ns, std::int64_t last_beat_ns) const;

  // Tells every application what it does not know yet. What does not go out is tried again with the next call.
  void Notify(const protocol::ForceProperties& properties);

  // Whoever is felt when it asks for something; 0: nobody.
  ipc::ClientId claimed_owner() const;

 private:
  struct Client {
    bool claimed = false;
    std::optional<protocol::ForceStanding> standing_told;
    std::uint64_t properties_told = 0;  // number of the last ones that went out
  };
  void EndAll();

  const Send send_;
  std::map<ipc::ClientId, Client> clients_;
  ipc::ClientId owner_ = 0;
  haptics::AppliedCommand command_;
  protocol::ForceProperties properties_;
  std::uint64_t properties_number_ = 1;
};

}  // namespace omni::daemon
