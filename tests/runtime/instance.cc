// Instances, extensions, names of results.

#include <openxr/openxr_reflection.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <sstream>
#include <string>
#include <vector>

#include "tests/runtime/crash_note.h"
#include "tests/runtime/entry_points.h"
#include "tests/runtime/newer_openxr.h"
#include "tests/runtime/spaces/clock.h"
#include "tests/runtime/state.h"

namespace omni::runtime {
namespace {

struct Extension {
  std::string name;
  uint32_t version;
};
const Extension kExtensions[] = {
    {XR_MND_HEADLESS_EXTENSION_NAME, XR_MND_headless_SPEC_VERSION},
    {XR_KHR_BINDING_MODIFICATION_EXTENSION_NAME, XR_KHR_binding_modification_SPEC_VERSION},
    {XR_VALVE_ANALOG_THRESHOLD_EXTENSION_NAME, XR_VALVE_analog_threshold_SPEC_VERSION},
    {XR_EXT_ACTIVE_ACTION_SET_PRIORITY_EXTENSION_NAME, 1},
    {XR_EXT_USER_PRESENCE_EXTENSION_NAME, 1},
    {XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME, XR_KHR_convert_timespec_time_SPEC_VERSION},
    {XR_KHR_LOCATE_SPACES_EXTENSION_NAME, XR_KHR_locate_spaces_SPEC_VERSION},
    {XR_EXT_HAND_TRACKING_EXTENSION_NAME, XR_EXT_hand_tracking_SPEC_VERSION},
    {XR_MSFT_CONTROLLER_MODEL_EXTENSION_NAME, XR_MSFT_controller_model_SPEC_VERSION},
    {XR_FB_RENDER_MODEL_EXTENSION_NAME, 4},
    {XR_EXT_UUID_EXTENSION_NAME, 1},
    {XR_EXT_RENDER_MODEL_EXTENSION_NAME, 1},
    {XR_EXT_INTERACTION_RENDER_MODEL_EXTENSION_NAME, 1},
    {XR_KHR_COMPOSITION_LAYER_DEPTH_EXTENSION_NAME, XR_KHR_composition_layer_depth_SPEC_VERSION},
    {XR_KHR_COMPOSITION_LAYER_CUBE_EXTENSION_NAME, XR_KHR_composition_layer_cube_SPEC_VERSION},
    {XR_KHR_COMPOSITION_LAYER_CYLINDER_EXTENSION_NAME, XR_KHR_composition_layer_cylinder_SPEC_VERSION},
    {XR_KHR_COMPOSITION_LAYER_EQUIRECT_EXTENSION_NAME, XR_KHR_composition_layer_equirect_SPEC_VERSION},
    {XR_KHR_COMPOSITION_LAYER_EQUIRECT2_EXTENSION_NAME, XR_KHR_composition_layer_equirect2_SPEC_VERSION},
};

// Those of the table that OMNI_TEST_RUNTIME_WITHOUT does not name, graphics that were built in, vibrations with a
// shape where a test wants them, and names that a test adds by OMNI_TEST_RUNTIME_EXTENSIONS (separated by spaces):
// accepted, without any effect.
std::vector<Extension> Extensions() {
  std::vector<Extension> all(std::begin(kExtensions), std::end(kExtensions));
  for (const GraphicsExtension& graphics : GraphicsExtensions()) all.push_back({graphics.name, graphics.version});
  if (std::getenv("OMNI_TEST_RUNTIME_AUTOMATION") != nullptr) {
    all.push_back({XR_EXT_CONFORMANCE_AUTOMATION_EXTENSION_NAME, XR_EXT_conformance_automation_SPEC_VERSION});
  }
  if (TheState().world.has_shapes) {
    all.push_back({XR_FB_HAPTIC_AMPLITUDE_ENVELOPE_EXTENSION_NAME, 1});
    all.push_back({XR_FB_HAPTIC_PCM_EXTENSION_NAME, 1});
  }
  if (!TheState().world.has_models)
    std::erase_if(all, [](const Extension& known) {
      return known.name == XR_EXT_RENDER_MODEL_EXTENSION_NAME || known.name == XR_EXT_UUID_EXTENSION_NAME ||
             known.name == XR_EXT_INTERACTION_RENDER_MODEL_EXTENSION_NAME;
    });
  if (!TheState().world.has_timespec)
    std::erase_if(all,
                  [](const Extension& known) { return known.name == XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME; });
  if (const char* without = std::getenv("OMNI_TEST_RUNTIME_WITHOUT"))
    std::erase_if(all, [without](const Extension& known) { return known.name == without; });
  const char* const more = std::getenv("OMNI_TEST_RUNTIME_EXTENSIONS");
  std::istringstream names(more == nullptr ? "" : more);
  for (std::string name; names >> name;) all.push_back({name, 1});
  return all;
}

template <size_t size>
bool IsTerminated(const char (&text)[size]) {
  return std::memchr(text, 0, size) != nullptr;
}

bool IsKnownExtension(const char* name) {
  const std::vector<Extension> all = Extensions();
  return std::any_of(all.begin(), all.end(), [name](const Extension& known) { return known.name == name; });
}

XrResult CheckCreateInfo(const XrInstanceCreateInfo* info, const XrInstance* instance) {
  OMNI_REQUIRE(Is(info, XR_TYPE_INSTANCE_CREATE_INFO) && instance != nullptr, XR_ERROR_VALIDATION_FAILURE);
  const XrApplicationInfo& app = info->applicationInfo;
  OMNI_REQUIRE(info->createFlags == 0, XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(IsTerminated(app.applicationName) && IsTerminated(app.engineName), XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(XR_VERSION_MAJOR(app.apiVersion) == 1 && XR_VERSION_MINOR(app.apiVersion) <= 1,
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
    for (const uint64_t child : session->children) state.handles.Erase(child);
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
  const std::vector<Extension> all = Extensions();
  const auto size = static_cast<uint32_t>(all.size());
  return TwoCall(size, capacity, count, properties, [&all](uint32_t i, XrExtensionProperties& out) {
    std::snprintf(out.extensionName, sizeof(out.extensionName), "%s", all[i].name.c_str());
    out.extensionVersion = all[i].version;
  });
}

XrResult CreateInstance(const XrInstanceCreateInfo* info, XrInstance* instance) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  if (const XrResult refusal = state.world.creation; XR_FAILED(refusal)) {
    std::fprintf(stderr, "omni_test_runtime: no instance, as a test wants it\n");
    return refusal;
  }
  if (const XrResult check = CheckCreateInfo(info, instance); XR_FAILED(check)) return check;
  const auto created = std::make_shared<Instance>();
  if (const char* const file = std::getenv("OMNI_TEST_RUNTIME_SCRIPT"); file != nullptr && *file != '\0') {
    const std::string error = LoadScript(file, Now(), &created->script);
    if (!error.empty()) {
      std::fprintf(stderr, "omni_test_runtime: %s\n", error.c_str());
      return XR_ERROR_RUNTIME_FAILURE;
    }
  }
  NoteCrashes();
  created->serial = ++state.instances_created;
  created->version_1_1 = XR_VERSION_MINOR(info->applicationInfo.apiVersion) >= 1;
  created->extensions.assign(info->enabledExtensionNames, info->enabledExtensionNames + info->enabledExtensionCount);
  created->headless = created->Enabled(XR_MND_HEADLESS_EXTENSION_NAME);
  created->binding_modification = created->Enabled(XR_KHR_BINDING_MODIFICATION_EXTENSION_NAME);
  created->analog_threshold = created->Enabled(XR_VALVE_ANALOG_THRESHOLD_EXTENSION_NAME);
  created->set_priorities = created->Enabled(XR_EXT_ACTIVE_ACTION_SET_PRIORITY_EXTENSION_NAME);
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
