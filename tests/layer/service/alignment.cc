// A measured base pose end to end: an OpenXR application, the loader, the layer, omnid, the twin. It holds when
// the user recentres the headset, when omnid is restarted, and for the application that comes next.
#include <gtest/gtest.h>

#include <cstdio>
#include <glm/geometric.hpp>
#include <memory>

#include "layer/src/spaces/locate.h"
#include "service/base/clock.h"
#include "service/tools/align/align.h"
#include "tests/layer/service/child_app.h"

namespace omni::test {
namespace test_service_alignment {

constexpr const char* kLying = R"({"name": "lying", "repeat": false, "waypoints": [
    {"s": 0, "tip_m": [0.01, 0.005, 0.06], "axis": [0, 0, -1]}, {"s": 600, "tip_m": [0.01, 0.005, 0.06], "axis": [0, 0, -1]}]})";

constexpr double kHand_mm = 3;  // the twin's hand does not lie quite still
constexpr XrSpaceLocationFlags kAll = layer::kValid | layer::kTracked;

class Viewer {
 public:
  Viewer()
      : stage_(app_.ReferenceSpace(XR_REFERENCE_SPACE_TYPE_STAGE)),
        local_(app_.ReferenceSpace(XR_REFERENCE_SPACE_TYPE_LOCAL)),
        pen_(app_.ActionSpace(app_.pose, app_.right)) {}

  // Frame after frame; false: timed out.
  template <class Done>
  bool Until(Done done) {
    return Eventually([&] {
      app_.Poll();
      app_.Sync();
      return done();
    });
  }
  bool SeesThePen() {
    return Until([this] { return At(stage_).locationFlags == kAll; });
  }
  bool LosesThePen() {
    return Until([this] { return At(stage_).locationFlags == 0; });
  }
  // Mean of some frames: a tracker trembles.
  glm::dvec3 PenInStage() { return Mean(stage_); }
  glm::dvec3 PenInLocal() { return Mean(local_); }

 private:
  XrSpaceLocation At(XrSpace base) const {
    XrSpaceLocation location{XR_TYPE_SPACE_LOCATION};
    EXPECT_EQ(xrLocateSpace(pen_, base, Now_ns() + kRuntimeOffset_ns, &location), XR_SUCCESS);
    return location;
  }
  glm::dvec3 Mean(XrSpace base) {
    constexpr int kFrames = 50;
    glm::dvec3 sum(0);
    int seen = 0;
    for (int i = 0; i < 4 * kFrames && seen < kFrames; ++i) {
      app_.Poll();
      app_.Sync();
      const XrSpaceLocation location = At(base);
      if (location.locationFlags == kAll) {  // there is none while the machine holds omnid up
        sum += layer::FromXr(location.pose.position);
        ++seen;
      }
      Pause_ms(4);
    }
    EXPECT_EQ(seen, kFrames);
    return sum / double{kFrames};
  }

  App app_;
  XrSpace stage_, local_, pen_;
};

// As `omni align` does at its end.
void StoreInLocal(const std::string& socket_path) {
  client::Connection connection(
      {.role = protocol::ClientRole::kTool, .application = "", .engine = "", .socket_path = socket_path});
  ASSERT_TRUE(Eventually([&] {
    connection.Poll(base::MonotonicNow_ns());
    return connection.connected();
  }));
  alignment::Outcome outcome;
  outcome.base_space = {.orientation = {0.64, -0.64, 0.3, 0.3}, .position_m = {0.2, -0.4, -0.5}};
  outcome.samples = 5;
  outcome.expected_error_m = 1e-3;
  const tools::Headset headset{
      .runtime = "Omni test runtime", .system = "Omni test system", .space = protocol::kSpaceLocal};
  const auto stored = tools::RequestBasePose(connection, tools::StoreCommand(headset, outcome, "touch"));
  ASSERT_TRUE(stored.ok()) << stored.error();
}

TEST(AlignmentStack, BasePoseHoldsThroughRecentringAndRestarts) {
  omni_test_reset();
  StackService service(OMNI_SOURCE_DIR "/scenes/extrusion.glb", kLying);
  auto viewer = std::make_unique<Viewer>();
  StoreInLocal(service.socket_path());
  ASSERT_TRUE(viewer->SeesThePen()) << "TRACKED from the base pose on";
  const glm::dvec3 in_stage = viewer->PenInStage(), in_local = viewer->PenInLocal();
  const auto moved_mm = [&] { return 1e3 * glm::length(viewer->PenInStage() - in_stage); };

  const float recentred[7] = {0.3f, -0.1f, 0.2f, 0, 0.6f, 0, 0.8f};
  ASSERT_EQ(omni_test_recenter(recentred, 0), 0);
  const double recentring_mm = moved_mm();
  EXPECT_LT(recentring_mm, kHand_mm);
  EXPECT_GT(glm::length(viewer->PenInLocal() - in_local), 0.1) << "LOCAL itself has moved";

  EXPECT_EQ(service.Stop(), 0);
  ASSERT_TRUE(viewer->LosesThePen());
  service.Start();
  ASSERT_TRUE(viewer->SeesThePen()) << "omnid has kept the base pose, and what became of LOCAL";
  const double restart_mm = moved_mm();
  EXPECT_LT(restart_mm, kHand_mm);

  viewer = nullptr;
  viewer = std::make_unique<Viewer>();
  ASSERT_TRUE(viewer->SeesThePen());
  const double next_mm = moved_mm();
  EXPECT_LT(next_mm, kHand_mm);
  std::printf(
      "[ figure   ] pen in STAGE, moved by: recentring %.3f mm, a restart of omnid %.3f mm, the next application %.3f "
      "mm\n",
      recentring_mm, restart_mm, next_mm);
}

}  // namespace test_service_alignment
}  // namespace omni::test
