// Negotiation with the loader and the table of functions.

#include <atomic>
#include <cstdlib>
#include <cstring>
#include <string_view>

#include "tests/runtime/entry_points.h"
#include "tests/runtime/negotiation.h"
#include "tests/runtime/state.h"

namespace omni::runtime {
namespace {

enum FunctionId : int {
#define OMNI_ID(name) k##name,
  OMNI_RUNTIME_FUNCTIONS(OMNI_ID)
#undef OMNI_ID
      kFunctions
};

std::atomic<long> call_counts[kFunctions];

// Instances of 1.0 and 1.1.
constexpr XrVersion kApiVersion = XR_MAKE_VERSION(1, 1, 0);

// What the application calls: counts, and lets no exception out.
template <int id, auto function>
struct Entry;
template <int id, class... Args, XrResult (*function)(Args...)>
struct Entry<id, function> {
  static XrResult Call(Args... args) noexcept {
    call_counts[id].fetch_add(1, std::memory_order_relaxed);
    try {
      return function(args...);
    } catch (...) {
      return XR_ERROR_RUNTIME_FAILURE;
    }
  }
};

struct NamedFunction {
  std::string_view name;
  PFN_xrVoidFunction function;
};

const NamedFunction kTable[] = {
#define OMNI_ROW(name) {"xr" #name, reinterpret_cast<PFN_xrVoidFunction>(&Entry<k##name, &(name)>::Call)},
    OMNI_RUNTIME_FUNCTIONS(OMNI_ROW)
#undef OMNI_ROW
};

bool NeedsNoInstance(std::string_view name) {
  return name == "xrGetInstanceProcAddr" || name == "xrEnumerateInstanceExtensionProperties" ||
         name == "xrEnumerateApiLayerProperties" || name == "xrCreateInstance";
}

// Functions of extensions and of OpenXR 1.1 exist only for instances that enabled them.
bool Offers(const Instance& instance, std::string_view name) {
  if (name == "xrLocateSpaces") return instance.version_1_1;
  if (name == "xrLocateSpacesKHR") return instance.Enabled(XR_KHR_LOCATE_SPACES_EXTENSION_NAME);
  if (name == "xrGetControllerModelKeyMSFT") return instance.Enabled(XR_MSFT_CONTROLLER_MODEL_EXTENSION_NAME);
  if (name == "xrEnumerateRenderModelPathsFB" || name == "xrGetRenderModelPropertiesFB")
    return instance.Enabled(XR_FB_RENDER_MODEL_EXTENSION_NAME);
  if (name.find("RenderModel") != std::string_view::npos)
    return instance.Enabled(XR_EXT_INTERACTION_RENDER_MODEL_EXTENSION_NAME);
  if (name.find("InputDevice") != std::string_view::npos)
    return instance.Enabled(XR_EXT_CONFORMANCE_AUTOMATION_EXTENSION_NAME);
  if (name == "xrGetDeviceSampleRateFB") return instance.Enabled(XR_FB_HAPTIC_PCM_EXTENSION_NAME);
  if (name.find("Hand") != std::string_view::npos) return instance.Enabled(XR_EXT_HAND_TRACKING_EXTENSION_NAME);
  if (name.find("Timespec") != std::string_view::npos)
    return instance.Enabled(XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME);
  return true;
}

}  // namespace

State& TheState() {
  // Never destroyed: a process may end with swapchains whose graphics library is gone already.
  static State& state = *new State;
  return state;
}

long CallCount(const char* function) {
  for (int i = 0; i < kFunctions; ++i) {
    if (kTable[i].name == function) return call_counts[i].load(std::memory_order_relaxed);
  }
  return -1;
}

XrResult GetInstanceProcAddr(XrInstance instance, const char* name, PFN_xrVoidFunction* function) {
  OMNI_REQUIRE(name != nullptr && function != nullptr, XR_ERROR_VALIDATION_FAILURE);
  *function = nullptr;
  State& state = TheState();
  const std::shared_lock lock(state.mutex);
  const Instance* owner = nullptr;
  if (instance == XR_NULL_HANDLE) {
    OMNI_REQUIRE(NeedsNoInstance(name), XR_ERROR_HANDLE_INVALID);
  } else {
    // A lost instance still answers: the loader looks up xrDestroyInstance here.
    owner = state.handles.Find<Instance>(instance);
    OMNI_REQUIRE(owner != nullptr, XR_ERROR_HANDLE_INVALID);
    *function = FindGraphicsFunction(*owner, name);
    if (*function != nullptr) return XR_SUCCESS;
  }
  const char* const without = std::getenv("OMNI_TEST_RUNTIME_WITHOUT");
  const bool hidden = without != nullptr && std::strcmp(without, name) == 0;
  for (const NamedFunction& entry : kTable) {
    if (entry.name != name || hidden) continue;
    if (owner != nullptr && !Offers(*owner, name)) break;
    *function = entry.function;
    return XR_SUCCESS;
  }
  return XR_ERROR_FUNCTION_UNSUPPORTED;
}

}  // namespace omni::runtime

extern "C" __attribute__((visibility("default"))) XrResult xrNegotiateLoaderRuntimeInterface(
    const omni::runtime::NegotiateLoaderInfo* loader, omni::runtime::NegotiateRuntimeRequest* request) {
  using namespace omni::runtime;
  const bool loader_ok = loader != nullptr && loader->struct_type == kLoaderInfoType &&
                         loader->struct_version == kStructVersion && loader->struct_size == sizeof(*loader);
  const bool request_ok = request != nullptr && request->struct_type == kRuntimeRequestType &&
                          request->struct_version == kStructVersion && request->struct_size == sizeof(*request);
  if (!loader_ok || !request_ok) return XR_ERROR_INITIALIZATION_FAILED;
  const bool interface_ok =
      loader->min_interface_version <= kInterfaceVersion && kInterfaceVersion <= loader->max_interface_version;
  const bool api_ok = loader->min_api_version <= kApiVersion && kApiVersion <= loader->max_api_version;
  if (!interface_ok || !api_ok) return XR_ERROR_INITIALIZATION_FAILED;
  request->runtime_interface_version = kInterfaceVersion;
  request->runtime_api_version = kApiVersion;
  request->get_instance_proc_addr =
      reinterpret_cast<PFN_xrGetInstanceProcAddr>(&Entry<kGetInstanceProcAddr, &GetInstanceProcAddr>::Call);
  return XR_SUCCESS;
}
