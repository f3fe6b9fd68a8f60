// The layer without Debian's loader (mini_loader): negotiation, versions, several instances at once, leaks of destroyed
// instances.
#include <gtest/gtest.h>
#include <malloc.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "service/base/sanitized.h"
#include "tests/layer/mini_loader/chain_app.h"
#include "tests/layer/support/app.h"

namespace omni::test {
namespace test_chain {

class Chain : public testing::Test {
 protected:
  void SetUp() override { omni_test_reset(); }
};

std::ptrdiff_t Entries(const char* folder) {
  const std::filesystem::directory_iterator entries(folder);
  return std::distance(begin(entries), end(entries));
}

bool Mapped(const std::string& library) {
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);)
    if (line.find(library) != std::string::npos) return true;
  return false;
}

// [loader: API Layer Conventions and Rules]
TEST_F(Chain, EnumeratesOnlyItselfAndItsExtensions) {
  const MiniLoader loader({OmniLayer()});
  const auto layers =
      reinterpret_cast<PFN_xrEnumerateApiLayerProperties>(loader.Get(XR_NULL_HANDLE, "xrEnumerateApiLayerProperties"));
  const auto extensions = reinterpret_cast<PFN_xrEnumerateInstanceExtensionProperties>(
      loader.Get(XR_NULL_HANDLE, "xrEnumerateInstanceExtensionProperties"));
  ASSERT_TRUE(layers && extensions);
  std::uint32_t count = 0;
  ASSERT_EQ(layers(0, &count, nullptr), XR_SUCCESS);
  ASSERT_EQ(count, 1u);
  XrApiLayerProperties properties{XR_TYPE_API_LAYER_PROPERTIES, nullptr, "", 0, 0, ""};
  ASSERT_EQ(layers(1, &count, &properties), XR_SUCCESS);
  EXPECT_STREQ(properties.layerName, kLayer);
  EXPECT_EQ(layers(1, nullptr, &properties), XR_ERROR_VALIDATION_FAILURE);
  ASSERT_EQ(extensions(nullptr, 0, &count, nullptr), XR_SUCCESS);
  EXPECT_EQ(count, 0u) << "an explicit layer lists nothing where no layer is named";
  EXPECT_EQ(extensions("XR_APILAYER_nobody", 0, &count, nullptr), XR_ERROR_API_LAYER_NOT_PRESENT);
  ASSERT_EQ(extensions(kLayer, 0, &count, nullptr), XR_SUCCESS);
  ASSERT_GE(count, 1u);
  std::vector<XrExtensionProperties> list(count, {XR_TYPE_EXTENSION_PROPERTIES, nullptr, "", 0});
  ASSERT_EQ(extensions(kLayer, count, &count, list.data()), XR_SUCCESS);
  for (const XrExtensionProperties& extension : list) EXPECT_GT(std::strlen(extension.extensionName), 3u);
}

TEST_F(Chain, DoesNotExposeCreateInstanceOrUnknownFunctions) {
  const MiniLoader loader({OmniLayer()});
  EXPECT_FALSE(loader.Get(XR_NULL_HANDLE, "xrCreateInstance"));
  EXPECT_FALSE(loader.Get(XR_NULL_HANDLE, "xrNothing"));
  const ChainApp app(loader);
  EXPECT_FALSE(loader.Get(app.instance, "xrNothing"));
}

// [loader: negotiation] no compile-time gate: any application version works.
TEST_F(Chain, WorksForApplicationsOfOpenXR10And11) {
  const MiniLoader loader({OmniLayer()});
  for (const XrVersion version : {XR_MAKE_VERSION(1, 0, 0), XR_MAKE_VERSION(1, 0, 20), XR_MAKE_VERSION(1, 0, 34),
                                  XR_MAKE_VERSION(1, 1, 0), XR_MAKE_VERSION(1, 1, 46)}) {
    FakeService service;
    ChainOptions options;
    options.api_version = version;
    const ChainApp app(loader, options);
    ASSERT_TRUE(app.WaitProfile(service, kTouch)) << XR_VERSION_MINOR(version) << '.' << XR_VERSION_PATCH(version);
    service.Set(protocol::InputIndex::kTipForce, 0.25f);
    service.Fill();
    ASSERT_EQ(app.Sync(), XR_SUCCESS);
    EXPECT_FLOAT_EQ(app.Force(app.right), 0.25f);
    const XrSpaceLocation located = app.Locate(app.ActionSpace(app.right), app.Local(), Now_ns() + kRuntimeOffset_ns);
    EXPECT_NE(located.locationFlags & XR_SPACE_LOCATION_POSITION_TRACKED_BIT, 0u);
  }
}

