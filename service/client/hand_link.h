// The leading end of the channel on which the digital twin's hand is led (protocol/hand_aim.h). Never blocks.
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
  // An aim that the twin has no room for is dropped: the next one counts anyway. False: nobody is there any more.
  bool Send(const protocol::HandAim& aim) noexcept;

  bool connected() const noexcept { return static_cast<bool>(socket_); }
  const std::string& problem() const noexcept { return problem_; }

 private:
  std::string path_;
  std::string problem_;
  base::UniqueFd socket_;
};

}  // namespace omni::client
