// A force end to end: an OpenXR application, the loader, the layer, omnid, the twin. The coils' currents are read from
// the twin's own recording.
#include <gtest/gtest.h>

#include <cstdio>
#include <functional>

#include "tests/layer/force/fixture.h"
#include "tests/layer/service/child_app.h"

namespace omni::test {
namespace test_service_force {

constexpr XrDuration kLong_ns = XR_MAX_FORCE_DURATION_OMNIX1;

constexpr const char* kHoldStill = R"({"name": "hold", "repeat": false, "waypoints": [
    {"s": 0, "tip_m": [0, 0, 0.055], "axis": [0, 0, -1]}, {"s": 60, "tip_m": [0, 0, 0.055], "axis": [0, 0, -1]}]})";

struct StillService : StackService {
  StillService() : StackService(OMNI_SOURCE_DIR "/scenes/extrusion.glb", kHoldStill) {}
};

// An OpenXR application with one force feedback handle. Lives in a process of its own.
class ForceApp {
 public:
  ForceApp() : app_(Options()) {
    create_ = FunctionOf<PFN_xrCreateForceFeedbackOMNIX1>(app_.instance, "xrCreateForceFeedbackOMNIX1");
    apply_ = FunctionOf<PFN_xrApplyForceOMNIX1>(app_.instance, "xrApplyForceOMNIX1");
    constrain_ =
        FunctionOf<PFN_xrSetForceFeedbackConstraintsOMNIX1>(app_.instance, "xrSetForceFeedbackConstraintsOMNIX1");
    state_ = FunctionOf<PFN_xrGetForceFeedbackStateOMNIX1>(app_.instance, "xrGetForceFeedbackStateOMNIX1");
    local_ = app_.ReferenceSpace(XR_REFERENCE_SPACE_TYPE_LOCAL);
  }

  bool Create() {
    return Until([&] {
      const XrForceFeedbackCreateInfoOMNIX1 info{XR_TYPE_FORCE_FEEDBACK_CREATE_INFO_OMNIX1, nullptr, app_.right};
      return create_(app_.session, &info, &force_) == XR_SUCCESS;
    });
  }
  // Upwards, in LOCAL.
  void Push(XrDuration duration) {
    const XrForceApplyInfoOMNIX1 info{XR_TYPE_FORCE_APPLY_INFO_OMNIX1, nullptr, local_, {0, 0.6f, 0}, duration, 0};
    apply_(force_, &info);
  }
  // A spring to a place 1 cm above the pen's.
  void Hold() {
    const XrForceFeedbackConstraintPointOMNIX1 point{
        XR_TYPE_FORCE_FEEDBACK_CONSTRAINT_POINT_OMNIX1, nullptr, local_, 300, 0.5f, 1, {0, -0.35f + 0.065f, -0.45f}};
    const auto* header = reinterpret_cast<const XrForceFeedbackConstraintBaseHeaderOMNIX1*>(&point);
    const XrForceFeedbackConstraintsSetInfoOMNIX1 info{XR_TYPE_FORCE_FEEDBACK_CONSTRAINTS_SET_INFO_OMNIX1, nullptr, 1,
                                                       &header};
    constrain_(force_, &info);
  }
  float RenderedForce_N() {
    const XrForceFeedbackStateGetInfoOMNIX1 info{XR_TYPE_FORCE_FEEDBACK_STATE_GET_INFO_OMNIX1, nullptr, local_,
                                                 Now_ns() + kRuntimeOffset_ns};
    XrForceFeedbackStateOMNIX1 state{XR_TYPE_FORCE_FEEDBACK_STATE_OMNIX1};
    return state_(force_, &info, &state) == XR_SUCCESS && state.isActive ? state.appliedForce.y : 0;
  }
  // As a frame loop does, every 10 ms.
  bool Until(const std::function<bool()>& done, int most_ms = 8000) {
    for (int ms = 0; ms < most_ms; ms += 10) {
      app_.Poll();
      app_.Sync();
      if (done()) return true;
      SleepMs(10);
    }
    return false;
  }
  bool PushUntilFelt() {
    return Until([&] {
      Push(kLong_ns);
      return RenderedForce_N() > 0.5f;
    });
  }
  bool HoldUntilFelt() {
    return Until([&] {
      if (held_ == 0) Hold();
      held_ = (held_ + 1) % 50;
      return RenderedForce_N() > 0.5f;
    });
  }

