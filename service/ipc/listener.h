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
  // With a socket that is listening already, made by systemd (ipc/activation.h): its folder is checked and its lock
  // taken, and it is never removed. `socket_path`: where it lies.
  static base::Result<Listener> Adopt(base::UniqueFd socket, const std::string& socket_path);
  Listener(Listener&&) = default;
  Listener& operator=(Listener&&) = delete;
  ~Listener();  // removes the socket unless it is adopted, then frees the lock

  int fd() const noexcept { return socket_.get(); }
  const std::string& path() const noexcept { return path_; }

 private:
  Listener(std::string path, base::UniqueFd lock, base::UniqueFd socket, bool adopted)
      : path_(std::move(path)), lock_(std::move(lock)), socket_(std::move(socket)), adopted_(adopted) {}
  std::string path_;
  base::UniqueFd lock_;
  base::UniqueFd socket_;
  bool adopted_;
};

}  // namespace omni::ipc
