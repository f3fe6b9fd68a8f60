// The listening socket of omnid: at most one per path, in a folder that only its user can enter.
#pragma once

#include <string>

#include "service/base/result.h"
#include "service/base/unique_fd.h"

namespace omni::ipc {

class Listener {
 public:
  // Makes the folder if it is missing (0700), takes the lock file, removes a dead omnid's socket, binds and listens.
  // The folder is never deleted: a sandbox's bind mount of it stays valid over a restart.
  static base::Result<Listener> Open(const std::string& socket_path);
  Listener(Listener&&) = default;
  Listener& operator=(Listener&&) = delete;
  ~Listener();  // removes the socket, then frees the lock

  int fd() const noexcept { return socket_.get(); }
  const std::string& path() const noexcept { return path_; }

  // "/x/omnid.sock" -> "/x/omnid.lock"
  static std::string LockPathOf(const std::string& socket_path);

 private:
  Listener(std::string path, base::UniqueFd lock, base::UniqueFd socket)
      : path_(std::move(path)), lock_(std::move(lock)), socket_(std::move(socket)) {}
  std::string path_;
  base::UniqueFd lock_;
  base::UniqueFd socket_;
};

}  // namespace omni::ipc
