#pragma once
// The process-wide state behind one lock, and the lookups with which every entry point begins. Calls that only read
// (locate, action states) share the lock; uncontended it costs no system call.

#include <openxr/openxr.h>

#include <cstring>
#include <memory>
#include <mutex>
#include <shared_mutex>
#include <string_view>
#include <vector>

#include "tests/runtime/handles.h"
#include "tests/runtime/world.h"
#include "tests/runtime/writer_first_mutex.h"

namespace omni::runtime {

struct State {
  WriterFirstMutex mutex;
  World world;
  Handles handles;
  std::vector<std::shared_ptr<Instance>> instances;
  uint32_t instances_created = 0;
};

State& TheState();

template <class Visit>
void ForEachSession(State& state, Visit visit) {
  for (const auto& instance : state.instances) {
    for (const auto& session : instance->sessions) visit(*session);
  }
}

inline XrResult Loss(const Instance& instance) { return instance.lost ? XR_ERROR_INSTANCE_LOST : XR_SUCCESS; }
inline XrResult Loss(const Session& session) {
  if (session.instance->lost) return XR_ERROR_INSTANCE_LOST;
  return session.lost ? XR_ERROR_SESSION_LOST : XR_SUCCESS;
}
inline XrResult Loss(const ActionSet& set) { return Loss(*set.instance); }
inline XrResult Loss(const Action& action) { return Loss(*action.set); }
inline XrResult Loss(const Swapchain& swapchain) { return Loss(*swapchain.session); }
inline XrResult Loss(const Space& space) { return Loss(*space.session); }
inline XrResult Loss(const HandTracker& tracker) { return Loss(*tracker.session); }
inline XrResult Loss(const RenderModelAsset& asset) { return Loss(*asset.session); }
inline XrResult Loss(const RenderModel& model) { return Loss(*model.session); }

// A new object of a session, which ends with it. The caller holds the state exclusively.
template <class Handle, class T>
Handle AddChild(State& state, Session& session, std::shared_ptr<T> child) {
  const uint64_t handle = state.handles.Insert(std::move(child));
  session.children.push_back(handle);
  return Handles::As<Handle>(handle);
}

// Allowed in a lost session too.
template <class T, class Handle>
XrResult DestroyChild(Handle handle) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  const auto doomed = state.handles.template Share<T>(handle);
  if (doomed == nullptr) return XR_ERROR_HANDLE_INVALID;
  std::erase(doomed->session->children, doomed->handle);
  state.handles.Erase(doomed->handle);
  return XR_SUCCESS;
}

// The structure of that type in a chain, or nullptr.
template <class T>
T* InChain(void* next, XrStructureType type) {
  auto* link = static_cast<XrBaseOutStructure*>(next);
  while (link != nullptr && link->type != type) link = link->next;
  return reinterpret_cast<T*>(link);
}

// A structure is present and has the right type.
template <class T>
bool Is(const T* structure, XrStructureType type) {
  return structure != nullptr && structure->type == type;
}

// The two-call idiom for arrays: sets the count, copies if there is room.
template <class T, class Fill>
XrResult TwoCall(uint32_t size, uint32_t capacity, uint32_t* count, T* out, Fill fill) {
  if (count == nullptr || (capacity != 0 && out == nullptr)) return XR_ERROR_VALIDATION_FAILURE;
  *count = size;
  if (capacity == 0) return XR_SUCCESS;
  if (capacity < size) return XR_ERROR_SIZE_INSUFFICIENT;
  for (uint32_t i = 0; i < size; ++i) fill(i, out[i]);
  return XR_SUCCESS;
}

// The same for strings: the count includes the terminator.
XrResult TwoCallString(std::string_view text, uint32_t capacity, uint32_t* count, char* out);

// paths.cc: the atoms of one instance. They carry the instance's serial number, so that another instance's fail.
XrPath InternPath(Instance& instance, std::string_view text);
// nullptr when the atom is not one of this instance's.
const std::string* PathText(const Instance& instance, XrPath path);
// 0 left, 1 right, -1 any other path.
int HandOf(const Instance& instance, XrPath path);
bool IsTopLevelPath(const std::string& text);

// events.cc
void PushEvent(Instance& instance, const XrEventDataBuffer& event);
template <class Event>
void Push(Instance& instance, const Event& event) {
  static_assert(sizeof(Event) <= sizeof(XrEventDataBuffer));
  XrEventDataBuffer buffer{XR_TYPE_EVENT_DATA_BUFFER, nullptr, {}};
  std::memcpy(&buffer, &event, sizeof(event));
  PushEvent(instance, buffer);
}
void SetSessionState(Session& session, XrSessionState state);
// [XrEventDataUserPresenceChangedEXT] where the instance enabled the extension: when it changes, and at each begin.
void SendUserPresence(const State& state, Session& session);
// Lets sessions follow World::focus.
void ApplyFocus(State& state);

// models.cc: follows the devices, in a sync. A model that is not shown cannot be located.
void UpdateModels(const World& world, Session& session);
bool IsShown(const RenderModel& model);

// action_state.cc: the answers for (action, subaction path) in a session. Checks the path first.
XrResult FindSlot(Session& session, const Action& action, XrPath subaction, Slot** slot);

}  // namespace omni::runtime

// Leave an entry point with `error` unless `condition` holds.
#define OMNI_REQUIRE(condition, error) \
  do {                                 \
    if (!(condition)) return error;    \
  } while (false)

// Declares `name`, the object behind `handle`, or leaves with HANDLE_INVALID / INSTANCE_LOST / SESSION_LOST.
// NOLINTBEGIN(bugprone-macro-parentheses): a declaration
#define OMNI_FIND(Type, name, handle)                                        \
  Type* const name = ::omni::runtime::TheState().handles.Find<Type>(handle); \
  if (name == nullptr) return XR_ERROR_HANDLE_INVALID;                       \
  if (const XrResult loss_of_##name = ::omni::runtime::Loss(*name); XR_FAILED(loss_of_##name)) return loss_of_##name
// NOLINTEND(bugprone-macro-parentheses)
