// The emergency stop, from the message to the currents of the tick.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <functional>
#include <thread>

#include <nlohmann/json.hpp>

#include "service/base/clock.h"
#include "service/client/connection.h"
#include "service/config/files/device_file.h"
#include "service/daemon/devices/attached_device.h"
#include "service/daemon/service.h"
#include "service/ipc/server.h"
#include "service/ipc/state_publisher.h"
#include "service/loop/tick_config.h"
#include "tests/support/held_pen.h"
#include "tests/support/process/temp_folder.h"

namespace omni::daemon {
namespace test_daemon_emergency_stop {

using namespace std::chrono_literals;

struct CurrentSink : loop::TickSink {
  void Publish(const loop::TickOutput& output, const base::HallScan& /*scan*/,
               const loop::TickTimes& /*times*/) noexcept override {
    flows.store(output.currents.current_A != base::CoilCurrents{}.current_A);
  }
  std::atomic<bool> flows{false};
};

// omnid with a pen that presses on the block, and its clients.
class EmergencyStopTest : public testing::Test {
 protected:
  EmergencyStopTest()
      : source_(pen_),
        publisher_(std::move(ipc::StatePublisher::Create(1).value())),
        service_({.version = "test", .instance = 1, .apps = Apps(), .inputs = {}, .hull_radius_m = 0.0375}) {
    loop_ = std::make_unique<loop::TickThread>(loop::MakeTickConfig(config::DefaultDevice()),
                                               loop::TickThread::Options{.realtime = false}, source_, sink_);
    loop_->Start();
    service_.device().Attach(*loop_, pen_);
    auto server = ipc::Server::Open(
        {.socket_path = folder_.Path("socket/omnid.sock"), .service_instance = 1, .state_fd = publisher_->fd()},
        service_);
    EXPECT_TRUE(server.ok()) << server.error();
    server_ = std::move(*server);
    service_.SetServer(server_.get());
    server_->Start();
    Join(application_);
    Join(monitor_);
    EXPECT_TRUE(application_->SendSession(protocol::SessionState::kBegun));
    EXPECT_TRUE(application_->SendSession(protocol::SessionState::kFocused));
  }
  ~EmergencyStopTest() override {
    server_->Stop();
    service_.device().Detach("the test is over");
  }

  static config::AppTable Apps() {
    config::AppTable table;
    table.entries.push_back(
        {.application_glob = "clay", .scene = std::string(OMNI_SOURCE_DIR) + "/scenes/extrusion.glb"});
    return table;
  }
  std::unique_ptr<client::Connection> NewClient(protocol::ClientRole role, const std::string& name) {
    return std::make_unique<client::Connection>(client::ConnectionInfo{
        .role = role, .application = name, .engine = "", .socket_path = folder_.Path("socket/omnid.sock")});
  }
  void Join(std::unique_ptr<client::Connection>& client) {
    ASSERT_TRUE(Until([&] { return client->connected(); })) << client->last_error();
  }
  static void Send(client::Connection& client, bool on) {
    protocol::EmergencyStop stop;
    stop.on = on ? 1 : 0;
    EXPECT_TRUE(client.Send(stop));
  }
  // The clients live until then; for at most 10 s.
  bool Until(const std::function<bool()>& holds) {
    for (int i = 0; i < 2000; ++i) {
      for (const auto* client : {&application_, &monitor_}) {
        if (*client == nullptr) continue;
        (*client)->Poll(base::MonotonicNow_ns());
        (*client)->SignalAlive();
      }
      if (holds()) return true;
      std::this_thread::sleep_for(5ms);
    }
    return false;
  }
  bool ZeroForAWhile() {
    int left = 60;
    bool zero = true;
    Until([&] {
      zero = zero && !sink_.flows;
      return --left == 0;
    });
    return zero;
  }
  nlohmann::json Status() {
    std::string text;
    EXPECT_TRUE(monitor_->Send(protocol::StatusRequest{}));
    Until([&] {
      text = monitor_->PopStatus();
      return !text.empty();
    });
    return nlohmann::json::parse(text, nullptr, false);
  }

  support::HeldPen pen_;
  TransportTickSource source_;
  CurrentSink sink_;
  test::TempFolder folder_;
  std::unique_ptr<ipc::StatePublisher> publisher_;
  Service service_;
  std::unique_ptr<loop::TickThread> loop_;
  std::unique_ptr<ipc::Server> server_;
  std::unique_ptr<client::Connection> application_ = NewClient(protocol::ClientRole::kApplication, "clay");
  std::unique_ptr<client::Connection> monitor_ = NewClient(protocol::ClientRole::kMonitor, "a page");
};

TEST_F(EmergencyStopTest, CurrentsAreZeroUntilItIsReleased) {
  ASSERT_TRUE(Until([&] { return sink_.flows.load(); })) << "the pen presses";
  EXPECT_TRUE(Status()["stopped"].is_null());
  Send(*monitor_, true);
  ASSERT_TRUE(Until([&] { return !sink_.flows; }));
  EXPECT_TRUE(ZeroForAWhile());
  const nlohmann::json status = Status();
  EXPECT_EQ(status["stopped"], "a page");
  EXPECT_NE(status["problems"].dump().find("emergency stop, by a page"), std::string::npos);
  Send(*monitor_, false);
  EXPECT_TRUE(Until([&] { return sink_.flows.load(); }));
  EXPECT_TRUE(Status()["stopped"].is_null());
}

// Whoever has pressed it may go; another application does not end it.
TEST_F(EmergencyStopTest, HoldsForEveryApplication) {
  ASSERT_TRUE(Until([&] { return sink_.flows.load(); })) << "the pen presses";
  Send(*monitor_, true);
  ASSERT_TRUE(Until([&] { return !sink_.flows; }));
  application_ = NewClient(protocol::ClientRole::kApplication, "clay");
  monitor_ = NewClient(protocol::ClientRole::kMonitor, "another page");
  Join(application_);
  Join(monitor_);
  EXPECT_TRUE(application_->SendSession(protocol::SessionState::kFocused));
  ASSERT_TRUE(Until([&] { return Status()["scene"]["triangles"] == 1608; }));
  EXPECT_TRUE(ZeroForAWhile());
}

TEST_F(EmergencyStopTest, SecondPressByAnotherClientChangesNothing) {
  Send(*monitor_, true);
  ASSERT_TRUE(Until([&] { return Status()["stopped"] == "a page"; }));
  const nlohmann::json first = Status()["stop"];
  monitor_ = NewClient(protocol::ClientRole::kMonitor, "another page");
  Join(monitor_);
  Send(*monitor_, true);
  EXPECT_EQ(Status()["stop"], first);
}

class EmergencyStopLatch : public testing::Test {
 protected:
  using Latch = EmergencyStop::Latch;

