// All instances of this process: the layer's only global state.
#pragma once

#include <memory>
#include <optional>
#include <shared_mutex>
#include <vector>

#include "layer/src/instance/instance.h"

namespace omni::layer {

// An instance that this layer has nothing to do with: something is missing below.
struct AsideInstance {
  XrInstance handle;
  PFN_xrGetInstanceProcAddr get;
  PFN_xrDestroyInstance destroy;
  bool hide_timespec;
};

class Registry {
 public:
  static Registry& Get();

  void AddAside(const AsideInstance& instance);
  std::optional<AsideInstance> FindAside(XrInstance handle) const;

  void Add(std::shared_ptr<Instance> instance);
  void Remove(XrInstance handle);  // of either kind
  std::shared_ptr<Instance> Find(XrInstance handle) const;

  // The instance that made this handle. An unknown handle (made by a function that we do not intercept, or invalid) is
  // left to the runtime: it goes down through the newest instance. Null: there is no instance.
  template <class Handle>
  std::shared_ptr<Instance> FindOwner(Handle handle) const {
    const std::shared_lock lock(mutex_);
    if (instances_.empty()) return nullptr;
    if (instances_.size() == 1) return instances_.front();
    for (const auto& instance : instances_)
      if (Knows(*instance, handle)) return instance;
    return instances_.back();
  }

 private:
  static bool Knows(const Instance& i, XrSession handle) { return i.records.sessions.Contains(handle); }
  static bool Knows(const Instance& i, XrActionSet handle) { return i.records.action_sets.Contains(handle); }
  static bool Knows(const Instance& i, XrAction handle) { return i.records.actions.Contains(handle); }
  static bool Knows(const Instance& i, XrSpace handle) { return i.records.spaces.Contains(handle); }
  static bool Knows(const Instance& i, XrHandTrackerEXT handle) { return i.locator.Contains(handle); }
  static bool Knows(const Instance& i, XrRenderModelEXT handle) { return i.render_models.Contains(handle); }
  static bool Knows(const Instance& i, XrRenderModelAssetEXT handle) { return i.render_models.Contains(handle); }
  static bool Knows(const Instance& i, XrForceFeedbackOMNIX1 handle) { return i.force_feedbacks.Contains(handle); }
  static bool Knows(const Instance& i, XrHapticSceneOMNIX1 handle) { return i.haptic_scenes.Contains(handle); }

  mutable std::shared_mutex mutex_;
  std::vector<std::shared_ptr<Instance>> instances_;
  std::vector<AsideInstance> aside_;
};

}  // namespace omni::layer
