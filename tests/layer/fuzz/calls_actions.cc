// The fuzzed calls about paths, actions, bindings and states.
#include <cmath>
#include <cstdio>
#include <cstring>
#include <type_traits>

#include "tests/layer/fuzz/pick.h"
#include "tests/layer/fuzz/sequence.h"

namespace omni::test {
namespace {

bool SameState(const XrActionStateBoolean& a, const XrActionStateBoolean& b) {
  return a.currentState == b.currentState && a.changedSinceLastSync == b.changedSinceLastSync &&
         a.lastChangeTime == b.lastChangeTime && a.isActive == b.isActive;
}
bool SameState(const XrActionStateFloat& a, const XrActionStateFloat& b) {
  return std::memcmp(&a.currentState, &b.currentState, sizeof(float)) == 0 && a.isActive == b.isActive &&
         a.changedSinceLastSync == b.changedSinceLastSync && a.lastChangeTime == b.lastChangeTime;
}
bool SameState(const XrActionStateVector2f& a, const XrActionStateVector2f& b) {
  return std::memcmp(&a.currentState, &b.currentState, sizeof(XrVector2f)) == 0 && a.isActive == b.isActive &&
         a.changedSinceLastSync == b.changedSinceLastSync && a.lastChangeTime == b.lastChangeTime;
}

template <class State>
std::string StateText(const State& s, double x, double y) {
  char text[120];
  std::snprintf(text, sizeof(text), " active %u value %.4f %.4f changed %u time %d", s.isActive, x, y,
                s.changedSinceLastSync,
                s.lastChangeTime > 0   ? 1
                : s.lastChangeTime < 0 ? -1
                                       : 0);
  return text;
}

bool IsUnitValue(double value) { return std::isfinite(value) && std::fabs(value) <= 1.0; }

}  // namespace

void Sequence::Paths() {
  static const std::vector<std::string> kTexts = {
      "/user/hand/left", "user", "/", "", "/user//hand", "/User/hand", "/a.b/c-d_e", "/..", "/user/hand/right/"};
  XrPath path = XR_NULL_PATH;
  const std::string& text = random_.Of(kTexts);
  Say("string to path", f_.StringToPath(Pick(Pool<XrInstance>{{instance_}, {}}), text.c_str(), OrNull(&path)));
  char buffer[64];
  std::uint32_t count = 0;
  const XrResult result = f_.PathToString(instance_, AnyPath(), random_.Below(64), OrNull(&count), OrNull(buffer));
  Say("path to string", result);
}

void Sequence::MakeSet() {
  XrActionSetCreateInfo info{Type(XR_TYPE_ACTION_SET_CREATE_INFO), Chain(), "", "", random_.Below(3)};
  std::snprintf(info.actionSetName, sizeof(info.actionSetName), "set%d", ++made_);
  std::snprintf(info.localizedActionSetName, sizeof(info.localizedActionSetName), "Set %d", made_);
  if (random_.Percent(3)) info.actionSetName[0] = 'S';
  XrActionSet set = XR_NULL_HANDLE;
  const XrResult result = f_.CreateActionSet(instance_, OrNull(&info), OrNull(&set));
  Say("create set", result);
  if (XR_SUCCEEDED(result)) sets_.live.push_back(set);
}

void Sequence::MakeAction(XrActionType type) {
  XrPath subactions[3] = {paths_[0], paths_[1], random_.Percent(10) ? AnyPath() : paths_[2]};
  XrActionCreateInfo info{Type(XR_TYPE_ACTION_CREATE_INFO), Chain(), "", type, 0, subactions, ""};
  info.countSubactionPaths = random_.Percent(80) ? 2 : random_.Below(4);
  std::snprintf(info.actionName, sizeof(info.actionName), "action%d", ++made_);
  std::snprintf(info.localizedActionName, sizeof(info.localizedActionName), "Action %d", made_);
  if (random_.Percent(2)) info.actionType = static_cast<XrActionType>(77);
  if (random_.Percent(2)) info.subactionPaths = nullptr;
  XrAction action = XR_NULL_HANDLE;
  const XrResult result = f_.CreateAction(Pick(sets_), OrNull(&info), OrNull(&action));
  Say("create action", result);
  if (XR_SUCCEEDED(result)) actions_.live.push_back(action);
}

void Sequence::DropSet() { Drop(sets_, f_.DestroyActionSet, "destroy set"); }

void Sequence::DropAction() { Drop(actions_, f_.DestroyAction, "destroy action"); }

void Sequence::Suggest(bool sane) {
  struct Usual {
    std::size_t action;
    const char* path;
  };
  static constexpr Usual kUsual[] = {
      {0, "/user/hand/left/input/grip/pose"},      {0, "/user/hand/right/input/aim/pose"},
      {1, "/user/hand/right/input/trigger/value"}, {1, "/user/hand/left/input/trigger/value"},
      {2, "/user/hand/right/input/trigger"},       {3, "/user/hand/right/input/thumbstick"},
      {3, "/user/hand/left/input/thumbstick"},     {4, "/user/hand/right/output/haptic"},
      {4, "/user/hand/left/output/haptic"}};
  std::vector<XrActionSuggestedBinding> bindings;
  if (sane) {
    for (const Usual& usual : kUsual)
      if (usual.action < actions_.live.size()) bindings.push_back({actions_.live[usual.action], Interned(usual.path)});
  } else {
    for (std::uint32_t i = random_.Below(5); i > 0; --i) bindings.push_back({Pick(actions_), AnyPath()});
  }
  XrInteractionProfileSuggestedBinding info{XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING, nullptr, paths_[5],
                                            static_cast<std::uint32_t>(bindings.size()), bindings.data()};
  if (!sane) {
    info.type = Type(info.type);
    info.next = Chain();
    info.interactionProfile = random_.Percent(70) ? paths_[5 + random_.Below(3)] : AnyPath();
    if (random_.Percent(3)) info.suggestedBindings = nullptr;
  }
  Say("suggest", f_.SuggestInteractionProfileBindings(instance_, sane ? &info : OrNull(&info)));
}

void Sequence::Attach(bool sane) {
  std::vector<XrActionSet> sets = sets_.live;
  if (!sane && random_.Percent(30)) sets.push_back(Pick(sets_));
  XrSessionActionSetsAttachInfo info{XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO, nullptr,
                                     static_cast<std::uint32_t>(sets.size()), sets.data()};
  if (sane) {
    Say("attach", f_.AttachSessionActionSets(sessions_.live.empty() ? XR_NULL_HANDLE : sessions_.live.front(), &info));
    return;
  }
  info.type = Type(info.type);
  info.next = Chain();
  if (random_.Percent(5)) info.actionSets = nullptr;
  Say("attach", f_.AttachSessionActionSets(Pick(sessions_), OrNull(&info)));
}

XrResult Sequence::SyncOnce(bool sane) {
  std::vector<XrActiveActionSet> active;
  if (sane) {
    for (const XrActionSet set : sets_.live) active.push_back({set, XR_NULL_PATH});
  } else {
    for (std::uint32_t i = random_.Below(4); i > 0; --i) active.push_back({Pick(sets_), HandPath()});
  }
  XrActionsSyncInfo info{XR_TYPE_ACTIONS_SYNC_INFO, nullptr, static_cast<std::uint32_t>(active.size()), active.data()};
  if (sane && !sessions_.live.empty()) {
    const XrResult result = f_.SyncActions(sessions_.live.front(), &info);
    Say("sync", result);
    return result;
  }
  info.type = Type(info.type);
  info.next = Chain();
  if (random_.Percent(3)) info.activeActionSets = nullptr;
  const XrResult result = f_.SyncActions(Pick(sessions_), OrNull(&info));
  Say("sync", result);
  return result;
}

// [input-reading-input-action-state] invariants of every state, whatever its source.
template <class State>
void Sequence::CheckState(const char* call, const State& state, bool rests) {
  const auto violated = [&](const char* rule) { Violation(std::string(call) + ": " + rule); };
  if (state.isActive != XR_TRUE && state.isActive != XR_FALSE) violated("isActive is not an XrBool32");
  if (state.changedSinceLastSync != XR_TRUE && state.changedSinceLastSync != XR_FALSE)
    violated("changedSinceLastSync is not an XrBool32");
  if (!state.isActive && (!rests || state.changedSinceLastSync || state.lastChangeTime != 0))
    violated("inactive but not zero, unchanged and of time 0");
  if (state.changedSinceLastSync && state.lastChangeTime <= 0) violated("changed without a change time");
}

void Sequence::Bool() {
  const XrActionStateGetInfo info{Type(XR_TYPE_ACTION_STATE_GET_INFO), Chain(), Pick(actions_), HandPath()};
  XrActionStateBoolean state{Type(XR_TYPE_ACTION_STATE_BOOLEAN), nullptr, XR_FALSE, XR_FALSE, 0, XR_FALSE};
  const XrSession session = Pick(sessions_);
  const XrResult result = f_.GetActionStateBoolean(session, OrNull(&info), OrNull(&state));
  Say("boolean", result, XR_SUCCEEDED(result) ? StateText(state, state.currentState, 0) : "");
  if (XR_FAILED(result)) return;
  CheckState("boolean", state, !state.currentState);
  if (state.currentState != XR_TRUE && state.currentState != XR_FALSE) Violation("an invalid boolean");
  XrActionStateBoolean again = state;
  f_.GetActionStateBoolean(session, &info, &again);
  if (!SameState(state, again)) Violation("a boolean changed between two syncs");
}

void Sequence::Float() {
  const XrActionStateGetInfo info{Type(XR_TYPE_ACTION_STATE_GET_INFO), Chain(), Pick(actions_), HandPath()};
  XrActionStateFloat state{Type(XR_TYPE_ACTION_STATE_FLOAT), nullptr, 0, XR_FALSE, 0, XR_FALSE};
  const XrSession session = Pick(sessions_);
  const XrResult result = f_.GetActionStateFloat(session, OrNull(&info), OrNull(&state));
  Say("float", result, XR_SUCCEEDED(result) ? StateText(state, state.currentState, 0) : "");
  if (XR_FAILED(result)) return;
  CheckState("float", state, !(state.currentState < 0 || state.currentState > 0));
  if (!IsUnitValue(state.currentState)) Violation("a float beyond -1 to 1");
  XrActionStateFloat again = state;
  f_.GetActionStateFloat(session, &info, &again);
  if (!SameState(state, again)) Violation("a float changed between two syncs");
}

void Sequence::Vector() {
  const XrActionStateGetInfo info{Type(XR_TYPE_ACTION_STATE_GET_INFO), Chain(), Pick(actions_), HandPath()};
  XrActionStateVector2f state{Type(XR_TYPE_ACTION_STATE_VECTOR2F), nullptr, {0, 0}, XR_FALSE, 0, XR_FALSE};
  const XrSession session = Pick(sessions_);
  const XrResult result = f_.GetActionStateVector2f(session, OrNull(&info), OrNull(&state));
  const XrVector2f v = state.currentState;
  Say("vector", result, XR_SUCCEEDED(result) ? StateText(state, v.x, v.y) : "");
  if (XR_FAILED(result)) return;
  CheckState("vector", state, !(v.x < 0 || v.x > 0 || v.y < 0 || v.y > 0));
  if (!IsUnitValue(v.x) || !IsUnitValue(v.y)) Violation("a vector beyond -1 to 1");
  XrActionStateVector2f again = state;
  f_.GetActionStateVector2f(session, &info, &again);
  if (!SameState(state, again)) Violation("a vector changed between two syncs");
}

void Sequence::PoseState() {
  const XrActionStateGetInfo info{Type(XR_TYPE_ACTION_STATE_GET_INFO), Chain(), Pick(actions_), HandPath()};
  XrActionStatePose state{Type(XR_TYPE_ACTION_STATE_POSE), nullptr, XR_FALSE};
  const XrSession session = Pick(sessions_);
  const XrResult result = f_.GetActionStatePose(session, OrNull(&info), OrNull(&state));
  Say("pose", result, XR_SUCCEEDED(result) ? " active " + std::to_string(state.isActive) : "");
  if (XR_FAILED(result)) return;
  XrActionStatePose again = state;
  f_.GetActionStatePose(session, &info, &again);
  if (again.isActive != state.isActive) Violation("a pose changed between two syncs");
}

void Sequence::Profile() {
  XrInteractionProfileState state{Type(XR_TYPE_INTERACTION_PROFILE_STATE), nullptr, XR_NULL_PATH};
  const XrResult result = f_.GetCurrentInteractionProfile(Pick(sessions_), HandPath(), OrNull(&state));
  Say("profile", result, XR_SUCCEEDED(result) ? " " + Text(state.interactionProfile) : "");
}

void Sequence::Sources() {
  const XrBoundSourcesForActionEnumerateInfo info{Type(XR_TYPE_BOUND_SOURCES_FOR_ACTION_ENUMERATE_INFO), Chain(),
                                                  Pick(actions_)};
  XrPath sources[8] = {};
  std::uint32_t count = 0;
  const std::uint32_t capacity = random_.Below(9);
  const XrResult result =
      f_.EnumerateBoundSourcesForAction(Pick(sessions_), OrNull(&info), capacity, OrNull(&count), OrNull(sources));
  std::string text = " " + std::to_string(count);
  if (XR_SUCCEEDED(result) && capacity >= count && capacity > 0)
    for (std::uint32_t i = 0; i < count; ++i) text += " " + Text(sources[i]);
  Say("sources", result, text);
}

void Sequence::SourceName() {
  const XrInputSourceLocalizedNameGetInfo info{Type(XR_TYPE_INPUT_SOURCE_LOCALIZED_NAME_GET_INFO), Chain(), AnyPath(),
                                               random_.Below(10)};
  char text[100] = {};
  std::uint32_t count = 0;
  const XrResult result =
      f_.GetInputSourceLocalizedName(Pick(sessions_), OrNull(&info), random_.Below(101), OrNull(&count), OrNull(text));
  Say("source name", result, " " + std::to_string(count) + " " + text);
}

}  // namespace omni::test
