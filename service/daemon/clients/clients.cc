#include "service/daemon/clients/clients.h"

namespace omni::daemon {

using protocol::SessionState;

void Clients::SetSession(ipc::ClientId id, SessionState state) {
  const auto found = clients_.find(id);
  if (found == clients_.end()) return;
  Client& client = found->second;
  if (state == SessionState::kFocused && client.session != state) client.focused_at = ++focus_counter_;
  client.session = state;
  client.session_seen = client.session_seen || state != SessionState::kNone;
}

const Client* Clients::Find(ipc::ClientId id) const {
  const auto found = clients_.find(id);
  return found == clients_.end() ? nullptr : &found->second;
}

const Client* Clients::owner() const {
  const Client* newest = nullptr;
  for (const auto& [id, client] : clients_) {
    const bool may_own = client.is_application() && client.session == SessionState::kFocused;
    if (may_own && (newest == nullptr || client.focused_at > newest->focused_at)) newest = &client;
  }
  return newest;
}

}  // namespace omni::daemon
