#include "tests/layer/actions/action_model.h"

#include <algorithm>
#include <cmath>

namespace omni::test {
namespace {

std::string UserOf(At at) { return at == At::kLeft ? "/user/hand/left" : "/user/hand/right"; }
std::string ParentOf(const std::string& path) { return path.substr(0, path.rfind('/')); }

const layer::Component* ComponentAt(const layer::Profile& profile, At hand, const std::string& path) {
  for (const layer::Component& c : profile.components)
    if (c.path == path && (hand == At::kLeft ? c.left : c.right)) return &c;
  return nullptr;
}

// [input-suggested-bindings] the source that a suggested path means for an action of that type; empty: none, which is
// ignored.
std::string SourceFor(const layer::Profile& profile, At hand, XrActionType type, const std::string& path) {
  const auto has = [&](const std::string& p) { return ComponentAt(profile, hand, p) != nullptr; };
  if (type == XR_ACTION_TYPE_POSE_INPUT) {
    for (const std::string& candidate : {path, path + "/pose"})
      for (const layer::PoseComponent& pose : profile.poses)
        if (pose.path == candidate) return candidate;
    return {};
  }
  if (type == XR_ACTION_TYPE_VIBRATION_OUTPUT) return path == "/output/haptic" ? path : std::string();
  if (type == XR_ACTION_TYPE_VECTOR2F_INPUT) return has(path + "/x") && has(path + "/y") ? path : std::string();
  if (has(path)) return path;
  const bool boolean = type == XR_ACTION_TYPE_BOOLEAN_INPUT;
  for (const char* child : boolean ? std::vector<const char*>{"/click", "/value", "/force"}
                                   : std::vector<const char*>{"/value", "/force", "/click"})
    if (has(path + child)) return path + child;
  return {};
}

// The stronger of two: [input-multiple].
ModelPart Combine(XrActionType type, const ModelPart& a, const ModelPart& b) {
  if (!a.active) return b;
  if (!b.active) return a;
  const bool vector = type == XR_ACTION_TYPE_VECTOR2F_INPUT;
  const auto weight = [vector](const ModelPart& p) { return vector ? std::hypot(p.x, p.y) : std::fabs(p.x); };
  ModelPart out = weight(b) > weight(a) ? b : a;
  out.t = std::max(a.t, b.t);
  return out;
}

bool SameValue(float ax, float ay, float bx, float by) { return !(ax != bx) && !(ay != by); }

}  // namespace

ActionModel::ActionModel(const std::vector<layer::Profile>& profiles, std::vector<ModelAction> actions,
                         std::vector<ModelSuggestion> suggestions, std::set<int> attached_sets)
    : profiles_(profiles),
      actions_(std::move(actions)),
      suggestions_(std::move(suggestions)),
      attached_(std::move(attached_sets)) {
  Choose();
}

// The top-level user paths at which the action can have a source: those of its suggested bindings, of whatever
// profile, that the action takes ([XrActionCreateInfo]: without subaction paths all of them).
std::set<std::string> ActionModel::PlacesOf(int action) const {
  const ModelAction& a = actions_[static_cast<std::size_t>(action)];
  std::set<std::string> places;
  for (const ModelSuggestion& s : suggestions_) {
    if (s.action != action) continue;
    std::string user = s.path.substr(0, s.path.find('/', 1));
    for (const At hand : {At::kLeft, At::kRight})
      if (s.path.rfind(UserOf(hand) + "/", 0) == 0) user = UserOf(hand);
    const bool taken =
        !a.any_declared() || (a.left && user == UserOf(At::kLeft)) || (a.right && user == UserOf(At::kRight));
    if (taken) places.insert(user);
  }
  return places;
}

// [XrActionStateGetInfo] XR_NULL_PATH means all subaction paths. Where the action has sources at one hand only, that is
// this hand: [input-multiple] whoever is picked up there is its single source, and "must only be changed" in a sync.
At ActionModel::Meant(int action, At at) const {
  if (at != At::kNull) return at;
  const std::set<std::string> places = PlacesOf(action);
  for (const At hand : {At::kLeft, At::kRight})
    if (places == std::set<std::string>{UserOf(hand)}) return hand;
  return at;
}

const layer::Profile* ActionModel::FindProfile(const std::string& path) const {
  for (const layer::Profile& profile : profiles_)
    if (profile.path == path) return &profile;
  return nullptr;
}

std::vector<ActionModel::Wire> ActionModel::WiresOf(const layer::Profile& profile) const {
  std::vector<Wire> wires;
  for (const ModelSuggestion& s : suggestions_) {
    const ModelAction& action = actions_[static_cast<std::size_t>(s.action)];
    const std::string user = UserOf(hand_);
    if (s.profile != profile.path || attached_.count(action.set) == 0 || s.path.rfind(user + "/", 0) != 0) continue;
    const std::string source = SourceFor(profile, hand_, action.type, s.path.substr(user.size()));
    if (source.empty()) continue;
    const bool whole = action.type == XR_ACTION_TYPE_VECTOR2F_INPUT || action.type == XR_ACTION_TYPE_VIBRATION_OUTPUT;
    wires.push_back({&s, source, whole ? source : ParentOf(source), false, 0, 0});
  }
  return wires;
}

// The preferred profile if it binds anything for the pen's hand, else the one of highest priority that does.
bool ActionModel::Choose() {
  std::vector<const layer::Profile*> order;
  if (const layer::Profile* preferred = FindProfile(preferred_)) order.push_back(preferred);
  for (const layer::Profile& profile : profiles_) order.push_back(&profile);
  for (const layer::Profile* profile : order) {
    wires_ = WiresOf(*profile);
    profile_ = profile->path;
    if (!wires_.empty()) return true;
  }
  profile_.clear();
  return false;
}

bool ActionModel::ActionIsActive(int action, const ModelSync& sync, std::uint32_t* priority) const {
  const ModelAction& a = actions_[static_cast<std::size_t>(action)];
  if (a.any_declared() && !a.HasSubaction(hand_)) return false;
  bool active = false;
  for (const ModelActiveSet& entry : sync.active) {
    if (entry.set != a.set || (entry.at != At::kNull && entry.at != hand_)) continue;
    active = true;
    *priority = entry.priority;
  }
  return active;
}

// [XrActionSetCreateInfo] the same source is bound in an active action of a higher set.
bool ActionModel::Suppressed(const Wire& wire, const ModelSync& sync) const {
  std::uint32_t mine = 0;
  ActionIsActive(wire.suggestion->action, sync, &mine);
  for (const Wire& other : wires_) {
    std::uint32_t theirs = 0;
    if (other.identifier == wire.identifier && ActionIsActive(other.suggestion->action, sync, &theirs) && theirs > mine)
      return true;
  }
  return false;
}

void ActionModel::StepEdges(const ModelSync& sync, bool start) {
  const layer::Profile& profile = *FindProfile(profile_);
  for (Wire& wire : wires_) {
    const layer::Component* c = ComponentAt(profile, hand_, wire.source);
    if (!c) continue;
    static const protocol::InputValue kRest;
    const auto read = [&](int source) {
      return source < 0 ? kRest : sync.inputs.components[static_cast<std::size_t>(source)];
    };
    const bool analog = c->type == layer::ComponentType::kFloat;
    const bool own = analog && wire.suggestion->threshold.has_value();
    const bool by_click = !own && (!analog || c->click_source >= 0);
    const protocol::InputValue in = by_click && c->click_source >= 0 ? read(c->click_source) : read(c->source);
    if (start) {
      wire.pressed = false;
      wire.presses = in.press_count;
      wire.releases = in.release_count;
    }
    const float on = own ? wire.suggestion->threshold->first : 0.5f;
    const float off = own ? wire.suggestion->threshold->second : 0.4f;
    const bool pressed_between = wire.presses != in.press_count && (by_click || on <= 0.5f);
    if (!wire.pressed) {
      wire.pressed = pressed_between || (by_click ? in.value > 0.5f : in.value >= on);
      wire.presses = in.press_count;
      if (wire.pressed) wire.releases = in.release_count;
    } else if (by_click) {
      wire.pressed = in.value > 0.5f && wire.releases == in.release_count;
      wire.releases = in.release_count;
    } else {
      wire.pressed = in.value >= off;
      if (wire.pressed) wire.presses = in.press_count;
    }
  }
}

ModelPart ActionModel::Scalar(const Wire& wire, const layer::Component& component, const ModelSync& sync) const {
  const XrActionType type = actions_[static_cast<std::size_t>(wire.suggestion->action)].type;
  const auto read = [&](int source) {
    return source < 0 ? protocol::InputValue() : sync.inputs.components[static_cast<std::size_t>(source)];
  };
  const bool boolean_source = component.type == layer::ComponentType::kBoolean;
  ModelPart part;
  part.active = true;
  if (type == XR_ACTION_TYPE_BOOLEAN_INPUT || boolean_source) {
    const bool own = wire.suggestion->threshold.has_value();
    const bool by_click = component.click_source >= 0 && !own;
    part.x = wire.pressed ? 1.0f : 0.0f;
    part.t = read(by_click ? component.click_source : component.source).t_change_ns;
  } else {
    part.x = read(component.source).value;
    part.t = read(component.source).t_change_ns;
  }
  return part;
}

ModelPart ActionModel::PenSays(int action, const ModelSync& sync) const {
  ModelPart out;
  std::uint32_t priority = 0;
  if (!owner_ || !sync.focused || !ActionIsActive(action, sync, &priority)) return out;
  const layer::Profile& profile = *FindProfile(profile_);
  const XrActionType type = actions_[static_cast<std::size_t>(action)].type;
  for (const Wire& wire : wires_) {
    if (wire.suggestion->action != action || Suppressed(wire, sync)) continue;
    ModelPart part;
    part.active = true;
    if (type == XR_ACTION_TYPE_VECTOR2F_INPUT) {
      const ModelPart x = Scalar(wire, *ComponentAt(profile, hand_, wire.source + "/x"), sync);
      const ModelPart y = Scalar(wire, *ComponentAt(profile, hand_, wire.source + "/y"), sync);
      part = {true, x.x, y.x, std::max(x.t, y.t)};
    } else if (type != XR_ACTION_TYPE_POSE_INPUT) {
      part = Scalar(wire, *ComponentAt(profile, hand_, wire.source), sync);
    }
    out = Combine(type, out, part);
  }
  return out;
}

// While the pen owns its hand, the runtime's controller there is ignored.
ModelPart ActionModel::RuntimeSays(int action, At at, const ModelSync& sync) const {
  const ModelAction& a = actions_[static_cast<std::size_t>(action)];
  const auto answer = [&](At where) {
    const auto found = sync.runtime.find({action, where});
    return found == sync.runtime.end() ? ModelPart() : found->second;
  };
  if (!sync.focused) return {};
  if (at != At::kNull) return owner_ && at == hand_ ? ModelPart() : answer(at);
  if (!owner_) return answer(At::kNull);
  if (Meant(action, at) == hand_) return {};
  if (!a.any_declared()) return answer(At::kNull);
  ModelPart out;
  for (const At hand : {At::kLeft, At::kRight})
    if (a.HasSubaction(hand) && hand != hand_) out = Combine(a.type, out, answer(hand));
  return out;
}

void ActionModel::Remember(int action, At at, const ModelPart& runtime, const ModelPart& pen, const ModelSync& sync) {
  Memory& m = memory_[{action, at}];
  const XrActionType type = actions_[static_cast<std::size_t>(action)].type;
  m.of_layer = m.of_layer || (owner_ && (at == At::kNull || at == hand_));
  if (type == XR_ACTION_TYPE_POSE_INPUT) {
    const bool may_change = at != At::kNull || PlacesOf(action).size() <= 1;
    const char lefts = hand_ == At::kLeft ? 'p' : 'r';
    const bool both = pen.active && runtime.active;
    if (m.device == 0 || may_change)
      m.device = both ? (may_change ? 'p' : lefts) : pen.active ? 'p' : runtime.active ? 'r' : 0;
    const bool from_pen = m.device == 'p' && !put_down_;
    m.state = {};
    m.state.active = from_pen ? pen.active : runtime.active;
    return;
  }
  const ModelState before = m.state;
  const ModelPart now = Combine(type, runtime, pen);
  ModelState s;
  if (now.active) {
    s.active = true;
    s.x = now.x;
    s.y = now.y;
    s.changed = before.active && !SameValue(now.x, now.y, before.x, before.y);
    if (before.active && !s.changed) {
      s.last_change_earliest = before.last_change_earliest;
      s.last_change_latest = before.last_change_latest;
    } else {
      // The physical time of what moved: never later than now, never before the last change.
      s.last_change_earliest = before.last_change_earliest;
      s.last_change_latest = sync.now;
      const bool only_pen = pen.active && !runtime.active && !m.runtime.active;
      const bool pen_as_before = !before.active || m.pen.active;
      if (only_pen && pen_as_before && pen.t > 0) {
        const std::int64_t t = std::max(std::min(pen.t, sync.now), before.last_change_earliest);
        s.last_change_earliest = t;
        s.last_change_latest = std::max(t, before.last_change_latest);
      }
    }
  }
  m.state = s;
  m.pen = pen;
  m.runtime = runtime;
}

void ActionModel::Sync(const ModelSync& sync) {
  bool start = sync.start_edges || !was_focused_;
  was_focused_ = sync.focused;
  if (sync.focused) {
    if (sync.hand != hand_ || sync.preferred != preferred_) {
      hand_ = sync.hand;
      preferred_ = sync.preferred;
      Choose();
      start = true;
    }
    put_down_ = sync.pen_present && sync.put_down;
    bool owner = !wires_.empty() && sync.pen_present && !put_down_;
    // A pen that comes later takes over one sync after it came: its first state is compared with the runtime's last.
    if (owner && !recording_ && synced_) {
      recording_ = true;
      owner = false;
    }
    start = start || !owner_ || service_ != sync.service;
    owner_ = owner;
    recording_ = recording_ || owner;
    synced_ = true;
    service_ = sync.service;
  }
  last_ = sync;
  if (!recording_) return;
  if (owner_ && sync.pen_present) StepEdges(sync, start);
  for (int action = 0; action < static_cast<int>(actions_.size()); ++action) {
    const ModelAction& a = actions_[static_cast<std::size_t>(action)];
    if (attached_.count(a.set) == 0 || a.type == XR_ACTION_TYPE_VIBRATION_OUTPUT) continue;
    const ModelPart pen = PenSays(action, sync);
    Remember(action, At::kNull, RuntimeSays(action, At::kNull, sync), pen, sync);
    for (const At hand : {At::kLeft, At::kRight})
      if (a.HasSubaction(hand))
        Remember(action, hand, RuntimeSays(action, hand, sync), owner_ && hand == hand_ ? pen : ModelPart(), sync);
  }
}

std::optional<ModelState> ActionModel::State(int action, At at) const {
  const auto found = memory_.find({action, at});
  if (found == memory_.end() || !found->second.of_layer) return std::nullopt;
  return found->second.state;
}

// [spaces-action-spaces-lifetime]
ModelSpace ActionModel::Space(int action, At at) const {
  const ModelAction& a = actions_[static_cast<std::size_t>(action)];
  at = Meant(action, at);
  if (!recording_ || attached_.count(a.set) == 0 || (at != At::kNull && at != hand_)) return {};
  const auto memory = memory_.find({action, At::kNull});
  const bool null_is_pens = memory != memory_.end() && memory->second.device == 'p' && !put_down_;
  if (at == At::kNull ? !null_is_pens : !owner_) return {};
  std::uint32_t priority = 0;
  if (!owner_ || !last_.focused || !ActionIsActive(action, last_, &priority)) return {SpaceSource::kNobody, {}};
  for (const Wire& wire : wires_)
    if (wire.suggestion->action == action && !Suppressed(wire, last_)) return {SpaceSource::kPen, wire.source};
  return {SpaceSource::kNobody, {}};
}

std::set<std::string> ActionModel::PenSources(int action) const {
  std::set<std::string> out;
  const ModelAction& a = actions_[static_cast<std::size_t>(action)];
  if (!owner_ || (a.any_declared() && !a.HasSubaction(hand_))) return out;
  for (const Wire& wire : wires_)
    if (wire.suggestion->action == action) out.insert(UserOf(hand_) + wire.source);
  return out;
}

}  // namespace omni::test