  // A second passes with each poll.
  bool PollsUntil(EmergencyStop& stop, const std::function<bool()>& holds) {
    for (int i = 0; i < 2000; ++i) {
      news_ += stop.Poll(now_ns_ += 1'000'000'000);
      if (holds()) return true;
      std::this_thread::sleep_for(5ms);
    }
    return false;
  }
  bool Settles(EmergencyStop& stop, Latch latch) {
    return PollsUntil(stop, [&] { return stop.state().latch == latch; });
  }

  test::TempFolder folder_;
  const std::string path_ = folder_.Path("state/emergency_stop.toml");
  std::int64_t now_ns_ = base::MonotonicNow_ns();
  std::string news_;
};

TEST_F(EmergencyStopLatch, NextServiceKnowsWhoPressedItAndWhen) {
  std::string at;
  {
    EmergencyStop stop(path_);
    EXPECT_FALSE(stop.on());
    stop.Press("a page");
    EXPECT_TRUE(stop.on());
    EXPECT_EQ(stop.state().latch, Latch::kPending);
    ASSERT_TRUE(Settles(stop, Latch::kKept));
    at = stop.state().at;
  }
  EmergencyStop stop(path_);
  EXPECT_TRUE(stop.on());
  EXPECT_EQ(stop.state().by, "a page");
  EXPECT_EQ(stop.state().at, at);
  stop.Release();
  EXPECT_FALSE(stop.on());
  ASSERT_TRUE(Settles(stop, Latch::kNone));
  EXPECT_FALSE(EmergencyStop(path_).on());
  EXPECT_EQ(stop.Problem(), "");
}

// By hand, or by another omnid of this person.
TEST_F(EmergencyStopLatch, RemovedLatchIsWrittenAgain) {
  EmergencyStop stop(path_);
  stop.Press("a page");
  ASSERT_TRUE(Settles(stop, Latch::kKept));
  ASSERT_TRUE(std::filesystem::remove(path_));
  EXPECT_TRUE(PollsUntil(stop, [&] { return std::filesystem::exists(path_); }));
  EXPECT_EQ(news_, "");
}

TEST_F(EmergencyStopLatch, FailedLatchIsTriedAgainAndBothAreReported) {
  const std::string blocking = folder_.Write("state", "a file where the folder belongs");
  EmergencyStop stop(path_);
  stop.Press("a page");
  ASSERT_TRUE(Settles(stop, Latch::kFailed));
  EXPECT_TRUE(stop.on());
  EXPECT_EQ(news_, stop.state().problem);
  EXPECT_NE(stop.Problem().find("forgotten when omnid ends: " + path_), std::string::npos) << stop.Problem();
  std::filesystem::remove(blocking);
  ASSERT_TRUE(Settles(stop, Latch::kKept));
  EXPECT_NE(news_.find("kept in " + path_), std::string::npos) << news_;
  EXPECT_EQ(stop.Problem().find("forgotten"), std::string::npos);
}

TEST_F(EmergencyStopLatch, LatchThatCannotBeRemovedIsReportedAndForcesReturn) {
  std::filesystem::create_directories(path_);
  EmergencyStop stop(path_);
  ASSERT_TRUE(stop.on());
  stop.Release();
  EXPECT_FALSE(stop.on());
  ASSERT_TRUE(Settles(stop, Latch::kFailed));
  EXPECT_NE(stop.Problem().find("the next omnid starts stopped: " + path_), std::string::npos) << stop.Problem();
}

TEST_F(EmergencyStopLatch, QuickPressAfterReleaseKeepsTheStop) {
  EmergencyStop stop(path_);
  for (int i = 0; i < 50; ++i) {
    stop.Press("a page");
    stop.Release();
  }
  stop.Press("a page");
  ASSERT_TRUE(Settles(stop, Latch::kKept));
  EXPECT_TRUE(EmergencyStop(path_).on());
}

TEST(EmergencyStopMessage, ApplicationsMayNotSendIt) {
  EXPECT_EQ(protocol::Traits<protocol::EmergencyStop>::kRoles, protocol::kMonitors | protocol::kTools);
}

}  // namespace test_daemon_emergency_stop
}  // namespace omni::daemon
