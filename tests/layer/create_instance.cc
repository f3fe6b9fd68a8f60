// xrCreateInstance with an error in its arguments: the result is the same with the layer as without.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <string>
#include <vector>

#include "tests/layer/mini_loader/mini_loader.h"
#include "tests/layer/support/app.h"

namespace omni::test {
namespace test_create_instance {

// An application's structure, and what it points to.
struct CreateInfo {
  XrInstanceCreateInfo info{XR_TYPE_INSTANCE_CREATE_INFO};
  std::vector<const char*> extensions{"XR_MND_headless"};
  XrBaseInStructure chained{static_cast<XrStructureType>(0x7FFFFF00), nullptr};

  CreateInfo() {
    std::strcpy(info.applicationInfo.applicationName, "layer test");
    info.applicationInfo.apiVersion = XR_MAKE_VERSION(1, 0, 20);
    UseExtensions();
  }
  CreateInfo(const CreateInfo&) = delete;
  CreateInfo& operator=(const CreateInfo&) = delete;

  void UseExtensions() {
    info.enabledExtensionCount = static_cast<std::uint32_t>(extensions.size());
    info.enabledExtensionNames = extensions.data();
  }
};

struct Mistake {
  const char* what;
  std::function<void(CreateInfo&)> make;
};

Mistake Type(const char* what, XrStructureType type) {
  return {what, [type](CreateInfo& create) { create.info.type = type; }};
}

Mistake Version(const char* what, XrVersion version) {
  return {what, [version](CreateInfo& create) { create.info.applicationInfo.apiVersion = version; }};
}

Mistake Extensions(const char* what, const std::vector<const char*>& names) {
  return {what, [names](CreateInfo& create) {
            create.extensions = names;
            create.UseExtensions();
          }};
}

template <std::size_t N>
void FillUp(char (&text)[N]) {
  std::memset(text, 'x', N);
}

const std::vector<Mistake>& Mistakes() {
  static const std::vector<Mistake> all{
      {"none", [](CreateInfo&) {}},
      Type("no type", XR_TYPE_UNKNOWN),
      Type("another structure's type", XR_TYPE_SESSION_CREATE_INFO),
      Type("an unknown type", XR_STRUCTURE_TYPE_MAX_ENUM),
      {"an unknown structure in the chain", [](CreateInfo& create) { create.info.next = &create.chained; }},
      {"a structure of another call in the chain",
       [](CreateInfo& create) {
         create.chained.type = XR_TYPE_SESSION_CREATE_INFO;
         create.info.next = &create.chained;
       }},
      {"unknown flags", [](CreateInfo& create) { create.info.createFlags = 1; }},
      Version("no version", 0),
      Version("0.90", XR_MAKE_VERSION(0, 90, 0)),
      Version("2.0", XR_MAKE_VERSION(2, 0, 0)),
      Version("the greatest version", ~XrVersion{0}),
      {"no application name", [](CreateInfo& create) { create.info.applicationInfo.applicationName[0] = '\0'; }},
      {"an application name without an end",
       [](CreateInfo& create) { FillUp(create.info.applicationInfo.applicationName); }},
      {"an engine name without an end", [](CreateInfo& create) { FillUp(create.info.applicationInfo.engineName); }},
      {"a name that is no UTF-8",
       [](CreateInfo& create) { std::strcpy(create.info.applicationInfo.applicationName, "\xFF\xFE"); }},
      Extensions("an unknown extension", {"XR_NOBODY_has_this"}),
      Extensions("an extension without a name", {""}),
      Extensions("an extension twice", {"XR_MND_headless", "XR_MND_headless"}),
      {"a wrong type and an unknown extension",
       [](CreateInfo& create) {
         create.info.type = XR_TYPE_UNKNOWN;
         create.extensions = {"XR_NOBODY_has_this"};
         create.UseExtensions();
       }},
  };
  return all;
}

// What Debian's loader rejects itself, or crashes on: only a mini_loader passes these on.
const std::vector<Mistake>& MistakesThatALoaderStops() {
  static const std::vector<Mistake> all{
      Version("1.1", XR_MAKE_VERSION(1, 1, 0)),
      Version("1.99", XR_MAKE_VERSION(1, 99, 0)),
      {"a null list of extensions", [](CreateInfo& create) { create.info.enabledExtensionNames = nullptr; }},
      Extensions("a null extension", {"XR_MND_headless", nullptr}),
      {"a wrong type and a null list of extensions",
       [](CreateInfo& create) {
         create.info.type = XR_TYPE_UNKNOWN;
         create.info.enabledExtensionNames = nullptr;
       }},
  };
  return all;
}

using Create = std::function<XrResult(const XrInstanceCreateInfo& info)>;

XrResult ResultOf(const Mistake& mistake, const Create& create) {
  omni_test_reset();
  CreateInfo given;
  mistake.make(given);
  return create(given.info);
}

int ExpectSameResults(const std::vector<Mistake>& mistakes, const Create& alone, const Create& layered) {
  int different = 0;
  for (const Mistake& mistake : mistakes) {
    const XrResult expected = ResultOf(mistake, alone);
    const XrResult result = ResultOf(mistake, layered);
    EXPECT_EQ(result, expected) << mistake.what;
    different += result != expected;
  }
  return different;
}

XrResult CreateByLoader(XrInstanceCreateInfo info, bool layer) {
  info.enabledApiLayerCount = layer ? 1 : 0;
  info.enabledApiLayerNames = &kLayer;
  XrInstance instance = XR_NULL_HANDLE;
  const XrResult result = xrCreateInstance(&info, &instance);
  if (XR_SUCCEEDED(result)) xrDestroyInstance(instance);
  return result;
}

XrResult CreateByMiniLoader(const MiniLoader& loader, const XrInstanceCreateInfo& info) {
  XrInstance instance = XR_NULL_HANDLE;
  const XrResult result = loader.CreateInstance(info, &instance);
  if (XR_SUCCEEDED(result)) {
    reinterpret_cast<PFN_xrDestroyInstance>(loader.Get(instance, "xrDestroyInstance"))(instance);
  }
  return result;
}

TEST(CreateInstance, InvalidInfoFailsAsWithoutTheLayer) {
  const int different = ExpectSameResults(
      Mistakes(), [](const XrInstanceCreateInfo& info) { return CreateByLoader(info, false); },
      [](const XrInstanceCreateInfo& info) { return CreateByLoader(info, true); });
  std::printf("[ figure   ] %d of %zu results are not those of loader and runtime\n", different, Mistakes().size());
  CreateInfo wrong_type;
  wrong_type.info.type = XR_TYPE_UNKNOWN;
  EXPECT_EQ(CreateByLoader(wrong_type.info, true), XR_ERROR_VALIDATION_FAILURE);
}

TEST(CreateInstance, InvalidInfoPastTheLoaderFailsAsWithoutTheLayer) {
  const MiniLoader alone({}), layered({OmniLayer()});
  const auto bare = [&](const XrInstanceCreateInfo& info) { return CreateByMiniLoader(alone, info); };
  const auto with_layer = [&](const XrInstanceCreateInfo& info) { return CreateByMiniLoader(layered, info); };
  ExpectSameResults(Mistakes(), bare, with_layer);
  ExpectSameResults(MistakesThatALoaderStops(), bare, with_layer);
  const CreateInfo good;
  EXPECT_EQ(layered.CreateInstance(good.info, nullptr), alone.CreateInstance(good.info, nullptr));
}

// An error that fewer extensions cannot help is returned at once: the runtime complains as often as without the layer.
TEST(CreateInstance, RuntimesRefusalIsReturnedAtOnce) {
  constexpr XrResult kRefusals[] = {XR_ERROR_RUNTIME_UNAVAILABLE, XR_ERROR_RUNTIME_FAILURE, XR_ERROR_OUT_OF_MEMORY,
                                    XR_ERROR_LIMIT_REACHED, XR_ERROR_INITIALIZATION_FAILED};
  const std::vector<const char*> shared{"XR_MND_headless", "XR_LOGITECH_mx_ink_stylus_interaction",
                                        "XR_KHR_generic_controller", "XR_FB_haptic_amplitude_envelope",
                                        "XR_FB_haptic_pcm"};
  long most = 0;
  for (const XrResult refusal : kRefusals) {
    omni_test_reset();
    CreateInfo given;
    given.extensions = shared;
    given.UseExtensions();
    omni_test_refuse_instances(refusal);
    const long before = omni_test_call_count("xrCreateInstance");
    EXPECT_EQ(CreateByLoader(given.info, true), refusal);
    const long tries = omni_test_call_count("xrCreateInstance") - before;
    EXPECT_EQ(tries, 1) << refusal;
    most = std::max(most, tries);
  }
  omni_test_reset();
  std::printf("[ figure   ] at most %ld tries for a runtime that refuses\n", most);
}

// What a runtime lacks is known from its list; without a list it is found in a linear number of tries.
TEST(CreateInstance, MissingExtensionsTakeFewTries) {
  struct Case {
    const char* without;
    std::vector<const char*> extensions;
    XrResult result;
    long most_tries;
  };
  const std::vector<const char*> four{"XR_LOGITECH_mx_ink_stylus_interaction", "XR_KHR_generic_controller",
                                      "XR_FB_haptic_amplitude_envelope", "XR_FB_haptic_pcm"};
  const std::vector<const char*> unknown{"XR_KHR_generic_controller", "XR_NOBODY_has_this"};
  const Case cases[] = {{"", {}, XR_SUCCESS, 1},
                        {"", four, XR_SUCCESS, 1},
                        {XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME, four, XR_SUCCESS, 1},
                        {"", unknown, XR_ERROR_EXTENSION_NOT_PRESENT, 2},
                        {"xrEnumerateInstanceExtensionProperties", {}, XR_SUCCESS, 1},
                        {"xrEnumerateInstanceExtensionProperties", four, XR_SUCCESS, 7},
                        {"xrEnumerateInstanceExtensionProperties", unknown, XR_ERROR_EXTENSION_NOT_PRESENT, 4}};
  const MiniLoader layered({OmniLayer()});
  for (const Case& c : cases) {
    omni_test_reset();
    setenv("OMNI_TEST_RUNTIME_WITHOUT", c.without, 1);
    CreateInfo given;
    given.extensions = c.extensions;
    given.UseExtensions();
    const long before = omni_test_call_count("xrCreateInstance");
    EXPECT_EQ(CreateByMiniLoader(layered, given.info), c.result) << c.without;
    EXPECT_LE(omni_test_call_count("xrCreateInstance") - before, c.most_tries) << c.without;
    unsetenv("OMNI_TEST_RUNTIME_WITHOUT");
  }
}

// A runtime that lacks a function this layer needs: the application runs as without the layer.
TEST(CreateInstance, LayerStepsAsideWhereAFunctionIsMissing) {
  for (const char* missing : {"xrEnumerateReferenceSpaces", "xrApplyHapticFeedback"}) {
    omni_test_reset();
    setenv("OMNI_TEST_RUNTIME_WITHOUT", missing, 1);
    const MiniLoader alone({}), layered({OmniLayer()});
    CreateInfo given;
    XrInstance bare = XR_NULL_HANDLE, instance = XR_NULL_HANDLE;
    ASSERT_EQ(alone.CreateInstance(given.info, &bare), XR_SUCCESS);
    ASSERT_EQ(layered.CreateInstance(given.info, &instance), XR_SUCCESS) << missing;
    for (const char* name : {"xrGetSystem", "xrSyncActions", "xrLocateSpace", "xrCreateSession", missing,
                             "xrConvertTimespecTimeToTimeKHR", "xrNoSuchFunction"})
      EXPECT_EQ(layered.Get(instance, name), alone.Get(bare, name)) << name;
    const auto destroy = reinterpret_cast<PFN_xrDestroyInstance>(layered.Get(instance, "xrDestroyInstance"));
    EXPECT_EQ(destroy(instance), XR_SUCCESS);
    EXPECT_EQ(destroy(instance), XR_ERROR_HANDLE_INVALID);
    reinterpret_cast<PFN_xrDestroyInstance>(alone.Get(bare, "xrDestroyInstance"))(bare);
    // What only the layer has is not there then.
    given.extensions.push_back("XR_OMNIX1_force_feedback");
    given.UseExtensions();
    EXPECT_EQ(layered.CreateInstance(given.info, &instance), XR_ERROR_EXTENSION_NOT_PRESENT);
    EXPECT_EQ(omni_test_live_handles(), 0u);
    unsetenv("OMNI_TEST_RUNTIME_WITHOUT");
  }
}

}  // namespace test_create_instance
}  // namespace omni::test
