#include "service/client/hand_link.h"

#include "service/client/dial.h"
#include "service/protocol/packet_socket.h"

namespace omni::client {

bool HandLink::Connect() {
  if (socket_) return true;
  auto socket = Dial(path_, {.name = "twin", .remedy = "start omnid --device twin --twin-hand " + path_});
  problem_ = socket.ok() ? std::string() : socket.error();
  if (socket.ok()) socket_ = std::move(*socket);
  return connected();
}

bool HandLink::Send(const protocol::HandAim& aim) noexcept {
  if (!socket_) return false;
  if (protocol::SendPacket(socket_.get(), &aim, sizeof(aim)) == protocol::SendResult::kGone) socket_.Reset();
  return connected();
}

}  // namespace omni::client
