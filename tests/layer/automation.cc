// XR_EXT_conformance_automation: a conformance test moves the pen. Available through a manifest of its own, in test
// mode only.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <cmath>

#include <stdexcept>

#include "tests/layer/support/app.h"

namespace omni::test {
namespace test_automation {

constexpr const char* kExtension = XR_EXT_CONFORMANCE_AUTOMATION_EXTENSION_NAME;
const std::string kLayers = std::string(OMNI_BINARY_DIR) + "/share/openxr/1/api_layers/";

// The conformance manifest, as long as one of these lives.
class ConformanceManifest {
 public:
  ConformanceManifest() {
    setenv("XR_API_LAYER_PATH", (kLayers + "conformance.d").c_str(), 1);
    setenv("OMNI_TEST_MODE", "1", 1);
  }
  ~ConformanceManifest() {
    setenv("XR_API_LAYER_PATH", (kLayers + "explicit.d").c_str(), 1);
    unsetenv("OMNI_TEST_MODE");
  }
};

class Automation : public testing::Test {
 protected:
  void SetUp() override { omni_test_reset(); }
  static AppOptions WithAutomation() {
    AppOptions options;
    options.extensions = {kExtension};
    return options;
  }
  ConformanceManifest manifest_;
};

template <class Function>
Function Get(const App& app, const char* name) {
  const auto function = FunctionOf<Function>(app.instance, name);
  EXPECT_NE(function, nullptr) << name;
  return function;
}

struct Functions {
  explicit Functions(const App& app)
      : active(Get<PFN_xrSetInputDeviceActiveEXT>(app, "xrSetInputDeviceActiveEXT")),
        set_bool(Get<PFN_xrSetInputDeviceStateBoolEXT>(app, "xrSetInputDeviceStateBoolEXT")),
        set_float(Get<PFN_xrSetInputDeviceStateFloatEXT>(app, "xrSetInputDeviceStateFloatEXT")),
        vector(Get<PFN_xrSetInputDeviceStateVector2fEXT>(app, "xrSetInputDeviceStateVector2fEXT")),
        location(Get<PFN_xrSetInputDeviceLocationEXT>(app, "xrSetInputDeviceLocationEXT")) {}
  PFN_xrSetInputDeviceActiveEXT active;
  PFN_xrSetInputDeviceStateBoolEXT set_bool;
  PFN_xrSetInputDeviceStateFloatEXT set_float;
  PFN_xrSetInputDeviceStateVector2fEXT vector;
  PFN_xrSetInputDeviceLocationEXT location;
};

TEST_F(Automation, SettingDeviceActiveTakesEffectAtSync) {
  App app(WithAutomation());
  const Functions f(app);
  ASSERT_EQ(app.Sync(), XR_SUCCESS);
  EXPECT_EQ(app.Profile(app.right), "");
  for (int i = 0; i < 3; ++i) {
    ASSERT_EQ(f.active(app.session, app.Path(kTouch), app.right, XR_TRUE), XR_SUCCESS);
    EXPECT_FALSE(app.PoseActive(app.pose, app.right)) << "not before the sync";
    ASSERT_EQ(app.Sync(), XR_SUCCESS);
    ASSERT_EQ(app.Sync(), XR_SUCCESS);
    EXPECT_EQ(app.Profile(app.right), kTouch);
    EXPECT_TRUE(app.PoseActive(app.pose, app.right));
    ASSERT_EQ(f.active(app.session, app.Path(kTouch), app.right, XR_FALSE), XR_SUCCESS);
    EXPECT_TRUE(app.PoseActive(app.pose, app.right)) << "until the sync";
    ASSERT_EQ(app.Sync(), XR_SUCCESS);
    EXPECT_EQ(app.Profile(app.right), "");
    EXPECT_FALSE(app.PoseActive(app.pose, app.right));
  }
}

TEST_F(Automation, SetsBooleanFloatAndVectorStatesAtSync) {
  App app(WithAutomation());
  const Functions f(app);
  ASSERT_EQ(f.active(app.session, app.Path(kTouch), app.right, XR_TRUE), XR_SUCCESS);
  ASSERT_EQ(app.Sync(), XR_SUCCESS);
  const auto path = [&](const char* local) { return app.Path(std::string("/user/hand/right") + local); };
  ASSERT_EQ(f.set_float(app.session, app.right, path("/input/trigger/value"), 0.8f), XR_SUCCESS);
  ASSERT_EQ(f.set_bool(app.session, app.right, path("/input/a/click"), XR_TRUE), XR_SUCCESS);
  ASSERT_EQ(f.vector(app.session, app.right, path("/input/thumbstick"), {-0.5f, 0.25f}), XR_SUCCESS);
  EXPECT_EQ(app.Float(app.force, app.right).currentState, 0.0f) << "not before the sync";
  const XrTime before = app.Float(app.force, app.right).lastChangeTime;
  ASSERT_EQ(app.Sync(), XR_SUCCESS);
  EXPECT_FLOAT_EQ(app.Float(app.force, app.right).currentState, 0.8f);
  EXPECT_GT(app.Float(app.force, app.right).lastChangeTime, before);
  EXPECT_TRUE(app.Bool(app.select, app.right).currentState) << "trigger as a boolean";
  EXPECT_TRUE(app.Bool(app.plain, XR_NULL_PATH).currentState);
  EXPECT_FLOAT_EQ(app.Vector(app.stick, app.right).currentState.x, -0.5f);
  EXPECT_FLOAT_EQ(app.Vector(app.stick, app.right).currentState.y, 0.25f);
}

// Where the aim pose is in STAGE after a test has set the location of `path` there.
XrSpaceLocation AimAfter(const App& app, const Functions& f, const char* path, const XrPosef& wanted) {
  EXPECT_EQ(f.active(app.session, app.Path(kTouch), app.right, XR_TRUE), XR_SUCCESS);
  EXPECT_EQ(app.Sync(), XR_SUCCESS);
  const XrSpace stage = app.ReferenceSpace(XR_REFERENCE_SPACE_TYPE_STAGE);
  const XrSpace aim = app.ActionSpace(app.pose, app.right);
  EXPECT_EQ(f.location(app.session, app.right, app.Path(path), stage, wanted), XR_SUCCESS);
  XrSpaceLocation location{XR_TYPE_SPACE_LOCATION};
  EXPECT_EQ(xrLocateSpace(aim, stage, Now_ns() + kRuntimeOffset_ns, &location), XR_SUCCESS);
  return location;
}

TEST_F(Automation, SettingLocationPlacesTheNamedPose) {
  App app(WithAutomation());
  const Functions f(app);
  const XrPosef wanted{{0.5f, 0.5f, 0.5f, 0.5f}, {0.3f, 1.1f, -0.2f}};
  const XrSpaceLocation location = AimAfter(app, f, "/user/hand/right/input/aim/pose", wanted);
  ASSERT_TRUE(location.locationFlags & XR_SPACE_LOCATION_POSITION_TRACKED_BIT);
  EXPECT_NEAR(location.pose.position.x, wanted.position.x, 1e-4f);
  EXPECT_NEAR(location.pose.position.y, wanted.position.y, 1e-4f);
  EXPECT_NEAR(location.pose.position.z, wanted.position.z, 1e-4f);
  const XrQuaternionf& q = location.pose.orientation;
  EXPECT_NEAR(std::fabs(0.5f * (q.x + q.y + q.z + q.w)), 1.0f, 1e-4f);
}

// ... also of one that is not where the tool frame is: the tip then lies 5 cm before the grip.
TEST_F(Automation, SettingGripLocationMovesTheTip) {
  App app(WithAutomation());
  const Functions f(app);
  const XrPosef wanted{{0, 0, 0, 1}, {0.3f, 1.1f, -0.2f}};
  const XrSpaceLocation location = AimAfter(app, f, "/user/hand/right/input/grip/pose", wanted);
  EXPECT_NEAR(location.pose.position.x, 0.3f, 1e-4f);
  EXPECT_NEAR(location.pose.position.y, 1.1f, 1e-4f);
  EXPECT_NEAR(location.pose.position.z, -0.25f, 1e-4f);
}

// A test that sets states replaces the hardware.
TEST_F(Automation, SimulatedDeviceOverridesHardware) {
  FakeService service;
  App app(WithAutomation());
  const Functions f(app);
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  service.Set(protocol::InputIndex::kTipForce, 0.9f);
  ASSERT_EQ(f.active(app.session, app.Path(kTouch), app.right, XR_TRUE), XR_SUCCESS);
  service.Fill();
  ASSERT_EQ(app.Sync(), XR_SUCCESS);
  EXPECT_EQ(app.Float(app.force, app.right).currentState, 0.0f);
}

TEST_F(Automation, InvalidArgumentsReturnSpecifiedErrors) {
  App app(WithAutomation());
  const Functions f(app);
  EXPECT_EQ(f.active(app.session, app.Path("/interaction_profiles/no/such"), app.right, XR_TRUE),
            XR_ERROR_PATH_UNSUPPORTED);
  EXPECT_EQ(f.active(app.session, 987654321, app.right, XR_TRUE), XR_ERROR_PATH_INVALID);
  EXPECT_EQ(f.active(app.session, app.Path(kTouch), app.left, XR_TRUE), XR_ERROR_FUNCTION_UNSUPPORTED)
      << "the runtime's hand, and the runtime has no such extension";
  EXPECT_EQ(f.active(app.session, app.Path(kTouch), app.left, XR_FALSE), XR_SUCCESS) << "it is inactive already";
  ASSERT_EQ(f.active(app.session, app.Path(kTouch), app.right, XR_TRUE), XR_SUCCESS);
  EXPECT_EQ(f.set_bool(app.session, app.right, app.Path("/user/hand/right/input/x/click"), XR_TRUE),
            XR_ERROR_PATH_UNSUPPORTED);
  EXPECT_EQ(f.set_bool(app.session, app.right, app.Path("/user/hand/left/input/x/click"), XR_TRUE),
            XR_ERROR_PATH_UNSUPPORTED);
  EXPECT_EQ(f.set_float(app.session, app.right, app.Path("/user/hand/right/input/trigger/value"), NAN),
            XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(f.set_float(XR_NULL_HANDLE, app.right, app.Path("/user/hand/right/input/trigger/value"), 0.5f),
            XR_ERROR_HANDLE_INVALID);
}

TEST_F(Automation, NeedsTestModeAndConformanceManifest) {
  unsetenv("OMNI_TEST_MODE");
  EXPECT_THROW(App app(WithAutomation()), std::runtime_error) << "no layer or runtime has the extension";
  setenv("OMNI_TEST_MODE", "1", 1);
  setenv("XR_API_LAYER_PATH", (kLayers + "explicit.d").c_str(), 1);
  EXPECT_THROW(App app(WithAutomation()), std::runtime_error) << "the usual manifest does not name it";
  const App plain;
  PFN_xrVoidFunction function = nullptr;
  EXPECT_EQ(xrGetInstanceProcAddr(plain.instance, "xrSetInputDeviceActiveEXT", &function),
            XR_ERROR_FUNCTION_UNSUPPORTED);
}

}  // namespace test_automation
}  // namespace omni::test
