#include "service/daemon/clients/owner.h"

namespace omni::daemon {

void OwnerTable::Add(std::uint64_t client, protocol::ClientRole role) { clients_[client] = Entry{.role = role}; }

void OwnerTable::Remove(std::uint64_t client) { clients_.erase(client); }

void OwnerTable::SetSession(std::uint64_t client, protocol::SessionState state) {
  const auto found = clients_.find(client);
  if (found == clients_.end()) return;
  Entry& entry = found->second;
  const bool becomes_focused =
      state == protocol::SessionState::kFocused && entry.session != protocol::SessionState::kFocused;
  if (becomes_focused) entry.focused_at = ++focus_counter_;
  entry.session = state;
}

std::uint64_t OwnerTable::owner() const {
  std::uint64_t best = 0;
  std::uint64_t latest = 0;
  for (const auto& [client, entry] : clients_) {
    const bool focused = entry.session == protocol::SessionState::kFocused;
    if (entry.role != protocol::ClientRole::kApplication || !focused || entry.focused_at <= latest) continue;
    best = client;
    latest = entry.focused_at;
  }
  return best;
}

protocol::SessionState OwnerTable::session(std::uint64_t client) const {
  const auto found = clients_.find(client);
  return found == clients_.end() ? protocol::SessionState::kNone : found->second.session;
}

}  // namespace omni::daemon
