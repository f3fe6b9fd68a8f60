#include "service/ipc/listener.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstring>

#include "service/protocol/socket_path.h"

namespace omni::ipc {
namespace {

using base::Error;
using base::Result;
using base::UniqueFd;

constexpr int kBacklog = 64;

Error Failed(const std::string& what, const std::string& path) {
  return Error{what + " " + path + ": " + std::strerror(errno)};
}

base::Status PrepareFolder(const std::string& folder) {
  if (::mkdir(folder.c_str(), 0700) != 0 && errno != EEXIST) {
    return Error{"cannot make the folder " + folder + ": " + std::strerror(errno) +
                 "; make it yourself (mkdir -p -m 700) or set OMNI_SOCKET to a path in a folder of your own"};
  }
  const protocol::FolderCheck check = protocol::CheckFolder(folder);
  if (check.state != protocol::FolderState::kGood) return Error{check.problem};
  return base::Ok{};
}

// The pid in the lock file; 0: unreadable.
int HolderOf(int lock_fd) {
  char text[32] = {};
  const ssize_t size = ::pread(lock_fd, text, sizeof(text) - 1, 0);
  int pid = 0;
  if (size > 0) std::from_chars(text, text + size, pid);
  return pid;
}

// Both kinds of lock end with their process whatever kills it. flock is the older one, that an omnid of before looks
// at; the other can be looked at without being taken.
Result<UniqueFd> TakeLock(const std::string& lock_path, const std::string& socket_path) {
  UniqueFd lock(::open(lock_path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600));
  if (!lock) return Failed("cannot open the lock file", lock_path);
  if (::flock(lock.get(), LOCK_EX | LOCK_NB) != 0 || !protocol::LockSocket(lock.get())) {
    if (errno != EWOULDBLOCK) return Failed("cannot lock", lock_path);
    const int pid = HolderOf(lock.get());
    return Error{"another omnid" + (pid > 0 ? " (pid " + std::to_string(pid) + ")" : std::string()) +
                 " already serves " + socket_path + "; stop it first or set OMNI_SOCKET to another path"};
  }
  // Only for the message above: a disk too full to hold it is no reason not to serve.
  const std::string pid = std::to_string(::getpid()) + "\n";
  if (::ftruncate(lock.get(), 0) == 0 && ::pwrite(lock.get(), pid.data(), pid.size(), 0) < 0) errno = 0;
  return lock;
}

// Precondition: the lock is held, so the socket belongs to no living omnid.
base::Status RemoveStaleSocket(const std::string& path) {
  struct stat info {};
  if (::lstat(path.c_str(), &info) != 0) {
    if (errno == ENOENT) return base::Ok{};
    return Failed("cannot examine", path);
  }
  if (!S_ISSOCK(info.st_mode)) {
    return Error{path + " exists and is not a socket; remove it or set OMNI_SOCKET to another path"};
  }
  if (::unlink(path.c_str()) != 0) return Failed("cannot remove the old socket", path);
  return base::Ok{};
}

Result<UniqueFd> PrepareAndLock(const std::string& socket_path) {
  if (std::string problem = protocol::PathProblem(socket_path); !problem.empty()) return Error{std::move(problem)};
  if (auto folder = PrepareFolder(protocol::FolderOf(socket_path)); !folder) return Error{folder.error()};
  return TakeLock(protocol::LockPathOf(socket_path), socket_path);
}

Result<UniqueFd> Bind(const std::string& path) {
  UniqueFd socket(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!socket) return Failed("cannot make a socket for", path);
  const protocol::SocketAddress at = protocol::AddressOf(path);
  if (::bind(socket.get(), reinterpret_cast<const sockaddr*>(&at.address), at.bytes) != 0) {
    return Failed("cannot bind", path);
  }
  if (::chmod(path.c_str(), 0600) != 0 || ::listen(socket.get(), kBacklog) != 0) {
    const Error error = Failed("cannot listen on", path);
    ::unlink(path.c_str());
    return error;
  }
  return socket;
}

}  // namespace

Result<Listener> Listener::Open(const std::string& socket_path) {
  auto lock = PrepareAndLock(socket_path);
  if (!lock) return Error{lock.error()};
  // No omnid, for we have the lock.
  if (protocol::IsListenedOn(socket_path)) {
    return Error{"systemd, or another program, listens on " + socket_path +
                 "; run `systemctl --user start omnid`, or set OMNI_SOCKET to another path"};
  }
  if (auto removed = RemoveStaleSocket(socket_path); !removed) return Error{removed.error()};
  auto socket = Bind(socket_path);
  if (!socket) return Error{socket.error()};
  return Listener(socket_path, std::move(*lock), std::move(*socket), false);
}

Result<Listener> Listener::Adopt(UniqueFd socket, const std::string& socket_path) {
  auto lock = PrepareAndLock(socket_path);
  if (!lock) return Error{lock.error()};
  return Listener(socket_path, std::move(*lock), std::move(socket), true);
}

Listener::~Listener() {
  if (socket_ && !adopted_) ::unlink(path_.c_str());
}

}  // namespace omni::ipc
