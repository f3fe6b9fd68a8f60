// The action state of one session: what the pen feeds, what the runtime feeds, and what the application sees of both.
// Not thread safe: Session guards it. Changes only in Attach and Sync.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "layer/src/actions/binding_modifications.h"
#include "layer/src/actions/merge.h"
#include "layer/src/actions/pen.h"
#include "layer/src/actions/profile.h"
#include "layer/src/instance/clock.h"
#include "layer/src/instance/records.h"
#include "layer/src/service/service_link.h"

namespace omni::layer {

// One profile's suggestions of an application: (action, full path).
struct Suggestion {
  std::shared_ptr<Action> action;
  std::string path;
  std::optional<AnalogThreshold> threshold;  // for this conversion instead of ours
};
// Key: the profile's path. Kept per instance, for every profile that the application suggests.
using Suggestions = std::unordered_map<std::string, std::vector<Suggestion>>;

// One entry of XrActionsSyncInfo, priority resolved.
struct ActiveSet {
  std::shared_ptr<ActionSet> set;
  XrPath subaction = XR_NULL_PATH;
  std::uint32_t priority = 0;
};

// The runtime's own part of an action, queried at sync.
class RuntimeStates {
 public:
  virtual ~RuntimeStates() = default;
  virtual StatePart Query(const Action& action, XrPath subaction) const = 0;
};

struct SyncInput {
  std::vector<ActiveSet> active;
  bool focused = false;
  PenChoice choice;
  PenSnapshot pen;
  bool put_down = false;             // the pen is present but has yielded its hand to the runtime's controller
  const TestInputs* test = nullptr;  // conformance automation replaces the pen
  bool start_edges = false;          // presses since the last sync were not meant for this session
};

class SessionActions {
 public:
  // `profiles`, highest priority first, outlive this. `hand_paths`: by Hand.
  SessionActions(const std::vector<Profile>& profiles, const PenChoice& choice,
                 const std::array<XrPath, 2>& hand_paths);

  void Attach(const std::vector<std::shared_ptr<ActionSet>>& sets, const std::vector<std::shared_ptr<Action>>& actions,
              const Suggestions& suggestions);

  void Sync(const SyncInput& input, const RuntimeStates& runtime, const RuntimeClock& clock, XrTime now);

  bool attached(const ActionSet& set) const;
  bool any_attached() const { return any_attached_; }

  Hand hand() const { return choice_.hand; }
  XrPath hand_path() const { return PathOf(choice_.hand); }
  // True while the pen owns its hand. Changes in Sync only.
  bool pen_owns_hand() const { return owner_; }
  // The pen's profile, while it owns its hand. Changes in Sync only.
  const Profile* profile() const { return owner_ ? chosen_ : nullptr; }
  // The same at one hand: null where the runtime's answer applies.
  const Profile* ProfileAt(XrPath user_path) const { return user_path == hand_path() ? profile() : nullptr; }
  // The preferred profile has no suggested binding that the pen serves.
  bool preference_unusable() const { return preference_unusable_; }

  // State of (action, subaction) at the last sync; null: the runtime's own answer applies.
  const ActionState* FindState(const Action& action, XrPath subaction) const;

  // Brings Space::served_by of an action space up to date.
  void UpdateServedBy(Space& space) const;

  // X_TP of a pose that Serve has named. Needs no lock: the profiles are constant.
  const Pose& PosePart(int pose) const { return poses_[static_cast<std::size_t>(pose)]->X_TP; }
  // The pose of the tool frame itself, which no profile names.
  int tool_pose() const { return static_cast<int>(poses_.size()) - 1; }

  // The pen's hand is a subaction path of an action in the sets of the last sync that is bound to the pen.
  bool FeedsSubaction() const;

  // Sources of the pen for this action, and whether it may vibrate for it now.
  std::vector<std::string> BoundSources(const Action& action) const;
  bool HapticBound(const Action& action, XrPath subaction) const;

