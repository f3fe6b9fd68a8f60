// What every entry point does: finds the instance that made the handle, and lets no exception out.
#pragma once

#include <new>

#include "layer/src/registry.h"

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

// Calls `method` of the instance that made `handle`.
template <class Handle, class... Parameters, class... Arguments>
XrResult On(Handle handle, XrResult (Instance::*method)(Parameters...), Arguments... arguments) noexcept {
  return Guarded([&] {
    const auto instance = Registry::Get().Owner(handle);
    return instance ? ((*instance).*method)(arguments...) : XR_ERROR_HANDLE_INVALID;
  });
}

template <class... Parameters, class... Arguments>
XrResult On(XrInstance handle, XrResult (Instance::*method)(Parameters...), Arguments... arguments) noexcept {
  return Guarded([&] {
    const auto instance = Registry::Get().Find(handle);
    return instance ? ((*instance).*method)(arguments...) : XR_ERROR_HANDLE_INVALID;
  });
}

template <class Function>
PFN_xrVoidFunction Erase(Function function) {
  return reinterpret_cast<PFN_xrVoidFunction>(function);
}

}  // namespace omni::layer
