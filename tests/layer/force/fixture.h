// An application with XR_OMNIX1_force_feedback, its one handle, and a service that reports what the device can do.
#pragma once

#include <gtest/gtest.h>

#include <optional>
#include <variant>
#include <vector>

#include "layer/include/openxr/omni_force_feedback.h"
#include "tests/layer/support/app.h"

namespace omni::test {

inline constexpr XrDuration kForceFrame_ns = 30'000'000;

inline AppOptions WithForce() {
  AppOptions options;
  options.extensions = {XR_OMNIX1_FORCE_FEEDBACK_EXTENSION_NAME};
  return options;
}

// An application that first queries what the device can do.
inline AppOptions WithForceAndNoMore() {
  AppOptions options = WithForce();
  options.attach = options.begin = false;
  return options;
}

inline XrSystemForceFeedbackPropertiesOMNIX1 ForceSystemProperties(const App& app) {
  XrSystemForceFeedbackPropertiesOMNIX1 ours{XR_TYPE_SYSTEM_FORCE_FEEDBACK_PROPERTIES_OMNIX1};
  XrSystemProperties properties{XR_TYPE_SYSTEM_PROPERTIES, &ours};
  EXPECT_EQ(xrGetSystemProperties(app.instance, app.system, &properties), XR_SUCCESS);
  EXPECT_EQ(properties.next, &ours) << "the application's chain is unchanged";
  EXPECT_STREQ(properties.systemName, "Omni test system");
  return ours;
}

struct ForceFunctions {
  PFN_xrCreateForceFeedbackOMNIX1 create = nullptr;
  PFN_xrDestroyForceFeedbackOMNIX1 destroy = nullptr;
  PFN_xrGetForceFeedbackPropertiesOMNIX1 properties = nullptr;
  PFN_xrApplyForceOMNIX1 apply = nullptr;
  PFN_xrSetForceFeedbackConstraintsOMNIX1 constraints = nullptr;
  PFN_xrStopForceFeedbackOMNIX1 stop = nullptr;
  PFN_xrGetForceFeedbackStateOMNIX1 state = nullptr;

  explicit ForceFunctions(XrInstance instance) {
    const auto get = [&](const char* name, auto& function) {
      function = FunctionOf<std::decay_t<decltype(function)>>(instance, name);
      EXPECT_NE(function, nullptr) << name;
    };
    get("xrCreateForceFeedbackOMNIX1", create);
    get("xrDestroyForceFeedbackOMNIX1", destroy);
    get("xrGetForceFeedbackPropertiesOMNIX1", properties);
    get("xrApplyForceOMNIX1", apply);
    get("xrSetForceFeedbackConstraintsOMNIX1", constraints);
    get("xrStopForceFeedbackOMNIX1", stop);
    get("xrGetForceFeedbackStateOMNIX1", state);
  }
};

class ForceTest : public testing::Test {
 protected:
  void SetUp() override {
    omni_test_reset();
    service_.SetForce(true, protocol::ForceStanding::kYours);
  }
  void TearDown() override { omni_test_reset(); }

  // An application that is focused, and a service that has reported its properties.
  void Start() {
    app_.emplace(WithForce());
    xr_.emplace(app_->instance);
    local_ = app_->ReferenceSpace(XR_REFERENCE_SPACE_TYPE_LOCAL);
    ASSERT_TRUE(app_->WaitProfile(service_, kTouch));
    ASSERT_TRUE(app_->SyncUntil(service_, [&] { return SystemSays().supportsForceFeedback == XR_TRUE; }));
  }
  void StartWithHandle() {
    Start();
    ASSERT_EQ(Create(force_), XR_SUCCESS);
  }

  XrResult Create(XrForceFeedbackOMNIX1& force, const char* path = "/user/hand/right") {
    const XrForceFeedbackCreateInfoOMNIX1 info{XR_TYPE_FORCE_FEEDBACK_CREATE_INFO_OMNIX1, nullptr, app_->Path(path)};
    return xr_->create(app_->session, &info, &force);
  }
  XrResult Push(const XrVector3f& force_N, XrSpace space, XrDuration duration = kForceFrame_ns, XrDuration ramp = 0) {
    const XrForceApplyInfoOMNIX1 info{XR_TYPE_FORCE_APPLY_INFO_OMNIX1, nullptr, space, force_N, duration, ramp};
    return xr_->apply(force_, &info);
  }
  XrResult Set(const std::vector<const void*>& constraints) {
    std::vector<const XrForceFeedbackConstraintBaseHeaderOMNIX1*> list;
    for (const void* c : constraints) list.push_back(static_cast<const XrForceFeedbackConstraintBaseHeaderOMNIX1*>(c));
    const XrForceFeedbackConstraintsSetInfoOMNIX1 info{XR_TYPE_FORCE_FEEDBACK_CONSTRAINTS_SET_INFO_OMNIX1, nullptr,
                                                       static_cast<std::uint32_t>(list.size()), list.data()};
    return xr_->constraints(force_, &info);
  }
  XrForceFeedbackConstraintPointOMNIX1 Point(XrSpace space, const XrVector3f& at = {0, 0, 0}) const {
    return {XR_TYPE_FORCE_FEEDBACK_CONSTRAINT_POINT_OMNIX1, nullptr, space, 200, 0.5f, 1, at};
  }
  XrSystemForceFeedbackPropertiesOMNIX1 SystemSays() { return ForceSystemProperties(*app_); }
  XrForceFeedbackStateOMNIX1 State() {
    const XrForceFeedbackStateGetInfoOMNIX1 info{XR_TYPE_FORCE_FEEDBACK_STATE_GET_INFO_OMNIX1, nullptr, local_,
                                                 Now_ns() + kRuntimeOffset_ns};
    XrForceFeedbackStateOMNIX1 state{XR_TYPE_FORCE_FEEDBACK_STATE_OMNIX1};
    EXPECT_EQ(xr_->state(force_, &info, &state), XR_SUCCESS);
    return state;
  }

  // The newest message of a type; waits for it to be the `n`-th one.
  template <class T>
  std::optional<T> Heard(std::size_t n) {
    std::optional<T> found;
    app_->SyncUntil(service_, [&] {
      std::size_t count = 0;
      for (const protocol::ForceRequest& request : service_.heard().forces) {
        if (!std::holds_alternative<T>(request)) continue;
        found = std::get<T>(request);
        ++count;
      }
      return count >= n;
    });
    return found;
  }
  template <class T>
  std::size_t Count() const {
    std::size_t count = 0;
    for (const protocol::ForceRequest& request : service_.heard().forces) count += std::holds_alternative<T>(request);
    return count;
  }

  FakeService service_;
  std::optional<App> app_;
  std::optional<ForceFunctions> xr_;
  XrSpace local_ = XR_NULL_HANDLE;
  XrForceFeedbackOMNIX1 force_ = XR_NULL_HANDLE;
};

}  // namespace omni::test
