// One attempt to connect to one of our servers (omnid, or the twin's hand), after checking that no other user
// impersonates it.
#pragma once

#include <string>

#include "service/base/result.h"
#include "service/base/unique_fd.h"
#include "service/protocol/hand_aim.h"

namespace omni::client {

// How messages name the server, and how it is started.
struct ServerWords {
  std::string name = "omnid";
  std::string remedy = "start omnid";
};

// Does not block: a Unix socket connects at once or fails. Refuses a folder that other users can enter and a server
// that runs under another user. The socket is non-blocking and close-on-exec.
base::Result<base::UniqueFd> Dial(const std::string& socket_path, const ServerWords& server = {});

// Client end of the channel that moves the digital twin's hand (protocol/hand_aim.h). Never blocks.
class HandLink {
 public:
  explicit HandLink(std::string path) : path_(std::move(path)) {}

  // Connects if it is not connected. False: problem() says why and what to do.
  bool Connect();
  // If the socket is full the aim is dropped: the next one replaces it anyway. False: the twin has gone.
  bool Send(const protocol::HandAim& aim) noexcept;

  bool connected() const noexcept { return static_cast<bool>(socket_); }
  const std::string& problem() const noexcept { return problem_; }

 private:
  std::string path_;
  std::string problem_;
  base::UniqueFd socket_;
};

}  // namespace omni::client
