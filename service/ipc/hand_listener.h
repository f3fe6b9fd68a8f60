// The twin's end of the channel that moves its hand (protocol/hand_aim.h): a seqpacket socket in a folder that only its
// user can enter. One process leads at a time; another that connects waits until the first one disconnects.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "service/base/result.h"
#include "service/base/unique_fd.h"
#include "service/protocol/hand_aim.h"

namespace omni::ipc {

class HandListener {
 public:
  // The folder must exist, be this user's own and closed to all others (0700). A socket without a listener is replaced.
  static base::Result<std::unique_ptr<HandListener>> Open(const std::string& path);
  ~HandListener();  // removes the socket
  HandListener(const HandListener&) = delete;
  HandListener& operator=(const HandListener&) = delete;

  // The newest aim received since the last call. Never waits, reads at most kAimsPerPoll packets. A peer of another
  // user, or one that sends anything but an aim, is disconnected.
  static constexpr int kAimsPerPoll = 16;
  std::optional<protocol::HandAim> Poll() noexcept;

 private:
  HandListener(std::string path, base::UniqueFd socket) : path_(std::move(path)), socket_(std::move(socket)) {}
  void Accept() noexcept;

  std::string path_;
  base::UniqueFd socket_, leader_;
};

}  // namespace omni::ipc
