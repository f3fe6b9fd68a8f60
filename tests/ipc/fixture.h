// A control server with a handler that records calls, and clients of every kind.
#pragma once

#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "service/base/clock.h"
#include "service/client/connection.h"
#include "service/ipc/server.h"
#include "service/ipc/state_publisher.h"
#include "service/protocol/messages.h"
#include "service/protocol/packet_socket.h"
#include "service/protocol/socket_path.h"
#include "service/protocol/text.h"
#include "tests/support/process/temp_folder.h"

namespace omni::test {

// True as soon as `condition` holds; false after a time that only a broken program needs.
template <class Condition>
bool Eventually(Condition&& condition) {
  const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > limit) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

class RecordingHandler : public ipc::ServerHandler {
  template <class Get>
  auto Locked(Get&& get) {
    const std::lock_guard lock(mutex_);
    return get();
  }

 public:
  void OnClient(const ipc::ClientInfo& client) override {
    const std::lock_guard lock(mutex_);
    clients_[client.id] = client;
    if (client.application == "throws") throw std::runtime_error("planted");
  }
  void OnGone(ipc::ClientId id) override {
    const std::lock_guard lock(mutex_);
    gone_[id] = base::MonotonicNow_ns();
  }
  void OnRequest(ipc::ClientId id, const protocol::Request& request, base::UniqueFd /*file*/) override {
    const std::lock_guard lock(mutex_);
    if (const auto* session = std::get_if<protocol::Session>(&request)) sessions_.emplace_back(id, session->state);
    if (const auto* haptic = std::get_if<protocol::Haptic>(&request)) haptics_.emplace_back(id, *haptic);
    if (std::holds_alternative<protocol::HapticStop>(request)) ++stops_;
    if (const auto* command = std::get_if<protocol::SceneCommand>(&request)) {
      scene_commands_.push_back(*command);
      if (on_scene_command) on_scene_command(id, *command);
    }
  }
  void OnPeriod(std::int64_t) override {
    const std::lock_guard lock(mutex_);
    ++periods_;
    for (const auto& [id, client] : clients_) {
      if (gone_.count(id) > 0) continue;
      if (const auto life = server->LifePageOf(id)) beats_[id] = life->beat.load();
      dropped_[id] = server->DroppedMessages(id);
      protocol::Notice notice;
      notice.level = 1;
      protocol::SetField(notice.text, "scene 'x' did not load");
      for (int i = 0; i < notices_per_period; ++i) server->Send(id, notice);
    }
  }
  std::string StatusJson() override {
    const std::lock_guard lock(mutex_);
    return status;
  }

  std::size_t ClientCount() {
    return Locked([&] { return clients_.size() - gone_.size(); });
  }
  bool Has(const std::string& application) { return IdOf(application) != 0; }
  ipc::ClientId IdOf(const std::string& application) {
    return Locked([&]() -> ipc::ClientId {
      for (const auto& [id, client] : clients_) {
        if (client.application == application && gone_.count(id) == 0) return id;
      }
      return 0;
    });
  }
  ipc::ClientInfo Info(ipc::ClientId id) {
    return Locked([&] { return clients_[id]; });
  }
  std::int64_t GoneAt_ns(ipc::ClientId id) {
    return Locked([&] { return gone_.count(id) > 0 ? gone_[id] : 0; });
  }
  std::uint64_t Beats(ipc::ClientId id) {
    return Locked([&] { return beats_[id]; });
  }
  std::uint64_t Dropped(ipc::ClientId id) {
    return Locked([&] { return dropped_[id]; });
  }
  int Periods() {
    return Locked([&] { return periods_; });
  }
  int Stops() {
    return Locked([&] { return stops_; });
  }
  std::vector<std::pair<ipc::ClientId, protocol::SessionState>> Sessions() {
    return Locked([&] { return sessions_; });
  }
  std::vector<protocol::SceneCommand> SceneCommands() {
    return Locked([&] { return scene_commands_; });
  }
  std::vector<std::pair<ipc::ClientId, protocol::Haptic>> Haptics() {
    return Locked([&] { return haptics_; });
  }

