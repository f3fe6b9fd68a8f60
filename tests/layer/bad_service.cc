// Faulty services: of another version, silent, replaced under a running application.
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cstdio>
#include <fstream>
#include <thread>

#include "service/protocol/control.h"
#include "service/protocol/socket_path.h"
#include "service/protocol/text.h"
#include "tests/layer/force/fixture.h"

namespace omni::test {
namespace test_bad_service {

// Listens where omnid does; the test chooses what it sends to clients.
class OddService {
 public:
  enum class Manner { kOtherVersion, kSilent };
  explicit OddService(Manner manner) : manner_(manner), path_(protocol::DefaultSocketPath()) {
    listener_ = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);
    const protocol::SocketAddress address = protocol::AddressOf(path_);
    unlink(path_.c_str());
    if (bind(listener_, static_cast<const sockaddr*>(static_cast<const void*>(&address.address)), address.bytes) != 0 ||
        listen(listener_, 8) != 0)
      std::perror("OddService");
    thread_ = std::thread([this] { Serve(); });
  }
  ~OddService() {
    stop_ = true;
    shutdown(listener_, SHUT_RDWR);
    thread_.join();
    for (const int client : clients_) close(client);
    close(listener_);
    unlink(path_.c_str());
  }
  OddService(const OddService&) = delete;
  OddService& operator=(const OddService&) = delete;
  int connections() const { return connections_; }

 private:
  void Serve() {
    while (!stop_) {
      const int client = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC);
      if (client < 0) continue;
      clients_.push_back(client);
      ++connections_;
      if (manner_ == Manner::kSilent) continue;
      protocol::Reject reject;
      reject.header.version = protocol::kProtocolVersion + 1;
      reject.server_version = protocol::kProtocolVersion + 1;
      protocol::SetField(reject.reason, std::string("another version"));
      send(client, &reject, sizeof(reject), MSG_NOSIGNAL);
    }
  }

  const Manner manner_;
  const std::string path_;
  int listener_ = -1;
  std::vector<int> clients_;
  std::atomic<int> connections_{0};
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

class BadService : public testing::Test {
 protected:
  void SetUp() override {
    omni_test_reset();
    log_ = protocol::DefaultSocketPath() + ".log";
    std::remove(log_.c_str());
    setenv("OMNI_LAYER_LOG", log_.c_str(), 1);
  }
  void TearDown() override { unsetenv("OMNI_LAYER_LOG"); }
  int LinesWith(const std::string& text) const {
    std::ifstream in(log_);
    int lines = 0;
    for (std::string line; std::getline(in, line);) lines += line.find(text) != std::string::npos ? 1 : 0;
    return lines;
  }
  std::string log_;
};

// Three attempts and more, one line, which names both versions and the remedy.
TEST_F(BadService, VersionMismatchIsLoggedOnce) {
  const OddService service(OddService::Manner::kOtherVersion);
  const App app;
  ASSERT_TRUE(Eventually([&] {
    EXPECT_EQ(app.Sync(), XR_SUCCESS);
    return service.connections() >= 4;
  }));
  EXPECT_EQ(LinesWith("speaks protocol version " + std::to_string(protocol::kProtocolVersion + 1)), 1);
  EXPECT_EQ(LinesWith("install the same Omni version"), 1);
  EXPECT_EQ(app.Profile(app.right), "");
}

// omnid is upgraded: the old one ends, one of another version comes, then the right one.
TEST_F(BadService, ApplicationRecoversWhenServiceIsUpgraded) {
  App app;
  {
    FakeService service;
    ASSERT_TRUE(app.WaitProfile(service, kTouch));
  }
  {
    const OddService service(OddService::Manner::kOtherVersion);
    ASSERT_TRUE(Eventually([&] {
      EXPECT_EQ(app.Sync(), XR_SUCCESS);
      return service.connections() >= 2;
    }));
    EXPECT_EQ(app.Profile(app.right), "");
    EXPECT_FALSE(app.PoseActive(app.pose, app.right));
  }
  FakeService service;
  EXPECT_TRUE(app.WaitProfile(service, kTouch));
  EXPECT_EQ(LinesWith("connected to omnid"), 2);
  EXPECT_EQ(LinesWith("speaks protocol version"), 1);
}

// A service that accepts and never answers delays no call.
TEST_F(BadService, SilentServiceDoesNotBlockSync) {
  const OddService service(OddService::Manner::kSilent);
  const App app;
  ASSERT_TRUE(Eventually([&] { return service.connections() == 1; }));
  // The layer gives up after 2 s and tries again. A call that waited for it would be seen as one sync in all that time.
  int syncs = 0;
  ASSERT_TRUE(Eventually([&] {
    EXPECT_EQ(app.Sync(), XR_SUCCESS);
    ++syncs;
    return service.connections() >= 2;
  }));
  EXPECT_GT(syncs, 100);
  EXPECT_EQ(LinesWith("does not answer"), 1);
}

// Only the first query of an instance waits for a service that is connected and silent.
TEST_F(BadService, SilentServiceDelaysOnlyTheFirstQuery) {
  const OddService service(OddService::Manner::kSilent);
  const App app(WithForceAndNoMore());
  const auto query_ns = [&] {
    const std::int64_t before_ns = Now_ns();
    EXPECT_EQ(ForceSystemProperties(app).supportsForceFeedback, XR_FALSE);
    return Now_ns() - before_ns;
  };
  const std::int64_t first_ns = query_ns();
  std::int64_t next_ns = 0;
  for (int i = 0; i < 5; ++i) next_ns += query_ns();
  EXPECT_LT(next_ns, first_ns);
}

}  // namespace test_bad_service
}  // namespace omni::test
