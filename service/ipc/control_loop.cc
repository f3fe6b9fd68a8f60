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

// The requests about forces that a client may make.
std::optional<protocol::ForceRequest> ForceRequestIn(const protocol::Message& message) {
  if (const auto* claim = std::get_if<protocol::ForceClaim>(&message)) return *claim;
  if (const auto* apply = std::get_if<protocol::ForceApply>(&message)) return *apply;
  if (const auto* constraints = std::get_if<protocol::ForceConstraints>(&message)) return *constraints;
  if (const auto* stop = std::get_if<protocol::ForceStop>(&message)) return *stop;
  return std::nullopt;
}

}  // namespace

base::Result<std::unique_ptr<ControlLoop>> ControlLoop::Open(const ServerOptions& options, ServerHandler& handler) {
  if (auto checked = CheckOptions(options); !checked) return Error{checked.error()};
  auto listener = Listener::Open(options.socket_path);
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
    return SendReject(socket.get(), "too many connections that have not said Hello; try again");
  }
  ProcessWatch process = WatchProcess(socket.get(), credentials.pid);
  if (process.already_dead) return;
  const ClientId id = next_id_++;
  Peer& peer =
      peers_.try_emplace(id, id, std::move(socket), std::move(process.fd), credentials.pid, now_ns).first->second;
  const bool watched = Watch(peer.socket(), Token(Source::kSocket, id)).ok() &&
                       (peer.process() < 0 || Watch(peer.process(), Token(Source::kProcess, id)).ok());
  if (!watched) Refuse(peer, "omnid cannot watch another client");
}

void ControlLoop::ReadFrom(Peer& peer) {
  for (int i = 0; i < kPacketsPerRound && !peer.doomed(); ++i) {
    const protocol::Received received =
        protocol::ReceivePacket(peer.socket(), buffer_.data(), buffer_.size(), &document_, 1);
    if (received.result == ReceiveResult::kNothing) return;
    if (received.result == ReceiveResult::kEnd) return peer.Doom({});
    if (received.result == ReceiveResult::kTooLong) {
      return Refuse(peer, "a packet over " + std::to_string(protocol::kMaxMessageBytes) +
                              " bytes, or with descriptors that no message has");
    }
    const protocol::Message message = protocol::Validate(buffer_.data(), received.size);
    if (received.fd_count > 0 && !std::holds_alternative<protocol::HapticSceneLoad>(message)) {
      return Refuse(peer, "a packet with descriptors that its message does not have");
    }
    const bool goes_on = Handle(peer, message);
    document_.Reset();
    if (!goes_on) return;
  }
}

bool ControlLoop::Handle(Peer& peer, const protocol::Message& message) {
  if (const auto* invalid = std::get_if<protocol::Invalid>(&message)) {
    const std::string remedy = invalid->other_version ? "; install the same Omni version for service and client" : "";
    Refuse(peer, invalid->reason + remedy);
    return false;
  }
  const auto* hello = std::get_if<protocol::Hello>(&message);
  if ((hello != nullptr) == peer.greeted()) {
    Refuse(peer, peer.greeted() ? "a second Hello" : "the first message must be Hello");
    return false;
  }
  if (hello != nullptr) {
    Greet(peer, *hello);
    return true;
  }
  if (std::holds_alternative<protocol::StatusRequest>(message)) {
    AnswerStatus(peer);
    return false;  // one answer per round: a client that floods must not starve the others
  }
  if (const auto* request = std::get_if<protocol::SurfaceRequest>(&message)) {
    Guarded("OnSurfaceRequest", &peer, [&] { handler_.OnSurfaceRequest(peer.id(), request->wanted != 0); });
    return !peer.doomed();
  }
  if (const auto* command = std::get_if<protocol::SceneCommand>(&message)) {
    Guarded("OnSceneCommand", &peer, [&] { handler_.OnSceneCommand(peer.id(), *command); });
    return false;  // as above
  }
  if (const auto force = ForceRequestIn(message)) return HandleForce(peer, *force);
  if (const auto* command = std::get_if<protocol::PlacementCommand>(&message)) {
    if (peer.info().role != protocol::ClientRole::kTool) {
      Refuse(peer, "only a tool such as omni align changes alignments; say Hello as a tool");
      return false;
    }
    Guarded("OnPlacementCommand", &peer, [&] { handler_.OnPlacementCommand(peer.id(), *command); });
    return false;  // as above
  }
  return HandleApplication(peer, message);
}

