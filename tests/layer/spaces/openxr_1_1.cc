// An application of OpenXR 1.1: xrLocateSpaces by its core name, LOCAL_FLOOR. Debian's loader is of 1.0 and refuses it,
// so layer and runtime are put together here as a loader does.
#include <dlfcn.h>

#include <array>
#include <cstring>
#include <glm/geometric.hpp>

#include "layer/src/entry/loader_interface.h"
#include "tests/layer/spaces/fixture.h"
#include "tests/runtime/negotiation.h"

extern "C" XrResult xrNegotiateLoaderRuntimeInterface(const omni::runtime::NegotiateLoaderInfo* loader,
                                                      omni::runtime::NegotiateRuntimeRequest* request);

namespace omni::test {
namespace test_spaces_1_1 {

constexpr XrReferenceSpaceType kLocalFloorType = static_cast<XrReferenceSpaceType>(kReferenceSpaceTypeLocalFloor);

PFN_xrGetInstanceProcAddr RuntimeGet() {
  const runtime::NegotiateLoaderInfo loader{
      runtime::kLoaderInfoType,      runtime::kStructVersion,    sizeof(runtime::NegotiateLoaderInfo),
      runtime::kInterfaceVersion,    runtime::kInterfaceVersion, XR_MAKE_VERSION(1, 0, 0),
      XR_MAKE_VERSION(1, 1023, 4095)};
  runtime::NegotiateRuntimeRequest request{
      runtime::kRuntimeRequestType, runtime::kStructVersion, sizeof(runtime::NegotiateRuntimeRequest), 0, 0, nullptr};
  return XR_SUCCEEDED(xrNegotiateLoaderRuntimeInterface(&loader, &request)) ? request.get_instance_proc_addr : nullptr;
}

// The end of a loader's chain.
XrResult CreateInRuntime(const XrInstanceCreateInfo* info, const XrApiLayerCreateInfo*, XrInstance* instance) {
  PFN_xrVoidFunction create = nullptr;
  const XrResult found = RuntimeGet()(XR_NULL_HANDLE, "xrCreateInstance", &create);
  return XR_FAILED(found) ? found : reinterpret_cast<PFN_xrCreateInstance>(create)(info, instance);
}

class Spaces11 : public testing::Test {
 protected:
  void SetUp() override {
    omni_test_reset();
    library_ = dlopen(OMNI_BINARY_DIR "/lib/libXrApiLayer_omni.so", RTLD_NOW | RTLD_LOCAL);
    ASSERT_NE(library_, nullptr) << dlerror();
    const auto negotiate =
        reinterpret_cast<XrResult (*)(const XrNegotiateLoaderInfo*, const char*, XrNegotiateApiLayerRequest*)>(
            dlsym(library_, "xrNegotiateLoaderApiLayerInterface"));
    ASSERT_NE(negotiate, nullptr);
    const XrNegotiateLoaderInfo loader{XR_LOADER_INTERFACE_STRUCT_LOADER_INFO,
                                       kLoaderInfoVersion,
                                       sizeof(XrNegotiateLoaderInfo),
                                       1,
                                       1,
                                       XR_MAKE_VERSION(1, 0, 0),
                                       XR_MAKE_VERSION(1, 1023, 4095)};
    XrNegotiateApiLayerRequest request{XR_LOADER_INTERFACE_STRUCT_API_LAYER_REQUEST,
                                       kApiLayerRequestVersion,
                                       sizeof(XrNegotiateApiLayerRequest),
                                       0,
                                       0,
                                       nullptr,
                                       nullptr};
    ASSERT_EQ(negotiate(&loader, kLayer, &request), XR_SUCCESS);
    get_ = request.getInstanceProcAddr;
    Create(request);
  }
  void TearDown() override {
    if (instance_ != XR_NULL_HANDLE) {
      EXPECT_EQ(Get<PFN_xrDestroyInstance>("xrDestroyInstance")(instance_), XR_SUCCESS);
    }
    if (library_) dlclose(library_);
  }