 private:
  static AppOptions Options() {
    AppOptions options;
    options.extensions = {XR_OMNIX1_FORCE_FEEDBACK_EXTENSION_NAME};
    return options;
  }

  App app_;
  PFN_xrCreateForceFeedbackOMNIX1 create_ = nullptr;
  PFN_xrApplyForceOMNIX1 apply_ = nullptr;
  PFN_xrSetForceFeedbackConstraintsOMNIX1 constrain_ = nullptr;
  PFN_xrGetForceFeedbackStateOMNIX1 state_ = nullptr;
  XrSpace local_ = XR_NULL_HANDLE;
  XrForceFeedbackOMNIX1 force_ = XR_NULL_HANDLE;
  int held_ = 0;
};

using ForkedForceApp = ForkedApp<ForceApp>;

void LiveOn(ForceApp& app) {
  app.Until([] { return false; }, 600);
}

// The event that `app` reported must have set the coils to zero within 50 ms.
void ExpectZeroSoonAfter(ServiceProcess& service, ForkedForceApp& app, const char* what) {
  SleepMs(500);
  app.Kill();
  ASSERT_NE(app.reported(), 0);
  const double ms = StopAndPrintTimeToZero_ms(service, what, app.reported());
  EXPECT_GE(ms, 0);
  EXPECT_LE(ms, 50);
}

// The very first query of an application that has just started, while omnid has its device.
TEST(ForceStack, FirstQueryReportsTheDevice) {
  StillService service;
  {
    const App early(WithForceAndNoMore());
    ASSERT_TRUE(Eventually([&] { return ForceSystemProperties(early).supportsForceFeedback == XR_TRUE; }));
  }
  int unsupported = 0;
  for (int i = 0; i < 60; ++i) {
    const App app(WithForceAndNoMore());
    unsupported += ForceSystemProperties(app).supportsForceFeedback == XR_FALSE;
  }
  std::printf("[ figure   ] the first query finds no force feedback in %d of 60 instances\n", unsupported);
  EXPECT_EQ(unsupported, 0);
}

TEST(ForceStack, UnrenewedForceEndsAfterItsDuration) {
  StillService service;
  ForkedForceApp app(
      [](ForceApp& a) -> std::int64_t {
        if (!a.Create() || !a.PushUntilFelt()) return 0;
        a.Until(
            [&] {
              a.Push(kLong_ns);
              return false;
            },
            300);
        a.Push(40'000'000);
        return Now_ns() + 40'000'000;
      },
      LiveOn);
  ExpectZeroSoonAfter(service, app, "the deadman's end for an OpenXR application");
}

TEST(ForceStack, LosingFocusEndsForceAndConstraint) {
  StillService service;
  ForkedForceApp app(
      [](ForceApp& a) -> std::int64_t {
        if (!a.Create() || !a.HoldUntilFelt() || !a.PushUntilFelt()) return 0;
        const std::int64_t t_ns = Now_ns();
        omni_test_set_focus(0);
        return t_ns;
      },
      LiveOn);
  ExpectZeroSoonAfter(service, app, "an OpenXR application's loss of focus");
}

TEST(ForceStack, KilledApplicationEndsForceAndConstraint) {
  StillService service;
  ForkedForceApp app(
      [](ForceApp& a) -> std::int64_t { return a.Create() && a.HoldUntilFelt() && a.PushUntilFelt() ? Now_ns() : 0; },
      [](ForceApp& a) {
        a.Until([&] {
          a.Push(kLong_ns);
          return false;
        });
      });
  SleepMs(200);
  const std::int64_t killed_ns = Now_ns();
  app.Kill();
  ASSERT_NE(app.reported(), 0);
  SleepMs(500);
  const double ms = StopAndPrintTimeToZero_ms(service, "kill -9 of an OpenXR application", killed_ns);
  EXPECT_GE(ms, 0);
  EXPECT_LE(ms, 50);
}

}  // namespace test_service_force
}  // namespace omni::test
