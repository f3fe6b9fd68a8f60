// Which extensions are requested from the next layer or runtime ("below").
//
// xrEnumerateInstanceExtensionProperties below says what is there. Some layers and runtimes lack it, or name what
// others provide: then we request what we want and, if that fails, request less. Only errors that say so are tried
// again; any other is returned at once. LunarG's core_validation 1.0.20, which does not enumerate, turns a runtime's
// XR_ERROR_EXTENSION_NOT_PRESENT into XR_ERROR_INITIALIZATION_FAILED. The last attempt requests no more than the
// application did, and its result is returned.
//
// Errors in the application's XrInstanceCreateInfo are left to be found below: the result is the same with this layer
// as without.
#include "layer/src/entry/create_instance.h"

#include <algorithm>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "layer/src/entry/own_extensions.h"
#include "layer/src/instance/registry.h"

namespace omni::layer {
namespace {

// Only the manifest for conformance tests names it (manifests/layer/conformance.json.in).
constexpr OurExtension kAutomation{XR_EXT_CONFORMANCE_AUTOMATION_EXTENSION_NAME, 3, true, nullptr};

const OurExtension* FindOurs(const std::string& name) {
  if (name == kAutomation.name) return TestDevice::IsEnabled() ? &kAutomation : nullptr;
  const auto all = OurExtensions();
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const OurExtension& extension) { return name == extension.name; });
  return found == all.end() ? nullptr : &*found;
}

bool Contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

// For ourselves, hidden from an application that did not ask for it: the runtime's time, and whether the headset is
// worn.
constexpr const char* kTimespec = XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME;
constexpr const char* kPresence = XR_EXT_USER_PRESENCE_EXTENSION_NAME;

struct Attempt {
  std::vector<std::string> ours;   // those of our extensions that are requested below
  std::vector<std::string> added;  // for ourselves
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
    if (!ours || Contains(attempt.ours, name)) names.push_back(name.c_str());
  }
  for (const std::string& name : attempt.added) names.push_back(name.c_str());
  XrInstanceCreateInfo info = *creation.info;
  info.enabledExtensionCount = static_cast<std::uint32_t>(names.size());
  info.enabledExtensionNames = names.data();
  return creation.next->nextCreateApiLayerInstance(&info, &creation.below, instance);
}

// The names that are enumerated below; empty: it cannot be enumerated there.
std::optional<std::vector<std::string>> OfferedBelow(PFN_xrGetInstanceProcAddr next_get) {
  PFN_xrVoidFunction found = nullptr;
  if (XR_FAILED(next_get(XR_NULL_HANDLE, "xrEnumerateInstanceExtensionProperties", &found)) || !found) return {};
  const auto enumerate = reinterpret_cast<PFN_xrEnumerateInstanceExtensionProperties>(found);
  std::uint32_t count = 0;
  if (XR_FAILED(enumerate(nullptr, 0, &count, nullptr)) || count == 0) return {};
  std::vector<XrExtensionProperties> all(count, {XR_TYPE_EXTENSION_PROPERTIES, nullptr, "", 0});
  if (XR_FAILED(enumerate(nullptr, count, &count, all.data()))) return {};
  std::vector<std::string> names;
  for (const XrExtensionProperties& one : all)
    names.emplace_back(one.extensionName, strnlen(one.extensionName, sizeof(one.extensionName)));
  return names;
}

// What to request, the most first; at last nothing more than the application did. Where it is unknown what is there,
// all but each one in between.
std::vector<Attempt> AttemptsFor(const std::vector<std::string>& asked,
                                 const std::optional<std::vector<std::string>>& offered) {
  const auto perhaps = [&](const std::string& name) { return !offered || Contains(*offered, name); };
  Attempt most;
  for (const std::string& name : asked)
    if (const OurExtension* ours = FindOurs(name); ours && ours->may_be_below && perhaps(name))
      most.ours.push_back(name);
  if (!Contains(asked, kTimespec) && perhaps(kTimespec)) most.added.push_back(kTimespec);
  if (!Contains(asked, kPresence) && offered && Contains(*offered, kPresence)) most.added.push_back(kPresence);
  std::vector<Attempt> attempts{most};
  if (!most.added.empty() && !most.ours.empty()) attempts.push_back({most.ours, {}});
  for (std::size_t i = 0; !offered && i < most.ours.size(); ++i) {
    attempts.push_back(most);
    attempts.back().ours.erase(attempts.back().ours.begin() + static_cast<std::ptrdiff_t>(i));
  }
  if (!most.added.empty() || !most.ours.empty()) attempts.push_back({});
  return attempts;
}

// A request for fewer extensions may succeed.
bool LessMayHelp(XrResult result, bool enumerated) {
  return result == XR_ERROR_EXTENSION_NOT_PRESENT || (result == XR_ERROR_INITIALIZATION_FAILED && !enumerated);
}

XrResult TryAll(const Creation& creation, Attempt& done, XrInstance* instance) {
  const auto offered = OfferedBelow(creation.next->nextGetInstanceProcAddr);
  XrResult result = XR_ERROR_EXTENSION_NOT_PRESENT;
  for (const Attempt& attempt : AttemptsFor(creation.asked, offered)) {
    done = attempt;
    result = Try(creation, done, instance);
    if (!LessMayHelp(result, offered.has_value())) return result;
  }
  return result;
}