  void Create(const XrNegotiateApiLayerRequest& layer_request) {
    XrApiLayerNextInfo next{XR_LOADER_INTERFACE_STRUCT_API_LAYER_NEXT_INFO,
                            kApiLayerNextInfoVersion,
                            sizeof(XrApiLayerNextInfo),
                            {},
                            RuntimeGet(),
                            &CreateInRuntime,
                            nullptr};
    std::strcpy(next.layerName, kLayer);
    XrApiLayerCreateInfo below{XR_LOADER_INTERFACE_STRUCT_API_LAYER_CREATE_INFO,
                               kApiLayerCreateInfoVersion,
                               sizeof(XrApiLayerCreateInfo),
                               nullptr,
                               {},
                               &next};
    const char* const headless = "XR_MND_headless";
    XrInstanceCreateInfo info{XR_TYPE_INSTANCE_CREATE_INFO};
    std::strcpy(info.applicationInfo.applicationName, "1.1 test");
    info.applicationInfo.apiVersion = XR_MAKE_VERSION(1, 1, 0);
    info.enabledExtensionCount = 1;
    info.enabledExtensionNames = &headless;
    ASSERT_EQ(layer_request.createApiLayerInstance(&info, &below, &instance_), XR_SUCCESS);
    const XrSessionCreateInfo session_info{XR_TYPE_SESSION_CREATE_INFO, nullptr, 0, 1};
    ASSERT_EQ(Get<PFN_xrCreateSession>("xrCreateSession")(instance_, &session_info, &session_), XR_SUCCESS);
  }

  template <class Function>
  Function Get(const char* name) {
    PFN_xrVoidFunction found = nullptr;
    EXPECT_EQ(get_(instance_, name, &found), XR_SUCCESS) << name;
    return reinterpret_cast<Function>(found);
  }
  XrSpace Reference(XrReferenceSpaceType type) {
    const XrReferenceSpaceCreateInfo info{
        XR_TYPE_REFERENCE_SPACE_CREATE_INFO, nullptr, type, {{0, 0, 0, 1}, {0, 0, 0}}};
    XrSpace made = XR_NULL_HANDLE;
    EXPECT_EQ(Get<PFN_xrCreateReferenceSpace>("xrCreateReferenceSpace")(session_, &info, &made), XR_SUCCESS);
    return made;
  }
  XrPath Path(const char* text) {
    XrPath path = XR_NULL_PATH;
    EXPECT_EQ(Get<PFN_xrStringToPath>("xrStringToPath")(instance_, text, &path), XR_SUCCESS);
    return path;
  }

  // A pose action on the right hand's grip_surface, attached; the session focused.
  void Bind() {
    XrActionSetCreateInfo set_info{XR_TYPE_ACTION_SET_CREATE_INFO};
    std::strcpy(set_info.actionSetName, "set");
    std::strcpy(set_info.localizedActionSetName, "Set");
    ASSERT_EQ(Get<PFN_xrCreateActionSet>("xrCreateActionSet")(instance_, &set_info, &set_), XR_SUCCESS);
    XrActionCreateInfo info{XR_TYPE_ACTION_CREATE_INFO};
    std::strcpy(info.actionName, "pose");
    std::strcpy(info.localizedActionName, "Pose");
    info.actionType = XR_ACTION_TYPE_POSE_INPUT;
    ASSERT_EQ(Get<PFN_xrCreateAction>("xrCreateAction")(set_, &info, &pose_), XR_SUCCESS);
    const XrActionSuggestedBinding binding{pose_, Path("/user/hand/right/input/aim/pose")};
    const XrInteractionProfileSuggestedBinding suggested{XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING, nullptr,
                                                         Path(kTouch), 1, &binding};
    ASSERT_EQ(
        Get<PFN_xrSuggestInteractionProfileBindings>("xrSuggestInteractionProfileBindings")(instance_, &suggested),
        XR_SUCCESS);
    const XrSessionActionSetsAttachInfo attach{XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO, nullptr, 1, &set_};
    ASSERT_EQ(Get<PFN_xrAttachSessionActionSets>("xrAttachSessionActionSets")(session_, &attach), XR_SUCCESS);
    const auto poll = Get<PFN_xrPollEvent>("xrPollEvent");
    const XrSessionBeginInfo begin{XR_TYPE_SESSION_BEGIN_INFO, nullptr, XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO};
    const auto poll_times = [&](int times) {
      for (int i = 0; i < times; ++i) {
        XrEventDataBuffer event{XR_TYPE_EVENT_DATA_BUFFER};
        poll(instance_, &event);
      }
    };
    poll_times(3);
    ASSERT_EQ(Get<PFN_xrBeginSession>("xrBeginSession")(session_, &begin), XR_SUCCESS);
    poll_times(6);
  }
  XrResult Sync() {
    const XrActiveActionSet active{set_, XR_NULL_PATH};
    const XrActionsSyncInfo info{XR_TYPE_ACTIONS_SYNC_INFO, nullptr, 1, &active};
    return Get<PFN_xrSyncActions>("xrSyncActions")(session_, &info);
  }

