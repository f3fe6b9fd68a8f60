// Setting up: what any OpenXR application does once. It asks for XR_MND_headless, since it draws nothing.

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <vector>

#include "tests/probe/app.h"

namespace probe {
namespace {

constexpr XrPosef kIdentity{{0, 0, 0, 1}, {0, 0, 0}};

std::vector<XrExtensionProperties> Extensions() {
  uint32_t count = 0;
  if (XR_FAILED(xrEnumerateInstanceExtensionProperties(nullptr, 0, &count, nullptr))) return {};
  std::vector<XrExtensionProperties> extensions(count, {XR_TYPE_EXTENSION_PROPERTIES});
  if (XR_FAILED(xrEnumerateInstanceExtensionProperties(nullptr, count, &count, extensions.data()))) return {};
  return extensions;
}

}  // namespace

bool App::Start() {
  hand_path_ = "/user/hand/" + options_.hand;
  if (!CreateInstance() || !CreateSession() || !CreateInput() || !CreateSpaces()) return false;
  if (options_.plant_error) PlantError();
  return true;
}

App::~App() {
  // Destroying the instance destroys everything below it.
  if (instance_ != XR_NULL_HANDLE) xrDestroyInstance(instance_);
}

bool App::HasExtension(const char* name) const {
  const auto extensions = Extensions();
  return std::any_of(extensions.begin(), extensions.end(), [name](const XrExtensionProperties& extension) {
    return std::strcmp(extension.extensionName, name) == 0;
  });
}

bool App::CreateInstance() {
  std::vector<const char*> enabled = {XR_MND_HEADLESS_EXTENSION_NAME, XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME};
  for (const char* const name : enabled) {
    if (HasExtension(name)) continue;
    std::fprintf(stderr, "omni_probe: no runtime was found, or it does not offer %s, which this example needs\n", name);
    report_.AddError("xrEnumerateInstanceExtensionProperties", name + std::string(" missing"));
    return false;
  }
  for (const std::string& profile : options_.profiles) {
    const char* const extension = FindProfile(profile)->extension;
    if (extension != nullptr && HasExtension(extension)) enabled.push_back(extension);
  }
  XrInstanceCreateInfo info{};
  info.type = XR_TYPE_INSTANCE_CREATE_INFO;
  std::snprintf(info.applicationInfo.applicationName, sizeof(info.applicationInfo.applicationName), "%s",
                options_.name.c_str());
  info.applicationInfo.applicationVersion = 1;
  info.applicationInfo.apiVersion = XR_MAKE_VERSION(1, 0, 0);
  info.enabledExtensionCount = static_cast<uint32_t>(enabled.size());
  info.enabledExtensionNames = enabled.data();
  return Check(xrCreateInstance(&info, &instance_), "xrCreateInstance");
}

bool App::CreateSession() {
  XrSystemGetInfo system_info{XR_TYPE_SYSTEM_GET_INFO};
  system_info.formFactor = XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY;
  if (!Check(xrGetSystem(instance_, &system_info, &system_), "xrGetSystem")) return false;
  // With XR_MND_headless a session needs no graphics binding.
  XrSessionCreateInfo info{XR_TYPE_SESSION_CREATE_INFO};
  info.systemId = system_;
  if (!Check(xrCreateSession(instance_, &info, &session_), "xrCreateSession")) return false;
  const auto function = reinterpret_cast<PFN_xrVoidFunction*>(&to_time_);
  return Check(xrGetInstanceProcAddr(instance_, "xrConvertTimespecTimeToTimeKHR", function), "xrGetInstanceProcAddr");
}

bool App::CreateInput() {
  if (!Check(xrStringToPath(instance_, hand_path_.c_str(), &hand_), "xrStringToPath")) return false;
  const char* call = "";
  if (!Check(CreateActions(instance_, hand_, &actions_, &call), call)) return false;
  for (const std::string& name : options_.profiles) {
    const ProfileBindings& profile = *FindProfile(name);
    if (profile.extension != nullptr && !HasExtension(profile.extension)) {
      if (!options_.quiet) std::printf("%s is not offered: no bindings for %s\n", profile.extension, name.c_str());
      continue;
    }
    const XrResult result = Suggest(instance_, hand_path_, profile, actions_);
    if (!Check(result, "xrSuggestInteractionProfileBindings")) return false;
  }
  XrSessionActionSetsAttachInfo attach{XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO};
  attach.countActionSets = 1;
  attach.actionSets = &actions_.set;
  return Check(xrAttachSessionActionSets(session_, &attach), "xrAttachSessionActionSets");
}

bool App::CreateSpaces() {
  XrReferenceSpaceCreateInfo local{XR_TYPE_REFERENCE_SPACE_CREATE_INFO};
  local.referenceSpaceType = XR_REFERENCE_SPACE_TYPE_LOCAL;
  local.poseInReferenceSpace = kIdentity;
  if (!Check(xrCreateReferenceSpace(session_, &local, &local_), "xrCreateReferenceSpace")) return false;
  XrActionSpaceCreateInfo info{XR_TYPE_ACTION_SPACE_CREATE_INFO};
  info.subactionPath = hand_;
  info.poseInActionSpace = kIdentity;
  const std::pair<XrAction, XrSpace*> spaces[] = {
      {actions_.grip, &grip_}, {actions_.aim, &aim_}, {actions_.tip, &tip_}};
  for (const auto& [action, space] : spaces) {
    info.action = action;
    if (!Check(xrCreateActionSpace(session_, &info, space), "xrCreateActionSpace")) return false;
  }
  return true;
}

// A structure that does not say what it is. Whoever watches the calls must object.
void App::PlantError() {
  XrSpaceLocation location{XR_TYPE_UNKNOWN};
  report_.planted_error_result = Name(xrLocateSpace(aim_, local_, Now(), &location));
}

}  // namespace probe
