#include "layer/src/actions/session_actions.h"

#include <algorithm>
#include <string_view>

namespace omni::layer {

SessionActions::SessionActions(const std::vector<Profile>& profiles, const PenChoice& choice,
                               const std::array<XrPath, 2>& hand_paths)
    : profiles_(profiles), hand_paths_(hand_paths), choice_(choice) {
  for (const Profile& profile : profiles_) {
    first_pose_.push_back(static_cast<int>(poses_.size()));
    for (const PoseComponent& pose : profile.poses) poses_.push_back(&pose);
  }
  static const PoseComponent kTool{};
  poses_.push_back(&kTool);
}

void SessionActions::Attach(const std::vector<std::shared_ptr<ActionSet>>& sets,
                            const std::vector<std::shared_ptr<Action>>& actions, const Suggestions& suggestions) {
  any_attached_ = true;
  sets_ = sets;
  suggestions_ = suggestions;
  for (const std::shared_ptr<Action>& action : actions)
    if (attached(*action->set)) bound_[action.get()].action = action;
  FindPlaces();
  Bind();
}

SessionActions::Place SessionActions::PlaceOf(const Action& action, const std::string& suggested) const {
  const bool any = action.subactions.empty();
  for (const Hand hand : {Hand::kLeft, Hand::kRight}) {
    if (suggested.rfind(std::string(UserPath(hand)) + "/", 0) != 0) continue;
    const Place there = hand == Hand::kLeft ? Place::kLeft : Place::kRight;
    return any || action.HasSubaction(PathOf(hand)) ? there : Place::kNowhere;
  }
  const auto is_no_hand = [this](XrPath path) {
    return std::find(hand_paths_.begin(), hand_paths_.end(), path) == hand_paths_.end();
  };
  const bool declared = any || std::any_of(action.subactions.begin(), action.subactions.end(), is_no_hand);
  return declared ? Place::kElsewhere : Place::kNowhere;
}

void SessionActions::FindPlaces() {
  for (const auto& [profile, entries] : suggestions_) {
    for (const Suggestion& s : entries) {
      const auto bound = bound_.find(s.action.get());
      const Place place = PlaceOf(*s.action, s.path);
      if (bound == bound_.end() || place == Place::kNowhere) continue;
      Place& known = bound->second.place;
      known = known == Place::kNowhere || known == place ? place : Place::kSeveral;
    }
  }
}

// The profile with bindings for the pen's hand: the preferred one, else the first in order of priority.
void SessionActions::Bind() {
  chosen_ = nullptr;
  preference_unusable_ = false;
  if (!choice_.profile.empty()) {
    const auto preferred = std::find_if(profiles_.begin(), profiles_.end(),
                                        [this](const Profile& profile) { return profile.path == choice_.profile; });
    preference_unusable_ = preferred == profiles_.end() || !BindProfile(*preferred);
    if (!preference_unusable_) return;
  }
  for (const Profile& profile : profiles_)
    if (BindProfile(profile)) return;
}

bool SessionActions::BindProfile(const Profile& profile) {
  for (auto& [key, bound] : bound_) bound.bindings.clear();
  const auto suggested = suggestions_.find(profile.path);
  if (suggested == suggestions_.end()) return false;
  bool any = false;
  for (const Suggestion& s : suggested->second) {
    const auto bound = bound_.find(s.action.get());
    if (bound == bound_.end()) continue;
    auto binding = ResolveBinding(profile, choice_.hand, s.action->type, s.path);
    if (!binding) continue;
    bound->second.bindings.push_back({std::move(*binding), s.threshold, {}, false});
    any = true;
  }
  if (!any) return false;
  chosen_ = &profile;
  return true;
}

bool SessionActions::attached(const ActionSet& set) const {
  return std::any_of(sets_.begin(), sets_.end(), [&](const auto& s) { return s.get() == &set; });
}

// Who owns the pen's hand. Selected in focused syncs only: before the first one no profile is current.
void SessionActions::UpdateOwner(const SyncInput& input) {
  start_edges_ = input.start_edges || !focused_;
  focused_ = input.focused;
  if (!input.focused) return;
  if (!(input.choice == choice_)) {
    choice_ = input.choice;
    start_edges_ = true;
    Bind();
  }
  put_down_ = input.pen.present && input.put_down;
  bool owner = chosen_ != nullptr && input.pen.present && !put_down_;
  if (owner && !merging_ && synced_) {
    // The pen's first state is compared with the runtime's present one: the hand changes in the next sync.
    merging_ = true;
    owner = false;
  }
  start_edges_ = start_edges_ || !owner_ || service_instance_ != input.pen.service_instance;
  owner_ = owner;
  merging_ = merging_ || owner;
  synced_ = synced_ || any_attached_;
  service_instance_ = input.pen.service_instance;
}

void SessionActions::StepBinding(LiveBinding& b, const InputValue& value, const InputValue& click) {
  const bool digital = inputs_[static_cast<std::size_t>(b.binding.first)].digital;
  const bool own_threshold =
      b.threshold.has_value() &&
      chosen_->components[static_cast<std::size_t>(b.binding.first)].type == ComponentType::kFloat;
  const InputValue& counted = own_threshold ? value : click;
  if (start_edges_) b.edges.Start(counted.press_count, counted.release_count);
  const bool before = b.edges.pressed;
  if (own_threshold) {
    b.edges.StepAnalog(value.value, value.press_count, b.threshold->on, b.threshold->off);
  } else if (digital) {
    b.edges.StepDigital(click.value > kPressThreshold, click.press_count, click.release_count);
  } else {
    b.edges.StepAnalog(value.value, value.press_count);
  }
  if (!own_threshold || !b.live || b.binding.kind != BindingKind::kBoolean || before == b.edges.pressed) return;
  const std::optional<Pulse>& pulse = b.edges.pressed ? b.threshold->on_pulse : b.threshold->off_pulse;
  if (pulse) pulses_.push_back(*pulse);
}

void SessionActions::UpdateInputs(const SyncInput& input) {
  inputs_ = ReadInputs(*chosen_, input.pen.inputs, input.test);
  pulses_.clear();
  for (auto& [key, bound] : bound_) {
    for (LiveBinding& b : bound.bindings) {
      if (b.binding.kind != BindingKind::kBoolean && b.binding.kind != BindingKind::kFloat) continue;
      const ComponentInput& component = inputs_[static_cast<std::size_t>(b.binding.first)];
      StepBinding(b, component.value, component.click);
    }
  }
}

// [XrActionSetCreateInfo] A source feeds only the active sets of the highest priority that bind it.
void SessionActions::UpdateLive(const std::vector<ActiveSet>& active) {
  std::unordered_map<std::string_view, std::uint32_t> highest;
  const auto source = [](const LiveBinding& b) -> std::string_view { return b.binding.identifier; };
  const auto priority_of = [&](const Action& action, std::uint32_t* priority) {
    bool is_active = false;
    for (const ActiveSet& entry : active) {
      if (entry.set != action.set) continue;
      const bool other_hand = entry.subaction != XR_NULL_PATH && entry.subaction != hand_path();
      if (other_hand) continue;
      *priority = entry.priority;
      is_active = true;
    }
    return is_active && (action.subactions.empty() || action.HasSubaction(hand_path()));
  };
  for (auto& [key, bound] : bound_) {
    std::uint32_t priority = 0;
    const bool is_active = bound.active = priority_of(*bound.action, &priority);
    for (LiveBinding& b : bound.bindings) {
      b.live = is_active;
      if (!is_active) continue;
      std::uint32_t& top = highest.try_emplace(source(b), priority).first->second;
      top = std::max(top, priority);
    }
  }
  for (auto& [key, bound] : bound_) {
    std::uint32_t priority = 0;
    if (!priority_of(*bound.action, &priority)) continue;
    for (LiveBinding& b : bound.bindings)
      b.live = b.binding.kind == BindingKind::kHaptic || priority >= highest[source(b)];
  }
}

StatePart SessionActions::Scalar(const LiveBinding& b, int index, const RuntimeClock& clock) const {
  if (static_cast<std::size_t>(index) >= inputs_.size()) return {};  // no data from the pen yet
  const ComponentInput& input = inputs_[static_cast<std::size_t>(index)];
  const bool digital = b.binding.kind == BindingKind::kBoolean ||
                       chosen_->components[static_cast<std::size_t>(index)].type == ComponentType::kBoolean;
  const bool by_click = digital && input.digital && !b.threshold;
  const std::int64_t t_ns = by_click ? input.click.t_change_ns : input.value.t_change_ns;
  StatePart part;
  part.active = true;
  part.change_time = t_ns > 0 ? clock.ToXr(t_ns) : 0;
  part.value.x = digital ? (b.edges.pressed ? 1.0f : 0.0f) : input.value.value;
  return part;
}

StatePart SessionActions::PenPart(const Bound& bound, const RuntimeClock& clock) const {
  StatePart out;
  if (!owner_) return out;
  for (const LiveBinding& b : bound.bindings) {
    if (!b.live) continue;
    StatePart part;
    part.active = true;
    if (b.binding.kind == BindingKind::kBoolean || b.binding.kind == BindingKind::kFloat) {
      part = Scalar(b, b.binding.first, clock);
    } else if (b.binding.kind == BindingKind::kVector2) {
      const StatePart x = Scalar(b, b.binding.first, clock);
      const StatePart y = Scalar(b, b.binding.second, clock);
      part.value = {x.value.x, y.value.x};
      part.change_time = std::max(x.change_time, y.change_time);
    }
    out = Merge(bound.action->type, out, part);
  }
  return out;
}

// While the pen owns its hand, a runtime's controller of that hand must not contribute. The runtime's answer to an
// action without subaction paths cannot be split by hand: it is included unless only the pen's hand is bound.
StatePart SessionActions::RuntimePartOfAny(const Bound& bound, const RuntimeStates& runtime) const {
  const Action& action = *bound.action;
  if (!owner_) return runtime.Query(action, XR_NULL_PATH);
  if (OnlyAtPensHand(bound)) return {};
  if (action.subactions.empty()) return runtime.Query(action, XR_NULL_PATH);
  StatePart out;
  for (const XrPath path : action.subactions)
    if (path != hand_path()) out = Merge(action.type, out, runtime.Query(action, path));
  return out;
}

// A pen that was put down yields to the runtime's controller until it is picked up again.
SessionActions::Device SessionActions::PoseDevice(const View& view) const {
  return view.pose_device == Device::kPen && put_down_ ? Device::kRuntime : view.pose_device;
}

void SessionActions::AdvanceView(View& view, const Action& action, const StatePart& runtime, const StatePart& pen,
                                 bool sticky, XrTime now) const {
  if (action.type != XR_ACTION_TYPE_POSE_INPUT) {
    view.state = Advance(action.type, view.state, runtime, pen, now);
    return;
  }
  // [input-multiple] One source, which changes when a controller is picked up or goes off. Of several places, the
  // XR_NULL_PATH view stays with the first that fed it, even when that goes off: another hand must not take over. Of
  // two that are there from the beginning, the left hand's is the first, as in the conformance tests.
  if (view.pose_device == Device::kNone || !sticky) {
    const bool runtimes_first = sticky && choice_.hand == Hand::kRight && runtime.active;
    view.pose_device = pen.active && !runtimes_first ? Device::kPen : runtime.active ? Device::kRuntime : Device::kNone;
  }
  view.state.active = PoseDevice(view) == Device::kPen ? pen.active : runtime.active;
}

void SessionActions::Sync(const SyncInput& input, const RuntimeStates& runtime, const RuntimeClock& clock, XrTime now) {
  UpdateOwner(input);
  if (!merging_) return;
  UpdateLive(input.focused ? input.active : std::vector<ActiveSet>{});
  if (owner_ && input.pen.present) UpdateInputs(input);
  for (auto& [key, bound] : bound_) {
    const Action& action = *bound.action;
    if (action.type == XR_ACTION_TYPE_VIBRATION_OUTPUT) continue;
    const StatePart pen = input.focused ? PenPart(bound, clock) : StatePart{};
    const StatePart runtimes_any = input.focused ? RuntimePartOfAny(bound, runtime) : StatePart{};
    AdvanceView(bound.any, action, runtimes_any, pen, bound.place == Place::kSeveral, now);
    bound.any.ours = bound.any.ours || owner_;
    for (const Hand hand : {Hand::kLeft, Hand::kRight}) {
      if (!action.HasSubaction(PathOf(hand))) continue;
      const bool pens = owner_ && hand == choice_.hand;
      const bool runtimes = !pens;
      const StatePart theirs = input.focused && runtimes ? runtime.Query(action, PathOf(hand)) : StatePart{};
      View& view = ViewAt(bound, hand);
      AdvanceView(view, action, theirs, pens ? pen : StatePart{}, false, now);
      view.ours = view.ours || pens;
    }
  }
}

const SessionActions::Bound* SessionActions::FindBound(const Action& action) const {
  const auto it = bound_.find(&action);
  return it == bound_.end() ? nullptr : &it->second;
}

const ActionState* SessionActions::FindState(const Action& action, XrPath subaction) const {
  const Bound* bound = merging_ ? FindBound(action) : nullptr;
  if (!bound) return nullptr;
  if (subaction == XR_NULL_PATH) return bound->any.ours ? &bound->any.state : nullptr;
  for (const Hand hand : {Hand::kLeft, Hand::kRight}) {
    const View& view = bound->at_hand[static_cast<std::size_t>(hand)];
    if (subaction == PathOf(hand) && view.ours) return &view.state;
  }
  return nullptr;
}

int SessionActions::SpaceServedBy(const Action& action, XrPath subaction) const {
  const Bound* bound = merging_ ? FindBound(action) : nullptr;
  if (!bound) return kServedByRuntime;
  const bool any = subaction == XR_NULL_PATH;
  if (subaction == hand_path() || (any && OnlyAtPensHand(*bound))) {
    if (!owner_) return kServedByRuntime;
  } else {
    if (!any || PoseDevice(bound->any) != Device::kPen) return kServedByRuntime;
    if (!owner_) return kServedByNobody;
  }
  const int first = first_pose_[static_cast<std::size_t>(chosen_ - profiles_.data())];
  for (const LiveBinding& b : bound->bindings)
    if (b.live && b.binding.kind == BindingKind::kPose) return first + b.binding.first;
  return kServedByNobody;
}

void SessionActions::UpdateServedBy(Space& space) const {
  space.served_by.store(SpaceServedBy(*space.action, space.subaction), std::memory_order_release);
}

std::vector<std::string> SessionActions::BoundSources(const Action& action) const {
  std::vector<std::string> out;
  const Bound* bound = owner_ ? FindBound(action) : nullptr;
  if (!bound || (!action.subactions.empty() && !action.HasSubaction(hand_path()))) return out;
  for (const LiveBinding& b : bound->bindings)
    if (std::find(out.begin(), out.end(), b.binding.path) == out.end()) out.push_back(b.binding.path);
  return out;
}

bool SessionActions::FeedsSubaction() const {
  return owner_ && std::any_of(bound_.begin(), bound_.end(), [this](const auto& entry) {
           const Bound& bound = entry.second;
           return bound.active && !bound.bindings.empty() && bound.action->HasSubaction(hand_path());
         });
}

bool SessionActions::HapticBound(const Action& action, XrPath subaction) const {
  const Bound* bound = owner_ ? FindBound(action) : nullptr;
  if (!bound || (subaction != XR_NULL_PATH && subaction != hand_path())) return false;
  return std::any_of(bound->bindings.begin(), bound->bindings.end(),
                     [](const LiveBinding& b) { return b.live && b.binding.kind == BindingKind::kHaptic; });
}

std::vector<XrPath> SessionActions::SubactionsBelow(const Action& action, XrPath subaction) const {
  const Bound* bound = owner_ ? FindBound(action) : nullptr;
  if (!bound) return {subaction};
  if (subaction != XR_NULL_PATH) {
    const bool pens = subaction == hand_path() && action.HasSubaction(subaction);
    return pens ? std::vector<XrPath>{} : std::vector<XrPath>{subaction};
  }
  if (OnlyAtPensHand(*bound)) return {};
  if (!action.HasSubaction(hand_path())) return {subaction};
  std::vector<XrPath> others = action.subactions;
  others.erase(std::remove(others.begin(), others.end(), hand_path()), others.end());
  return others;
}

}  // namespace omni::layer
