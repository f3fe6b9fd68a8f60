// xrCreateInstance with an error in its arguments: the result is the same with the layer as without.
#include <gtest/gtest.h>

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

}  // namespace test_create_instance
}  // namespace omni::test