  // Set before Start().
  ipc::Server* server = nullptr;
  std::string status = R"({"status":"fine"})";
  int notices_per_period = 0;
  std::function<void(ipc::ClientId, const protocol::SceneCommand&)> on_scene_command;

 private:
  std::mutex mutex_;
  std::map<ipc::ClientId, ipc::ClientInfo> clients_;
  std::map<ipc::ClientId, std::int64_t> gone_;
  std::map<ipc::ClientId, std::uint64_t> beats_;
  std::map<ipc::ClientId, std::uint64_t> dropped_;
  std::vector<std::pair<ipc::ClientId, protocol::SessionState>> sessions_;
  std::vector<std::pair<ipc::ClientId, protocol::Haptic>> haptics_;
  std::vector<protocol::SceneCommand> scene_commands_;
  int periods_ = 0;
  int stops_ = 0;
};

// Server, state memory and handler. `prepare` may change options and handler before the start.
struct Service {
  explicit Service(const std::string& socket_path, std::uint64_t instance = 77,
                   const std::function<void(ipc::ServerOptions&, RecordingHandler&)>& prepare = {}) {
    publisher = std::move(ipc::StatePublisher::Create(instance).value());
    ipc::ServerOptions options;
    options.socket_path = socket_path;
    options.service_instance = instance;
    options.state_fd = publisher->fd();
    options.period_ns = 5'000'000;
    options.log = [this](const std::string& line) {
      const std::lock_guard lock(log_mutex);
      log.push_back(line);
    };
    if (prepare) prepare(options, handler);
    auto opened = ipc::Server::Open(options, handler);
    if (!opened) throw std::runtime_error(opened.error());
    server = std::move(*opened);
    handler.server = server.get();
    server->Start();
  }
  std::vector<std::string> Log() {
    const std::lock_guard lock(log_mutex);
    return log;
  }

  std::mutex log_mutex;
  std::vector<std::string> log;
  RecordingHandler handler;
  std::unique_ptr<ipc::StatePublisher> publisher;
  std::unique_ptr<ipc::Server> server;
};

inline client::ConnectionInfo InfoFor(const std::string& socket_path, const std::string& application) {
  client::ConnectionInfo info;
  info.socket_path = socket_path;
  info.application = application;
  info.engine = "test";
  info.retry_interval_ns = 5'000'000;
  return info;
}

inline bool PollUntilConnected(client::Connection& connection) {
  return Eventually([&] {
    connection.Poll(base::MonotonicNow_ns());
    return connection.connected();
  });
}

// A client that sends raw bytes: for everything that Connection would never send.
class RawClient {
 public:
  explicit RawClient(const std::string& path)
      : socket_(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)) {
    const protocol::SocketAddress to = protocol::AddressOf(path);
    connected_ = Eventually([&] {
      const bool done = ::connect(socket_.get(), reinterpret_cast<const sockaddr*>(&to.address), to.bytes) == 0;
      return done || errno != EAGAIN;  // the backlog is full for a moment
    });
  }
  bool connected() const { return connected_; }
  int fd() const { return socket_.get(); }

  bool Send(const void* bytes, std::size_t size) {
    return protocol::SendPacket(socket_.get(), bytes, size) == protocol::SendResult::kSent;
  }
  template <class T>
  bool Send(const T& message) {
    return Send(&message, sizeof(message));
  }
  bool Greet(const std::string& application, protocol::ClientRole role = protocol::ClientRole::kApplication) {
    protocol::Hello hello;
    hello.role = role;
    protocol::SetField(hello.application, application);
    return Send(hello) && std::holds_alternative<protocol::Welcome>(Receive());
  }

