// What every entry point does: finds the instance that made the handle, and lets no exception out.
#pragma once

#include <memory>
#include <new>
#include <tuple>
#include <type_traits>

#include "layer/src/instance/registry.h"

namespace omni::layer {

// Exceptions must not cross the C interface.
template <class Body>
XrResult Guarded(Body body) noexcept {
  try {
    return body();
  } catch (const std::bad_alloc&) {
    return XR_ERROR_OUT_OF_MEMORY;
  } catch (...) {
    return XR_ERROR_RUNTIME_FAILURE;
  }
}

inline std::shared_ptr<Instance> InstanceOf(XrInstance instance) { return Registry::Get().Find(instance); }
template <class Handle>
std::shared_ptr<Instance> InstanceOf(Handle handle) {
  return Registry::Get().FindOwner(handle);
}

template <class Part, class... Arguments>
Part ClassOf(XrResult (Part::*)(Arguments...));

// The C function of type `Function` that calls a method of the instance that made its first argument, or of a part of
// that instance. The method gets all arguments but an XrInstance, which it knows.
template <class Function, auto kMethod>
struct Entry;
template <class Handle, class... Arguments, auto kMethod>
struct Entry<XrResult(XRAPI_PTR*)(Handle, Arguments...), kMethod> {
  static XRAPI_ATTR XrResult XRAPI_CALL Call(Handle handle, Arguments... arguments) noexcept {
    return Guarded([&] {
      const auto instance = InstanceOf(handle);
      if (!instance) return XR_ERROR_HANDLE_INVALID;
      using Part = decltype(ClassOf(kMethod));
      Part& part = std::get<Part&>(instance->Parts());
      constexpr bool kPolls = std::is_same_v<Part, HapticScenes> || std::is_same_v<Part, ForceFeedbacks> ||
                              std::is_same_v<Part, Vibrations>;
      if constexpr (kPolls) instance->KeepAlive();
      XrResult result = XR_SUCCESS;
      if constexpr (std::is_same_v<Handle, XrInstance>) {
        result = (part.*kMethod)(arguments...);
      } else {
        result = (part.*kMethod)(handle, arguments...);
      }
      if (result == XR_ERROR_INSTANCE_LOST || result == XR_ERROR_SESSION_LOST) instance->OnLoss();
      return result;
    });
  }
};

template <class Function>
PFN_xrVoidFunction Erase(Function function) {
  return reinterpret_cast<PFN_xrVoidFunction>(function);
}

}  // namespace omni::layer
