// The control server and the client's connection, one behaviour at a time.
#include "service/ipc/server.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <limits>

#include "tests/ipc/fixture.h"

namespace omni {
namespace test_ipc_server_unit {

using namespace test;
using protocol::SessionState;

TEST(Server, WelcomesAClientWithTheStateMemory) {
  const TempFolder temp;
  Service service(temp.Path("omnid.sock"));
  client::Connection connection(InfoFor(temp.Path("omnid.sock"), "touch"));
  EXPECT_FALSE(connection.connected());
  EXPECT_EQ(connection.state(), nullptr);
  ASSERT_TRUE(PollUntilConnected(connection)) << connection.last_error();
  EXPECT_EQ(connection.last_error(), "");
  ASSERT_NE(connection.state(), nullptr);
  EXPECT_EQ(connection.state()->service_instance(), 77u);
  ASSERT_TRUE(Eventually([&] { return service.handler.Has("touch"); }));
  const ipc::ClientInfo info = service.handler.Info(service.handler.IdOf("touch"));
  EXPECT_EQ(info.pid, ::getpid());
  EXPECT_EQ(info.engine, "test");
  EXPECT_EQ(info.role, protocol::ClientRole::kApplication);
  protocol::ToolSample sample;
  sample.t_ns = 5;
  service.publisher->Publish(sample, {});
  protocol::ToolSample seen;
  ASSERT_TRUE(connection.state()->ReadNewest(seen));
  EXPECT_EQ(seen.t_ns, 5);
}

TEST(Server, DeliversSessionAndHapticsToTheHandler) {
  const TempFolder temp;
  Service service(temp.Path("omnid.sock"));
  client::Connection connection(InfoFor(temp.Path("omnid.sock"), "touch"));
  EXPECT_FALSE(connection.SendHaptic(1, 1, 1));
  ASSERT_TRUE(PollUntilConnected(connection));
  EXPECT_TRUE(connection.SendSession(SessionState::kFocused));
  EXPECT_TRUE(connection.SendHaptic(-500, 7.0f, -3.0f));  // values out of range are clamped
  EXPECT_FALSE(connection.SendHaptic(1, std::numeric_limits<float>::quiet_NaN(), 0));
  EXPECT_TRUE(connection.Send(protocol::HapticStop{}));
  ASSERT_TRUE(Eventually([&] { return service.handler.Stops() == 1; }));
  ASSERT_EQ(service.handler.Sessions().size(), 1u);
  EXPECT_EQ(service.handler.Sessions()[0].second, SessionState::kFocused);
  ASSERT_EQ(service.handler.Haptics().size(), 1u);
  const protocol::Haptic haptic = service.handler.Haptics()[0].second;
  EXPECT_EQ(haptic.duration_ns, -1);
  EXPECT_EQ(haptic.amplitude, 1);
  EXPECT_EQ(haptic.frequency_Hz, 0);
}

TEST(Server, AnswersStatus) {
  const TempFolder temp;
  Service service(temp.Path("omnid.sock"));
  auto info = InfoFor(temp.Path("omnid.sock"), "status");
  info.role = protocol::ClientRole::kMonitor;
  client::Connection connection(info);
  EXPECT_FALSE(connection.Send(protocol::StatusRequest{}));
  ASSERT_TRUE(PollUntilConnected(connection));
  ASSERT_TRUE(connection.Send(protocol::StatusRequest{}));
  std::string status;
  ASSERT_TRUE(Eventually([&] {
    connection.Poll(base::MonotonicNow_ns());
    status = connection.PopStatus();
    return !status.empty();
  }));
  EXPECT_EQ(status, R"({"status":"fine"})");
  EXPECT_EQ(connection.PopStatus(), "");
}

TEST(Server, OversizedStatusIsReplacedByAnError) {
  const TempFolder temp;
  Service service(temp.Path("omnid.sock"), 77, [](ipc::ServerOptions&, RecordingHandler& handler) {
    handler.status = std::string(protocol::kMaxMessageBytes, 'x');
  });
  RawClient raw(temp.Path("omnid.sock"));
  ASSERT_TRUE(raw.Greet("raw"));
  raw.Send(protocol::StatusRequest{});
  const protocol::Message reply = raw.Receive();
  ASSERT_TRUE(std::holds_alternative<protocol::StatusReply>(reply));
}

TEST(Server, NoticesReachTheClient) {
  const TempFolder temp;
  Service service(temp.Path("omnid.sock"), 77,
                  [](ipc::ServerOptions&, RecordingHandler& handler) { handler.notices_per_period = 1; });
  client::Connection connection(InfoFor(temp.Path("omnid.sock"), "touch"));
  std::vector<protocol::Notice> notices;
  ASSERT_TRUE(Eventually([&] {
    connection.Poll(base::MonotonicNow_ns());
    notices = connection.PopNotices();
    return !notices.empty();
  }));
  EXPECT_EQ(notices[0].level, 1u);
  EXPECT_STREQ(notices[0].text, "scene 'x' did not load");
}

TEST(Server, RejectsOtherVersionsNamingBoth) {
  const TempFolder temp;
  Service service(temp.Path("omnid.sock"));
  RawClient raw(temp.Path("omnid.sock"));
  protocol::Hello hello;
  hello.header.version = protocol::kProtocolVersion + 5;
  raw.Send(hello);
  const protocol::Message message = raw.Receive();
  const auto* reject = std::get_if<protocol::Reject>(&message);
  ASSERT_NE(reject, nullptr);
  EXPECT_EQ(reject->server_version, protocol::kProtocolVersion);
  EXPECT_NE(std::string(reject->reason)
                .find("version " + std::to_string(hello.header.version) + ", must be " +
                      std::to_string(protocol::kProtocolVersion)),
            std::string::npos)
      << reject->reason;
  EXPECT_TRUE(raw.AtEnd());
  EXPECT_EQ(service.handler.ClientCount(), 0u);
}

// The reason names the role that may send the message.
TEST(Server, RejectsMessagesThatTheRoleMayNotSend) {
  const TempFolder temp;
  Service service(temp.Path("omnid.sock"));
  const auto reason_of = [&](protocol::ClientRole role, const auto& message) {
    RawClient raw(temp.Path("omnid.sock"));
    raw.Greet("x", role) && raw.Send(message);
    return raw.RejectReason();
  };
  protocol::SpaceChange change;
  EXPECT_EQ(reason_of(protocol::ClientRole::kMonitor, protocol::Session{}),
            "Session: only an application may send it, not a monitor; connect as an application");
  EXPECT_EQ(reason_of(protocol::ClientRole::kTool, protocol::ForceStop{}),
            "ForceStop: only an application may send it, not a tool; connect as an application");
  EXPECT_EQ(reason_of(protocol::ClientRole::kMonitor, change),
            "SpaceChange: only an application may send it, not a monitor; connect as an application");
  protocol::BasePoseCommand command;
  EXPECT_EQ(reason_of(protocol::ClientRole::kApplication, command),
            "BasePoseCommand: only a tool may send it, not an application; connect as a tool");
  protocol::HapticSceneEnd end;
  end.number = 1;
  EXPECT_EQ(reason_of(protocol::ClientRole::kMonitor, end),
            "HapticSceneEnd: only an application may send it, not a monitor; connect as an application");
}

// A descriptor that no row of the table has, and one that is missing.
TEST(Server, RejectsUnexpectedOrMissingDescriptors) {
  const TempFolder temp;
  Service service(temp.Path("omnid.sock"));
  RawClient with(temp.Path("omnid.sock")), without(temp.Path("omnid.sock"));
  ASSERT_TRUE(with.Greet("with") && without.Greet("without"));
  const protocol::Session session;
  const int fd = with.fd();
  ASSERT_EQ(protocol::SendPacket(with.fd(), &session, sizeof(session), &fd, 1), protocol::SendResult::kSent);
  EXPECT_EQ(with.RejectReason(), "Session: comes with descriptors, must have none");
  protocol::HapticSceneLoad load;
  load.number = 1;
  load.bytes = 10;
  ASSERT_TRUE(without.Send(load));
  EXPECT_EQ(without.RejectReason(), "HapticSceneLoad: comes without its descriptor");
}

TEST(Server, InvalidMessagesEndOnlyTheirSendersConnection) {
  const TempFolder temp;
  Service service(temp.Path("omnid.sock"));
  client::Connection good(InfoFor(temp.Path("omnid.sock"), "good"));
  ASSERT_TRUE(PollUntilConnected(good));
  const auto reason_after = [&](auto&& speak) {
    RawClient raw(temp.Path("omnid.sock"));
    speak(raw);
    return raw.RejectReason();
  };
  protocol::Session bad_session;
  bad_session.state = static_cast<SessionState>(7);
  const std::string before = reason_after([](RawClient& raw) { raw.Send(protocol::Session{}); });
  EXPECT_NE(before.find("must be Hello"), std::string::npos) << before;
  const std::string noise = reason_after([](RawClient& raw) { raw.Send("twelve bytes", 12); });
  EXPECT_NE(noise.find("shorter"), std::string::npos) << noise;
  const std::string twice = reason_after([](RawClient& raw) { raw.Greet("x") && raw.Send(protocol::Hello{}); });
  EXPECT_NE(twice.find("second Hello"), std::string::npos) << twice;
  const std::string range = reason_after([&](RawClient& raw) { raw.Greet("x") && raw.Send(bad_session); });
  EXPECT_NE(range.find("state"), std::string::npos) << range;
  const std::string server_side = reason_after([](RawClient& raw) { raw.Greet("x") && raw.Send(protocol::Notice{}); });
  EXPECT_NE(server_side.find("only omnid sends"), std::string::npos) << server_side;
  const std::string huge = reason_after([](RawClient& raw) {
    const std::vector<char> bytes(protocol::kMaxMessageBytes + 8);
    raw.Greet("x") && raw.Send(bytes.data(), bytes.size());
  });
  EXPECT_NE(huge.find("65536"), std::string::npos) << huge;
  const std::string monitor = reason_after(
      [](RawClient& raw) { raw.Greet("x", protocol::ClientRole::kMonitor) && raw.Send(protocol::Session{}); });
  EXPECT_NE(monitor.find("monitor"), std::string::npos) << monitor;
  for (const auto role : {protocol::ClientRole::kMonitor, protocol::ClientRole::kApplication}) {
    const std::string forgets =
        reason_after([role](RawClient& raw) { raw.Greet("x", role) && raw.Send(protocol::BasePoseCommand{}); });
    EXPECT_NE(forgets.find("only a tool"), std::string::npos) << forgets;
  }
  const std::string with_fd = reason_after([](RawClient& raw) {
    const int fd = 0;
    const protocol::HapticStop stop;
    raw.Greet("x") && protocol::SendPacket(raw.fd(), &stop, sizeof(stop), &fd, 1) == protocol::SendResult::kSent;
  });
  EXPECT_NE(with_fd.find("descriptors"), std::string::npos) << with_fd;

  ASSERT_TRUE(Eventually([&] { return service.handler.ClientCount() == 1; }));
  good.Poll(base::MonotonicNow_ns());
  EXPECT_TRUE(good.connected());
  EXPECT_TRUE(good.Send(protocol::HapticStop{}));
  EXPECT_TRUE(Eventually([&] { return service.handler.Stops() == 1; }));
}

TEST(Server, RejectsThe33rdClientWithAReason) {
  const TempFolder temp;
  Service service(temp.Path("omnid.sock"));
  std::vector<std::unique_ptr<RawClient>> clients;
  for (int i = 0; i < 32; ++i) {
    clients.push_back(std::make_unique<RawClient>(temp.Path("omnid.sock")));
    ASSERT_TRUE(clients.back()->Greet("client " + std::to_string(i)));
  }
  client::Connection late(InfoFor(temp.Path("omnid.sock"), "late"));
  ASSERT_TRUE(Eventually([&] {
    late.Poll(base::MonotonicNow_ns());
    return late.last_error().find("already serves 32 clients") != std::string::npos;
  })) << late.last_error();
  clients.pop_back();
  EXPECT_TRUE(PollUntilConnected(late)) << "a place is free again";
}

TEST(Server, ClosesConnectionsWithoutHello) {
  const TempFolder temp;
  Service service(temp.Path("omnid.sock"), 77,
                  [](ipc::ServerOptions& options, RecordingHandler&) { options.hello_timeout_ns = 20'000'000; });
  RawClient raw(temp.Path("omnid.sock"));
  EXPECT_EQ(raw.RejectReason(), "no Hello in time");
  EXPECT_TRUE(raw.AtEnd());
}

TEST(Server, LimitsConnectionsWithoutHello) {
  const TempFolder temp;
  Service service(temp.Path("omnid.sock"));
  std::vector<std::unique_ptr<RawClient>> silent;
  silent.reserve(32);
  for (int i = 0; i < 32; ++i) silent.push_back(std::make_unique<RawClient>(temp.Path("omnid.sock")));
  RawClient next(temp.Path("omnid.sock"));
  EXPECT_NE(next.RejectReason().find("have not sent Hello"), std::string::npos);
}

TEST(Server, ClientThatDoesNotReadOnlyLosesMessages) {
  const TempFolder temp;
  Service service(temp.Path("omnid.sock"), 77,
                  [](ipc::ServerOptions&, RecordingHandler& handler) { handler.notices_per_period = 100; });
  RawClient lazy(temp.Path("omnid.sock"));
  ASSERT_TRUE(lazy.Greet("lazy"));
  ASSERT_TRUE(Eventually([&] { return service.handler.Has("lazy"); }));
  const ipc::ClientId id = service.handler.IdOf("lazy");
  ASSERT_TRUE(Eventually([&] { return service.handler.Dropped(id) > 0; }));
  const int periods = service.handler.Periods();
  EXPECT_TRUE(Eventually([&] { return service.handler.Periods() > periods + 3; })) << "the server is stuck";
  EXPECT_EQ(service.handler.GoneAt_ns(id), 0);
}

TEST(Server, ThrowingHandlerEndsOnlyThatConnection) {
  const TempFolder temp;
  Service service(temp.Path("omnid.sock"));
  RawClient raw(temp.Path("omnid.sock"));
  raw.Greet("throws");
  EXPECT_NE(raw.RejectReason().find("internal error"), std::string::npos);
  RawClient other(temp.Path("omnid.sock"));
  EXPECT_TRUE(other.Greet("other"));
  ASSERT_FALSE(service.Log().empty());
  EXPECT_NE(service.Log()[0].find("planted"), std::string::npos);
}

TEST(Server, MakesClientNamesPrintable) {
  const TempFolder temp;
  Service service(temp.Path("omnid.sock"));
  RawClient raw(temp.Path("omnid.sock"));
  ASSERT_TRUE(raw.Greet("evil\x1B[2J\xFF"));
  EXPECT_TRUE(Eventually([&] { return service.handler.Has("evil?[2J?"); }));
}

TEST(Server, BeatReachesTheLifePage) {
  const TempFolder temp;
  Service service(temp.Path("omnid.sock"));
  client::Connection connection(InfoFor(temp.Path("omnid.sock"), "touch"));
  connection.SignalAlive();  // not connected: harmless
  ASSERT_TRUE(PollUntilConnected(connection));
  ASSERT_TRUE(Eventually([&] { return service.handler.Has("touch"); }));
  const ipc::ClientId id = service.handler.IdOf("touch");
  const std::uint64_t before = service.handler.Beats(id);
  connection.SignalAlive();
  EXPECT_TRUE(Eventually([&] { return service.handler.Beats(id) > before; }));
}

TEST(Server, RejectsInvalidOptions) {
  const TempFolder temp;
  RecordingHandler handler;
  const auto publisher = std::move(ipc::StatePublisher::Create(1).value());
  ipc::ServerOptions options;
  options.socket_path = temp.Path("omnid.sock");
  const auto error_of = [&] {
    const auto opened = ipc::Server::Open(options, handler);
    return opened ? std::string("opened") : opened.error();
  };
  EXPECT_NE(error_of().find("state_fd"), std::string::npos);
  options.state_fd = publisher->fd();
  options.period_ns = 0;
  EXPECT_NE(error_of().find("period_ns"), std::string::npos);
  options.period_ns = 10'000'000;
  options.max_clients = 0;
  EXPECT_NE(error_of().find("max_clients"), std::string::npos);
  options.max_clients = 1;
  EXPECT_EQ(error_of(), "opened");
}

// Needs root, to become another user and to open the folder to that user.
TEST(Server, RejectsOtherUsers) {
  if (::geteuid() != 0) GTEST_SKIP() << "needs root to become another user";
  const TempFolder temp;
  int pipe_fds[2];
  ASSERT_EQ(::pipe(pipe_fds), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    char byte = 0;
    if (::setuid(65534) != 0 || ::read(pipe_fds[0], &byte, 1) != 1) ::_exit(10);
    RawClient raw(temp.Path("omnid.sock"));
    raw.Send(protocol::Hello{});
    const std::string reason = raw.RejectReason();
    ::_exit(reason.find("does not serve user 65534") != std::string::npos ? 0 : 11);
  }
  Service service(temp.Path("omnid.sock"));
  ASSERT_EQ(::chmod(temp.Path().c_str(), 0711), 0);
  ASSERT_EQ(::chmod(temp.Path("omnid.sock").c_str(), 0666), 0);
  ASSERT_EQ(::write(pipe_fds[1], "x", 1), 1);
  int status = -1;
  ::waitpid(child, &status, 0);
  ::close(pipe_fds[0]);
  ::close(pipe_fds[1]);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
  EXPECT_EQ(service.handler.ClientCount(), 0u);
}

}  // namespace test_ipc_server_unit
}  // namespace omni
