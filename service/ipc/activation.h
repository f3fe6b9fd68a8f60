// Socket activation: systemd has made omnid's socket and starts omnid when somebody connects (sd_listen_fds(3)).
#pragma once

#include <optional>
#include <string>

#include "service/base/result.h"
#include "service/base/unique_fd.h"

namespace omni::ipc {

struct InheritedSocket {
  base::UniqueFd fd;  // non-blocking, close-on-exec
  std::string path;
};

// The socket that was passed to this process; nullopt: none was. Takes $LISTEN_PID, $LISTEN_FDS and $LISTEN_FDNAMES out
// of the environment, so call it before the first thread starts. Error: more than one socket, or another kind than
// ListenSequentialPacket= with a path.
base::Result<std::optional<InheritedSocket>> TakeInheritedSocket();

}  // namespace omni::ipc
