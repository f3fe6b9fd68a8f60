// Which clients there are, and who owns the force: the application that last became FOCUSED. Pure bookkeeping, control
// thread only.
#pragma once

#include <cstdint>
#include <map>

#include "service/config/files/app_file.h"
#include "service/ipc/server.h"
#include "service/protocol/control.h"

namespace omni::daemon {

struct Client {
  ipc::ClientInfo info;
  const config::AppEntry* app = nullptr;  // null: no entry matches
  protocol::SessionState session = protocol::SessionState::kNone;
  bool session_seen = false;     // one has begun since it connected
  std::uint64_t focused_at = 0;  // running number of the last change to FOCUSED

  bool is_application() const { return info.role == protocol::ClientRole::kApplication; }
};

class Clients {
 public:
  void Add(const ipc::ClientInfo& info, const config::AppEntry* app) { clients_[info.id] = {.info = info, .app = app}; }
  void Remove(ipc::ClientId id) { clients_.erase(id); }
  void SetSession(ipc::ClientId id, protocol::SessionState state);

  // Null: there is no such client.
  const Client* Find(ipc::ClientId id) const;
  // The focused application that became so last; null, or 0: none.
  const Client* owner() const;
  ipc::ClientId owner_id() const { return owner() == nullptr ? 0 : owner()->info.id; }
  const std::map<ipc::ClientId, Client>& all() const { return clients_; }

 private:
  std::map<ipc::ClientId, Client> clients_;
  std::uint64_t focus_counter_ = 0;
};

inline void Clients::SetSession(ipc::ClientId id, protocol::SessionState state) {
  const auto found = clients_.find(id);
  if (found == clients_.end()) return;
  Client& client = found->second;
  if (state == protocol::SessionState::kFocused && client.session != state) client.focused_at = ++focus_counter_;
  client.session = state;
  client.session_seen = client.session_seen || state != protocol::SessionState::kNone;
}

inline const Client* Clients::Find(ipc::ClientId id) const {
  const auto found = clients_.find(id);
  return found == clients_.end() ? nullptr : &found->second;
}

inline const Client* Clients::owner() const {
  const Client* newest = nullptr;
  for (const auto& [id, client] : clients_) {
    const bool may_own = client.is_application() && client.session == protocol::SessionState::kFocused;
    if (may_own && (newest == nullptr || client.focused_at > newest->focused_at)) newest = &client;
  }
  return newest;
}

}  // namespace omni::daemon
