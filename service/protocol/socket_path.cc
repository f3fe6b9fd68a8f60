#include "service/protocol/socket_path.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <fstream>

#include "service/base/unique_fd.h"
#include "service/protocol/control.h"
#include "service/protocol/environment.h"

namespace omni::protocol {
namespace {

FolderCheck RefusedFolder(std::string problem) { return {FolderState::kRefused, std::move(problem)}; }

struct flock WholeFile() {
  struct flock lock {};
  lock.l_type = F_WRLCK;
  lock.l_whence = SEEK_SET;
  return lock;
}

bool IsLocked(const std::string& path) {
  const base::UniqueFd file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
  struct flock lock = WholeFile();
  return file && ::fcntl(file.get(), F_OFD_GETLK, &lock) == 0 && lock.l_type != F_UNLCK;
}

}  // namespace

std::string DefaultSocketPath() {
  if (std::string path = EnvironmentVariable("OMNI_SOCKET"); !path.empty()) return path;
  if (const std::string folder = EnvironmentVariable("XDG_RUNTIME_DIR"); !folder.empty() && folder.front() == '/') {
    return folder + "/omni/omnid.sock";
  }
  const std::string uid = std::to_string(::geteuid());
  if (const std::string folder = "/run/user/" + uid; CheckFolder(folder).state == FolderState::kGood) {
    return folder + "/omni/omnid.sock";
  }
  return "/tmp/omni-" + uid + "/omnid.sock";
}

std::string PathProblem(const std::string& socket_path) {
  const char* const remedy = "; set OMNI_SOCKET to an absolute path of at most 107 bytes, e.g. /tmp/omni/omnid.sock";
  if (socket_path.empty() || socket_path.front() != '/' || socket_path.back() == '/') {
    return "socket path '" + socket_path + "' is not the absolute path of a file" + remedy;
  }
  if (socket_path.find('\0') != std::string::npos) return std::string("socket path contains a NUL") + remedy;
  if (socket_path.size() > kMaxSocketPathBytes) {
    return "socket path '" + socket_path + "' has " + std::to_string(socket_path.size()) + " bytes, the limit is " +
           std::to_string(kMaxSocketPathBytes) + remedy;
  }
  return {};
}

std::string FolderOf(const std::string& socket_path) {
  const std::size_t slash = socket_path.rfind('/');
  return slash == 0 ? "/" : socket_path.substr(0, slash);
}

FolderCheck CheckFolder(const std::string& folder) {
  struct stat info {};
  if (::lstat(folder.c_str(), &info) != 0) {
    if (errno == ENOENT) return {FolderState::kMissing, "folder " + folder + " does not exist"};
    return RefusedFolder("folder " + folder + " cannot be examined: " + std::strerror(errno));
  }
  if (S_ISLNK(info.st_mode)) {
    return RefusedFolder("folder " + folder +
                         " is a symbolic link; remove it or set OMNI_SOCKET to a path in a real folder");
  }
  if (!S_ISDIR(info.st_mode)) {
    return RefusedFolder(folder + " is not a folder; remove it or set OMNI_SOCKET to a path in another folder");
  }
  if (info.st_uid != ::geteuid()) {
    return RefusedFolder("folder " + folder + " belongs to user " + std::to_string(info.st_uid) + ", not to user " +
                         std::to_string(::geteuid()) + "; set OMNI_SOCKET to a path in a folder of your own");
  }
  if ((info.st_mode & 077) != 0) {
    char mode[8];
    std::snprintf(mode, sizeof(mode), "%04o", info.st_mode & 07777u);
    return RefusedFolder("folder " + folder + " has mode " + mode + ", open to other users; run `chmod 700 " + folder +
                         "` or set OMNI_SOCKET to a path in a folder of its own");
  }
  return {FolderState::kGood, {}};
}

std::string LockPathOf(const std::string& socket_path) {
  const std::string suffix = ".sock";
  const bool usual = socket_path.size() > suffix.size() && socket_path.ends_with(suffix);
  return (usual ? socket_path.substr(0, socket_path.size() - suffix.size()) : socket_path) + ".lock";
}

bool LockSocket(int lock_fd) noexcept {
  struct flock lock = WholeFile();
  return ::fcntl(lock_fd, F_OFD_SETLK, &lock) == 0;
}

// A row of /proc/net/unix ends with "FLAGS TYPE STATE INODE PATH"; the flag 0x10000 is of a socket that accepts.
bool IsListenedOn(const std::string& socket_path) {
  std::ifstream rows("/proc/net/unix");
  for (std::string row; std::getline(rows, row);) {
    const bool names_it = row.size() > socket_path.size() && row.ends_with(socket_path) &&
                          row[row.size() - socket_path.size() - 1] == ' ';
    if (names_it && row.find(" 00010000 ") != std::string::npos) return true;
  }
  return false;
}

ServiceState FindService(const std::string& socket_path) {
  if (IsLocked(LockPathOf(socket_path))) return ServiceState::kRuns;
  return IsListenedOn(socket_path) ? ServiceState::kOnDemand : ServiceState::kAbsent;
}

SocketAddress AddressOf(const std::string& socket_path) {
  SocketAddress result;
  result.address.sun_family = AF_UNIX;
  std::memcpy(result.address.sun_path, socket_path.c_str(), socket_path.size() + 1);
  result.bytes = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + socket_path.size() + 1);
  return result;
}

}  // namespace omni::protocol
