// What we remember of the application's objects. A record outlives its handle while something still uses it: a
// destroyed action keeps working in spaces and bindings, as the spec requires.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <shared_mutex>
#include <string>
#include <unordered_map>
#include <vector>

#include "layer/src/entry/omni_openxr_compat.h"
#include "layer/src/spaces/pose_math.h"

namespace omni::layer {

class Session;

struct ActionSet {
  XrActionSet handle = XR_NULL_HANDLE;
  std::uint32_t priority = 0;
  std::atomic<bool> attached{false};  // to any session, ever
};

struct Action {
  XrAction handle = XR_NULL_HANDLE;
  std::shared_ptr<ActionSet> set;
  XrActionType type = XR_ACTION_TYPE_BOOLEAN_INPUT;
  std::vector<XrPath> subactions;
  std::atomic<bool> destroyed{false};  // its handle is invalid and must not be passed down
  std::atomic<bool> withdrawn{false};  // destroyed before its set was attached: it feeds nothing
  bool HasSubaction(XrPath path) const {
    return std::find(subactions.begin(), subactions.end(), path) != subactions.end();
  }
};

// Who serves an action space. Set at xrSyncActions and at creation, read by xrLocateSpace.
enum : int {
  kServedByRuntime = -1,  // pass on
  kServedByNobody = -2    // the pen owns that hand but does not feed this action now
  // >= 0: the pen, by this pose of the current profile
};

struct Space {
  XrSpace handle = XR_NULL_HANDLE;
  std::shared_ptr<Session> session;
  std::shared_ptr<Action> action;  // null: a reference space
  XrReferenceSpaceType reference = XR_REFERENCE_SPACE_TYPE_MAX_ENUM;
  XrPath subaction = XR_NULL_PATH;
  Pose X_PS;                  // poseInActionSpace
  bool focused_only = false;  // not locatable while the session is not focused: of the pen's render model
  std::atomic<int> served_by{kServedByRuntime};
};

// Handle -> record. Readers share.
template <class Handle, class Record>
class HandleMap {
 public:
  std::shared_ptr<Record> Find(Handle handle) const {
    const std::shared_lock lock(mutex_);
    const auto it = map_.find(handle);
    return it == map_.end() ? nullptr : it->second;
  }
  bool Contains(Handle handle) const {
    const std::shared_lock lock(mutex_);
    return map_.count(handle) != 0;
  }
  void Insert(Handle handle, std::shared_ptr<Record> record) {
    const std::unique_lock lock(mutex_);
    map_[handle] = std::move(record);
  }
  void Erase(Handle handle) {
    const std::unique_lock lock(mutex_);
    map_.erase(handle);
  }
  template <class Predicate>
  void EraseIf(Predicate predicate) {
    const std::unique_lock lock(mutex_);
    for (auto it = map_.begin(); it != map_.end();) it = predicate(*it->second) ? map_.erase(it) : std::next(it);
  }
  // The records are touched under the shared lock: keep `visit` short and call no runtime function in it.
  template <class Visit>
  void ForEach(Visit visit) const {
    const std::shared_lock lock(mutex_);
    for (const auto& [handle, record] : map_) visit(*record);
  }
  std::vector<std::shared_ptr<Record>> Values() const {
    const std::shared_lock lock(mutex_);
    std::vector<std::shared_ptr<Record>> out;
    for (const auto& [handle, record] : map_) out.push_back(record);
    return out;
  }

 private:
  mutable std::shared_mutex mutex_;
  std::unordered_map<Handle, std::shared_ptr<Record>> map_;
};

// What the application has made and several parts use.
struct Records {
  HandleMap<XrSession, Session> sessions;
  HandleMap<XrActionSet, ActionSet> action_sets;
  HandleMap<XrAction, Action> actions;
  HandleMap<XrSpace, Space> spaces;
};

}  // namespace omni::layer
