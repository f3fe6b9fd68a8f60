// The client's side against servers that are absent, broken or hostile.
#include "service/client/connection.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/stat.h>

#include <array>
#include <iterator>

#include "service/ipc/surface_publisher.h"
#include "tests/ipc/fixture.h"
#include "tests/support/process/scoped_variable.h"

namespace omni {
namespace test_ipc_connection {

using namespace test;

// Listens like omnid, but sends only what the test sends.
class FakeServer {
 public:
  explicit FakeServer(const std::string& path) : listener_(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0)) {
    const protocol::SocketAddress at = protocol::AddressOf(path);
    EXPECT_EQ(::bind(listener_.get(), reinterpret_cast<const sockaddr*>(&at.address), at.bytes), 0);
    EXPECT_EQ(::listen(listener_.get(), 8), 0);
  }
  bool HasCaller() const {
    pollfd wait{listener_.get(), POLLIN, 0};
    return ::poll(&wait, 1, 0) == 1;
  }
  // Accepts the waiting connection.
  void Accept() {
    peer_.Reset(::accept4(listener_.get(), nullptr, nullptr, SOCK_CLOEXEC));
    EXPECT_TRUE(peer_);
  }
  template <class T>
  void Send(const T& message, const std::vector<int>& fds = {}) {
    EXPECT_EQ(protocol::SendPacket(peer_.get(), &message, sizeof(message), fds.data(), fds.size()),
              protocol::SendResult::kSent);
  }
  void Close() { peer_.Reset(); }

