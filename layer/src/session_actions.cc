#include "layer/src/session_actions.h"

#include <algorithm>
#include <string_view>

#include "layer/src/fault.h"

namespace omni::layer {
namespace {

std::vector<Binding> ResolveFor(const Profile& profile, Hand hand, const Action& action,
                                const std::vector<Suggestion>& suggested) {
  std::vector<Binding> out;
  for (const Suggestion& s : suggested) {
    if (s.action.get() != &action) continue;
    if (auto binding = Resolve(profile, hand, action.type, s.path)) out.push_back(std::move(*binding));
  }
  return out;
}

}  // namespace

void SessionActions::Attach(const std::vector<std::shared_ptr<ActionSet>>& sets,
                            const std::vector<std::shared_ptr<Action>>& actions, const Suggestions& suggestions) {
  any_attached_ = true;
  sets_ = sets;
  for (const std::shared_ptr<Action>& action : actions)
    if (attached(*action->set)) bound_[action.get()].action = action;
  for (const Profile& profile : profiles_) {  // highest priority first
    const auto suggested = suggestions.find(profile.path);
    if (suggested == suggestions.end()) continue;
    for (auto& [key, bound] : bound_) {
      for (Binding& binding : ResolveFor(profile, hand_, *bound.action, suggested->second)) {
        chosen_ = &profile;
        bound.bindings.push_back({std::move(binding), false});
      }
    }
    if (chosen_ && !OMNI_FAULT("lowest-profile-chosen")) break;
  }
  if (chosen_) components_.resize(chosen_->components.size());
}

bool SessionActions::attached(const ActionSet& set) const {
  return std::any_of(sets_.begin(), sets_.end(), [&](const auto& s) { return s.get() == &set; });
}

void SessionActions::UpdateOwner(const SyncInput& input) {
  // Selection is made in focused syncs only: before the first one no profile is current.
  start_edges_ = false;
  if (!input.focused && !OMNI_FAULT("unfocused-sync-selects")) return;
  const bool owner = chosen_ != nullptr && (input.pen.present || OMNI_FAULT("absent-pen-present"));
  start_edges_ = owner && (!owner_ || service_instance_ != input.pen.service_instance);
  owner_ = owner;
  merging_ = merging_ || owner;
  service_instance_ = input.pen.service_instance;
}

void SessionActions::UpdateComponents(const PenSnapshot& pen, const RuntimeClock& clock, bool restart) {
  static const protocol::InputValue kAtRest;
  for (std::size_t i = 0; i < components_.size(); ++i) {
    const Component& component = chosen_->components[i];
    ComponentState& state = components_[i];
    const auto input = [&](int source) -> const protocol::InputValue& {
      return source == kNoSource ? kAtRest : pen.inputs.components[static_cast<std::size_t>(source)];
    };
    const protocol::InputValue& value = input(component.source);
    const bool digital = component.type == ComponentType::kBoolean || component.click_source != kNoSource;
    const protocol::InputValue& click = component.click_source != kNoSource ? input(component.click_source) : value;
    if (restart && !OMNI_FAULT("old-presses-reported")) state.edges.Start(click.press_count, click.release_count);
    if (digital) {
      state.edges.StepDigital(click.value > kPressThreshold, click.press_count, click.release_count);
    } else {
      state.edges.StepAnalog(value.value, value.press_count);
    }
    state.value = value.value;
    state.value_time = value.t_change_ns > 0 ? clock.ToXr(value.t_change_ns) : 0;
    state.click_time = click.t_change_ns > 0 ? clock.ToXr(click.t_change_ns) : 0;
  }
}

// [XrActionSetCreateInfo] A source feeds only the active sets of the highest priority that bind it.
void SessionActions::UpdateLive(const std::vector<ActiveSet>& active) {
  std::unordered_map<std::string_view, std::uint32_t> highest;
  const auto source = [](const LiveBinding& b) -> std::string_view {
    return OMNI_FAULT("components-apart") ? b.binding.path : b.binding.identifier;
  };
  const auto priority_of = [&](const Action& action, std::uint32_t* priority) {
    bool is_active = false;
    for (const ActiveSet& entry : active) {
      if (entry.set != action.set) continue;
      const bool other_hand = entry.subaction != XR_NULL_PATH && entry.subaction != hand_path_;
      if (other_hand && !OMNI_FAULT("active-subaction-ignored")) continue;
      *priority = entry.priority;
      is_active = true;
    }
    return is_active && (action.subactions.empty() || action.Declares(hand_path_));
  };
  for (auto& [key, bound] : bound_) {
    std::uint32_t priority = 0;
    const bool is_active = priority_of(*bound.action, &priority);
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
      b.live =
          b.binding.kind == BindingKind::kHaptic || priority >= highest[source(b)] || OMNI_FAULT("priority-ignored");
  }
}

StatePart SessionActions::Scalar(BindingKind kind, int index) const {
  const ComponentState& state = components_[static_cast<std::size_t>(index)];
  const bool digital = kind == BindingKind::kBoolean ||
                       chosen_->components[static_cast<std::size_t>(index)].type == ComponentType::kBoolean;
  StatePart part;
  part.active = true;
  part.change_time = digital ? state.click_time : state.value_time;
  part.value.x = digital ? (state.edges.pressed ? 1.0f : 0.0f) : state.value;
  return part;
}

StatePart SessionActions::PenPart(const Bound& bound) const {
  StatePart out;
  if (!owner_) return out;
  for (const LiveBinding& b : bound.bindings) {
    if (!b.live) continue;
    StatePart part;
    part.active = true;
    if (b.binding.kind == BindingKind::kBoolean || b.binding.kind == BindingKind::kFloat) {
      part = Scalar(b.binding.kind, b.binding.first);
    } else if (b.binding.kind == BindingKind::kVector2) {
      const StatePart x = Scalar(BindingKind::kFloat, b.binding.first);
      const StatePart y = Scalar(BindingKind::kFloat, b.binding.second);
      part.value = {x.value.x, OMNI_FAULT("vector-loses-y") ? 0.0f : y.value.x};
      part.change_time = std::max(x.change_time, y.change_time);
    }
    out = Merge(bound.action->type, out, part);
  }
  return out;
}

// While the pen owns our hand, a runtime's controller of that hand must not speak. Without subaction paths the
// runtime's answer cannot be divided by hand; then it stays in.
StatePart SessionActions::RuntimePartOfAny(const Action& action, const RuntimeStates& runtime) const {
  if (!owner_ || action.subactions.empty()) return runtime.Query(action, XR_NULL_PATH);
  StatePart out;
  if (OMNI_FAULT("other-hand-stolen")) return out;
  for (const XrPath path : action.subactions)
    if (path != hand_path_) out = Merge(action.type, out, runtime.Query(action, path));
  return out;
}

void SessionActions::AdvancePose(View& view, const StatePart& runtime, const StatePart& pen, bool sticky) const {
  // [input-multiple] One device; the XR_NULL_PATH view stays with the first it got, even when that goes off.
  if (view.pose_device == Device::kNone || !sticky || OMNI_FAULT("pose-device-switches"))
    view.pose_device = pen.active ? Device::kPen : runtime.active ? Device::kRuntime : Device::kNone;
  view.state.active = view.pose_device == Device::kPen ? pen.active : runtime.active;
}

void SessionActions::Sync(const SyncInput& input, const RuntimeStates& runtime, const RuntimeClock& clock, XrTime now) {
  UpdateOwner(input);
  if (!merging_) return;
  if (owner_ && input.pen.present) UpdateComponents(input.pen, clock, start_edges_);
  UpdateLive(input.focused ? input.active : std::vector<ActiveSet>{});
  for (auto& [key, bound] : bound_) {
    const Action& action = *bound.action;
    if (action.type == XR_ACTION_TYPE_VIBRATION_OUTPUT) continue;
    const StatePart pen = PenPart(bound);
    const StatePart others = input.focused ? RuntimePartOfAny(action, runtime) : StatePart{};
    const bool has_hand = action.Declares(hand_path_);
    const bool runtimes = !owner_ || OMNI_FAULT("runtime-controller-heard");
    const StatePart mine = input.focused && has_hand && runtimes ? runtime.Query(action, hand_path_) : StatePart{};
    if (action.type == XR_ACTION_TYPE_POSE_INPUT) {
      AdvancePose(bound.any, others, pen, true);
      if (has_hand) AdvancePose(bound.owned, mine, pen, false);
      continue;
    }
    bound.any.state = Advance(action.type, bound.any.state, others, pen, now);
    if (has_hand) bound.owned.state = Advance(action.type, bound.owned.state, mine, pen, now);
  }
}

const SessionActions::Bound* SessionActions::FindBound(const Action& action) const {
  const auto it = bound_.find(&action);
  return it == bound_.end() ? nullptr : &it->second;
}

const ActionState* SessionActions::Find(const Action& action, XrPath subaction) const {
  const Bound* bound = merging_ ? FindBound(action) : nullptr;
  if (!bound) return nullptr;
  if (subaction == XR_NULL_PATH) return &bound->any.state;
  return subaction == hand_path_ && action.Declares(hand_path_) ? &bound->owned.state : nullptr;
}

int SessionActions::SpaceServedBy(const Action& action, XrPath subaction) const {
  const Bound* bound = merging_ ? FindBound(action) : nullptr;
  if (!bound || (subaction != XR_NULL_PATH && subaction != hand_path_)) return kServedByRuntime;
  const View& view = subaction == XR_NULL_PATH ? bound->any : bound->owned;
  if (subaction == XR_NULL_PATH && view.pose_device != Device::kPen) return kServedByRuntime;
  if (subaction == hand_path_ && !owner_) return kServedByRuntime;
  if (!owner_) return kServedByNobody;
  for (const LiveBinding& b : bound->bindings)
    if ((b.live || OMNI_FAULT("unlocatable-stays-valid")) && b.binding.kind == BindingKind::kPose)
      return b.binding.first;
  return kServedByNobody;
}

void SessionActions::Serve(Space& space) const {
  space.served_by.store(SpaceServedBy(*space.action, space.subaction), std::memory_order_release);
}

std::vector<std::string> SessionActions::BoundSources(const Action& action) const {
  std::vector<std::string> out;
  const Bound* bound = owner_ ? FindBound(action) : nullptr;
  if (!bound || (!action.subactions.empty() && !action.Declares(hand_path_))) return out;
  for (const LiveBinding& b : bound->bindings)
    if (std::find(out.begin(), out.end(), b.binding.path) == out.end() && !OMNI_FAULT("no-bound-sources"))
      out.push_back(b.binding.path);
  return out;
}

bool SessionActions::HapticBound(const Action& action, XrPath subaction) const {
  const Bound* bound = owner_ ? FindBound(action) : nullptr;
  if (!bound || (subaction != XR_NULL_PATH && subaction != hand_path_)) return false;
  return std::any_of(bound->bindings.begin(), bound->bindings.end(),
                     [](const LiveBinding& b) { return b.live && b.binding.kind == BindingKind::kHaptic; });
}

}  // namespace omni::layer
