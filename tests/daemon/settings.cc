// The settings that a layer receives from its application's file in apps.d and from omnid's own options.
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "service/base/clock.h"
#include "service/client/connection.h"
#include "service/daemon/service.h"
#include "service/ipc/state_publisher.h"
#include "tests/support/process/temp_folder.h"

namespace omni::daemon {
namespace test_daemon_settings {

config::AppTable Wishes() {
  config::AppTable table;
  config::AppEntry painter;
  painter.application_glob = "painter";
  painter.profile = "/interaction_profiles/oculus/touch_controller";
  painter.hand = "right";
  painter.rest_after_s = 3;
  table.entries = {painter};
  return table;
}

class Omnid {
 public:
  explicit Omnid(const std::string& hand)
      : publisher_(ipc::StatePublisher::Create(1)),
        service_({.version = "test", .instance = 1, .apps = Wishes(), .hull_radius_m = 0.0375, .hand = hand}) {
    auto server = ipc::Server::Open(
        {.socket_path = socket_path(), .service_instance = 1, .state_fd = (*publisher_)->fd()}, service_);
    EXPECT_TRUE(server.ok()) << server.error();
    server_ = std::move(*server);
    service_.SetServer(server_.get());
    server_->Start();
  }
  ~Omnid() { server_->Stop(); }

  protocol::AppSettings HeardBy(const std::string& application) {
    client::ConnectionInfo info;
    info.application = application;
    info.socket_path = socket_path();
    client::Connection connection(info);
    const std::int64_t end_ns = base::MonotonicNow_ns() + 10'000'000'000;
    // The settings are the last message: after them, or a few periods, the result is known.
    for (int rounds = 0; rounds < 50 && base::MonotonicNow_ns() < end_ns; rounds += connection.connected()) {
      connection.Poll(base::MonotonicNow_ns());
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    EXPECT_TRUE(connection.connected()) << connection.last_error();
    return connection.settings();
  }

 private:
  std::string socket_path() const { return folder_.Path("socket/omnid.sock"); }

  test::TempFolder folder_;
  base::Result<std::unique_ptr<ipc::StatePublisher>> publisher_;
  Service service_;
  std::unique_ptr<ipc::Server> server_;
};

TEST(DaemonSettings, LayerReceivesSettingsFromApplicationFile) {
  Omnid omnid("left");
  const protocol::AppSettings painter = omnid.HeardBy("painter");
  EXPECT_STREQ(painter.profile, "/interaction_profiles/oculus/touch_controller");
  EXPECT_EQ(painter.hand, protocol::HandSetting::kRight);
  EXPECT_EQ(painter.rest_after_s, 3.0f);
  const protocol::AppSettings other = omnid.HeardBy("other");
  EXPECT_STREQ(other.profile, "");
  EXPECT_EQ(other.hand, protocol::HandSetting::kLeft) << "omnid --hand left";
  EXPECT_EQ(other.rest_after_s, 0.0f);
}

TEST(DaemonSettings, HandIsUnsetWithoutOptions) {
  Omnid omnid("auto");
  EXPECT_EQ(omnid.HeardBy("other").hand, protocol::HandSetting::kUnset);
}

}  // namespace test_daemon_settings
}  // namespace omni::daemon
