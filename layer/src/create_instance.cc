// Which extensions the next layer is asked for.
//
// xrEnumerateInstanceExtensionProperties of what lies below is not to be relied on (layers and runtimes that lack it
// exist), so we ask for what we want and, on XR_ERROR_EXTENSION_NOT_PRESENT, ask again for less.
#include "layer/src/create_instance.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <string>
#include <vector>

#include "layer/src/registry.h"

namespace omni::layer {
namespace {

// Extensions that we answer, all of them advertised in the manifest.
struct OurExtension {
  const char* name;
  std::uint32_t version;
  bool may_be_below;  // asked for there first; else only we know it, and what lies below never hears of it
};
constexpr std::array kOurExtensions{
    OurExtension{XR_LOGITECH_MX_INK_STYLUS_INTERACTION_EXTENSION_NAME, 1, true},
    OurExtension{XR_FB_HAPTIC_AMPLITUDE_ENVELOPE_EXTENSION_NAME, 1, true},
    OurExtension{XR_FB_HAPTIC_PCM_EXTENSION_NAME, 1, true},
};

const OurExtension* FindOurs(const std::string& name) {
  const auto found = std::find_if(kOurExtensions.begin(), kOurExtensions.end(),
                                  [&](const OurExtension& extension) { return name == extension.name; });
  return found == kOurExtensions.end() ? nullptr : &*found;
}

bool Contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

struct Attempt {
  bool ours = false;      // ask below for our extensions as well
  bool timespec = false;  // add XR_KHR_convert_timespec_time
};

struct Creation {
  const XrInstanceCreateInfo* info;
  const XrApiLayerNextInfo* next;
  XrApiLayerCreateInfo below;  // what the next layer gets
  std::vector<std::string> asked;
};

XrResult Try(const Creation& creation, const Attempt& attempt, XrInstance* instance) {
  std::vector<const char*> names;
  for (const std::string& name : creation.asked) {
    const OurExtension* ours = FindOurs(name);
    if (!ours || (attempt.ours && ours->may_be_below)) names.push_back(name.c_str());
  }
  if (attempt.timespec) names.push_back(XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME);
  XrInstanceCreateInfo info = *creation.info;
  info.enabledExtensionCount = static_cast<std::uint32_t>(names.size());
  info.enabledExtensionNames = names.data();
  return creation.next->nextCreateApiLayerInstance(&info, &creation.below, instance);
}

XrResult TryAll(const Creation& creation, Attempt& done, XrInstance* instance) {
  const bool ours = std::any_of(creation.asked.begin(), creation.asked.end(), [](const std::string& name) {
    const OurExtension* extension = FindOurs(name);
    return extension && extension->may_be_below;
  });
  const bool timespec = !Contains(creation.asked, XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME);
  XrResult result = XR_ERROR_EXTENSION_NOT_PRESENT;
  for (const bool with_timespec : {true, false}) {
    for (const bool with_ours : {true, false}) {
      if ((with_timespec && !timespec) || (with_ours && !ours)) continue;
      done = {with_ours, with_timespec};
      result = Try(creation, done, instance);
      if (result != XR_ERROR_EXTENSION_NOT_PRESENT) return result;
    }
  }
  return result;
}

bool Readable(const XrInstanceCreateInfo* info, const XrApiLayerCreateInfo* layer_info, const XrInstance* instance) {
  return info && info->type == XR_TYPE_INSTANCE_CREATE_INFO && instance && layer_info &&
         layer_info->structType == XR_LOADER_INTERFACE_STRUCT_API_LAYER_CREATE_INFO &&
         layer_info->structVersion == kApiLayerCreateInfoVersion &&
         layer_info->structSize >= sizeof(XrApiLayerCreateInfo) && layer_info->nextInfo &&
         layer_info->nextInfo->structType == XR_LOADER_INTERFACE_STRUCT_API_LAYER_NEXT_INFO &&
         layer_info->nextInfo->structVersion == kApiLayerNextInfoVersion &&
         layer_info->nextInfo->structSize >= sizeof(XrApiLayerNextInfo) &&
         layer_info->nextInfo->nextGetInstanceProcAddr && layer_info->nextInfo->nextCreateApiLayerInstance;
}

std::string Text(const char* bytes, std::size_t capacity) { return {bytes, strnlen(bytes, capacity)}; }

client::ConnectionInfo ConnectionFor(const XrApplicationInfo& application) {
  client::ConnectionInfo info;
  info.application = Text(application.applicationName, sizeof(application.applicationName));
  info.engine = Text(application.engineName, sizeof(application.engineName));
  info.api_version_major = static_cast<std::uint32_t>(XR_VERSION_MAJOR(application.apiVersion));
  info.api_version_minor = static_cast<std::uint32_t>(XR_VERSION_MINOR(application.apiVersion));
  return info;
}

}  // namespace

XrResult CreateApiLayerInstance(const XrInstanceCreateInfo* info, const XrApiLayerCreateInfo* layer_info,
                                XrInstance* instance) {
  if (!Readable(info, layer_info, instance)) return XR_ERROR_INITIALIZATION_FAILED;
  Creation creation{info, layer_info->nextInfo, *layer_info, {}};
  creation.below.nextInfo = layer_info->nextInfo->next;
  creation.asked.assign(info->enabledExtensionNames, info->enabledExtensionNames + info->enabledExtensionCount);
  Attempt done;
  const XrResult result = TryAll(creation, done, instance);
  if (XR_FAILED(result)) return result;

  InstanceSetup setup;
  setup.handle = *instance;
  const char* missing = nullptr;
  if (!LoadDispatch(*instance, creation.next->nextGetInstanceProcAddr, setup.next, &missing)) {
    Log().Line(std::string("not loaded: what lies below has no ") + missing);
    if (setup.next.DestroyInstance) setup.next.DestroyInstance(*instance);
    return XR_ERROR_INITIALIZATION_FAILED;
  }
  setup.enabled = creation.asked;
  const XrVersion version = info->applicationInfo.apiVersion;
  if (XR_VERSION_MAJOR(version) > 1 || XR_VERSION_MINOR(version) >= 1) setup.enabled.push_back("1.1");
  for (const std::string& name : creation.asked)
    if (const OurExtension* ours = FindOurs(name); ours && !(ours->may_be_below && done.ours))
      setup.only_ours.push_back(name);
  setup.hide_timespec = done.timespec;
  setup.connection = ConnectionFor(info->applicationInfo);
  try {
    Registry::Get().Add(std::make_shared<Instance>(std::move(setup)));
  } catch (...) {
    setup.next.DestroyInstance(*instance);
    throw;
  }
  return result;
}

XrResult EnumerateLayers(uint32_t capacity, uint32_t* count, XrApiLayerProperties* properties) {
  if (!count) return XR_ERROR_VALIDATION_FAILURE;
  *count = 1;
  if (capacity == 0) return XR_SUCCESS;
  if (!properties || properties->type != XR_TYPE_API_LAYER_PROPERTIES) return XR_ERROR_VALIDATION_FAILURE;
  std::strncpy(properties->layerName, kLayerName, sizeof(properties->layerName) - 1);
  std::strncpy(properties->description, "Omni: a magnetically tracked pen as a hand's controller",
               sizeof(properties->description) - 1);
  properties->specVersion = XR_MAKE_VERSION(1, 0, 20);
  properties->layerVersion = 1;
  return XR_SUCCESS;
}

XrResult EnumerateExtensions(const char* layer_name, uint32_t capacity, uint32_t* count,
                             XrExtensionProperties* properties) {
  if (!count) return XR_ERROR_VALIDATION_FAILURE;
  if (!layer_name || std::strcmp(layer_name, kLayerName) != 0) {
    // Not a question for us. The loader adds what the manifest names.
    const auto below = Registry::Get().Owner(XrSession{});
    if (below && below->next.EnumerateInstanceExtensionProperties)
      return below->next.EnumerateInstanceExtensionProperties(layer_name, capacity, count, properties);
    *count = 0;
    return layer_name ? XR_ERROR_API_LAYER_NOT_PRESENT : XR_SUCCESS;
  }
  *count = static_cast<std::uint32_t>(kOurExtensions.size());
  if (capacity == 0) return XR_SUCCESS;
  if (capacity < kOurExtensions.size()) return XR_ERROR_SIZE_INSUFFICIENT;
  if (!properties) return XR_ERROR_VALIDATION_FAILURE;
  for (std::size_t i = 0; i < kOurExtensions.size(); ++i) {
    if (properties[i].type != XR_TYPE_EXTENSION_PROPERTIES) return XR_ERROR_VALIDATION_FAILURE;
    std::strncpy(properties[i].extensionName, kOurExtensions[i].name, sizeof(properties[i].extensionName) - 1);
    properties[i].extensionVersion = kOurExtensions[i].version;
  }
  return XR_SUCCESS;
}

}  // namespace omni::layer
