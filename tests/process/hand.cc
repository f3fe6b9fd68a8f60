// The twin's hand controlled from outside, with real processes: omnid passes the socket on, aims move the pen that
// applications see, and `omni twin hand` touches a scene by what omnid publishes.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <fstream>
#include <string>
#include <thread>

#include "service/client/dial.h"
#include "tests/support/process/service_process.h"

namespace omni::test {
namespace test_process_hand {

constexpr const char* kScene = OMNI_SOURCE_DIR "/scenes/extrusion.glb";
constexpr const char* kHandScript = OMNI_SOURCE_DIR "/scenes/extrusion.hand.json";

class LedService {
 public:
  LedService() {
    std::filesystem::create_directories(folder_.Path("run"));
    std::filesystem::permissions(folder_.Path("run"), std::filesystem::perms::owner_all);
    folder_.Write("config/omni/apps.d/test.toml",
                  "application = \"process_test*\"\nscene = \"" OMNI_SOURCE_DIR "/scenes/extrusion.glb\"\n");
  }
  base::Result<test::ChildProcess> StartOmnid() const {
    return test::ChildProcess::Start({Program("omnid"), "--device", "twin", "--twin", "ideal", "--twin-script",
                                      kHandScript, "--twin-hand", hand_path(), "--log-level", "warn"},
                                     environment());
  }
  base::Result<test::ChildProcess> StartHand(const std::string& patience_s) const {
    return test::ChildProcess::Start(
        {Program("omni"), "twin", "hand", kScene, "--hand", hand_path(), "--patience", patience_s}, environment(),
        output_path());
  }
  test::Environment environment() const {
    return {"OMNI_SOCKET=" + socket_path(), "XDG_CONFIG_HOME=" + folder_.Path("config"),
            "XDG_CACHE_HOME=" + folder_.Path("cache")};
  }
  std::string socket_path() const { return folder_.Path("run/omnid.sock"); }
  std::string hand_path() const { return folder_.Path("run/hand.sock"); }
  std::string output_path() const { return folder_.Path("hand.txt"); }

 private:
  static std::string Program(const std::string& name) { return std::string(OMNI_BINARY_DIR "/bin/") + name; }
  const TempFolder folder_;
};

TEST(ProcessHand, AimsMoveThePenWhichThenStays) {
  const LedService service;
  const auto omnid = service.StartOmnid();
  ASSERT_TRUE(omnid.ok());
  TestApplication app(service.socket_path(), "process_test");
  ASSERT_TRUE(app.Focus());
  client::HandLink hand(service.hand_path());
  const auto tip_x_mm = [&] {
    const auto state = app.connection().state();
    protocol::ToolSample sample;
    const bool seen = state != nullptr && state->ReadNewest(sample) && (sample.flags & protocol::kToolTracked) != 0;
    return seen ? 1e3 * sample.position_base_m[0] : std::nan("");
  };
  ASSERT_TRUE(app.Run(10'000, 5, [&] { return hand.Connect() && std::abs(tip_x_mm()) < 5; })) << hand.problem();
  ASSERT_TRUE(hand.Send({.tip_base_m = {0.02, 0, 0.075}}));
  EXPECT_TRUE(app.Run(5000, 5, [&] { return std::abs(tip_x_mm() - 20) < 5; })) << tip_x_mm();
  app.Run(500, 5);
  EXPECT_NEAR(tip_x_mm(), 20, 5) << "nothing was said since";
}

TEST(ProcessHand, SculptsClayFromPublishedStateOnly) {
  const LedService service;
  const auto omnid = service.StartOmnid();
  ASSERT_TRUE(omnid.ok());
  TestApplication app(service.socket_path(), "process_test");
  ASSERT_TRUE(app.Focus());
  auto hand = service.StartHand("80");
  ASSERT_TRUE(hand.ok());
  std::atomic<int> status{-1};
  std::thread waiter([&] { status = hand->Wait(); });
  app.Run(100'000, 5, [&] { return status >= 0; });
  waiter.join();
  std::ifstream file(service.output_path());
  std::string said;
  std::getline(file, said);
  EXPECT_EQ(status, 0) << said;
  EXPECT_NE(said.find("sculpted in"), std::string::npos) << said;
}

// Without an application there is no clay: it fails in time.
TEST(ProcessHand, FailsInTimeWithoutAnApplication) {
  const LedService service;
  const auto omnid = service.StartOmnid();
  ASSERT_TRUE(omnid.ok());
  auto hand = service.StartHand("3");
  ASSERT_TRUE(hand.ok());
  EXPECT_EQ(hand->Wait(), 1);
}

TEST(ProcessHand, ExitsWithNoServiceStatusWithoutOmnid) {
  const LedService service;
  auto hand = service.StartHand("1");
  ASSERT_TRUE(hand.ok());
  EXPECT_EQ(hand->Wait(), 3);
}

}  // namespace test_process_hand
}  // namespace omni::test