  FakeService service_;
  void* library_ = nullptr;
  PFN_xrGetInstanceProcAddr get_ = nullptr;
  XrInstance instance_ = XR_NULL_HANDLE;
  XrSession session_ = XR_NULL_HANDLE;
  XrActionSet set_ = XR_NULL_HANDLE;
  XrAction pose_ = XR_NULL_HANDLE;
};

TEST_F(Spaces11, LocateSpacesFindsThePenInLocalFloor) {
  service_.SetTrajectory([](protocol::ToolSample& sample) { sample.position_base_m = {0.01, 0.02, 0.07}; });
  Bind();
  const XrActionSpaceCreateInfo info{
      XR_TYPE_ACTION_SPACE_CREATE_INFO, nullptr, pose_, XR_NULL_PATH, {{0, 0, 0, 1}, {0, 0, 0}}};
  XrSpace pen = XR_NULL_HANDLE;
  ASSERT_EQ(Get<PFN_xrCreateActionSpace>("xrCreateActionSpace")(session_, &info, &pen), XR_SUCCESS);
  const std::array spaces{pen, Reference(XR_REFERENCE_SPACE_TYPE_LOCAL)};
  const auto locate = Get<PFN_xrLocateSpaces>("xrLocateSpaces");
  std::array<XrSpaceLocationData, 2> location{};
  for (int i = 0; i < 200 && location[0].locationFlags != kSeen; ++i) {
    service_.Fill();
    ASSERT_EQ(Sync(), XR_SUCCESS);
    const XrSpacesLocateInfo question{XR_TYPE_SPACES_LOCATE_INFO, nullptr,       Reference(kLocalFloorType),
                                      ToXrTime(Now_ns()),         spaces.size(), spaces.data()};
    XrSpaceLocations answer{XR_TYPE_SPACE_LOCATIONS, nullptr, 2, location.data()};
    ASSERT_EQ(locate(session_, &question, &answer), XR_SUCCESS);
    const timespec pause{0, 5'000'000};
    nanosleep(&pause, nullptr);
  }
  ASSERT_EQ(location[0].locationFlags, kSeen);
  // LOCAL is 1.6 m above the floor; the base 0.35 m below it and 0.45 m ahead, its z up, its y away.
  const glm::dvec3 tip = layer::FromXr(location[0].pose.position);
  EXPECT_LT(glm::length(tip - glm::dvec3(0.01, 1.6 - 0.35 + 0.07, -0.45 - 0.02)), 1e-5);
  EXPECT_NEAR(location[1].pose.position.y, 1.6f, 1e-5f);
}

// The extension's name is for those who enabled it.
TEST_F(Spaces11, ExtensionFunctionNamesNeedTheExtension) {
  PFN_xrVoidFunction found = nullptr;
  EXPECT_EQ(get_(instance_, "xrLocateSpacesKHR", &found), XR_ERROR_FUNCTION_UNSUPPORTED);
  EXPECT_EQ(get_(instance_, "xrLocateHandJointsEXT", &found), XR_ERROR_FUNCTION_UNSUPPORTED);
}

}  // namespace test_spaces_1_1
}  // namespace omni::test
