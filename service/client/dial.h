// One attempt to reach a server of ours (omnid, or the twin's hand), after checking that nobody else stands in for it.
#pragma once

#include <string>

#include "service/protocol/unique_fd.h"

namespace omni::client {

struct Dialled {
  protocol::UniqueFd socket;  // non-blocking, close-on-exec; none: `problem` says why and what to do
  std::string problem;
};

// How problems call the server, and how it is started.
struct ServerWords {
  std::string name = "omnid";
  std::string remedy = "start omnid";
};

// Does not block: a Unix socket connects at once or fails. Refuses a folder that other users can enter and a server
// that runs under another user.
Dialled Dial(const std::string& socket_path, const ServerWords& server = {});

}  // namespace omni::client
