// Instances, extensions, names of results.

#include <openxr/openxr_reflection.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <vector>

#include "tests/runtime/clock.h"
#include "tests/runtime/entry_points.h"
#include "tests/runtime/state.h"
#include "tests/runtime/vulkan.h"

namespace omni::runtime {
namespace {

struct Extension {
  const char* name;
  uint32_t version;
};
constexpr Extension kExtensions[] = {
    {XR_MND_HEADLESS_EXTENSION_NAME, XR_MND_headless_SPEC_VERSION},
    {XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME, XR_KHR_convert_timespec_time_SPEC_VERSION},
};

// Those above that OMNI_TEST_RUNTIME_WITHOUT does not name, and Vulkan where it was built in.
std::vector<Extension> OfferedExtensions() {
  std::vector<Extension> offered(std::begin(kExtensions), std::end(kExtensions));
  if (VulkanExtension() != nullptr) offered.push_back({VulkanExtension(), 2});
  if (const char* without = std::getenv("OMNI_TEST_RUNTIME_WITHOUT"))
    std::erase_if(offered, [without](const Extension& known) { return std::strcmp(known.name, without) == 0; });
  return offered;
}

template <size_t size>
bool IsTerminated(const char (&text)[size]) {
  return std::memchr(text, 0, size) != nullptr;
}

bool IsKnownExtension(const char* name) {
  const std::vector<Extension> offered = OfferedExtensions();
  return std::any_of(offered.begin(), offered.end(),
                     [name](const Extension& known) { return std::strcmp(known.name, name) == 0; });
}

bool Enables(const XrInstanceCreateInfo& info, const char* extension) {
  const char* const* const names = info.enabledExtensionNames;
  return std::any_of(names, names + info.enabledExtensionCount,
                     [extension](const char* name) { return std::strcmp(name, extension) == 0; });
}

XrResult CheckCreateInfo(const XrInstanceCreateInfo* info, const XrInstance* instance) {
  OMNI_REQUIRE(Is(info, XR_TYPE_INSTANCE_CREATE_INFO) && instance != nullptr, XR_ERROR_VALIDATION_FAILURE);
  const XrApplicationInfo& app = info->applicationInfo;
  OMNI_REQUIRE(info->createFlags == 0, XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(IsTerminated(app.applicationName) && IsTerminated(app.engineName), XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(XR_VERSION_MAJOR(app.apiVersion) == 1 && XR_VERSION_MINOR(app.apiVersion) == 0,
               XR_ERROR_API_VERSION_UNSUPPORTED);
  OMNI_REQUIRE(app.applicationName[0] != '\0', XR_ERROR_NAME_INVALID);
  OMNI_REQUIRE(info->enabledExtensionCount == 0 || info->enabledExtensionNames != nullptr, XR_ERROR_VALIDATION_FAILURE);
  for (uint32_t i = 0; i < info->enabledExtensionCount; ++i) {
    OMNI_REQUIRE(info->enabledExtensionNames[i] != nullptr, XR_ERROR_VALIDATION_FAILURE);
    OMNI_REQUIRE(IsKnownExtension(info->enabledExtensionNames[i]), XR_ERROR_EXTENSION_NOT_PRESENT);
  }
  return XR_SUCCESS;
}

void CopyName(const char* name, int32_t value, const char* unknown, char* buffer) {
  if (name != nullptr) {
    std::snprintf(buffer, XR_MAX_RESULT_STRING_SIZE, "%s", name);
  } else {
    std::snprintf(buffer, XR_MAX_RESULT_STRING_SIZE, "%s%d", unknown, value);
  }
}

void EraseHandles(State& state, const Instance& instance) {
  for (const auto& session : instance.sessions) {
    for (const uint64_t space : session->spaces) state.handles.Erase(space);
    state.handles.Erase(session->handle);
  }
  for (const auto& set : instance.action_sets) {
    for (const auto& action : set->actions) state.handles.Erase(action->handle);
    state.handles.Erase(set->handle);
  }
}

}  // namespace

XrResult EnumerateApiLayerProperties(uint32_t capacity, uint32_t* count, XrApiLayerProperties* properties) {
  return TwoCall(0, capacity, count, properties, [](uint32_t, XrApiLayerProperties&) {});
}

XrResult EnumerateInstanceExtensionProperties(const char* layer, uint32_t capacity, uint32_t* count,
                                              XrExtensionProperties* properties) {
  OMNI_REQUIRE(layer == nullptr, XR_ERROR_API_LAYER_NOT_PRESENT);
  for (uint32_t i = 0; properties != nullptr && i < capacity; ++i) {
    OMNI_REQUIRE(Is(&properties[i], XR_TYPE_EXTENSION_PROPERTIES), XR_ERROR_VALIDATION_FAILURE);
  }
  const std::vector<Extension> offered = OfferedExtensions();
  return TwoCall(static_cast<uint32_t>(offered.size()), capacity, count, properties,
                 [&offered](uint32_t i, XrExtensionProperties& out) {
                   std::snprintf(out.extensionName, sizeof(out.extensionName), "%s", offered[i].name);
                   out.extensionVersion = offered[i].version;
                 });
}

XrResult CreateInstance(const XrInstanceCreateInfo* info, XrInstance* instance) {
  if (const XrResult check = CheckCreateInfo(info, instance); XR_FAILED(check)) return check;
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  const auto created = std::make_shared<Instance>();
  if (const char* const file = std::getenv("OMNI_TEST_RUNTIME_SCRIPT"); file != nullptr && *file != '\0') {
    const std::string error = LoadScript(file, Now(), &created->script);
    if (!error.empty()) {
      std::fprintf(stderr, "omni_test_runtime: %s\n", error.c_str());
      return XR_ERROR_RUNTIME_FAILURE;
    }
  }
  created->serial = ++state.instances_created;
  created->headless = Enables(*info, XR_MND_HEADLESS_EXTENSION_NAME);
  created->convert_timespec = Enables(*info, XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME);
  created->vulkan = VulkanExtension() != nullptr && Enables(*info, VulkanExtension());
  *instance = Handles::As<XrInstance>(state.handles.Insert(created));
  state.instances.push_back(created);
  return XR_SUCCESS;
}

// Allowed on a lost instance too.
XrResult DestroyInstance(XrInstance instance) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  const auto doomed = state.handles.Share<Instance>(instance);
  OMNI_REQUIRE(doomed != nullptr, XR_ERROR_HANDLE_INVALID);
  EraseHandles(state, *doomed);
  state.handles.Erase(doomed->handle);
  std::erase(state.instances, doomed);
  return XR_SUCCESS;
}

XrResult GetInstanceProperties(XrInstance instance, XrInstanceProperties* properties) {
  State& state = TheState();
  const std::shared_lock lock(state.mutex);
  OMNI_FIND(Instance, owner, instance);
  OMNI_REQUIRE(Is(properties, XR_TYPE_INSTANCE_PROPERTIES), XR_ERROR_VALIDATION_FAILURE);
  properties->runtimeVersion = XR_MAKE_VERSION(0, 1, 0);
  std::snprintf(properties->runtimeName, sizeof(properties->runtimeName), "Omni test runtime");
  return XR_SUCCESS;
}

XrResult ResultToString(XrInstance instance, XrResult value, char buffer[XR_MAX_RESULT_STRING_SIZE]) {
  State& state = TheState();
  const std::shared_lock lock(state.mutex);
  OMNI_FIND(Instance, owner, instance);
  OMNI_REQUIRE(buffer != nullptr, XR_ERROR_VALIDATION_FAILURE);
  const char* name = nullptr;
  switch (value) {
#define OMNI_NAME(enumerator, number) \
  case enumerator:                    \
    name = #enumerator;               \
    break;
    XR_LIST_ENUM_XrResult(OMNI_NAME) default : break;
  }
  CopyName(name, value, XR_SUCCEEDED(value) ? "XR_UNKNOWN_SUCCESS_" : "XR_UNKNOWN_FAILURE_", buffer);
  return XR_SUCCESS;
}

XrResult StructureTypeToString(XrInstance instance, XrStructureType value, char buffer[XR_MAX_STRUCTURE_NAME_SIZE]) {
  State& state = TheState();
  const std::shared_lock lock(state.mutex);
  OMNI_FIND(Instance, owner, instance);
  OMNI_REQUIRE(buffer != nullptr, XR_ERROR_VALIDATION_FAILURE);
  const char* name = nullptr;
  switch (value) {
    XR_LIST_ENUM_XrStructureType(OMNI_NAME) default : break;
#undef OMNI_NAME
  }
  CopyName(name, value, "XR_UNKNOWN_STRUCTURE_TYPE_", buffer);
  return XR_SUCCESS;
}

}  // namespace omni::runtime
