#include "service/client/connection.h"

#include <fcntl.h>
#include <sys/mman.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>
#include <variant>

#include "service/client/dial.h"
#include "service/client/life_link.h"
#include "service/protocol/messages.h"
#include "service/protocol/packet_socket.h"
#include "service/protocol/socket_path.h"
#include "service/protocol/text.h"

namespace omni::client {

namespace {

using base::UniqueFd;
using protocol::ReceiveResult;
using protocol::SendResult;

constexpr int kMessagesPerPoll = 16;
constexpr std::size_t kMaxNotices = 32;  // older ones are dropped
constexpr std::int64_t kWelcomeTimeout_ns = 2'000'000'000;

// Line ends are kept.
std::string PrintableLines(std::string_view text) {
  std::string lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    lines += protocol::Printable(text.substr(0, end));
    if (end < text.size()) lines += '\n';
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

HapticSceneTable TableOf(const protocol::HapticSceneRows& rows) {
  HapticSceneTable table{.number = rows.table.number, .nodes = {}, .materials = {}};
  for (std::uint32_t i = 0; i < rows.table.node_count; ++i) table.nodes.push_back(rows.Node(i));
  for (std::uint32_t i = 0; i < rows.table.material_count; ++i) table.materials.push_back(rows.Material(i));
  return table;
}

}  // namespace

std::string DefaultSocketPath() { return protocol::DefaultSocketPath(); }

// What the service is to know as long as it stands: sent until it is sent, and again after a reconnection.
template <class M>
struct Standing {
  M message;
  bool wanted = false;   // false: it says that nothing is wanted, which a new service assumes anyway
  bool pending = false;  // the service does not know it yet
};

struct Connection::Impl {
  enum class Phase { kIdle, kGreeting, kConnected };

  explicit Impl(ConnectionInfo connection_info)
      : info(std::move(connection_info)),
        path(info.socket_path.empty() && !info.privileged ? DefaultSocketPath() : info.socket_path),
        buffer(protocol::kMaxMessageBytes) {}

  void Advance(std::int64_t now_ns);
  void Attempt(std::int64_t now_ns);
  void Read(std::int64_t now_ns);
  // A packet from the service, with its descriptors.
  struct Incoming {
    std::int64_t now_ns = 0;
    UniqueFd* files = nullptr;
    std::size_t file_count = 0;
  };
  template <class M>
  void Receive(const Incoming& packet, const M& message);
  // One for each of OMNI_SERVER_MESSAGES.
  void Handle(const Incoming& packet, const protocol::Welcome& welcome);
  void Handle(const Incoming& packet, const protocol::Reject& reject);
  void Handle(const Incoming& packet, const protocol::Surfaces& announced);
  void Handle(const Incoming& packet, const protocol::SceneAnswer& answer);
  void Handle(const Incoming&, const protocol::StatusReply& reply) { status.assign(reply.json); }
  void Handle(const Incoming&, const protocol::Notice& notice);
  void Handle(const Incoming&, const protocol::AppSettings& wish) { settings = wish; }
  void Handle(const Incoming&, const protocol::ForceOwner& owner) { force_standing = owner.standing; }
  void Handle(const Incoming&, const protocol::ForceProperties& properties);
  void Handle(const Incoming&, const protocol::HapticSceneNews& news);
  void Handle(const Incoming&, const protocol::HapticSceneRows& rows);
  void Handle(const Incoming&, const protocol::BasePose& there) { base_pose = there; }
  void Handle(const Incoming&, const protocol::BasePoseReply& reply);
  void KeepHapticScene(HapticSceneUpdate update);
  // A packet that is invalid, or not expected now.
  void RefuseNonsense(std::int64_t now_ns, const std::string& what);
  void Disconnect(std::int64_t now_ns) noexcept;
  void Fail(std::int64_t now_ns, const std::string& problem);

  template <class M>
  bool Want(Standing<M>& standing, const M& message, bool wanted) noexcept {
    standing = {.message = message, .wanted = wanted, .pending = true};
    return Deliver(standing);
  }
  template <class M>
  bool Deliver(Standing<M>& standing) noexcept {
    if (standing.pending) standing.pending = !Send(standing.message);
    return !standing.pending;
  }