// Two applications at once: paths, handles, states and profiles do not mix.
TEST_F(Chain, TwoInstancesDoNotShareState) {
  const MiniLoader loader({OmniLayer()});
  FakeService service;
  ChainOptions idle;
  idle.begin = false;
  const ChainApp first(loader, idle);
  const ChainApp second(loader);
  ASSERT_TRUE(second.WaitProfile(service, kTouch));
  service.Set(protocol::InputIndex::kTipForce, 0.75f);
  service.Fill();
  ASSERT_EQ(second.Sync(), XR_SUCCESS);
  EXPECT_FLOAT_EQ(second.Force(second.right), 0.75f);
  EXPECT_EQ(second.Profile(second.right), kTouch);
  XrInteractionProfileState state{XR_TYPE_INTERACTION_PROFILE_STATE, nullptr, XR_NULL_PATH};
  EXPECT_EQ(first.f.GetCurrentInteractionProfile(first.session, first.right, &state), XR_ERROR_ACTIONSET_NOT_ATTACHED);
  EXPECT_EQ(first.Suggest(kTouch, {{first.force, first.Path("/user/hand/right/input/trigger/value")}}), XR_SUCCESS)
      << "nothing of the first is attached";
  EXPECT_TRUE(XR_FAILED(first.Suggest(kTouch, {{second.force, first.Path("/user/hand/right/input/trigger/value")}})))
      << "an action of the other instance";
  EXPECT_TRUE(Eventually([&] { return service.heard().applications.size() == 2; })) << "one connection each";
}

// 200 instances with a session, some with the pen: no memory, descriptor or thread is leaked.
TEST_F(Chain, TwoHundredInstancesLeakNothing) {
  const MiniLoader loader({OmniLayer()});
  FakeService service;
  const auto cycle = [&](bool with_pen) {
    const ChainApp app(loader);
    app.ActionSpace(app.right);
    if (with_pen)
      EXPECT_TRUE(app.WaitProfile(service, kTouch));
    else
      EXPECT_EQ(app.Sync(), XR_SUCCESS);
  };
  for (int i = 0; i < 20; ++i) cycle(i < 2);
  const auto clients_gone = [&] {
    return service.heard().gone == static_cast<int>(service.heard().applications.size());
  };
  ASSERT_TRUE(Eventually(clients_gone));
  const auto files = Entries("/proc/self/fd");
  const auto threads = Entries("/proc/self/task");
  const std::size_t heap = mallinfo2().uordblks;
  for (int i = 0; i < 200; ++i) cycle(i % 20 == 0);
  ASSERT_TRUE(Eventually(clients_gone));
  EXPECT_EQ(omni_test_live_handles(), 0u);
  EXPECT_TRUE(Eventually([&] { return Entries("/proc/self/fd") <= files; }));
  EXPECT_EQ(Entries("/proc/self/task"), threads);
  if (base::kSanitized) return;  // it has a heap of its own
  // The service of this test keeps a name and a state of each client; an instance of ours is 100 kB and more.
  const std::size_t now = mallinfo2().uordblks;
  EXPECT_LT(now, heap + std::size_t{200} * 1024) << "grew by " << now - heap << " bytes";
}

// The loader closes a layer with the instance: nothing may hold it, and the next opening starts from scratch.
TEST_F(Chain, LibraryIsUnloadedWithTheInstance) {
  const std::string library = std::filesystem::path(OmniLayer().library).filename();
  if (Mapped(library)) GTEST_SKIP() << "Debian's loader has left it open: run this test in a process of its own";
  for (int i = 0; i < 5; ++i) {
    FakeService service;
    const MiniLoader loader({OmniLayer()});
    EXPECT_TRUE(Mapped(library));
    const ChainApp app(loader);
    EXPECT_TRUE(app.WaitProfile(service, kTouch));
  }
  if (base::kSanitized) return;  // which keeps it for its own reports
  EXPECT_FALSE(Mapped(library)) << "something of it cannot be unloaded";
}

