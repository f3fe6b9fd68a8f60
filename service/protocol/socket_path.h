// Where the control socket lies, and what its folder must be like: checked by the server before it binds and by the
// client before it connects, so that no other user can impersonate either.
#pragma once

#include <sys/socket.h>
#include <sys/un.h>

#include <string>

namespace omni::protocol {

// $OMNI_SOCKET, else $XDG_RUNTIME_DIR/omni/omnid.sock, else /run/user/<uid>/omni/omnid.sock if that folder is the
// user's (sandboxes, cron and su leave the variable out), else /tmp/omni-<uid>/omnid.sock.
std::string DefaultSocketPath();

// What is wrong with the path itself (length, not absolute); empty: nothing.
std::string PathProblem(const std::string& socket_path);

// Everything before the last '/'. Precondition: PathProblem is empty.
std::string FolderOf(const std::string& socket_path);

enum class FolderState { kGood, kMissing, kRefused };
struct FolderCheck {
  FolderState state = FolderState::kRefused;
  std::string problem;  // with the remedy; empty if good
};

// Good: a real folder (no symlink), owned by this user, closed to all others (0700).
FolderCheck CheckFolder(const std::string& folder);

// Of the file that a running omnid keeps locked: "/x/omnid.sock" -> "/x/omnid.lock".
std::string LockPathOf(const std::string& socket_path);

// A lock of the open file description (fcntl F_OFD_SETLK) on that file. False, errno EAGAIN: another omnid has it.
bool LockSocket(int lock_fd) noexcept;

// Whether a process listens on this socket.
bool IsListenedOn(const std::string& socket_path);

// kOnDemand: systemd listens on the socket, and a connection would start omnid.
enum class ServiceState { kAbsent, kOnDemand, kRuns };
// Without connecting. Precondition: PathProblem is empty.
ServiceState FindService(const std::string& socket_path);

// Precondition: PathProblem is empty.
struct SocketAddress {
  sockaddr_un address{};
  socklen_t bytes = 0;
};
SocketAddress AddressOf(const std::string& socket_path);

}  // namespace omni::protocol
