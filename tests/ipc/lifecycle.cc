// Scenarios of processes that die, freeze and come back. Clients are forked before any thread of ours exists.
#include <gtest/gtest.h>

#include <atomic>

#include "service/ipc/peer.h"
#include "tests/ipc/fixture.h"

namespace omni {
namespace test_ipc_lifecycle {

using namespace test;
using protocol::SessionState;

TEST(Lifecycle, KilledClientIsRemovedThoughItsChildHoldsTheSocket) {
  const TempFolder temp;
  ForkedClient client(temp.Path("omnid.sock"), "victim", /*keeper=*/true);
  Service service(temp.Path("omnid.sock"));
  ASSERT_GT(client.WaitForKeeper(), 0);
  ASSERT_TRUE(Eventually([&] { return service.handler.Has("victim"); }));
  const ipc::ClientId id = service.handler.IdOf("victim");
  const std::int64_t killed_ns = base::MonotonicNow_ns();
  client.Signal(SIGKILL);
  ASSERT_TRUE(Eventually([&] { return service.handler.GoneAt_ns(id) != 0; }));
  RecordProperty("us_from_kill_to_gone", static_cast<int>((service.handler.GoneAt_ns(id) - killed_ns) / 1000));
}

// [proc_pid_stat(5)] state, flags and pending signals are fields 3, 9 and 31.
TEST(Lifecycle, PendingKillOrBegunExitInProcIsRecognised) {
  const auto line = [](const char* state, const char* flags, const char* pending) {
    return "7 (a ) R name) " + std::string(state) + " 1 7 7 0 -1 " + flags +
           " 1 0 0 0 1 1 0 0 20 0 1 0 99 4096 10 18446744073709551615 1 1 0 0 0 " + pending + " 0 0 0 0 17 1\n";
  };
  EXPECT_FALSE(ipc::IsEnding(line("S", "4194304", "0")));
  EXPECT_FALSE(ipc::IsEnding(line("T", "4194304", "262144"))) << "SIGSTOP";
  EXPECT_TRUE(ipc::IsEnding(line("S", "4194304", "256")));
  EXPECT_TRUE(ipc::IsEnding(line("R", "4194308", "0")));
  EXPECT_FALSE(ipc::IsEnding(line("Z", "4194308", "0"))) << "its other threads may live";
  EXPECT_FALSE(ipc::IsEnding(""));
  EXPECT_FALSE(ipc::IsEnding("7 (x) S 1 2"));
  EXPECT_FALSE(ipc::IsEnding(")))))  (((("));
}

TEST(Lifecycle, StoppedClientStopsBeatingButStaysConnected) {
  const TempFolder temp;
  ForkedClient client(temp.Path("omnid.sock"), "frozen");
  Service service(temp.Path("omnid.sock"));
  ASSERT_TRUE(Eventually([&] { return service.handler.Has("frozen"); }));
  const ipc::ClientId id = service.handler.IdOf("frozen");
  const std::uint64_t start = service.handler.Beats(id);
  ASSERT_TRUE(Eventually([&] { return service.handler.Beats(id) > start; }));

  client.Signal(SIGSTOP);
  // It has stopped once 30 periods (ten times its own pace) bring nothing new.
  std::uint64_t last = 0;
  ASSERT_TRUE(Eventually([&] {
    last = service.handler.Beats(id);
    const int periods = service.handler.Periods();
    return Eventually([&] { return service.handler.Periods() > periods + 30; }) && service.handler.Beats(id) == last;
  }));
  EXPECT_EQ(service.handler.GoneAt_ns(id), 0) << "stopped is not dead";

  client.Signal(SIGCONT);
  EXPECT_TRUE(Eventually([&] { return service.handler.Beats(id) > last; }));
}

TEST(Lifecycle, ClientsReconnectToARestartedServiceWithTheirSessions) {
  const TempFolder temp;
  auto service = std::make_unique<Service>(temp.Path("omnid.sock"), 1);
  client::Connection connection(InfoFor(temp.Path("omnid.sock"), "touch"));
  connection.SendSession(SessionState::kFocused);  // before there is a service
  ASSERT_TRUE(PollUntilConnected(connection));
  ASSERT_TRUE(Eventually([&] { return service->handler.Sessions().size() == 1; }));
  const auto old_state = connection.state();
  protocol::ToolSample sample;
  sample.t_ns = 5;
  service->publisher->Publish(sample, {});

  service.reset();
  ASSERT_TRUE(Eventually([&] {
    connection.Poll(base::MonotonicNow_ns());
    return !connection.connected();
  }));
  EXPECT_EQ(connection.state(), nullptr);
  EXPECT_FALSE(connection.Send(protocol::HapticStop{}));
  connection.SignalAlive();
  protocol::ToolSample seen;
  EXPECT_TRUE(old_state->ReadNewest(seen)) << "a reader that is still held stays readable";
  EXPECT_NE(connection.last_error(), "");

  service = std::make_unique<Service>(temp.Path("omnid.sock"), 2);
  ASSERT_TRUE(PollUntilConnected(connection)) << connection.last_error();
  EXPECT_EQ(connection.state()->service_instance(), 2u);
  ASSERT_TRUE(Eventually([&] { return service->handler.Sessions().size() == 1; }));
  EXPECT_EQ(service->handler.Sessions()[0].second, SessionState::kFocused);
  const ipc::ClientId id = service->handler.IdOf("touch");
  const std::uint64_t before = service->handler.Beats(id);
  connection.SignalAlive();
  EXPECT_TRUE(Eventually([&] { return service->handler.Beats(id) > before; }));
}

TEST(Lifecycle, BeatIsSafeFromOtherThreadsDuringReconnection) {
  const TempFolder temp;
  client::Connection connection(InfoFor(temp.Path("omnid.sock"), "touch"));
  std::atomic<bool> stop{false};
  std::thread beating([&] {
    while (!stop.load(std::memory_order_relaxed)) {
      connection.SignalAlive();
      std::this_thread::yield();
    }
  });
  for (std::uint64_t instance = 1; instance <= 10; ++instance) {
    Service service(temp.Path("omnid.sock"), instance);
    EXPECT_TRUE(PollUntilConnected(connection));
    EXPECT_EQ(connection.state()->service_instance(), instance);
    service.server.reset();
    EXPECT_TRUE(Eventually([&] {
      connection.Poll(base::MonotonicNow_ns());
      return !connection.connected();
    }));
  }
  stop = true;
  beating.join();
}

TEST(Lifecycle, ClosedConnectionRemovesTheClient) {
  const TempFolder temp;
  Service service(temp.Path("omnid.sock"));
  auto connection = std::make_unique<client::Connection>(InfoFor(temp.Path("omnid.sock"), "touch"));
  ASSERT_TRUE(PollUntilConnected(*connection));
  ASSERT_TRUE(Eventually([&] { return service.handler.Has("touch"); }));
  connection.reset();
  EXPECT_TRUE(Eventually([&] { return service.handler.ClientCount() == 0; }));
}

TEST(Lifecycle, ASecondServiceDoesNotDisturbTheFirst) {
  const TempFolder temp;
  Service service(temp.Path("omnid.sock"));
  client::Connection connection(InfoFor(temp.Path("omnid.sock"), "touch"));
  ASSERT_TRUE(PollUntilConnected(connection));
  EXPECT_THROW(Service(temp.Path("omnid.sock")), std::runtime_error);
  connection.Poll(base::MonotonicNow_ns());
  EXPECT_TRUE(connection.connected());
  client::Connection next(InfoFor(temp.Path("omnid.sock"), "next"));
  EXPECT_TRUE(PollUntilConnected(next));
}

}  // namespace test_ipc_lifecycle
}  // namespace omni
