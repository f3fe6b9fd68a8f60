// An instance of OpenXR 1.1. Debian's loader is of 1.0 and creates none, so this calls the runtime directly.

#include <algorithm>
#include <array>
#include <cstring>

#include "tests/runtime/cases/fixture.h"
#include "tests/runtime/negotiation.h"
#include "tests/runtime/newer_openxr.h"

extern "C" XrResult xrNegotiateLoaderRuntimeInterface(const omni::runtime::NegotiateLoaderInfo* loader,
                                                      omni::runtime::NegotiateRuntimeRequest* request);

namespace omni::runtime {
namespace test_version_1_1 {

class Version11Test : public RuntimeTest {
 protected:
  void SetUp() override {
    RuntimeTest::SetUp();
    const NegotiateLoaderInfo loader{
        kLoaderInfoType,   kStructVersion,           sizeof(NegotiateLoaderInfo),   kInterfaceVersion,
        kInterfaceVersion, XR_MAKE_VERSION(1, 0, 0), XR_MAKE_VERSION(1, 1023, 4095)};
    NegotiateRuntimeRequest request{
        kRuntimeRequestType, kStructVersion, sizeof(NegotiateRuntimeRequest), 0, 0, nullptr};
    ASSERT_EQ(xrNegotiateLoaderRuntimeInterface(&loader, &request), XR_SUCCESS);
    EXPECT_EQ(XR_VERSION_MINOR(request.runtime_api_version), 1);
    get_ = request.get_instance_proc_addr;
  }
  void TearDown() override {
    if (made_ != XR_NULL_HANDLE) {
      EXPECT_EQ(Get<PFN_xrDestroyInstance>("xrDestroyInstance")(made_), XR_SUCCESS);
    }
    RuntimeTest::TearDown();
  }

  template <class Function>
  Function Get(const char* name) {
    PFN_xrVoidFunction found = nullptr;
    EXPECT_EQ(get_(made_, name, &found), XR_SUCCESS) << name;
    return reinterpret_cast<Function>(found);
  }

  XrResult Make11(XrVersion version) {
    const char* const headless = XR_MND_HEADLESS_EXTENSION_NAME;
    auto info = Make<XrInstanceCreateInfo>(XR_TYPE_INSTANCE_CREATE_INFO);
    std::strcpy(info.applicationInfo.applicationName, "version test");
    info.applicationInfo.apiVersion = version;
    info.enabledExtensionCount = 1;
    info.enabledExtensionNames = &headless;
    return Get<PFN_xrCreateInstance>("xrCreateInstance")(&info, &made_);
  }

  PFN_xrGetInstanceProcAddr get_ = nullptr;
  XrInstance made_ = XR_NULL_HANDLE;
};

TEST_F(Version11Test, RejectsNewerMinorVersions) {
  EXPECT_EQ(Make11(XR_MAKE_VERSION(1, 2, 0)), XR_ERROR_API_VERSION_UNSUPPORTED);
  EXPECT_EQ(Make11(XR_MAKE_VERSION(2, 0, 0)), XR_ERROR_API_VERSION_UNSUPPORTED);
  EXPECT_EQ(Make11(XR_MAKE_VERSION(1, 1, 60)), XR_SUCCESS);
}

TEST_F(Version11Test, HasLocateSpacesAndLocalFloor) {
  ASSERT_EQ(Make11(XR_MAKE_VERSION(1, 1, 0)), XR_SUCCESS);
  auto create = Make<XrSessionCreateInfo>(XR_TYPE_SESSION_CREATE_INFO);
  create.systemId = 1;
  XrSession session = XR_NULL_HANDLE;
  ASSERT_EQ(Get<PFN_xrCreateSession>("xrCreateSession")(made_, &create, &session), XR_SUCCESS);
  std::array<XrReferenceSpaceType, 8> types{};
  uint32_t count = 0;
  ASSERT_EQ(Get<PFN_xrEnumerateReferenceSpaces>("xrEnumerateReferenceSpaces")(session, 8, &count, types.data()),
            XR_SUCCESS);
  ASSERT_NE(std::find(types.begin(), types.begin() + count, kLocalFloor), types.begin() + count);
  std::array<XrSpace, 2> spaces{};
  const XrReferenceSpaceType wanted[] = {XR_REFERENCE_SPACE_TYPE_LOCAL, kLocalFloor};
  for (size_t i = 0; i < 2; ++i) {
    const XrReferenceSpaceCreateInfo info{XR_TYPE_REFERENCE_SPACE_CREATE_INFO, nullptr, wanted[i], kHere};
    ASSERT_EQ(Get<PFN_xrCreateReferenceSpace>("xrCreateReferenceSpace")(session, &info, &spaces[i]), XR_SUCCESS);
  }
  const XrSpacesLocateInfo info{XR_TYPE_SPACES_LOCATE_INFO, nullptr, spaces[1], 1, 1, spaces.data()};
  XrSpaceLocationData local{};
  XrSpaceLocations out{XR_TYPE_SPACE_LOCATIONS, nullptr, 1, &local};
  ASSERT_EQ(Get<PFN_xrLocateSpaces>("xrLocateSpaces")(session, &info, &out), XR_SUCCESS);
  EXPECT_NEAR(local.pose.position.y, 1.6f, 1e-6f) << "LOCAL is at the eyes, LOCAL_FLOOR below it on the floor";
}

}  // namespace test_version_1_1
}  // namespace omni::runtime