  template <class T>
  bool Send(const T& message) noexcept {
    return SendBytes({reinterpret_cast<const char*>(&message), sizeof(message)}, -1);
  }
  bool SendBytes(std::string_view message, int file) noexcept;

  ConnectionInfo info;
  std::string path;
  LifeLink life;
  Phase phase = Phase::kIdle;
  UniqueFd socket;
  std::shared_ptr<const StateReader> reader;
  std::int64_t next_attempt_ns = std::numeric_limits<std::int64_t>::min();
  std::int64_t greeting_since_ns = 0;
  Standing<protocol::Session> session;
  Standing<protocol::SurfaceRequest> surfaces;
  Standing<protocol::ForceClaim> force;
  Standing<protocol::BasePoseRequest> base_pose_request;
  std::shared_ptr<const SurfaceReader> surface_reader;
  bool surfaces_answered = false;
  protocol::ForceStanding force_standing = protocol::ForceStanding::kFree;
  protocol::ForceProperties force_properties;
  bool force_properties_said = false;
  std::string status;
  std::vector<protocol::Notice> notices;
  protocol::AppSettings settings;
  std::uint32_t scene_commands = 0;  // sent so far
  std::optional<SceneAnswer> scene_answer;
  std::vector<HapticSceneUpdate> haptic_scene;
  std::uint64_t welcomes = 0;
  std::optional<protocol::BasePose> base_pose;
  std::uint32_t base_pose_commands = 0;  // sent so far
  std::optional<BasePoseAnswer> base_pose_answer;
  std::string last_error;
  std::vector<std::byte> buffer;
};

void Connection::Impl::Advance(std::int64_t now_ns) {
  if (phase == Phase::kIdle && now_ns >= next_attempt_ns) Attempt(now_ns);
  if (phase == Phase::kIdle) return;
  Read(now_ns);
  if (phase == Phase::kGreeting && now_ns - greeting_since_ns > kWelcomeTimeout_ns) {
    Fail(now_ns, "omnid at " + path + " does not answer; restart omnid");
  }
  Deliver(session);
  Deliver(surfaces);
  Deliver(force);
  Deliver(base_pose_request);
}

void Connection::Impl::Attempt(std::int64_t now_ns) {
  if (path.empty()) {
    return Fail(
        now_ns,
        "a privileged process (set-uid, set-gid or capabilities) needs an explicit socket path to connect to omnid");
  }
  // Only an application starts omnid: who looks and finds none has an answer.
  if (info.role != protocol::ClientRole::kApplication && protocol::PathProblem(path).empty() &&
      protocol::FindService(path) == protocol::ServiceState::kOnDemand) {
    return Fail(now_ns, "omnid does not run; systemd starts it with the first application (socket " + path + ")");
  }
  base::Result<UniqueFd> dialled = Dial(path);
  if (!dialled.ok()) return Fail(now_ns, dialled.error());
  protocol::Hello hello;
  hello.role = info.role;
  hello.api_version_major = info.api_version_major;
  hello.api_version_minor = info.api_version_minor;
  protocol::SetField(hello.application, info.application);
  protocol::SetField(hello.engine, info.engine);
  socket = std::move(*dialled);
  phase = Phase::kGreeting;
  greeting_since_ns = now_ns;
  // A failed send is not the end yet: the server's reason may wait to be read, and a lost Hello times out.
  protocol::SendPacket(socket.get(), &hello, sizeof(hello));
}

void Connection::Impl::Read(std::int64_t now_ns) {
  for (int i = 0; i < kMessagesPerPoll && phase != Phase::kIdle; ++i) {
    UniqueFd fds[protocol::kMaxPassedFds];
    const protocol::Received received =
        protocol::ReceivePacket(socket.get(), buffer.data(), buffer.size(), fds, protocol::kMaxPassedFds);
    if (received.result == ReceiveResult::kNothing) return;
    if (received.result == ReceiveResult::kEnd) {
      return Fail(now_ns, "omnid at " + path + " closed the connection; start omnid if it does not restart");
    }
    if (received.result == ReceiveResult::kTooLong) {
      return Fail(now_ns, "omnid at " + path + " sent a packet that is too long; restart omnid");
    }
    if (received.result == ReceiveResult::kNoRoom) {
      return Fail(now_ns, "this process has as many files open as it may (ulimit -n): omnid's memory cannot be mapped");
    }
    const Incoming packet{now_ns, fds, received.fd_count};
    std::visit([&](const auto& message) { Receive(packet, message); },
               protocol::ValidateFromServer(buffer.data(), received.size));
  }
}

template <class M>
void Connection::Impl::Receive(const Incoming& packet, const M& message) {
  if constexpr (std::is_same_v<M, protocol::Invalid>) {
    RefuseNonsense(packet.now_ns, message.reason);
  } else {
    // Reject may come at any time, Welcome only as the greeting, and everything else only after it.
    const bool is_expected =
        std::is_same_v<M, protocol::Reject> || (phase == Phase::kGreeting) == std::is_same_v<M, protocol::Welcome>;
    if (is_expected) {
      Handle(packet, message);
    } else {
      RefuseNonsense(packet.now_ns, "an unexpected message");
    }
  }
}

void Connection::Impl::Handle(const Incoming& packet, const protocol::Welcome& welcome) {
  const auto& [now_ns, fds, fd_count] = packet;
  const std::string who = "omnid at " + path + ": ";
  if (fd_count != 2) {
    return Fail(now_ns, who + "its Welcome carries " + std::to_string(fd_count) + " descriptors, must be 2");
  }
  auto mapped = StateReader::Map(std::move(fds[0]), welcome.state_bytes);
  if (!mapped.ok()) return Fail(now_ns, who + "its " + mapped.error());
  if ((*mapped)->service_instance() != welcome.service_instance) {
    return Fail(now_ns, who + "its state memory belongs to another instance of the service; restart omnid");
  }
  const std::string problem = life.Attach(fds[1].get());
  if (!problem.empty()) return Fail(now_ns, who + "its life page " + problem);
  reader = std::move(*mapped);
  phase = Phase::kConnected;
  ++welcomes;
  last_error.clear();
  session.pending = session.wanted;
  surfaces.pending = surfaces.wanted;
  force.pending = force.wanted;
  base_pose_request.pending = base_pose_request.wanted;
}

void Connection::Impl::Handle(const Incoming&, const protocol::BasePoseReply& reply) {
  base_pose_answer = {.number = reply.number, .done = reply.done == 1, .text = protocol::Printable(reply.text)};
}

void Connection::Impl::Handle(const Incoming& packet, const protocol::Reject& reject) {
  const std::int64_t now_ns = packet.now_ns;
  if (reject.server_version != protocol::kProtocolVersion) {
    return Fail(now_ns, "omnid at " + path + " speaks protocol version " + std::to_string(reject.server_version) +
                            ", this client version " + std::to_string(protocol::kProtocolVersion) +
                            "; install the same Omni version for both and restart omnid");
  }
  Fail(now_ns, "omnid at " + path + " refused this client: " + protocol::Printable(reject.reason));
}

void Connection::Impl::Handle(const Incoming&, const protocol::Notice& notice) {
  if (notices.size() >= kMaxNotices) notices.erase(notices.begin());
  notices.push_back(notice);
}

void Connection::Impl::Handle(const Incoming&, const protocol::ForceProperties& properties) {
  force_properties = properties;
  force_properties_said = true;
}

void Connection::Impl::Handle(const Incoming&, const protocol::HapticSceneNews& news) {
  KeepHapticScene({.state = news.state, .text = PrintableLines(news.text), .table = {}});
}

void Connection::Impl::Handle(const Incoming&, const protocol::HapticSceneRows& rows) {
  KeepHapticScene({.is_table = true, .state = {}, .text = {}, .table = TableOf(rows)});
}

void Connection::Impl::Handle(const Incoming& packet, const protocol::Surfaces& announced) {
  const auto& [now_ns, fds, fd_count] = packet;
  const std::size_t expected = announced.total_bytes > 0 ? 1 : 0;
  if (fd_count != expected) {
    return Fail(now_ns, "omnid at " + path + ": its Surfaces carries " + std::to_string(fd_count) +
                            " descriptors, must be " + std::to_string(expected));
  }
  if (!surfaces.wanted || surfaces.pending) return;  // of a cancelled request
  surfaces_answered = true;
  surface_reader.reset();
  if (announced.total_bytes == 0) return;
  auto mapped = SurfaceReader::Map(std::move(fds[0]), announced.total_bytes);
  if (!mapped.ok()) return Fail(now_ns, "omnid at " + path + ": its " + mapped.error());
  if ((*mapped)->memory_generation() != announced.memory_generation) {
    return Fail(now_ns, "omnid at " + path + ": its surface memory is not the one it announced; restart omnid");
  }
  surface_reader = std::move(*mapped);
}

void Connection::Impl::Handle(const Incoming& packet, const protocol::SceneAnswer& answer) {
  const auto& [now_ns, fds, fd_count] = packet;
  const protocol::SceneReply& reply = answer.reply;
  SceneAnswer taken{
      .number = reply.number, .done = reply.done == 1, .text = protocol::Printable(answer.text), .file = {}};
  if (reply.file_bytes > 0) {
    const std::string who = "omnid at " + path + ": the file in its answer ";
    if (fd_count != 1) return Fail(now_ns, who + "is missing; restart omnid");
    const auto bytes = static_cast<std::size_t>(reply.file_bytes);
    taken.file.resize(bytes);  // before the mapping: nothing is lost if there is no memory
    const auto mapped = base::MapSealed(fds[0].get(), base::kSealsOneWriter, bytes, PROT_READ);
    if (!mapped.ok()) return Fail(now_ns, who + mapped.error());
    std::memcpy(taken.file.data(), mapped->get(), bytes);
  }
  scene_answer = std::move(taken);
}

void Connection::Impl::KeepHapticScene(HapticSceneUpdate update) {
  if (haptic_scene.size() >= kMaxHapticSceneUpdates) haptic_scene.erase(haptic_scene.begin());
  haptic_scene.push_back(std::move(update));
}

void Connection::Impl::RefuseNonsense(std::int64_t now_ns, const std::string& what) {
  Fail(now_ns, "omnid at " + path + " sent an invalid message (" + what + "); install the same Omni version for both");
}

void Connection::Impl::Disconnect(std::int64_t now_ns) noexcept {
  phase = Phase::kIdle;
  socket.Reset();
  reader.reset();
  surface_reader.reset();
  surfaces_answered = false;
  force_standing = protocol::ForceStanding::kFree;
  force_properties = {};
  force_properties_said = false;
  haptic_scene.clear();
  life.Detach();
  next_attempt_ns = now_ns + info.retry_interval_ns;
}

void Connection::Impl::Fail(std::int64_t now_ns, const std::string& problem) {
  Disconnect(now_ns);
  last_error = problem;
}

Connection::Connection(ConnectionInfo info) : impl_(std::make_unique<Impl>(std::move(info))) {}
Connection::~Connection() = default;

void Connection::Poll(std::int64_t now_ns) noexcept {
  try {
    impl_->Advance(now_ns);
  } catch (...) {  // out of memory: the application goes on, we try again later
    impl_->Disconnect(now_ns);
  }
}

bool Connection::connected() const noexcept { return impl_->phase == Impl::Phase::kConnected; }

std::shared_ptr<const StateReader> Connection::state() const noexcept { return impl_->reader; }

void Connection::SignalAlive() noexcept { impl_->life.SignalAlive(); }

bool Connection::SendSession(protocol::SessionState state) noexcept {
  if (impl_->info.role != protocol::ClientRole::kApplication) return false;
  return impl_->Want(impl_->session, {.state = state}, state != protocol::SessionState::kNone);
}

bool Connection::SendHaptic(std::int64_t duration_ns, float amplitude, float frequency_Hz) noexcept {
  protocol::Haptic message;
  message.duration_ns = std::max(duration_ns, protocol::kShortestPulse_ns);
  message.amplitude = std::clamp(amplitude, 0.0f, 1.0f);
  message.frequency_Hz = std::clamp(frequency_Hz, 0.0f, protocol::kHighestFrequency_Hz);
  return impl_->Send(message);
}

bool Connection::SendWaveform(const protocol::Waveform& waveform, std::span<const float> samples) noexcept {
  if (samples.empty() || samples.size() > protocol::kMaxWaveformSamples) return false;
  const float least = waveform.kind == protocol::WaveformKind::kPcm ? -1.0f : 0.0f;
  protocol::Waveform head = waveform;
  head.count = static_cast<std::uint32_t>(samples.size());
  head.header.size = static_cast<std::uint32_t>(sizeof(head) + samples.size_bytes());
  std::array<unsigned char, sizeof(head) + sizeof(float) * protocol::kMaxWaveformSamples> packet;
  std::memcpy(packet.data(), &head, sizeof(head));
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const float value = std::clamp(samples[i], least, 1.0f);
    std::memcpy(packet.data() + sizeof(head) + i * sizeof(value), &value, sizeof(value));
  }
  return SendBytes({reinterpret_cast<const char*>(packet.data()), head.header.size}, -1);
}

bool Connection::SendBytes(std::string_view message, int file) noexcept { return impl_->SendBytes(message, file); }

// Messages for which omnid would drop this client are not sent; this also finds NaN.
bool Connection::Impl::SendBytes(std::string_view message, int file) noexcept {
  protocol::MessageHeader header;
  if (phase != Phase::kConnected || message.size() < sizeof(header)) return false;
  std::memcpy(&header, message.data(), sizeof(header));
  if ((protocol::RolesOf(header.type) & protocol::RoleBit(info.role)) == 0) return false;
  const protocol::ClientMessage checked = protocol::ValidateFromClient(message.data(), message.size());
  if (std::holds_alternative<protocol::Invalid>(checked)) return false;
  return protocol::SendPacket(socket.get(), message.data(), message.size(), &file, file >= 0 ? 1 : 0) ==
         SendResult::kSent;
}

bool Connection::ClaimForce(bool wanted) noexcept {
  if (impl_->info.role != protocol::ClientRole::kApplication) return false;
  return impl_->Want(impl_->force, {.wanted = wanted ? 1U : 0U}, wanted);
}

protocol::ForceStanding Connection::force_standing() const noexcept { return impl_->force_standing; }

const protocol::ForceProperties& Connection::force_properties() const noexcept { return impl_->force_properties; }

bool Connection::awaits_force_properties() const noexcept {
  return impl_->phase != Impl::Phase::kIdle && impl_->info.role == protocol::ClientRole::kApplication &&
         !impl_->force_properties_said;
}

bool Connection::RequestSurfaces(bool wanted) noexcept {
  impl_->surfaces_answered = false;
  impl_->surface_reader.reset();
  return impl_->Want(impl_->surfaces, {.wanted = wanted ? 1U : 0U}, wanted);
}

std::shared_ptr<const SurfaceReader> Connection::surfaces() const noexcept { return impl_->surface_reader; }

bool Connection::surfaces_answered() const noexcept { return impl_->surfaces_answered; }
std::uint32_t Connection::SendSceneCommand(protocol::SceneAction action, std::uint64_t client_id,
                                           const std::string& object) {
  protocol::SceneCommand message;
  message.action = action;
  message.number = impl_->scene_commands + 1;
  message.client_id = client_id;
  protocol::SetField(message.object, object);
  return impl_->Send(message) ? ++impl_->scene_commands : 0;
}

std::optional<SceneAnswer> Connection::PopSceneAnswer() { return std::exchange(impl_->scene_answer, std::nullopt); }

std::uint64_t Connection::welcomes() const noexcept { return impl_->welcomes; }

std::vector<HapticSceneUpdate> Connection::PopHapticSceneUpdates() { return std::exchange(impl_->haptic_scene, {}); }
bool Connection::RequestBasePose(const protocol::BasePoseRequest& request) noexcept {
  if (impl_->info.role != protocol::ClientRole::kApplication) return false;
  return impl_->Want(impl_->base_pose_request, request, true);
}

std::optional<protocol::BasePose> Connection::PopBasePose() noexcept {
  return std::exchange(impl_->base_pose, std::nullopt);
}

std::uint32_t Connection::SendBasePoseCommand(protocol::BasePoseCommand command) noexcept {
  command.number = impl_->base_pose_commands + 1;
  return impl_->Send(command) ? ++impl_->base_pose_commands : 0;
}

std::optional<BasePoseAnswer> Connection::PopBasePoseAnswer() {
  return std::exchange(impl_->base_pose_answer, std::nullopt);
}

std::string Connection::PopStatus() { return std::exchange(impl_->status, {}); }

std::vector<protocol::Notice> Connection::PopNotices() { return std::exchange(impl_->notices, {}); }

const protocol::AppSettings& Connection::settings() const noexcept { return impl_->settings; }

const std::string& Connection::last_error() const noexcept { return impl_->last_error; }

}  // namespace omni::client
