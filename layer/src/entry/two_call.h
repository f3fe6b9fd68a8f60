// The two-call idiom [buffer-size-parameters]: capacity 0 asks for the count.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "layer/src/entry/omni_openxr_compat.h"

namespace omni::layer {

// Sets the count. If it returns XR_SUCCESS and the capacity is not 0, there is room for all.
XrResult CheckCapacity(std::size_t n, std::uint32_t capacity, std::uint32_t* count, const void* out);

// `write(i)` fills the application's element i.
template <class Write>
XrResult FillBy(std::size_t n, std::uint32_t capacity, std::uint32_t* count, const void* out, Write write) {
  const XrResult result = CheckCapacity(n, capacity, count, out);
  for (std::size_t i = 0; result == XR_SUCCESS && i < n && i < capacity; ++i) write(i);
  return result;
}

template <class T>
XrResult Fill(const T* values, std::size_t n, std::uint32_t capacity, std::uint32_t* count, T* out) {
  return FillBy(n, capacity, count, out, [&](std::size_t i) { out[i] = values[i]; });
}

// All that the next layer enumerates: `enumerate(capacity, &count, out)` is its function, `empty` an element to fill.
template <class T, class Enumerate>
XrResult EnumerateBelow(std::vector<T>& all, const T& empty, Enumerate enumerate) {
  std::uint32_t count = 0;
  all.clear();
  XrResult result = enumerate(0u, &count, static_cast<T*>(nullptr));
  if (XR_FAILED(result) || count == 0) return result;
  all.assign(count, empty);
  result = enumerate(static_cast<std::uint32_t>(all.size()), &count, all.data());
  all.resize(XR_FAILED(result) ? 0 : std::min<std::size_t>(count, all.size()));
  return result;
}

}  // namespace omni::layer
