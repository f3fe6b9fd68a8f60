#include "service/ipc/control_loop.h"

#include <fcntl.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <exception>
#include <optional>
#include <utility>

#include "service/base/clock.h"
#include "service/protocol/text.h"

namespace omni::ipc {
namespace {

using base::Error;
using base::UniqueFd;
using protocol::ReceiveResult;

constexpr int kAcceptsPerRound = 16;
constexpr int kPacketsPerRound = 32;
constexpr std::size_t kMaxSilent = 32;  // connections that have not said Hello

// What an epoll event is about: a peer's id above, the kind of descriptor below.
enum class Source : std::uint64_t { kListener = 0, kTimer = 1, kStop = 2, kSocket = 3, kProcess = 4 };
constexpr std::uint64_t kSourceBits = 3;
constexpr std::uint64_t Token(Source source, ClientId id = 0) {
  return id << kSourceBits | static_cast<std::uint64_t>(source);
}

Error Failed(const char* what) {
  return Error{std::string("control socket: ") + what + " failed: " + std::strerror(errno) +
               "; check the limit on open files (ulimit -n)"};
}

base::Status CheckOptions(const ServerOptions& options) {
  const int seals = ::fcntl(options.state_fd, F_GET_SEALS);
  if (seals < 0 || (seals & base::kSealsOneWriter) != base::kSealsOneWriter) {
    return Error{"ServerOptions.state_fd is no sealed state memory; pass StatePublisher::fd()"};
  }
  if (!(options.period_ns >= 1'000'000 && options.period_ns <= 1'000'000'000)) {
    return Error{"ServerOptions.period_ns is " + std::to_string(options.period_ns) + ", must be in 1e6..1e9"};
  }
  if (!(options.max_clients >= 1 && options.max_clients <= 1024)) {
    return Error{"ServerOptions.max_clients is " + std::to_string(options.max_clients) + ", must be in 1..1024"};
  }
  return base::Ok{};
}

// What is wrong with the descriptor of a message; empty: nothing.
template <class M>
std::string ProblemOfFile(const M& message, const UniqueFd& file) {
  if (protocol::Traits<M>::kDescriptors == 0) return file ? "comes with descriptors, must have none" : "";
  if (!file) return "comes without its descriptor";
  if constexpr (std::is_same_v<M, protocol::HapticSceneLoad>) {
    // A document that cannot change.
    const auto checked = base::CheckSealed(file.get(), F_SEAL_WRITE | F_SEAL_SHRINK | F_SEAL_GROW, message.bytes);
    if (!checked.ok()) return "its memory " + checked.error();
  }
  return {};
}

// "an application or a tool"
std::string NamesOfRoles(std::uint32_t roles) {
  std::string names;
  for (const auto& [role, name] :
       {std::pair{protocol::kApplications, "an application"}, std::pair{protocol::kMonitors, "a monitor"},
        std::pair{protocol::kTools, "a tool"}}) {
    if ((roles & role) != 0) names += (names.empty() ? "" : " or ") + std::string(name);
  }
  return names;
}

}  // namespace

base::Result<std::unique_ptr<ControlLoop>> ControlLoop::Open(const ServerOptions& options, ServerHandler& handler) {
  if (auto checked = CheckOptions(options); !checked) return Error{checked.error()};
  auto listener = options.inherited_fd < 0 ? Listener::Open(options.socket_path)
                                           : Listener::Adopt(base::UniqueFd(options.inherited_fd), options.socket_path);
  if (!listener) return Error{listener.error()};
  std::unique_ptr<ControlLoop> loop(new ControlLoop(options, handler, std::move(*listener)));
  if (auto opened = loop->OpenDescriptors(); !opened) return Error{opened.error()};
  return loop;
}

ControlLoop::ControlLoop(const ServerOptions& options, ServerHandler& handler, Listener listener)
    : options_(options),
      handler_(handler),
      listener_(std::move(listener)),
      log_(options.log),
      buffer_(protocol::kMaxMessageBytes) {}

base::Status ControlLoop::OpenDescriptors() {
  epoll_.Reset(::epoll_create1(EPOLL_CLOEXEC));
  timer_.Reset(::timerfd_create(CLOCK_MONOTONIC, TFD_CLOEXEC | TFD_NONBLOCK));
  stop_.Reset(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
  spare_.Reset(::open("/dev/null", O_RDONLY | O_CLOEXEC));
  if (!epoll_ || !timer_ || !stop_) return Failed("making its descriptors");
  const timespec period{options_.period_ns / 1'000'000'000, options_.period_ns % 1'000'000'000};
  const itimerspec schedule{period, period};
  if (::timerfd_settime(timer_.get(), 0, &schedule, nullptr) != 0) return Failed("timerfd_settime");
  const std::pair<int, Source> watched[] = {
      {listener_.fd(), Source::kListener}, {timer_.get(), Source::kTimer}, {stop_.get(), Source::kStop}};
  for (const auto& [fd, source] : watched) {
    if (auto status = Watch(fd, Token(source)); !status) return status;
  }
  return base::Ok{};
}

base::Status ControlLoop::Watch(int fd, std::uint64_t token) {
  epoll_event event{};
  event.events = EPOLLIN;
  event.data.u64 = token;
  if (::epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, fd, &event) != 0) return Failed("epoll_ctl");
  return base::Ok{};
}

void ControlLoop::Run() {
  if (options_.on_start) options_.on_start();
  std::array<epoll_event, 64> events;
  while (!stopping_.load(std::memory_order_acquire)) {
    const int count = ::epoll_wait(epoll_.get(), events.data(), static_cast<int>(events.size()), -1);
    for (int i = 0; i < count; ++i) {
      const std::uint64_t token = events[static_cast<std::size_t>(i)].data.u64;
      Guarded("the control loop", nullptr, [&] { Dispatch(token); });
    }
    Guarded("the control loop", nullptr, [&] { Sweep(); });
  }
}

void ControlLoop::RequestStop() {
  stopping_.store(true, std::memory_order_release);
  const std::uint64_t one = 1;
  while (::write(stop_.get(), &one, sizeof(one)) < 0 && errno == EINTR) {
  }
}

void ControlLoop::Dispatch(std::uint64_t token) {
  const auto source = static_cast<Source>(token & ((1u << kSourceBits) - 1));
  if (source == Source::kListener) return Accept();
  if (source == Source::kTimer) return OnTimer();
  if (source == Source::kStop) return;
  const auto found = peers_.find(token >> kSourceBits);
  if (found == peers_.end() || found->second.doomed()) return;
  if (source == Source::kProcess) return found->second.Doom({});  // its socket may live on in a forked child
  ReadFrom(found->second);
}

void ControlLoop::Accept() {
  for (int i = 0; i < kAcceptsPerRound; ++i) {
    UniqueFd socket(::accept4(listener_.fd(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
    if (socket) {
      Admit(std::move(socket));
    } else if (errno == EMFILE || errno == ENFILE) {
      return RefuseOneWithoutDescriptors();
    } else if (errno != ECONNABORTED && errno != EINTR) {
      return;
    }
  }
}

// An unaccepted connection would keep epoll_wait from sleeping.
void ControlLoop::RefuseOneWithoutDescriptors() {
  log_.Write("a client was refused: no file descriptor is left; raise the limit (ulimit -n)", base::MonotonicNow_ns());
  spare_.Reset();
  if (const UniqueFd socket(::accept4(listener_.fd(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK)); socket) {
    SendReject(socket.get(), "omnid has no file descriptor left; raise its limit (ulimit -n)");
  }
  spare_.Reset(::open("/dev/null", O_RDONLY | O_CLOEXEC));
}

void ControlLoop::Admit(UniqueFd socket) {
  const std::int64_t now_ns = base::MonotonicNow_ns();
  const Credentials credentials = CredentialsOf(socket.get());
  if (credentials.uid != ::geteuid()) {
    const std::string reason = "omnid of user " + std::to_string(::geteuid()) + " does not serve user " +
                               std::to_string(credentials.uid) + "; start an omnid of your own";
    SendReject(socket.get(), reason);
    return log_.Write("pid " + std::to_string(credentials.pid) + " was refused: " + reason, now_ns);
  }
  if (peers_.size() - CountGreeted() >= kMaxSilent) {
    return SendReject(socket.get(), "too many connections that have not sent Hello; try again");
  }
  ProcessWatch process = WatchProcess(socket.get(), credentials.pid);
  if (process.already_dead) return;
  const ClientId id = next_id_++;
  Peer& peer = peers_.try_emplace(id, id, std::move(socket), std::move(process), credentials.pid, now_ns).first->second;
  const bool watched = Watch(peer.socket(), Token(Source::kSocket, id)).ok() &&
                       (peer.process() < 0 || Watch(peer.process(), Token(Source::kProcess, id)).ok());
  if (!watched) Refuse(peer, "omnid cannot watch another client");
}

void ControlLoop::ReadFrom(Peer& peer) {
  for (int i = 0; i < kPacketsPerRound && !peer.doomed(); ++i) {
    UniqueFd file;
    const protocol::Received received =
        protocol::ReceivePacket(peer.socket(), buffer_.data(), buffer_.size(), &file, 1);
    if (received.result == ReceiveResult::kNothing) return;
    if (received.result == ReceiveResult::kEnd) return peer.Doom({});
    if (received.result == ReceiveResult::kTooLong) {
      return Refuse(peer, "a packet over " + std::to_string(protocol::kMaxMessageBytes) +
                              " bytes, or with descriptors that no message has");
    }
    if (received.result == ReceiveResult::kNoRoom) {
      return Refuse(peer, "omnid has as many files open as it may; try again, or start it with a higher ulimit -n");
    }
    if (!Handle(peer, protocol::ValidateFromClient(buffer_.data(), received.size), std::move(file))) return;
  }
}

bool ControlLoop::Handle(Peer& peer, const protocol::ClientMessage& message, UniqueFd file) {
  return std::visit(
      [&]<class M>(const M& one) {
        if constexpr (std::is_same_v<M, protocol::Invalid>) {
          const std::string remedy = one.other_version ? "; install the same Omni version for service and client" : "";
          Refuse(peer, one.reason + remedy);
          return false;
        } else {
          HandleAs(peer, one, std::move(file));
          return !peer.doomed() && protocol::Traits<M>::kPace == protocol::Pace::kStream;
        }
      },
      message);
}

template <class M>
void ControlLoop::HandleAs(Peer& peer, const M& message, UniqueFd file) {
  using Row = protocol::Traits<M>;
  constexpr bool kIsHello = std::is_same_v<M, protocol::Hello>;
  if (kIsHello == peer.greeted()) {
    return Refuse(peer, peer.greeted() ? "a second Hello" : "the first message must be Hello");
  }
  if (!kIsHello && (Row::kRoles & protocol::RoleBit(peer.info().role)) == 0) {
    const std::string who = NamesOfRoles(Row::kRoles), is = NamesOfRoles(protocol::RoleBit(peer.info().role));
    return Refuse(peer, std::string(Row::kName) + ": only " + who + " may send it, not " + is + "; connect as " + who);
  }
  if (const std::string problem = ProblemOfFile(message, file); !problem.empty()) {
    return Refuse(peer, std::string(Row::kName) + ": " + problem);
  }
  if constexpr (kIsHello) {
    Greet(peer, message);
  } else if constexpr (std::is_same_v<M, protocol::StatusRequest>) {
    AnswerStatus(peer);
  } else {
    Guarded(Row::kName, &peer, [&] { handler_.OnRequest(peer.id(), protocol::Request(message), std::move(file)); });
  }
}

void ControlLoop::Greet(Peer& peer, const protocol::Hello& hello) {
  if (CountGreeted() >= static_cast<std::size_t>(options_.max_clients)) {
    return Refuse(peer, "omnid already serves " + std::to_string(options_.max_clients) +
                            " clients, its limit; close one of them");
  }
  const auto greeted = peer.Greet(hello, options_.service_instance, options_.state_fd);
  if (!greeted) return Refuse(peer, greeted.error());
  Guarded("OnClient", &peer, [&] { handler_.OnClient(peer.info()); });
}

void ControlLoop::AnswerStatus(Peer& peer) {
  Guarded("StatusJson", &peer, [&] {
    protocol::MessageHeader header;
    header.type = protocol::MessageType::kStatusReply;
    const std::string json = handler_.StatusJson();
    const bool fits = json.size() <= protocol::kMaxMessageBytes - sizeof(header);
    Send(peer.id(), header, sizeof(header), fits ? json : R"({"error":"the status does not fit into one message"})",
         -1);
  });
}

void ControlLoop::OnTimer() {
  std::uint64_t expirations = 0;
  if (::read(timer_.get(), &expirations, sizeof(expirations)) < 0) return;
  const std::int64_t now_ns = base::MonotonicNow_ns();
  for (auto& [id, peer] : peers_) {
    if (peer.greeted() && peer.info().role == protocol::ClientRole::kApplication && peer.IsKilled()) peer.Doom({});
    if (!peer.greeted() && now_ns - peer.accepted_ns() > options_.hello_timeout_ns) peer.Doom("no Hello in time");
  }
  Guarded("OnPeriod", nullptr, [&] { handler_.OnPeriod(now_ns); });
}

void ControlLoop::Refuse(Peer& peer, const std::string& reason) {
  peer.Doom(reason);
  const std::string name = peer.info().application.empty() ? "a client" : "'" + peer.info().application + "'";
  log_.Write(name + " (pid " + std::to_string(peer.info().pid) + ") was dropped: " + reason, base::MonotonicNow_ns());
}

// Doomed peers leave here and nowhere else, so that no call above ever holds a peer that is gone. A handler may doom
// others (Send), so this goes on until none is left.
void ControlLoop::Sweep() {
  const auto doomed = [](const auto& entry) { return entry.second.doomed(); };
  for (auto at = std::find_if(peers_.begin(), peers_.end(), doomed); at != peers_.end();
       at = std::find_if(peers_.begin(), peers_.end(), doomed)) {
    const ClientId id = at->first;
    const bool greeted = at->second.greeted();
    // Explicitly: closing would not remove a descriptor that a child of ours has inherited meanwhile.
    ::epoll_ctl(epoll_.get(), EPOLL_CTL_DEL, at->second.socket(), nullptr);
    if (at->second.process() >= 0) ::epoll_ctl(epoll_.get(), EPOLL_CTL_DEL, at->second.process(), nullptr);
    peers_.erase(at);
    if (greeted) Guarded("OnGone", nullptr, [&] { handler_.OnGone(id); });
  }
}

std::size_t ControlLoop::CountGreeted() const {
  return static_cast<std::size_t>(
      std::count_if(peers_.begin(), peers_.end(), [](const auto& entry) { return entry.second.greeted(); }));
}

void ControlLoop::ReportThrow(const char* name, Peer* peer, const std::string& what) {
  log_.Write(std::string("internal error in ") + name + ": " + what, base::MonotonicNow_ns());
  if (peer != nullptr) peer->Doom("internal error in omnid; see its log");
}

const Peer* ControlLoop::Find(ClientId id) const {
  const auto found = peers_.find(id);
  return found != peers_.end() && found->second.greeted() ? &found->second : nullptr;
}

bool ControlLoop::Send(ClientId id, const protocol::MessageHeader& head, std::size_t head_bytes, std::string_view tail,
                       int file) {
  std::string packet(reinterpret_cast<const char*>(&head), head_bytes);
  packet.append(tail, 0, protocol::kMaxMessageBytes - head_bytes);
  const auto size = static_cast<std::uint32_t>(packet.size());
  std::memcpy(packet.data() + offsetof(protocol::MessageHeader, size), &size, sizeof(size));
  return SendBytes(id, packet, file);
}

bool ControlLoop::SendBytes(ClientId id, std::string_view message, int file) {
  const auto found = peers_.find(id);
  if (found == peers_.end() || !found->second.greeted() || found->second.doomed()) return false;
  protocol::MessageHeader header;
  std::memcpy(&header, message.data(), std::min(message.size(), sizeof(header)));
  return found->second.Send(message, file, protocol::DeliveryOf(header.type));
}

}  // namespace omni::ipc
