// The listening sockets of omnid and of the twin's hand.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "service/base/result.h"
#include "service/base/unique_fd.h"
#include "service/protocol/hand_aim.h"

namespace omni::ipc {

// The listening socket of omnid: at most one per path, in a folder that only its user can enter.
class Listener {
 public:
  // Makes the folder if it is missing (0700), takes the lock file, removes a dead omnid's socket, binds and listens.
  // The folder is never deleted: a sandbox's bind mount of it stays valid over a restart.
  static base::Result<Listener> Open(const std::string& socket_path);
  // With a socket that is listening already, made by systemd (TakeInheritedSocket): its folder is checked and its lock
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

// Socket activation: systemd has made omnid's socket and starts omnid when a client connects (sd_listen_fds(3)).
struct InheritedSocket {
  base::UniqueFd fd;  // non-blocking, close-on-exec
  std::string path;
};

// The socket that was passed to this process; nullopt: none was. Takes $LISTEN_PID, $LISTEN_FDS and $LISTEN_FDNAMES out
// of the environment, so call it before the first thread starts. Error: more than one socket, or another kind than
// ListenSequentialPacket= with a path.
base::Result<std::optional<InheritedSocket>> TakeInheritedSocket();

// The twin's end of the channel that moves its hand (protocol/hand_aim.h): a seqpacket socket in a folder that only its
// user can enter. One process leads at a time; another that connects waits until the first one disconnects.
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
