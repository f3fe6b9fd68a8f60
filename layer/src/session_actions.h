// The action state of one session: what the pen feeds, what the runtime feeds, and what the application sees of both.
// Not thread safe: Session guards it. Changes only in Attach and Sync.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "layer/src/clock.h"
#include "layer/src/merge.h"
#include "layer/src/profile.h"
#include "layer/src/records.h"
#include "layer/src/service_link.h"

namespace omni::layer {

// One profile's suggestions of an application: (action, full path).
struct Suggestion {
  std::shared_ptr<Action> action;
  std::string path;
};
// Key: the profile's path. Kept per instance, for every profile that the application suggests.
using Suggestions = std::unordered_map<std::string, std::vector<Suggestion>>;

// One entry of XrActionsSyncInfo, priority resolved.
struct ActiveSet {
  std::shared_ptr<ActionSet> set;
  XrPath subaction = XR_NULL_PATH;
  std::uint32_t priority = 0;
};

// The runtime's own part of an action, asked at sync.
class RuntimeStates {
 public:
  virtual ~RuntimeStates() = default;
  virtual StatePart Query(const Action& action, XrPath subaction) const = 0;
};

struct SyncInput {
  std::vector<ActiveSet> active;
  bool focused = false;
  PenSnapshot pen;
};

class SessionActions {
 public:
  SessionActions(const std::vector<Profile>& profiles, Hand hand, XrPath hand_path)
      : profiles_(profiles), hand_(hand), hand_path_(hand_path) {}

  // Binds what the application suggested, once: the best profile that gives our hand something.
  void Attach(const std::vector<std::shared_ptr<ActionSet>>& sets, const std::vector<std::shared_ptr<Action>>& actions,
              const Suggestions& suggestions);

  void Sync(const SyncInput& input, const RuntimeStates& runtime, const RuntimeClock& clock, XrTime now);

  bool attached(const ActionSet& set) const;
  bool any_attached() const { return any_attached_; }

  // True while our hand is the pen's. Changes in Sync only.
  bool pen_owns_hand() const { return owner_; }
  // The pen has owned the hand once: from then on states are merged and remembered here.
  bool merging() const { return merging_; }
  const Profile* profile() const { return owner_ ? chosen_ : nullptr; }

  // State of (action, subaction) at the last sync; null: the runtime's own answer stands.
  const ActionState* Find(const Action& action, XrPath subaction) const;

  // Brings Space::served_by of an action space up to date.
  void Serve(Space& space) const;

  // X_TP of a pose that Serve has named. Needs no lock: the profile is fixed once a space is served by the pen.
  const Pose& PosePart(int pose) const { return chosen_->poses[static_cast<std::size_t>(pose)].X_TP; }

  // Sources of the pen for this action, and whether it may vibrate for it now.
  std::vector<std::string> BoundSources(const Action& action) const;
  bool HapticBound(const Action& action, XrPath subaction) const;

 private:
  struct LiveBinding {
    Binding binding;
    bool live = false;  // its set is active for our hand, and no higher priority takes its source
  };
  enum class Device { kNone, kPen, kRuntime };
  struct View {  // one (action, subaction) as an application may ask for it
    ActionState state;
    Device pose_device = Device::kNone;
  };
  struct Bound {
    std::shared_ptr<Action> action;
    std::vector<LiveBinding> bindings;
    View any;    // XR_NULL_PATH
    View owned;  // our hand
  };
  struct ComponentState {  // a component of the chosen profile at this sync
    float value = 0;
    EdgeTracker edges;
    XrTime value_time = 0;
    XrTime click_time = 0;
  };

  void UpdateOwner(const SyncInput& input);
  void UpdateComponents(const PenSnapshot& pen, const RuntimeClock& clock, bool restart);
  void UpdateLive(const std::vector<ActiveSet>& active);
  StatePart PenPart(const Bound& bound) const;
  StatePart RuntimePartOfAny(const Action& action, const RuntimeStates& runtime) const;
  StatePart Scalar(BindingKind kind, int component) const;
  void AdvancePose(View& view, const StatePart& runtime, const StatePart& pen, bool sticky) const;
  int SpaceServedBy(const Action& action, XrPath subaction) const;
  const Bound* FindBound(const Action& action) const;

  const std::vector<Profile>& profiles_;
  const Hand hand_;
  const XrPath hand_path_;
  const Profile* chosen_ = nullptr;
  bool any_attached_ = false;
  bool owner_ = false;
  bool merging_ = false;
  bool start_edges_ = false;
  std::uint64_t service_instance_ = 0;
  std::vector<std::shared_ptr<ActionSet>> sets_;
  std::unordered_map<const Action*, Bound> bound_;
  std::vector<ComponentState> components_;
};

}  // namespace omni::layer