void ControlLoop::Greet(Peer& peer, const protocol::Hello& hello) {
  if (CountGreeted() >= static_cast<std::size_t>(options_.max_clients)) {
    return Refuse(peer, "omnid already serves " + std::to_string(options_.max_clients) +
                            " clients, its limit; close one of them");
  }
  const auto greeted = peer.Greet(hello, options_.service_instance, options_.state_fd, base::MonotonicNow_ns());
  if (!greeted) return Refuse(peer, greeted.error());
  Guarded("OnClient", &peer, [&] { handler_.OnClient(peer.info()); });
}

bool ControlLoop::HandleForce(Peer& peer, const protocol::ForceRequest& request) {
  if (peer.info().role != protocol::ClientRole::kApplication) {
    Refuse(peer, "a monitor has no forces; say Hello as an application");
  } else {
    Guarded("OnForce", &peer, [&] { handler_.OnForce(peer.id(), request); });
  }
  return !peer.doomed();
}

bool ControlLoop::HandleApplication(Peer& peer, const protocol::Message& message) {
  const ClientId id = peer.id();
  const auto* session = std::get_if<protocol::Session>(&message);
  const auto* haptic = std::get_if<protocol::Haptic>(&message);
  const auto* shaped = std::get_if<protocol::ShapedHaptic>(&message);
  const bool stop = std::holds_alternative<protocol::HapticStop>(message);
  if (HandleHapticScene(peer, message)) return !peer.doomed();
  if (HandlePlacement(peer, message)) return !peer.doomed();
  if (session == nullptr && haptic == nullptr && shaped == nullptr && !stop) {
    Refuse(peer, "a message that only omnid sends");
  } else if (peer.info().role != protocol::ClientRole::kApplication) {
    Refuse(peer, "a monitor has neither session nor haptics; say Hello as an application");
  } else if (session != nullptr) {
    Guarded("OnSession", &peer, [&] { handler_.OnSession(id, session->state); });
  } else if (haptic != nullptr) {
    Guarded("OnHaptic", &peer, [&] { handler_.OnHaptic(id, *haptic); });
  } else if (shaped != nullptr) {
    Guarded("OnWaveform", &peer, [&] { handler_.OnWaveform(id, *shaped); });
  } else {
    Guarded("OnHapticStop", &peer, [&] { handler_.OnHapticStop(id); });
  }
  return !peer.doomed();
}

// True: it was about the places of bases, and is done.
bool ControlLoop::HandlePlacement(Peer& peer, const protocol::Message& message) {
  const auto* request = std::get_if<protocol::PlacementRequest>(&message);
  const auto* change = std::get_if<protocol::SpaceChange>(&message);
  if (request == nullptr && change == nullptr) return false;
  if (peer.info().role != protocol::ClientRole::kApplication) {
    Refuse(peer, "a monitor has no spaces; say Hello as an application");
  } else if (request != nullptr) {
    Guarded("OnPlacementRequest", &peer, [&] { handler_.OnPlacementRequest(peer.id(), *request); });
  } else {
    Guarded("OnSpaceChange", &peer, [&] { handler_.OnSpaceChange(peer.id(), *change); });
  }
  return true;
}

void ControlLoop::AnswerStatus(Peer& peer) {
  Guarded("StatusJson", &peer, [&] {
    std::string json = handler_.StatusJson();
    if (json.size() > protocol::kMaxMessageBytes - sizeof(protocol::MessageHeader)) {
      json = R"({"error":"the status does not fit into one message"})";
    }
    protocol::MessageHeader header;
    header.type = protocol::MessageType::kStatusReply;
    header.size = static_cast<std::uint32_t>(sizeof(header) + json.size());
    std::string packet(reinterpret_cast<const char*>(&header), sizeof(header));
    packet += json;
    peer.Send(packet.data(), packet.size());
  });
}

