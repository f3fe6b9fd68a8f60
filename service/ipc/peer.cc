#include "service/ipc/peer.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstdio>
#include <utility>

#include "service/protocol/text.h"

namespace omni::ipc {
namespace {

using base::UniqueFd;
using protocol::SendResult;

constexpr int kSoPeerPidfd = 77;  // SO_PEERPIDFD, Linux 6.5: names the process itself, not a number that may be reused

base::UniqueFd OpenStat(pid_t pid) noexcept {
  char path[64];
  std::snprintf(path, sizeof(path), "/proc/%d/task/%d/stat", pid, pid);
  return UniqueFd(::open(path, O_RDONLY | O_CLOEXEC));
}

bool HasEnded(int process) noexcept {
  pollfd wait{.fd = process, .events = POLLIN, .revents = 0};
  return ::poll(&wait, 1, 0) == 1;
}

}  // namespace

Credentials CredentialsOf(int socket) noexcept {
  ucred peer{};
  socklen_t bytes = sizeof(peer);
  if (::getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &peer, &bytes) != 0) return {};
  return {peer.uid, peer.pid};
}

ProcessWatch WatchProcess(int socket, pid_t pid) noexcept {
  int fd = -1;
  socklen_t bytes = sizeof(fd);
  ProcessWatch watch;
  if (::getsockopt(socket, SOL_SOCKET, kSoPeerPidfd, &fd, &bytes) == 0) {
    watch.fd.Reset(fd);
  } else if (pid > 0) {
    watch.fd.Reset(static_cast<int>(::syscall(SYS_pidfd_open, pid, 0)));
    watch.already_dead = !watch.fd && errno == ESRCH;
  }
  if (!watch.fd || pid <= 0) return watch;
  watch.stat = OpenStat(pid);
  if (HasEnded(watch.fd.get())) watch.stat.Reset();  // the number may be another process's by now
  return watch;
}

bool IsEnding(std::string_view stat) noexcept {
  constexpr std::uint64_t kExiting = 4;  // PF_EXITING
  char state = 0;
  std::uint64_t flags = 0, pending = 0;
  // After the name, which may hold anything: the state is field 3.
  const std::size_t name_end = stat.rfind(')');
  if (name_end == std::string_view::npos) return false;
  std::string_view rest = stat.substr(name_end + 1);
  for (int field = 3; field <= 31; ++field) {
    rest.remove_prefix(std::min(rest.find_first_not_of(' '), rest.size()));
    const std::string_view word = rest.substr(0, rest.find(' '));
    rest.remove_prefix(word.size());
    if (word.empty()) return false;
    if (field == 3) state = word.front();
    if (field == 9) std::from_chars(word.data(), word.data() + word.size(), flags);
    if (field == 31) std::from_chars(word.data(), word.data() + word.size(), pending);
  }
  // A first thread that has ended (Z) may leave others behind.
  return (pending >> (SIGKILL - 1) & 1) != 0 || ((flags & kExiting) != 0 && state != 'Z');
}

Peer::Peer(ClientId id, UniqueFd socket, ProcessWatch process, pid_t pid, std::int64_t now_ns)
    : socket_(std::move(socket)), process_(std::move(process)), accepted_ns_(now_ns) {
  info_.id = id;
  info_.pid = pid;
}

base::Status Peer::Greet(const protocol::Hello& hello, std::uint64_t service_instance, int state_fd) {
  auto page = base::MakeSealedMemory("omni-life", protocol::kLifePageBytes, PROT_READ, base::kSealsFixedSize);
  if (!page) return base::Error{page.error()};
  info_.role = hello.role;
  info_.application = protocol::Printable(hello.application);
  info_.engine = protocol::Printable(hello.engine);
  protocol::Welcome welcome;
  welcome.client_id = info_.id;
  welcome.service_instance = service_instance;
  welcome.state_bytes = sizeof(protocol::StateMemory);
  welcome.life_bytes = protocol::kLifePageBytes;
  const int fds[] = {state_fd, page->fd.get()};
  if (protocol::SendPacket(socket_.get(), &welcome, sizeof(welcome), fds, 2) != SendResult::kSent) {
    return base::Error{"Welcome could not be sent"};
  }
  const auto mapping = std::make_shared<const base::Mapping>(std::move(page->mapping));
  life_ = {mapping, static_cast<const protocol::LifePage*>(mapping->get())};
  return base::Ok{};
}

bool Peer::Send(std::string_view message, int file, protocol::Delivery delivery) noexcept {
  const SendResult result =
      protocol::SendPacket(socket_.get(), message.data(), message.size(), &file, file >= 0 ? 1 : 0);
  if (result == SendResult::kFull && delivery == protocol::Delivery::kOnce) ++dropped_;
  if (result == SendResult::kGone) doomed_ = true;
  return result == SendResult::kSent;
}

bool Peer::IsKilled() const noexcept {
  char line[1024];
  const ssize_t size = process_.stat ? ::pread(process_.stat.get(), line, sizeof(line), 0) : 0;
  return size > 0 && IsEnding({line, static_cast<std::size_t>(size)});
}

void Peer::Doom(const std::string& reason) noexcept {
  if (doomed_) return;
  doomed_ = true;
  if (!reason.empty()) SendReject(socket_.get(), reason);
}

void SendReject(int socket, const std::string& reason) noexcept {
  protocol::Reject reject;
  protocol::SetField(reject.reason, reason);
  protocol::SendPacket(socket, &reject, sizeof(reject));
}

namespace {

constexpr std::int64_t kRepeatAfter_ns = 60'000'000'000;
constexpr std::int64_t kWindow_ns = 1'000'000'000;
constexpr int kMaxLinesPerWindow = 20;  // further ones are dropped

}  // namespace

LogLines::LogLines(std::function<void(const std::string&)> sink) : sink_(std::move(sink)) {
  if (!sink_) sink_ = [](const std::string& line) { std::fprintf(stderr, "omnid: %s\n", line.c_str()); };
}

void LogLines::Write(const std::string& line, std::int64_t now_ns) {
  if (line == last_line_ && now_ns - last_ns_ < kRepeatAfter_ns) return;
  if (now_ns - window_start_ns_ >= kWindow_ns) {
    window_start_ns_ = now_ns;
    lines_in_window_ = 0;
  }
  if (++lines_in_window_ > kMaxLinesPerWindow) return;
  last_line_ = line;
  last_ns_ = now_ns;
  sink_(line);
}

}  // namespace omni::ipc
