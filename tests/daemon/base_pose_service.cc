// BasePoses in the service: whose headset counts, and whose space changes are accepted.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "service/base/clock.h"
#include "service/daemon/service.h"
#include "tests/daemon/base_pose_scenario.h"

namespace omni::daemon {
namespace test_daemon_base_pose_service {

protocol::Session SessionOf(protocol::SessionState state) {
  protocol::Session session;
  session.state = state;
  return session;
}

// The flag of every sample and the status are about the headset of the owner of the force.
TEST(DaemonBasePoseService, StatusSaysWhetherTheOwnersHeadsetIsAligned) {
  const TempFolder temp;
  bool aligned = false;
  Service service({.version = "test",
                   .instance = 1,
                   .hull_radius_m = 0.0375,
                   .alignment_path = temp.Path("a.toml"),
                   .on_aligned = [&aligned](bool now) { aligned = now; }});
  const auto join = [&service](ipc::ClientId id, const protocol::BasePoseRequest& request) {
    service.OnClient(
        {.id = id, .role = protocol::ClientRole::kApplication, .pid = 1, .application = "a", .engine = ""});
    service.OnRequest(id, SessionOf(protocol::SessionState::kFocused), {});
    service.OnRequest(id, request, {});
  };
  const auto status = [&service] { return nlohmann::json::parse(service.StatusJson()); };
  join(1, Request({kSpaceLocal}));
  EXPECT_FALSE(aligned);
  service.OnRequest(9, Store(kSpaceLocal), {});
  EXPECT_TRUE(aligned);
  EXPECT_EQ(status()["aligned"], true);
  EXPECT_EQ(status()["alignments"]["stored"].size(), 1U);
  EXPECT_EQ(status()["clients"][0]["runtime"], "Monado(XRT)");
  protocol::BasePoseRequest other = Request({kSpaceLocal});
  other.headset = Headset("another runtime");
  join(2, other);
  EXPECT_FALSE(aligned) << "it owns the force now, and its headset is not aligned";
  EXPECT_EQ(status()["clients"][0]["aligned"], true);
  service.OnGone(2);
  service.OnPeriod(1);
  EXPECT_TRUE(aligned);
  service.OnGone(1);
  service.OnPeriod(2);
  EXPECT_FALSE(aligned) << "there is no client";
}

// A change of a space is accepted only from an application whose session has begun, and for its own spaces.
TEST(DaemonBasePoseService, IgnoresSpaceChangesBeforeTheFirstSession) {
  const TempFolder temp;
  const std::string path = temp.Path("a.toml");
  Service service({.version = "test", .instance = 1, .hull_radius_m = 0.0375, .alignment_path = path});
  service.OnRequest(9, Store(kSpaceLocal), {});
  const auto recentred = [&service] {
    return nlohmann::json::parse(service.StatusJson())["alignments"]["stored"][0]["recentred"].get<int>();
  };
  const auto now_ns = [] { return base::MonotonicNow_ns(); };
  service.OnClient({.id = 1, .role = protocol::ClientRole::kApplication, .pid = 1, .application = "a", .engine = ""});
  service.OnRequest(1, Request({kSpaceLocal}), {});
  service.OnRequest(1, Moved(0.5, now_ns()), {});
  EXPECT_EQ(recentred(), 0) << "no session has begun";
  service.OnRequest(1, SessionOf(protocol::SessionState::kBegun), {});
  service.OnRequest(1, Moved(0.5, now_ns() + 1'000'000'000), {});
  EXPECT_EQ(recentred(), 1);
  service.OnRequest(1, SessionOf(protocol::SessionState::kNone), {});
  service.OnRequest(1, Moved(0.5, now_ns() + 2'000'000'000), {});
  EXPECT_EQ(recentred(), 2) << "the headset was taken off: the runtime still notifies this application";
  service.OnClient({.id = 2, .role = protocol::ClientRole::kApplication, .pid = 1, .application = "b", .engine = ""});
  service.OnRequest(2, SessionOf(protocol::SessionState::kFocused), {});
  service.OnRequest(2, Request({kSpaceStage}), {});
  service.OnRequest(2, Moved(0.5, now_ns() + 3'000'000'000), {});
  EXPECT_EQ(recentred(), 2) << "it has no LOCAL";
}

}  // namespace test_daemon_base_pose_service
}  // namespace omni::daemon