void ControlLoop::OnTimer() {
  std::uint64_t expirations = 0;
  if (::read(timer_.get(), &expirations, sizeof(expirations)) < 0) return;
  const std::int64_t now_ns = base::MonotonicNow_ns();
  for (auto& [id, peer] : peers_) {
    peer.ReadBeat(now_ns);
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
// others (SendNotice), so this goes on until none is left.
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

void ControlLoop::TellOfThrow(const char* name, Peer* peer, const std::string& what) {
  log_.Write(std::string("internal error in ") + name + ": " + what, base::MonotonicNow_ns());
  if (peer != nullptr) peer->Doom("internal error in omnid; see its log");
}

const Peer* ControlLoop::Find(ClientId id) const {
  const auto found = peers_.find(id);
  return found != peers_.end() && found->second.greeted() ? &found->second : nullptr;
}

void ControlLoop::SendNotice(ClientId id, int level, const std::string& text) {
  const auto found = peers_.find(id);
  if (found == peers_.end() || !found->second.greeted() || found->second.doomed()) return;
  protocol::Notice notice;
  notice.level = static_cast<std::uint32_t>(std::clamp(level, 0, 2));
  protocol::SetField(notice.text, text);
  found->second.Send(&notice, sizeof(notice));
}

void ControlLoop::SendSettings(ClientId id, const protocol::AppSettings& settings) {
  const auto found = peers_.find(id);
  if (found == peers_.end() || !found->second.greeted() || found->second.doomed()) return;
  found->second.Send(&settings, sizeof(settings));
}

bool ControlLoop::SendSurfaces(ClientId id, const protocol::Surfaces& surfaces, int fd) {
  const auto found = peers_.find(id);
  if (found == peers_.end() || !found->second.greeted() || found->second.doomed()) return false;
  return found->second.TrySend(&surfaces, sizeof(surfaces), fd);
}

bool ControlLoop::SendAgainLater(ClientId id, const void* bytes, std::size_t size) {
  const auto found = peers_.find(id);
  if (found == peers_.end() || !found->second.greeted() || found->second.doomed()) return false;
  return found->second.TrySend(bytes, size, -1);
}

bool ControlLoop::SendPlacement(ClientId id, const protocol::Placement& placement) {
  const auto found = peers_.find(id);
  if (found == peers_.end() || !found->second.greeted() || found->second.doomed()) return false;
  return found->second.TrySend(&placement, sizeof(placement), -1);
}

void ControlLoop::SendPlacementReply(ClientId id, std::uint32_t number, bool done, const std::string& text) {
  const auto found = peers_.find(id);
  if (found == peers_.end() || !found->second.greeted() || found->second.doomed()) return;
  protocol::PlacementReply reply;
  reply.number = number;
  reply.done = done ? 1 : 0;
  protocol::SetField(reply.text, text);
  found->second.Send(&reply, sizeof(reply));
}

void ControlLoop::SendSceneReply(ClientId id, const SceneReplyParts& parts) {
  const auto found = peers_.find(id);
  if (found == peers_.end() || !found->second.greeted() || found->second.doomed()) return;
  protocol::SceneReply reply;
  const std::size_t text_bytes = std::min(parts.text.size(), protocol::kMaxMessageBytes - sizeof(reply));
  reply.header.size = static_cast<std::uint32_t>(sizeof(reply) + text_bytes);
  reply.number = parts.number;
  reply.done = parts.done ? 1 : 0;
  reply.file_bytes = parts.done ? parts.file_bytes : 0;
  std::string packet(reinterpret_cast<const char*>(&reply), sizeof(reply));
  packet.append(parts.text, 0, text_bytes);
  found->second.Send(packet.data(), packet.size(), &parts.file, reply.file_bytes > 0 ? 1 : 0);
}

}  // namespace omni::ipc