// An extension of ours without the one of ours that it depends on [extension-dependencies].
bool LacksDependency(const std::vector<std::string>& asked) {
  return std::any_of(asked.begin(), asked.end(), [&](const std::string& name) {
    const OurExtension* ours = FindOurs(name);
    return ours && ours->needs && !Contains(asked, ours->needs);
  });
}

// The application's structure unchanged: its extensions cannot be read.
XrResult TryUnchanged(const Creation& creation, XrInstance* instance) {
  return creation.next->nextCreateApiLayerInstance(creation.info, &creation.below, instance);
}

bool ExtensionsAreReadable(const XrInstanceCreateInfo& info) {
  if (info.type != XR_TYPE_INSTANCE_CREATE_INFO) return false;
  if (info.enabledExtensionCount == 0) return true;
  const char* const* const names = info.enabledExtensionNames;
  return names && std::all_of(names, names + info.enabledExtensionCount, [](const char* name) { return name; });
}

// The loader's part of the call.
bool IsFromLoader(const XrApiLayerCreateInfo* layer_info) {
  return layer_info && layer_info->structType == XR_LOADER_INTERFACE_STRUCT_API_LAYER_CREATE_INFO &&
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

// This instance is below what it would be without us, and the application gets its functions from there. What only we
// provide is not present then.
XrResult StepAside(const std::vector<std::string>& asked, const Attempt& done, const Dispatch& next,
                   XrInstance* instance) {
  const bool lacks_ours = std::any_of(asked.begin(), asked.end(), [&](const std::string& name) {
    return FindOurs(name) && !Contains(done.ours, name);
  });
  if (!lacks_ours) {
    Registry::Get().AddAside(
        {*instance, next.GetInstanceProcAddr, next.DestroyInstance, Contains(done.added, kTimespec)});
    return XR_SUCCESS;
  }
  if (next.DestroyInstance) next.DestroyInstance(*instance);
  *instance = XR_NULL_HANDLE;
  return XR_ERROR_EXTENSION_NOT_PRESENT;
}

}  // namespace

XrResult CreateApiLayerInstance(const XrInstanceCreateInfo* info, const XrApiLayerCreateInfo* layer_info,
                                XrInstance* instance) {
  if (!IsFromLoader(layer_info)) return XR_ERROR_INITIALIZATION_FAILED;
  if (!info || !instance) return XR_ERROR_VALIDATION_FAILURE;
  const bool readable = ExtensionsAreReadable(*info);
  Creation creation{info, layer_info->nextInfo, *layer_info, {}};
  creation.below.nextInfo = layer_info->nextInfo->next;
  if (readable)
    creation.asked.assign(info->enabledExtensionNames, info->enabledExtensionNames + info->enabledExtensionCount);
  if (LacksDependency(creation.asked)) return kErrorExtensionDependencyNotEnabled;
  Attempt done;
  const XrResult result = readable ? TryAll(creation, done, instance) : TryUnchanged(creation, instance);
  if (XR_FAILED(result)) return result;

  InstanceSetup setup;
  setup.handle = *instance;
  const char* missing = nullptr;
  if (!LoadDispatch(*instance, creation.next->nextGetInstanceProcAddr, setup.next, &missing)) {
    Log().WriteLine(std::string("not used: the runtime (or next layer) lacks ") + missing);
    return StepAside(creation.asked, done, setup.next, instance);
  }
  setup.enabled = creation.asked;
  const XrVersion version = info->applicationInfo.apiVersion;
  if (XR_VERSION_MAJOR(version) > 1 || XR_VERSION_MINOR(version) >= 1) setup.enabled.push_back("1.1");
  for (const std::string& name : creation.asked)
    if (const OurExtension* ours = FindOurs(name); ours && !Contains(done.ours, name)) setup.only_ours.push_back(name);
  setup.hide_timespec = Contains(done.added, kTimespec);
  setup.hide_presence = Contains(done.added, kPresence);
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
    // Not for us to answer. The loader adds what the manifest names.
    const auto below = Registry::Get().FindOwner(XrSession{});
    if (below && below->runtime.next.EnumerateInstanceExtensionProperties)
      return below->runtime.next.EnumerateInstanceExtensionProperties(layer_name, capacity, count, properties);
    *count = 0;
    return layer_name ? XR_ERROR_API_LAYER_NOT_PRESENT : XR_SUCCESS;
  }
  const auto ours = OurExtensions();
  *count = static_cast<std::uint32_t>(ours.size());
  if (capacity == 0) return XR_SUCCESS;
  if (capacity < ours.size()) return XR_ERROR_SIZE_INSUFFICIENT;
  if (!properties) return XR_ERROR_VALIDATION_FAILURE;
  for (std::size_t i = 0; i < ours.size(); ++i) {
    if (properties[i].type != XR_TYPE_EXTENSION_PROPERTIES) return XR_ERROR_VALIDATION_FAILURE;
    std::strncpy(properties[i].extensionName, ours[i].name, sizeof(properties[i].extensionName) - 1);
    properties[i].extensionVersion = ours[i].version;
  }
  return XR_SUCCESS;
}

}  // namespace omni::layer
