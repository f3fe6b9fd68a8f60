// One attempt to connect to one of our servers (omnid, or the twin's hand), after checking that no other user
// impersonates it.
#pragma once

#include <string>

#include "service/base/result.h"
#include "service/base/unique_fd.h"

namespace omni::client {

// How messages name the server, and how it is started.
struct ServerWords {
  std::string name = "omnid";
  std::string remedy = "start omnid";
};

// Does not block: a Unix socket connects at once or fails. Refuses a folder that other users can enter and a server
// that runs under another user. The socket is non-blocking and close-on-exec.
base::Result<base::UniqueFd> Dial(const std::string& socket_path, const ServerWords& server = {});

}  // namespace omni::client
