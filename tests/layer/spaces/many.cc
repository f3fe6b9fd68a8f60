// xrLocateSpacesKHR: each space as by xrLocateSpace, with one runtime call. (xrLocateSpaces of 1.1: spaces_1_1.cc.)
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>

#include "tests/layer/spaces/fixture.h"

namespace omni::test {
namespace test_spaces_many {

AppOptions ManyOptions() {
  AppOptions options;
  options.extensions = {XR_KHR_LOCATE_SPACES_EXTENSION_NAME};
  return options;
}

class SpacesMany : public SpacesTest {
 protected:
  void SetUp() override {
    SpacesTest::SetUp();
    app = std::make_unique<App>(ManyOptions());
    Start(*app, RandomPath(3));
    locate_ = FunctionOf<PFN_xrLocateSpacesKHR>(app->instance, "xrLocateSpacesKHR");
    ASSERT_NE(locate_, nullptr);
    const float head[7] = {0.1f, 1.6f, 0.2f, 0, 0, 0, 1};
    const float moving[6] = {0.2f, 0, -0.1f, 0.1f, 0.7f, 0};
    ASSERT_EQ(omni_test_set_head(head, moving), 0);
    view = app->ReferenceSpace(XR_REFERENCE_SPACE_TYPE_VIEW);
    stage = app->ReferenceSpace(XR_REFERENCE_SPACE_TYPE_STAGE, {{0, 0, 0, 1}, {0, 0.5f, 0}});
    left = app->ActionSpace(app->pose, app->left);
    offset = app->ActionSpace(app->pose, app->right, {{0, 0, 0, 1}, {0.05f, 0, 0.1f}});
    service.Fill();
    ASSERT_EQ(app->Sync(), XR_SUCCESS);
    now = Now_ns();
  }

  struct Answer {
    XrResult result = XR_SUCCESS;
    std::vector<XrSpaceLocationData> location;
    std::vector<XrSpaceVelocityData> velocity;
  };
  Answer Ask(const std::vector<XrSpace>& spaces, XrSpace base, XrTime time, bool velocities = true) const {
    Answer out;
    const auto count = static_cast<std::uint32_t>(spaces.size());
    out.location.resize(count);
    out.velocity.resize(count);
    const XrSpacesLocateInfo info{XR_TYPE_SPACES_LOCATE_INFO, nullptr, base, time, count, spaces.data()};
    XrSpaceVelocities rates{XR_TYPE_SPACE_VELOCITIES, nullptr, count, out.velocity.data()};
    XrSpaceLocations places{XR_TYPE_SPACE_LOCATIONS, velocities ? &rates : nullptr, count, out.location.data()};
    out.result = locate_(app->session, &info, &places);
    return out;
  }

