#include "service/daemon/clients/force_clients.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <utility>
#include <variant>

namespace omni::daemon {
namespace {

static_assert(protocol::kMaxForceConstraints == haptics::kMaxConstraints);
static_assert(protocol::kForceShapes.size() == haptics::kConstraintKinds);

// A message from the future counts as sent now; an old one has lost its remaining time.
std::int64_t SentAt_ns(std::int64_t t_ns, std::int64_t now_ns) {
  return std::clamp(t_ns, now_ns - protocol::kLongestForce_ns, now_ns);
}

haptics::Constraint ConstraintOf(const protocol::ForceConstraint& c) {
  return {.kind = static_cast<haptics::ConstraintKind>(c.shape),
          .side = static_cast<haptics::ConstraintSide>(c.side),
          .stiffness_N_m = c.stiffness_N_m,
          .damping_Ns_m = c.damping_Ns_m,
          .max_force_N = c.max_force_N,
          .radius_m = c.radius_m,
          .point_base_m = base::VecOf(c.point_base_m),
          .direction_base = base::VecOf(c.direction_base),
          .velocity_base_m_s = base::VecOf(c.velocity_base_m_s),
          .angular_velocity_base_rad_s = base::VecOf(c.angular_velocity_base_rad_s)};
}

void Obey(const protocol::ForceApply& apply, std::int64_t now_ns, haptics::AppliedCommand& command) {
  ++command.force_id;
  command.force_base_N = base::VecOf(apply.force_base_N);
  command.force_end_ns = SentAt_ns(apply.t_ns, now_ns) + apply.duration_ns;
  command.ramp_s = 1e-9 * static_cast<double>(apply.ramp_ns);
}

void Obey(const protocol::ForceConstraints& set, std::int64_t now_ns, haptics::AppliedCommand& command) {
  ++command.constraints_id;
  command.constraints_t_ns = SentAt_ns(set.t_ns, now_ns);
  command.constraint_count = set.count;
  for (std::uint32_t i = 0; i < set.count; ++i) command.constraints[i] = ConstraintOf(set.constraints[i]);
}

bool SameProperties(const protocol::ForceProperties& a, const protocol::ForceProperties& b) {
  // No padding: checked by the size in the header.
  return std::memcmp(&a, &b, sizeof(a)) == 0;  // NOLINT(bugprone-suspicious-memory-comparison): the same bits
}

}  // namespace

ForceClients::ForceClients(Send send) : send_(std::move(send)) {}

void ForceClients::Add(ipc::ClientId id) { clients_[id] = {}; }

void ForceClients::Remove(ipc::ClientId id) {
  clients_.erase(id);
  if (id == owner_) SetOwner(0);
}

void ForceClients::SetOwner(ipc::ClientId owner) {
  if (owner == owner_) return;
  owner_ = owner;
  EndAll();
}

void ForceClients::EndAll() {
  ++command_.force_id;
  command_.force_end_ns = std::numeric_limits<std::int64_t>::min();
  ++command_.constraints_id;
  command_.constraint_count = 0;
}

bool ForceClients::HandleRequest(ipc::ClientId id, const protocol::ForceRequest& request, std::int64_t now_ns) {
  const auto found = clients_.find(id);
  if (found == clients_.end()) return false;
  if (const auto* claim = std::get_if<protocol::ForceClaim>(&request)) {
    found->second.claimed = claim->wanted != 0;
    if (id == owner_ && !found->second.claimed) EndAll();
    return id == owner_;
  }
  if (id != claimed_owner()) return false;
  if (const auto* apply = std::get_if<protocol::ForceApply>(&request)) Obey(*apply, now_ns, command_);
  if (const auto* set = std::get_if<protocol::ForceConstraints>(&request)) Obey(*set, now_ns, command_);
  if (std::holds_alternative<protocol::ForceStop>(request)) EndAll();
  return true;
}

haptics::AppliedCommand ForceClients::MakeCommand(std::int64_t now_ns) const {
  haptics::AppliedCommand command = command_;
  command.open = claimed_owner() != 0;
  // The tick uses the device's stamps; if those stand still, this clock ends the force.
  if (now_ns >= command.force_end_ns) command.force_end_ns = std::numeric_limits<std::int64_t>::min();
  return command;
}

ipc::ClientId ForceClients::claimed_owner() const {
  const auto found = clients_.find(owner_);
  return found != clients_.end() && found->second.claimed ? owner_ : 0;
}

void ForceClients::Notify(const protocol::ForceProperties& properties) {
  if (!SameProperties(properties, properties_)) {
    properties_ = properties;
    ++properties_number_;
  }
  const ipc::ClientId felt = claimed_owner();
  for (auto& [id, client] : clients_) {
    if (client.properties_reported != properties_number_ && send_.properties(id, properties_)) {
      client.properties_reported = properties_number_;
    }
    const auto standing = felt == 0    ? protocol::ForceStanding::kFree
                          : felt == id ? protocol::ForceStanding::kYours
                                       : protocol::ForceStanding::kTaken;
    if (client.standing_reported == standing) continue;
    protocol::ForceOwner message;
    message.standing = standing;
    if (send_.owner(id, message)) client.standing_reported = standing;
  }
}

}  // namespace omni::daemon