  // The subaction paths of the runtime's devices when an application uses `subaction`: without that of the pen's hand
  // while the pen owns it.
  std::vector<XrPath> SubactionsBelow(const Action& action, XrPath subaction) const;

  // Vibrations requested by thresholds in the last sync; clears them.
  std::vector<Pulse> PopPulses() { return std::exchange(pulses_, {}); }

 private:
  enum class Device { kNone, kPen, kRuntime };
  // Where the sources of an action can lie: the top-level paths of its suggestions, of all profiles, that it declares.
  enum class Place { kNowhere, kLeft, kRight, kElsewhere, kSeveral };
  struct LiveBinding {
    Binding binding;
    std::optional<AnalogThreshold> threshold;
    EdgeTracker edges;
    bool live = false;  // feeds its action in the present sync
  };
  struct View {  // of an action, at one subaction path or at XR_NULL_PATH
    ActionState state;
    Device pose_device = Device::kNone;
    bool ours = false;  // the pen has fed it once: from then on this layer answers
  };
  struct Bound {
    std::shared_ptr<Action> action;
    std::vector<LiveBinding> bindings;
    bool active = false;  // its set was, in the last sync, for the pen's hand
    Place place = Place::kNowhere;
    View any;
    std::array<View, 2> at_hand;
  };

  XrPath PathOf(Hand hand) const { return hand_paths_[static_cast<std::size_t>(hand)]; }
  View& ViewAt(Bound& bound, Hand hand) const { return bound.at_hand[static_cast<std::size_t>(hand)]; }
  Place PlaceOf(const Action& action, const std::string& suggested) const;
  void FindPlaces();
  // The only device that can feed it is that of the pen's hand: XR_NULL_PATH then means this hand.
  bool OnlyAtPensHand(const Bound& bound) const {
    return bound.place == (choice_.hand == Hand::kLeft ? Place::kLeft : Place::kRight);
  }
  void Bind();
  bool BindProfile(const Profile& profile);
  void UpdateOwner(const SyncInput& input);
  void UpdateInputs(const SyncInput& input);
  void UpdateLive(const std::vector<ActiveSet>& active);
  void UpdateBound(Bound& bound, bool focused, const RuntimeStates& runtime, XrTime now) const;
  void StepBinding(LiveBinding& b, const InputValue& value, const InputValue& click);
  StatePart Scalar(const LiveBinding& b, int component, const RuntimeClock& clock) const;
  StatePart PenPart(const Bound& bound, const RuntimeClock& clock) const;
  StatePart RuntimePartOfAny(const Bound& bound, const RuntimeStates& runtime) const;
  void AdvanceView(View& view, const Action& action, const StatePart& runtime, const StatePart& pen, bool sticky,
                   XrTime now) const;
  Device PoseDevice(const View& view) const;
  int SpaceServedBy(const Action& action, XrPath subaction) const;
  const Bound* FindBound(const Action& action) const;

  const std::vector<Profile>& profiles_;
  const std::array<XrPath, 2> hand_paths_;
  std::vector<const PoseComponent*> poses_;  // of all profiles, one after another
  std::vector<int> first_pose_;              // of each profile, in poses_

  PenChoice choice_;
  const Profile* chosen_ = nullptr;
  bool preference_unusable_ = false;
  bool any_attached_ = false;
  bool synced_ = false;   // with focus, once
  bool focused_ = false;  // in the last sync
  bool owner_ = false;
  bool merging_ = false;  // states are remembered here; from the sync before the pen first owns its hand
  bool put_down_ = false;
  bool start_edges_ = false;
  std::uint64_t service_instance_ = 0;
  std::vector<std::shared_ptr<ActionSet>> sets_;
  Suggestions suggestions_;
  std::unordered_map<const Action*, Bound> bound_;
  std::vector<ComponentInput> inputs_;  // by component of the chosen profile
  std::vector<Pulse> pulses_;
};

}  // namespace omni::layer