// A wrong name in the negotiation and an unknown extension are rejected.
TEST_F(Chain, RejectsWrongLayerNameAndUnknownExtension) {
  const MiniLoader loader({OmniLayer()});
  const LayerFile misnamed{"XR_APILAYER_another", OmniLayer().library};
  EXPECT_THROW(MiniLoader another({misnamed}), std::runtime_error);
  XrInstance instance = XR_NULL_HANDLE;
  const char* unknown = "XR_NOBODY_has_this";
  ChainOptions options;
  options.extensions = {unknown};
  EXPECT_EQ(loader.CreateInstance(InstanceInfo(options), &instance), XR_ERROR_EXTENSION_NOT_PRESENT);
}

// Calls that a loader would reject reach the layer.
TEST_F(Chain, NullUnknownAndDestroyedHandlesAreInvalid) {
  const MiniLoader loader({OmniLayer()});
  ChainApp app(loader);
  const auto bogus = reinterpret_cast<XrInstance>(std::uint64_t{0x1234});
  XrEventDataBuffer event{XR_TYPE_EVENT_DATA_BUFFER, nullptr, {}};
  EXPECT_EQ(app.f.PollEvent(XR_NULL_HANDLE, &event), XR_ERROR_HANDLE_INVALID);
  EXPECT_EQ(app.f.PollEvent(bogus, &event), XR_ERROR_HANDLE_INVALID);
  EXPECT_EQ(app.f.DestroyInstance(bogus), XR_ERROR_HANDLE_INVALID);
  EXPECT_EQ(app.f.DestroySession(XR_NULL_HANDLE), XR_ERROR_HANDLE_INVALID);
  EXPECT_EQ(app.f.SyncActions(app.session, nullptr), XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(app.f.DestroySpace(reinterpret_cast<XrSpace>(app.session)), XR_ERROR_HANDLE_INVALID);
  ASSERT_EQ(app.f.DestroyInstance(app.instance), XR_SUCCESS);
  EXPECT_EQ(app.f.DestroyInstance(app.instance), XR_ERROR_HANDLE_INVALID) << "twice";
  EXPECT_EQ(app.f.DestroySession(app.session), XR_ERROR_HANDLE_INVALID) << "after its instance";
  app.instance = XR_NULL_HANDLE;
}

// Another layer that makes a dummy instance inside its own creation, above and below ours.
class OtherLayers : public testing::Test {
 protected:
  void SetUp() override { omni_test_reset(); }
  void TearDown() override { unsetenv("OMNI_OTHER_LAYER"); }

  static void Run(const std::vector<LayerFile>& layers) {
    const MiniLoader loader(layers);
    for (int life = 0; life < 3; ++life) {
      FakeService service;
      const ChainApp app(loader);
      ASSERT_TRUE(app.WaitProfile(service, kTouch));
      service.Set(protocol::InputIndex::kTipForce, 0.5f);
      service.Fill();
      ASSERT_EQ(app.Sync(), XR_SUCCESS);
      EXPECT_FLOAT_EQ(app.Force(app.right), 0.5f);
    }
    EXPECT_EQ(omni_test_live_handles(), 0u);
  }
  static void BothOrders() {
    Run({OtherLayer(), OmniLayer()});
    Run({OmniLayer(), OtherLayer()});
  }
};

TEST_F(OtherLayers, WorksAboveAndBelowLayerWithDummyInstance) { BothOrders(); }

TEST_F(OtherLayers, WorksWhenOtherLayerKeepsItsDummyInstance) {
  setenv("OMNI_OTHER_LAYER", "keep", 1);
  Run({OtherLayer(), OmniLayer()});
  Run({OmniLayer(), OtherLayer()});
}

}  // namespace test_chain
}  // namespace omni::test
