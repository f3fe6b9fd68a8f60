// Instances, extensions, strings, the system.

#include <cstring>

#include "tests/runtime/cases/fixture.h"
#include "tests/runtime/negotiation.h"

extern "C" XrResult xrNegotiateLoaderRuntimeInterface(const omni::runtime::NegotiateLoaderInfo* loader,
                                                      omni::runtime::NegotiateRuntimeRequest* request);

namespace omni::runtime {
namespace test_instance {

using InstanceTest = RuntimeTest;

NegotiateLoaderInfo Loader() {
  return {kLoaderInfoType,
          kStructVersion,
          sizeof(NegotiateLoaderInfo),
          1,
          1,
          XR_MAKE_VERSION(1, 0, 0),
          XR_MAKE_VERSION(1, 0x3ff, 0xfff)};
}

NegotiateRuntimeRequest Request() {
  return {kRuntimeRequestType, kStructVersion, sizeof(NegotiateRuntimeRequest), 0, 0, nullptr};
}

TEST_F(InstanceTest, UnknownExtensionIsRefused) {
  EXPECT_EQ(CreateInstance({"XR_LOGITECH_mx_ink_stylus_interaction"}), XR_ERROR_EXTENSION_NOT_PRESENT);
  EXPECT_EQ(instance_, nullptr);
  EXPECT_EQ(omni_test_live_handles(), 0U);
}

TEST_F(InstanceTest, ExtensionListTakesTwoCalls) {
  uint32_t count = 0;
  ASSERT_EQ(xrEnumerateInstanceExtensionProperties(nullptr, 0, &count, nullptr), XR_SUCCESS);
  ASSERT_GE(count, 2U);
  std::vector<XrExtensionProperties> properties(count, Make<XrExtensionProperties>(XR_TYPE_EXTENSION_PROPERTIES));
  ASSERT_EQ(xrEnumerateInstanceExtensionProperties(nullptr, count, &count, properties.data()), XR_SUCCESS);
  bool headless = false;
  bool timespec = false;
  for (const auto& property : properties) {
    headless |= std::strcmp(property.extensionName, XR_MND_HEADLESS_EXTENSION_NAME) == 0;
    timespec |= std::strcmp(property.extensionName, XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME) == 0;
  }
  EXPECT_TRUE(headless);
  EXPECT_TRUE(timespec);
}

TEST_F(InstanceTest, NegotiationRejectsMismatchedStructures) {
  NegotiateLoaderInfo loader = Loader();
  NegotiateRuntimeRequest request = Request();
  ASSERT_EQ(xrNegotiateLoaderRuntimeInterface(&loader, &request), XR_SUCCESS);
  EXPECT_NE(request.get_instance_proc_addr, nullptr);
  EXPECT_EQ(request.runtime_api_version, XR_MAKE_VERSION(1, 1, 0));
  loader.struct_size = 8;
  EXPECT_EQ(xrNegotiateLoaderRuntimeInterface(&loader, &request), XR_ERROR_INITIALIZATION_FAILED);
  loader = Loader();
  loader.min_interface_version = loader.max_interface_version = 2;
  EXPECT_EQ(xrNegotiateLoaderRuntimeInterface(&loader, &request), XR_ERROR_INITIALIZATION_FAILED);
  loader = Loader();
  loader.min_api_version = XR_MAKE_VERSION(2, 0, 0);
  EXPECT_EQ(xrNegotiateLoaderRuntimeInterface(&loader, &request), XR_ERROR_INITIALIZATION_FAILED);
  EXPECT_EQ(xrNegotiateLoaderRuntimeInterface(nullptr, &request), XR_ERROR_INITIALIZATION_FAILED);
}

// Below the loader, which allows one instance at a time only.
TEST_F(InstanceTest, TwoInstancesDoNotShareHandlesOrAtoms) {
  NegotiateLoaderInfo loader = Loader();
  NegotiateRuntimeRequest request = Request();
  ASSERT_EQ(xrNegotiateLoaderRuntimeInterface(&loader, &request), XR_SUCCESS);
  const auto get = [&request](XrInstance instance, const char* name) {
    PFN_xrVoidFunction function = nullptr;
    EXPECT_EQ(request.get_instance_proc_addr(instance, name, &function), XR_SUCCESS) << name;
    return function;
  };
  const auto create = reinterpret_cast<PFN_xrCreateInstance>(get(XR_NULL_HANDLE, "xrCreateInstance"));
  auto info = Make<XrInstanceCreateInfo>(XR_TYPE_INSTANCE_CREATE_INFO);
  std::strcpy(info.applicationInfo.applicationName, "two");
  info.applicationInfo.apiVersion = XR_MAKE_VERSION(1, 0, 0);
  XrInstance a = XR_NULL_HANDLE;
  XrInstance b = XR_NULL_HANDLE;
  ASSERT_EQ(create(&info, &a), XR_SUCCESS);
  ASSERT_EQ(create(&info, &b), XR_SUCCESS);
  EXPECT_NE(a, b);
  const auto to_path = reinterpret_cast<PFN_xrStringToPath>(get(a, "xrStringToPath"));
  const auto to_text = reinterpret_cast<PFN_xrPathToString>(get(a, "xrPathToString"));
  XrPath path = XR_NULL_PATH;
  ASSERT_EQ(to_path(a, "/user/head", &path), XR_SUCCESS);
  ASSERT_EQ(to_path(b, "/user/head", &path), XR_SUCCESS);
  char text[64];
  uint32_t length = 0;
  EXPECT_EQ(to_text(b, path, sizeof(text), &length, text), XR_SUCCESS);
  EXPECT_STREQ(text, "/user/head");
  EXPECT_EQ(to_text(a, path, sizeof(text), &length, text), XR_ERROR_PATH_INVALID);
  const auto destroy = reinterpret_cast<PFN_xrDestroyInstance>(get(a, "xrDestroyInstance"));
  EXPECT_EQ(destroy(a), XR_SUCCESS);
  EXPECT_EQ(destroy(a), XR_ERROR_HANDLE_INVALID);
  EXPECT_EQ(to_path(a, "/user/head", &path), XR_ERROR_HANDLE_INVALID);
  EXPECT_EQ(destroy(b), XR_SUCCESS);
}

TEST_F(InstanceTest, ExtensionFunctionsNeedTheirExtension) {
  ASSERT_EQ(CreateInstance({XR_MND_HEADLESS_EXTENSION_NAME}), XR_SUCCESS);
  PFN_xrVoidFunction function = nullptr;
  EXPECT_EQ(xrGetInstanceProcAddr(instance_, "xrConvertTimespecTimeToTimeKHR", &function),
            XR_ERROR_FUNCTION_UNSUPPORTED);
  EXPECT_EQ(function, nullptr);
}

TEST_F(InstanceTest, TimeIsMonotonicPlusTheKnownOffset) {
  Start();
  timespec before{};
  clock_gettime(CLOCK_MONOTONIC, &before);
  const int64_t before_ns = int64_t{before.tv_sec} * 1'000'000'000 + before.tv_nsec;
  const XrTime now = Now();
  EXPECT_GE(now, before_ns + 1'000'000'000'000);
  EXPECT_LT(now, before_ns + 1'000'000'000'000 + 10'000'000'000);
  PFN_xrConvertTimeToTimespecTimeKHR back = nullptr;
  ASSERT_EQ(
      xrGetInstanceProcAddr(instance_, "xrConvertTimeToTimespecTimeKHR", reinterpret_cast<PFN_xrVoidFunction*>(&back)),
      XR_SUCCESS);
  timespec then{};
  ASSERT_EQ(back(instance_, 1'002'000'000'003, &then), XR_SUCCESS);
  EXPECT_EQ(then.tv_sec, 2);
  EXPECT_EQ(then.tv_nsec, 3);
  EXPECT_EQ(back(instance_, 0, &then), XR_ERROR_TIME_INVALID);
}

TEST_F(InstanceTest, ResultsAndStructureTypesHaveNames) {
  Start();
  char name[XR_MAX_RESULT_STRING_SIZE];
  EXPECT_EQ(xrResultToString(instance_, XR_ERROR_PATH_INVALID, name), XR_SUCCESS);
  EXPECT_STREQ(name, "XR_ERROR_PATH_INVALID");
  EXPECT_EQ(xrResultToString(instance_, static_cast<XrResult>(-123456), name), XR_SUCCESS);
  EXPECT_STREQ(name, "XR_UNKNOWN_FAILURE_-123456");
  EXPECT_EQ(xrResultToString(instance_, static_cast<XrResult>(123456), name), XR_SUCCESS);
  EXPECT_STREQ(name, "XR_UNKNOWN_SUCCESS_123456");
  EXPECT_EQ(xrStructureTypeToString(instance_, XR_TYPE_SPACE_LOCATION, name), XR_SUCCESS);
  EXPECT_STREQ(name, "XR_TYPE_SPACE_LOCATION");
}

TEST_F(InstanceTest, SystemIsOneStereoDisplay) {
  Start();
  auto get = Make<XrSystemGetInfo>(XR_TYPE_SYSTEM_GET_INFO);
  get.formFactor = XR_FORM_FACTOR_HANDHELD_DISPLAY;
  XrSystemId system = 7;
  EXPECT_EQ(xrGetSystem(instance_, &get, &system), XR_ERROR_FORM_FACTOR_UNSUPPORTED);
  get.formFactor = XR_FORM_FACTOR_MAX_ENUM;
  EXPECT_EQ(xrGetSystem(instance_, &get, &system), XR_ERROR_FORM_FACTOR_UNSUPPORTED);
  get.formFactor = XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY;
  ASSERT_EQ(xrGetSystem(instance_, &get, &system), XR_SUCCESS);
  auto properties = Make<XrSystemProperties>(XR_TYPE_SYSTEM_PROPERTIES);
  EXPECT_EQ(xrGetSystemProperties(instance_, system + 1, &properties), XR_ERROR_SYSTEM_INVALID);
  ASSERT_EQ(xrGetSystemProperties(instance_, system, &properties), XR_SUCCESS);
  EXPECT_STREQ(properties.systemName, "Omni test system");
  EXPECT_EQ(properties.trackingProperties.positionTracking, XR_TRUE);
  constexpr auto kStereo = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
  uint32_t count = 0;
  XrEnvironmentBlendMode modes[8];
  EXPECT_EQ(xrEnumerateEnvironmentBlendModes(instance_, system, kStereo, 1, &count, modes), XR_ERROR_SIZE_INSUFFICIENT);
  ASSERT_EQ(xrEnumerateEnvironmentBlendModes(instance_, system, kStereo, 8, &count, modes), XR_SUCCESS);
  EXPECT_EQ(count, 2U);
  EXPECT_EQ(modes[0], XR_ENVIRONMENT_BLEND_MODE_OPAQUE);
  std::vector<XrViewConfigurationView> views(2, Make<XrViewConfigurationView>(XR_TYPE_VIEW_CONFIGURATION_VIEW));
  ASSERT_EQ(xrEnumerateViewConfigurationViews(instance_, system, kStereo, 2, &count, views.data()), XR_SUCCESS);
  EXPECT_EQ(count, 2U);
  EXPECT_GT(views[1].recommendedImageRectWidth, 0U);
}

// 200 instances in a row leak no handles (TearDown counts those of the last).
TEST_F(InstanceTest, RepeatedInstancesLeakNoHandles) {
  for (int i = 0; i < 200; ++i) {
    Start();
    const XrAction pose = AddAction("pose", XR_ACTION_TYPE_POSE_INPUT, {"left"});
    ActionSpace(pose, "left");
    EXPECT_EQ(omni_test_live_handles(), 5U);
    DestroyInstance();
    ASSERT_EQ(omni_test_live_handles(), 0U);
  }
}

TEST_F(InstanceTest, LostInstanceSendsEventThenFailsCalls) {
  Start();
  ASSERT_EQ(omni_test_lose_instance(), 0);
  const auto events = Poll();
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].type, XR_TYPE_EVENT_DATA_INSTANCE_LOSS_PENDING);
  XrPath path = XR_NULL_PATH;
  EXPECT_EQ(xrStringToPath(instance_, "/user/head", &path), XR_ERROR_INSTANCE_LOST);
  EXPECT_EQ(Attach({set_}), XR_ERROR_INSTANCE_LOST);
}

}  // namespace test_instance
}  // namespace omni::runtime