  std::unique_ptr<App> app;
  PFN_xrLocateSpacesKHR locate_ = nullptr;
  XrSpace view = XR_NULL_HANDLE, stage = XR_NULL_HANDLE, left = XR_NULL_HANDLE, offset = XR_NULL_HANDLE;
  std::int64_t now = 0;
};

// [Locate spaces] "each space ... follow the same specifics as the corresponding inputs to the xrLocateSpace function"
TEST_F(SpacesMany, LocateSpacesMatchesLocateSpaceInEveryBase) {
  const std::vector<XrSpace> spaces{pen, view, left, offset, stage, local};
  for (const XrSpace base : {local, view, stage, left, pen, offset}) {
    const XrTime time = ToXrTime(now - 10'000'000);
    const Answer many = Ask(spaces, base, time);
    ASSERT_EQ(many.result, XR_SUCCESS);
    for (std::size_t i = 0; i < spaces.size(); ++i) {
      const Seen one = Locate(spaces[i], base, now - 10'000'000);
      ASSERT_EQ(one.location.locationFlags, kSeen) << i;
      EXPECT_EQ(many.location[i].locationFlags, kSeen) << i;
      EXPECT_EQ(std::memcmp(&many.location[i].pose, &one.location.pose, sizeof(XrPosef)), 0) << i;
      EXPECT_EQ(many.velocity[i].velocityFlags, one.velocity.velocityFlags) << i;
      EXPECT_EQ(std::memcmp(&many.velocity[i].linearVelocity, &one.velocity.linearVelocity, sizeof(XrVector3f)), 0);
      EXPECT_EQ(std::memcmp(&many.velocity[i].angularVelocity, &one.velocity.angularVelocity, sizeof(XrVector3f)), 0);
    }
  }
}

TEST_F(SpacesMany, LocateSpacesMakesOneRuntimeCall) {
  const long many = omni_test_call_count("xrLocateSpacesKHR");
  const long one = omni_test_call_count("xrLocateSpace");
  ASSERT_EQ(Ask({pen, view, offset, left}, pen, ToXrTime(now)).result, XR_SUCCESS);
  EXPECT_EQ(omni_test_call_count("xrLocateSpacesKHR"), many + 1);
  EXPECT_EQ(omni_test_call_count("xrLocateSpace"), one);
}

TEST_F(SpacesMany, WorksWithoutVelocities) {
  const Answer answer = Ask({pen}, view, ToXrTime(now), false);
  ASSERT_EQ(answer.result, XR_SUCCESS);
  EXPECT_EQ(answer.location[0].locationFlags, kSeen);
}

// [Locate spaces] counts must agree, there must be at least one space, time > 0: with the pen in the list as without.
TEST_F(SpacesMany, InvalidCountsTimesAndHandlesAreRejected) {
  EXPECT_EQ(Ask({}, pen, ToXrTime(now)).result, XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(Ask({pen}, local, 0).result, XR_ERROR_TIME_INVALID);
  EXPECT_EQ(Ask({local}, pen, -1).result, XR_ERROR_TIME_INVALID);
  EXPECT_EQ(Ask({pen, offset}, pen, 0).result, XR_ERROR_TIME_INVALID);
  EXPECT_EQ(Ask({pen, XR_NULL_HANDLE}, local, ToXrTime(now)).result, XR_ERROR_HANDLE_INVALID);
  EXPECT_EQ(Ask({pen}, XR_NULL_HANDLE, ToXrTime(now)).result, XR_ERROR_HANDLE_INVALID);
  const XrSpace spaces[] = {pen, local};
  std::array<XrSpaceLocationData, 2> location{};
  std::array<XrSpaceVelocityData, 2> velocity{};
  XrSpacesLocateInfo info{XR_TYPE_SPACES_LOCATE_INFO, nullptr, local, ToXrTime(now), 2, spaces};
  XrSpaceVelocities rates{XR_TYPE_SPACE_VELOCITIES, nullptr, 1, velocity.data()};
  XrSpaceLocations places{XR_TYPE_SPACE_LOCATIONS, &rates, 2, location.data()};
  EXPECT_EQ(locate_(app->session, &info, &places), XR_ERROR_VALIDATION_FAILURE) << "too few velocities";
  rates.velocityCount = 2;
  places.locationCount = 1;
  EXPECT_EQ(locate_(app->session, &info, &places), XR_ERROR_VALIDATION_FAILURE) << "too few locations";
  places.locationCount = 2;
  EXPECT_EQ(locate_(app->session, &info, &places), XR_SUCCESS);
  EXPECT_EQ(locate_(app->session, nullptr, &places), XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(locate_(app->session, &info, nullptr), XR_ERROR_VALIDATION_FAILURE);
}

// Not fed by the pen at the moment: unlocatable, and the others are where they are.
TEST_F(SpacesMany, InactiveSpaceIsUnlocatable) {
  ASSERT_EQ(app->SyncSets({{app->set, app->left}}), XR_SUCCESS);
  const Answer answer = Ask({pen, view}, local, ToXrTime(now));
  ASSERT_EQ(answer.result, XR_SUCCESS);
  EXPECT_EQ(answer.location[0].locationFlags, 0u);
  EXPECT_EQ(answer.velocity[0].velocityFlags, 0u);
  EXPECT_EQ(answer.location[1].locationFlags, kSeen);
  EXPECT_EQ(Ask({view}, pen, ToXrTime(now)).location[0].locationFlags, 0u);
}

TEST_F(SpacesMany, RuntimeSpacesMatchLocateSpaceWithoutPen) {
  const Answer answer = Ask({view, stage}, local, ToXrTime(now));
  ASSERT_EQ(answer.result, XR_SUCCESS);
  const Seen one = Locate(view, local, now);
  EXPECT_EQ(std::memcmp(&answer.location[0].pose, &one.location.pose, sizeof(XrPosef)), 0);
}

}  // namespace test_spaces_many
}  // namespace omni::test