  // Next message; Invalid with the reason "end" when the server has closed.
  protocol::Message Receive() {
    pollfd wait{socket_.get(), POLLIN, 0};
    while (::poll(&wait, 1, 20'000) < 0 && errno == EINTR) {
    }
    base::UniqueFd fds[protocol::kMaxPassedFds];
    const protocol::Received received =
        protocol::ReceivePacket(socket_.get(), buffer_.data(), buffer_.size(), fds, protocol::kMaxPassedFds);
    if (received.result == protocol::ReceiveResult::kPacket) return protocol::Validate(buffer_.data(), received.size);
    protocol::Invalid end;
    protocol::SetField(end.reason, received.result == protocol::ReceiveResult::kEnd ? "end" : "nothing");
    return end;
  }
  // The text of the Reject that comes next, behind whatever else is queued.
  std::string RejectReason() {
    for (;;) {
      const protocol::Message message = Receive();
      if (const auto* reject = std::get_if<protocol::Reject>(&message)) return reject->reason;
      if (const auto* invalid = std::get_if<protocol::Invalid>(&message)) {
        return std::string("no reject: ") + invalid->reason;
      }
    }
  }
  bool AtEnd() {
    const protocol::Message message = Receive();
    const auto* invalid = std::get_if<protocol::Invalid>(&message);
    return invalid != nullptr && std::string(invalid->reason) == "end";
  }

 private:
  base::UniqueFd socket_;
  bool connected_ = false;
  std::vector<char> buffer_ = std::vector<char>(protocol::kMaxMessageBytes);
};

// A client in a process of its own, made before any thread of ours. It connects, becomes FOCUSED and beats until it is
// killed; with `keeper` it also has a child that does nothing but hold the socket.
class ForkedClient {
 public:
  ForkedClient(const std::string& socket_path, const std::string& application, bool keeper = false) {
    int to_parent[2];
    if (::pipe(to_parent) != 0) throw std::runtime_error("pipe");
    pid_ = ::fork();
    if (pid_ == 0) {
      ::prctl(PR_SET_PDEATHSIG, SIGKILL);
      Live(socket_path, application, keeper, to_parent[1]);
    }
    ::close(to_parent[1]);
    keeper_pipe_.Reset(to_parent[0]);
  }
  ~ForkedClient() {
    Kill();
    if (keeper_pid_ > 0) ::kill(keeper_pid_, SIGKILL);
  }
  ForkedClient(const ForkedClient&) = delete;
  ForkedClient& operator=(const ForkedClient&) = delete;

  pid_t pid() const { return pid_; }
  void Signal(int signal) const { ::kill(pid_, signal); }
  void Kill() {
    if (pid_ <= 0) return;
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
    pid_ = 0;
  }
  // Waits until the child that keeps the socket exists; its pid.
  pid_t WaitForKeeper() {
    if (::read(keeper_pipe_.get(), &keeper_pid_, sizeof(keeper_pid_)) != sizeof(keeper_pid_)) keeper_pid_ = 0;
    return keeper_pid_;
  }

 private:
  [[noreturn]] static void Live(const std::string& path, const std::string& application, bool keeper, int to_parent) {
    client::Connection connection(InfoFor(path, application));
    connection.SendSession(protocol::SessionState::kFocused);
    bool reported = !keeper;
    for (;;) {
      connection.Poll(base::MonotonicNow_ns());
      connection.SignalAlive();
      if (connection.connected() && !reported) {
        reported = true;
        const pid_t child = ::fork();
        if (child == 0) {
          ::sleep(60);  // ends by itself should the test die
          ::_exit(0);
        }
        if (::write(to_parent, &child, sizeof(child)) < 0) ::_exit(1);
      }
      ::usleep(1000);
    }
  }

  pid_t pid_ = 0;
  pid_t keeper_pid_ = 0;
  base::UniqueFd keeper_pipe_;
};

}  // namespace omni::test
