#include "service/client/hand_link.h"

#include "service/client/dial.h"
#include "service/protocol/packet_socket.h"

namespace omni::client {

bool HandLink::Connect() {
  if (socket_) return true;
  Dialled dialled = Dial(path_, {.name = "twin", .remedy = "start omnid --device twin --twin-hand " + path_});
  socket_ = std::move(dialled.socket);
  problem_ = std::move(dialled.problem);
  return connected();
}

bool HandLink::Send(const protocol::HandAim& aim) noexcept {
  if (!socket_) return false;
  if (protocol::SendPacket(socket_.get(), &aim, sizeof(aim)) == protocol::SendResult::kGone) socket_.Reset();
  return connected();
}

}  // namespace omni::client
