// How a sequence picks handles and pointers; mostly valid ones.
#pragma once

#include "tests/layer/fuzz/sequence.h"

namespace omni::test {

template <class Handle>
Handle Sequence::Pick(const Pool<Handle>& pool) {
  const std::uint32_t kind = random_.Below(24);
  if (kind == 0) return XR_NULL_HANDLE;
  if (kind == 1) return reinterpret_cast<Handle>(0xdead0000beef0000ULL + random_.Below(16));
  if (kind == 2 && !pool.dead.empty()) return random_.Of(pool.dead);
  // A handle of another type.
  if (kind == 3 && !spaces_.live.empty()) return reinterpret_cast<Handle>(spaces_.live.front());
  if (kind == 4 && !sessions_.live.empty()) return reinterpret_cast<Handle>(sessions_.live.front());
  return pool.live.empty() ? Handle(XR_NULL_HANDLE) : random_.Of(pool.live);
}

template <class Handle>
void Sequence::Keep(Pool<Handle>& pool, Handle handle, XrSession session) {
  pool.live.push_back(handle);
  session_of_[handle] = session;
}

template <class Handle>
void Sequence::Bury(Pool<Handle>& pool, XrSession session) {
  for (const Handle handle : pool.live)
    if (session_of_[handle] == session) pool.dead.push_back(handle);
  std::erase_if(pool.live, [&](Handle handle) { return session_of_[handle] == session; });
}

template <class T>
T* Sequence::OrNull(T* pointer) {
  return random_.Percent(3) ? nullptr : pointer;
}

template <class Handle>
std::optional<Handle> Sequence::Drop(Pool<Handle>& pool, XrResult(XRAPI_PTR* destroy)(Handle), const char* what) {
  const Handle handle = Pick(pool);
  const XrResult result = destroy(handle);
  Say(what, result);
  if (XR_FAILED(result)) return std::nullopt;
  std::erase(pool.live, handle);
  pool.dead.push_back(handle);
  return handle;
}

}  // namespace omni::test
