// Who owns the force: the client that last became FOCUSED. Pure bookkeeping, control thread only.
#pragma once

#include <cstdint>
#include <map>

#include "service/protocol/control.h"

namespace omni::daemon {

class OwnerTable {
 public:
  void Add(std::uint64_t client, protocol::ClientRole role);
  void Remove(std::uint64_t client);
  void SetSession(std::uint64_t client, protocol::SessionState state);

  // The focused application that became so last; 0: none.
  std::uint64_t owner() const;
  bool empty() const { return clients_.empty(); }
  protocol::SessionState session(std::uint64_t client) const;

 private:
  struct Entry {
    protocol::ClientRole role = protocol::ClientRole::kApplication;
    protocol::SessionState session = protocol::SessionState::kNone;
    std::uint64_t focused_at = 0;  // running number of the last change to FOCUSED
  };
  std::map<std::uint64_t, Entry> clients_;
  std::uint64_t focus_counter_ = 0;
};

}  // namespace omni::daemon