 private:
  base::UniqueFd listener_;
  base::UniqueFd peer_;
};

protocol::Welcome WelcomeOf(std::uint64_t instance) {
  protocol::Welcome welcome;
  welcome.client_id = 1;
  welcome.service_instance = instance;
  welcome.state_bytes = sizeof(protocol::StateMemory);
  welcome.life_bytes = protocol::kLifePageBytes;
  return welcome;
}

base::UniqueFd LifeFile(int seals, off_t bytes = protocol::kLifePageBytes) {
  base::UniqueFd fd(::memfd_create("life", MFD_CLOEXEC | MFD_ALLOW_SEALING));
  EXPECT_EQ(::ftruncate(fd.get(), bytes), 0);
  EXPECT_EQ(::fcntl(fd.get(), F_ADD_SEALS, seals), 0);
  return fd;
}
constexpr int kLifeSeals = F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL;

int OpenDescriptors() {
  const std::filesystem::directory_iterator entries("/proc/self/fd");
  return static_cast<int>(std::distance(begin(entries), end(entries)));
}

// The last error of the connection after the server has answered its Hello with `answer`.
std::string ErrorAfter(const std::function<void(FakeServer&)>& answer) {
  const TempFolder temp;
  FakeServer server(temp.Path("omnid.sock"));
  client::Connection connection(InfoFor(temp.Path("omnid.sock"), "touch"));
  connection.Poll(0);
  server.Accept();
  const int before = OpenDescriptors();
  answer(server);
  connection.Poll(1);
  EXPECT_FALSE(connection.connected());
  EXPECT_EQ(connection.state(), nullptr);
  server.Close();
  EXPECT_EQ(OpenDescriptors(), before - 2) << "a descriptor leaked";  // both ends of the socket are gone
  return connection.last_error();
}

TEST(Connection, ReportsMissingServiceAndKeepsRetrying) {
  const TempFolder temp;
  client::Connection connection(InfoFor(temp.Path("omnid.sock"), "touch"));
  connection.Poll(base::MonotonicNow_ns());
  EXPECT_FALSE(connection.connected());
  EXPECT_NE(connection.last_error().find("no omnid at " + temp.Path("omnid.sock")), std::string::npos);
  EXPECT_FALSE(connection.Send(protocol::HapticStop{}));
  Service service(temp.Path("omnid.sock"));
  EXPECT_TRUE(PollUntilConnected(connection));
}

TEST(Connection, WaitsForTheRetryInterval) {
  const TempFolder temp;
  auto info = InfoFor(temp.Path("omnid.sock"), "touch");
  info.retry_interval_ns = 1000;
  client::Connection connection(info);
  connection.Poll(0);
  FakeServer server(temp.Path("omnid.sock"));
  connection.Poll(999);
  EXPECT_FALSE(server.HasCaller());
  connection.Poll(1000);
  EXPECT_TRUE(server.HasCaller());
}

TEST(Connection, RejectsFoldersOpenToOtherUsers) {
  const TempFolder temp;
  Service service(temp.Path("omnid.sock"));
  ASSERT_EQ(::chmod(temp.Path().c_str(), 0755), 0);
  client::Connection connection(InfoFor(temp.Path("omnid.sock"), "touch"));
  connection.Poll(0);
  EXPECT_NE(connection.last_error().find("chmod 700"), std::string::npos) << connection.last_error();
  const std::string link = temp.Path() + "-link";
  ASSERT_EQ(::symlink(temp.Path().c_str(), link.c_str()), 0);
  client::Connection through_link(InfoFor(link + "/omnid.sock", "touch"));
  through_link.Poll(0);
  EXPECT_NE(through_link.last_error().find("symbolic link"), std::string::npos) << through_link.last_error();
  ::unlink(link.c_str());
}

TEST(Connection, RejectsOverlongPaths) {
  client::Connection connection(InfoFor("/" + std::string(200, 'x'), "touch"));
  connection.Poll(0);
  EXPECT_NE(connection.last_error().find("the limit is 107"), std::string::npos) << connection.last_error();
}

TEST(Connection, ReportsBothVersionsOnMismatch) {
  constexpr std::uint16_t kNewer = protocol::kProtocolVersion + 1;
  const std::string error = ErrorAfter([](FakeServer& server) {
    protocol::Reject reject;
    reject.header.version = kNewer;
    reject.server_version = kNewer;
    server.Send(reject);
  });
  EXPECT_NE(error.find("speaks protocol version " + std::to_string(kNewer) + ", this client version " +
                       std::to_string(protocol::kProtocolVersion)),
            std::string::npos)
      << error;
}

TEST(Connection, ReportsRejectReasonThoughTheSocketIsReset) {
  const std::string error = ErrorAfter([](FakeServer& server) {
    protocol::Reject reject;
    protocol::SetField(reject.reason, "because\x1B");
    server.Send(reject);
    server.Close();  // with the client's Hello unread: the socket is reset
  });
  EXPECT_NE(error.find("refused this client: because?"), std::string::npos) << error;
}

TEST(Connection, RejectsWelcomeWithoutTwoDescriptors) {
  for (const std::size_t count : {0u, 1u, 3u}) {
    const std::string error = ErrorAfter([count](FakeServer& server) {
      const base::UniqueFd life = LifeFile(kLifeSeals);
      server.Send(WelcomeOf(1), std::vector<int>(count, life.get()));
    });
    EXPECT_NE(error.find(std::to_string(count) + " descriptors"), std::string::npos) << error;
  }
}

TEST(Connection, RejectsUnsealedMemory) {
  const std::string state = ErrorAfter([](FakeServer& server) {
    const base::UniqueFd life = LifeFile(kLifeSeals);
    const base::UniqueFd loose = LifeFile(F_SEAL_SEAL, sizeof(protocol::StateMemory));
    server.Send(WelcomeOf(1), {loose.get(), life.get()});
  });
  EXPECT_NE(state.find("state memory lacks the seals F_SEAL_SHRINK"), std::string::npos) << state;
  const auto publisher = std::move(ipc::StatePublisher::Create(1).value());
  const std::string loose = ErrorAfter([&](FakeServer& server) {
    const base::UniqueFd life = LifeFile(F_SEAL_GROW | F_SEAL_SEAL);
    server.Send(WelcomeOf(1), {publisher->fd(), life.get()});
  });
  EXPECT_NE(loose.find("life page lacks the seals F_SEAL_SHRINK"), std::string::npos) << loose;
  const std::string small = ErrorAfter([&](FakeServer& server) {
    const base::UniqueFd life = LifeFile(kLifeSeals, 64);
    server.Send(WelcomeOf(1), {publisher->fd(), life.get()});
  });
  EXPECT_NE(small.find("life page has 64 bytes"), std::string::npos) << small;
}

TEST(Connection, RejectsStateMemoryOfAnotherInstance) {
  const auto publisher = std::move(ipc::StatePublisher::Create(1).value());
  const std::string error = ErrorAfter([&](FakeServer& server) {
    const base::UniqueFd life = LifeFile(kLifeSeals);
    server.Send(WelcomeOf(2), {publisher->fd(), life.get()});
  });
  EXPECT_NE(error.find("another instance"), std::string::npos) << error;
}

TEST(Connection, InvalidMessagesEndOnlyTheConnection) {
  const std::string noise = ErrorAfter([](FakeServer& server) { server.Send(std::array<char, 20>{}); });
  EXPECT_NE(noise.find("magic"), std::string::npos) << noise;
  const std::string early = ErrorAfter([](FakeServer& server) { server.Send(protocol::Notice{}); });
  EXPECT_NE(early.find("an unexpected message"), std::string::npos) << early;
  const std::string closed = ErrorAfter([](FakeServer& server) { server.Close(); });
  EXPECT_NE(closed.find("closed the connection"), std::string::npos) << closed;
}

TEST(Connection, TimesOutIfTheServerNeverAnswers) {
  const TempFolder temp;
  FakeServer server(temp.Path("omnid.sock"));
  client::Connection connection(InfoFor(temp.Path("omnid.sock"), "touch"));
  connection.Poll(0);
  EXPECT_EQ(connection.last_error(), "");
  connection.Poll(2'000'000'001);
  EXPECT_NE(connection.last_error().find("does not answer"), std::string::npos) << connection.last_error();
}

TEST(Connection, BoundsNoticesPerPollAndInMemory) {
  const TempFolder temp;
  FakeServer server(temp.Path("omnid.sock"));
  client::Connection connection(InfoFor(temp.Path("omnid.sock"), "touch"));
  connection.Poll(0);
  server.Accept();
  const auto publisher = std::move(ipc::StatePublisher::Create(1).value());
  const base::UniqueFd life = LifeFile(kLifeSeals);
  server.Send(WelcomeOf(1), {publisher->fd(), life.get()});
  connection.Poll(1);
  ASSERT_TRUE(connection.connected()) << connection.last_error();
  for (int i = 0; i < 60; ++i) server.Send(protocol::Notice{});
  connection.Poll(2);
  EXPECT_EQ(connection.PopNotices().size(), 16u);
  for (int i = 3; i < 10; ++i) connection.Poll(i);
  EXPECT_EQ(connection.PopNotices().size(), 32u);
}

TEST(Connection, MonitorCannotSendSessionOrHaptics) {
  const TempFolder temp;
  Service service(temp.Path("omnid.sock"));
  auto info = InfoFor(temp.Path("omnid.sock"), "watch");
  info.role = protocol::ClientRole::kMonitor;
  client::Connection connection(info);
  ASSERT_TRUE(PollUntilConnected(connection));
  EXPECT_FALSE(connection.SendSession(protocol::SessionState::kFocused));
  EXPECT_FALSE(connection.SendHaptic(1, 1, 1));
  EXPECT_FALSE(connection.Send(protocol::HapticStop{}));
  connection.Poll(base::MonotonicNow_ns());
  EXPECT_TRUE(connection.connected());
}

// When and how long a client waits for the properties of the device.
TEST(Connection, AwaitsForcePropertiesOnlyAfterReachingAService) {
  const TempFolder temp;
  client::Connection connection(InfoFor(temp.Path("omnid.sock"), "touch"));
  EXPECT_FALSE(connection.awaits_force_properties());
  connection.Poll(0);
  EXPECT_FALSE(connection.awaits_force_properties()) << "there is no service";
  FakeServer server(temp.Path("omnid.sock"));
  connection.Poll(5'000'000);
  EXPECT_TRUE(connection.awaits_force_properties()) << "reached, not welcomed";
  server.Accept();
  const auto publisher = std::move(ipc::StatePublisher::Create(1).value());
  const base::UniqueFd life = LifeFile(kLifeSeals);
  server.Send(WelcomeOf(1), {publisher->fd(), life.get()});
  connection.Poll(5'000'001);
  ASSERT_TRUE(connection.connected()) << connection.last_error();
  EXPECT_TRUE(connection.awaits_force_properties()) << "welcomed, no properties yet";
  server.Send(protocol::ForceProperties{});
  connection.Poll(5'000'002);
  EXPECT_FALSE(connection.awaits_force_properties()) << "it has reported that there is no device";
  server.Close();
  connection.Poll(5'000'003);
  EXPECT_FALSE(connection.awaits_force_properties());
}

// Whoever starts a set-uid program chooses its environment, and must not choose its service.
TEST(Connection, PrivilegedProcessIgnoresSocketPathOfEnvironment) {
  const TempFolder temp;
  Service service(temp.Path("omnid.sock"));
  const ScopedVariable socket("OMNI_SOCKET", temp.Path("omnid.sock"));
  auto info = InfoFor({}, "touch");
  info.privileged = true;
  client::Connection privileged(info);
  privileged.Poll(0);
  EXPECT_FALSE(privileged.awaits_force_properties());
  EXPECT_NE(privileged.last_error().find("set-uid"), std::string::npos) << privileged.last_error();
  info.socket_path = temp.Path("omnid.sock");
  client::Connection by_program(info);
  EXPECT_TRUE(PollUntilConnected(by_program)) << "a path of the program's own";
  info.socket_path.clear();
  info.privileged = false;
  client::Connection usual(info);
  EXPECT_TRUE(PollUntilConnected(usual));
  EXPECT_FALSE(service.handler.ClientCount() > 2);
}

// A connection that has requested surfaces, and its reaction to an answer.
struct RequestingSurfaces {
  RequestingSurfaces() : server(temp.Path("omnid.sock")), connection(InfoFor(temp.Path("omnid.sock"), "touch")) {
    connection.RequestSurfaces(true);
    connection.Poll(0);
    server.Accept();
    const auto publisher = std::move(ipc::StatePublisher::Create(1).value());
    const base::UniqueFd life = LifeFile(kLifeSeals);
    server.Send(WelcomeOf(1), {publisher->fd(), life.get()});
    connection.Poll(1);
    EXPECT_TRUE(connection.connected()) << connection.last_error();
  }
  void Answer(std::uint64_t bytes, std::uint64_t generation, const std::vector<int>& fds) {
    protocol::Surfaces surfaces;
    surfaces.total_bytes = bytes;
    surfaces.memory_generation = generation;
    server.Send(surfaces, fds);
    connection.Poll(2);
  }
  const TempFolder temp;
  FakeServer server;
  client::Connection connection;
};

std::unique_ptr<ipc::SurfacePublisher> OneSurface(std::uint64_t generation) {
  const protocol::SurfacePlan plan{.name = "cup", .flags = protocol::kSurfaceMoved};
  return std::move(ipc::SurfacePublisher::Create({.memory_generation = generation}, {&plan, 1}).value());
}

TEST(Connection, ReplacesSurfacesByNewerMemories) {
  RequestingSurfaces asking;
  EXPECT_FALSE(asking.connection.surfaces_answered());
  asking.Answer(0, 0, {});
  EXPECT_TRUE(asking.connection.surfaces_answered());
  EXPECT_EQ(asking.connection.surfaces(), nullptr);
  const auto first = OneSurface(1), second = OneSurface(2);
  asking.Answer(first->bytes(), 1, {first->fd()});
  ASSERT_NE(asking.connection.surfaces(), nullptr) << asking.connection.last_error();
  const auto kept = asking.connection.surfaces();
  asking.Answer(second->bytes(), 2, {second->fd()});
  ASSERT_NE(asking.connection.surfaces(), nullptr);
  EXPECT_EQ(asking.connection.surfaces()->memory_generation(), 2u);
  EXPECT_EQ(kept->memory_generation(), 1u) << "the earlier memory stays";
  asking.connection.RequestSurfaces(false);
  asking.Answer(second->bytes(), 2, {second->fd()});
  EXPECT_EQ(asking.connection.surfaces(), nullptr) << "an answer that comes too late";
  EXPECT_TRUE(asking.connection.connected());
}

TEST(Connection, InvalidSurfacesEndOnlyTheConnection) {
  const auto memory = OneSurface(3);
  const auto error_after = [](std::uint64_t bytes, std::uint64_t generation, const std::vector<int>& fds) {
    RequestingSurfaces asking;
    asking.Answer(bytes, generation, fds);
    EXPECT_FALSE(asking.connection.connected());
    EXPECT_EQ(asking.connection.surfaces(), nullptr);
    return asking.connection.last_error();
  };
  const std::string none = error_after(memory->bytes(), 3, {});
  EXPECT_NE(none.find("carries 0 descriptors, must be 1"), std::string::npos) << none;
  const std::string too_many = error_after(0, 0, {memory->fd()});
  EXPECT_NE(too_many.find("carries 1 descriptors, must be 0"), std::string::npos) << too_many;
  const std::string other = error_after(memory->bytes(), 4, {memory->fd()});
  EXPECT_NE(other.find("not the one it announced"), std::string::npos) << other;
  const std::string small = error_after(memory->bytes() - 64, 3, {memory->fd()});
  EXPECT_NE(small.find("surface memory"), std::string::npos) << small;
  const base::UniqueFd life = LifeFile(kLifeSeals);
  const std::string life_page = error_after(protocol::kLifePageBytes, 3, {life.get()});
  EXPECT_NE(life_page.find("lacks the seals F_SEAL_FUTURE_WRITE"), std::string::npos) << life_page;
}

}  // namespace test_ipc_connection
}  // namespace omni
