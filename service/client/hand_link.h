// Client end of the channel that moves the digital twin's hand (protocol/hand_aim.h). Never blocks.
#pragma once

#include <string>

#include "service/base/unique_fd.h"
#include "service/protocol/hand_aim.h"

namespace omni::client {

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
