// One attempt to reach omnid, after checking that nobody else stands in for it.
#pragma once

#include <string>

#include "service/protocol/unique_fd.h"

namespace omni::client {

struct Dialled {
  protocol::UniqueFd socket;  // non-blocking, close-on-exec; none: `problem` says why and what to do
  std::string problem;
};

// Does not block: a Unix socket connects at once or fails. Refuses a folder that other users can enter and a server
// that runs under another user.
Dialled Dial(const std::string& socket_path);

}  // namespace omni::client
