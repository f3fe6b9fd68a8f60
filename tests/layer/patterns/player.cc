#include "tests/layer/patterns/player.h"

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <stdexcept>

#include "tests/layer/support/app.h"

namespace omni::test::patterns {
namespace {

constexpr XrPosef kIdentity{{0, 0, 0, 1}, {0, 0, 0}};

template <std::size_t kSize>
void Copy(const std::string& text, char (&out)[kSize]) {
  std::snprintf(out, kSize, "%s", text.c_str());
}

// A well-formed part of a path.
std::string Lower(std::string text) {
  for (char& c : text) c = c == '/' || c == ' ' ? '_' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

std::string FirstSide(int hand) { return hand < 0 ? "" : std::string(kSides[hand]) + "_"; }

}  // namespace

void Player::Must(XrResult result, const std::string& what) {
  if (XR_FAILED(result)) throw std::runtime_error(what + ": " + Name(result));
}

Player::Player(const Pattern& pattern) : pattern_(pattern) {
  StartInstance();
  if (pattern_.asks_profile_in_first_session) AskProfileInFirstSession();
  StartSession(true);
}

Player::~Player() {
  if (instance_ != XR_NULL_HANDLE) xrDestroyInstance(instance_);
}

// What the loader lists for a program: the runtime's and the layer's, which is there for every application.
std::set<std::string> Player::OfferedExtensions() {
  std::set<std::string> names;
  for (const char* layer : {static_cast<const char*>(nullptr), kLayer}) {
    std::uint32_t count = 0;
    Must(xrEnumerateInstanceExtensionProperties(layer, 0, &count, nullptr), "extensions");
    std::vector<XrExtensionProperties> list(count, {XR_TYPE_EXTENSION_PROPERTIES});
    Must(xrEnumerateInstanceExtensionProperties(layer, count, &count, list.data()), "extensions");
    for (const XrExtensionProperties& one : list) names.insert(one.extensionName);
  }
  return names;
}

void Player::StartInstance() {
  const std::set<std::string> offered = OfferedExtensions();
  enabled_ = {"XR_MND_headless"};
  for (const std::string& wanted : pattern_.extensions)
    if (offered.count(wanted) > 0) enabled_.insert(wanted);
  std::vector<const char*> extensions;
  for (const std::string& name : enabled_) extensions.push_back(name.c_str());
  XrInstanceCreateInfo info{XR_TYPE_INSTANCE_CREATE_INFO};
  Copy(pattern_.name, info.applicationInfo.applicationName);
  info.applicationInfo.apiVersion = XR_MAKE_VERSION(1, 0, 20);
  info.enabledApiLayerCount = 1;
  info.enabledApiLayerNames = &kLayer;
  info.enabledExtensionCount = static_cast<std::uint32_t>(extensions.size());
  info.enabledExtensionNames = extensions.data();
  Must(xrCreateInstance(&info, &instance_), "xrCreateInstance");
  const XrSystemGetInfo get{XR_TYPE_SYSTEM_GET_INFO, nullptr, XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY};
  Must(xrGetSystem(instance_, &get, &system_), "xrGetSystem");
  for (const int hand : {kLeftHand, kRightHand})
    hand_paths_[static_cast<std::size_t>(hand)] = Path(std::string("/user/hand/") + kSides[hand]);
}

void Player::StopInstance() {
  Must(xrDestroyInstance(instance_), "xrDestroyInstance");
  instance_ = XR_NULL_HANDLE;
  session_ = XR_NULL_HANDLE;
  base_ = XR_NULL_HANDLE;
  running_ = profile_event_ = false;
  sets_.clear();
  actions_.clear();
  spaces_.clear();
  profile_ = {};
  seen_ = {};
}

void Player::StartSession(bool with_actions) {
  if (with_actions && pattern_.suggests_before_session) {
    MakeActions();
    Suggest();
  }
  const XrSessionCreateInfo info{XR_TYPE_SESSION_CREATE_INFO, nullptr, 0, system_};
  Must(xrCreateSession(instance_, &info, &session_), "xrCreateSession");
  state_ = XR_SESSION_STATE_UNKNOWN;
  MakeBase();
  if (with_actions && !pattern_.suggests_before_session) {
    MakeActions();
    if (pattern_.spaces == Spaces::kBeforeSuggestions) MakeSpaces();
    Suggest();
  }
  if (pattern_.spaces == Spaces::kBeforeAttach || (!with_actions && pattern_.spaces == Spaces::kBeforeSuggestions))
    MakeSpaces();
  AttachAll();
  if (pattern_.spaces == Spaces::kAfterAttach) MakeSpaces();
  PollUntil(XR_SESSION_STATE_FOCUSED);
}

void Player::StopSession(bool with_actions) {
  if (with_actions) DestroyActions();
  Must(xrDestroySession(session_), "xrDestroySession");
  session_ = XR_NULL_HANDLE;
  running_ = profile_event_ = false;
  spaces_.clear();
  profile_ = {};
  seen_ = {};
}

void Player::RestartSession() {
  if (pattern_.new_session == NewSession::kNewInstance) return RestartInstance();
  const bool new_actions = pattern_.new_session == NewSession::kNewActions;
  StopSession(new_actions);
  StartSession(new_actions);
}

void Player::RestartInstance() {
  StopInstance();
  StartInstance();
  if (pattern_.asks_profile_in_first_session) AskProfileInFirstSession();
  StartSession(true);
}

// With an action set of its own, which it leaves behind.
void Player::AskProfileInFirstSession() {
  XrActionSetCreateInfo set_info{XR_TYPE_ACTION_SET_CREATE_INFO};
  Copy("info", set_info.actionSetName);
  Copy("Info", set_info.localizedActionSetName);
  XrActionSet set = XR_NULL_HANDLE;
  Must(xrCreateActionSet(instance_, &set_info, &set), "xrCreateActionSet");
  const XrAction action = MakeAction(set, {"info", XR_ACTION_TYPE_POSE_INPUT, false, SubactionPaths::kBothHands}, -1);
  for (const PatternProfile& profile : pattern_.profiles) {
    std::vector<XrActionSuggestedBinding> bindings;
    for (const char* side : kSides)
      bindings.push_back({action, Path(std::string("/user/hand/") + side + "/input/grip/pose")});
    SuggestBindings(profile, bindings);
  }
  const XrSessionCreateInfo info{XR_TYPE_SESSION_CREATE_INFO, nullptr, 0, system_};
  Must(xrCreateSession(instance_, &info, &session_), "xrCreateSession");
  state_ = XR_SESSION_STATE_UNKNOWN;
  sets_["info"] = set;
  AttachAll();
  PollUntil(XR_SESSION_STATE_FOCUSED);
  constexpr int kFrames = 20;
  for (int frame = 0; frame < kFrames && profile_[0].empty() && profile_[1].empty(); ++frame) {
    Poll();
    const XrActiveActionSet active{set, XR_NULL_PATH};
    const XrActionsSyncInfo sync{XR_TYPE_ACTIONS_SYNC_INFO, nullptr, 1, &active};
    Must(xrSyncActions(session_, &sync), "xrSyncActions");
  }
  sets_.clear();
  StopSession(false);
}

XrAction Player::MakeAction(XrActionSet set, const PatternAction& action, int hand) const {
  XrActionCreateInfo info{XR_TYPE_ACTION_CREATE_INFO};
  Copy(Lower(FirstSide(hand) + action.name), info.actionName);
  Copy(FirstSide(hand) + action.name, info.localizedActionName);
  info.actionType = action.type;
  info.countSubactionPaths = action.paths == SubactionPaths::kBothHands ? 2 : action.paths == SubactionPaths::kItsHand;
  info.subactionPaths = hand_paths_.data() + (action.paths == SubactionPaths::kItsHand ? hand : 0);
  XrAction made = XR_NULL_HANDLE;
  Must(xrCreateAction(set, &info, &made), action.name);
  return made;
}

// The set of a binding's action.
std::string Player::SetOf(const PatternProfile& profile, int hand) const {
  if (pattern_.sets == ActionSets::kOne) return "actions";
  return pattern_.sets == ActionSets::kPerHand ? kSides[hand]
                                               : profile.path.substr(sizeof("/interaction_profiles/") - 1);
}

// Every action that some binding uses; of one set per profile, the actions of that profile.
void Player::MakeActions() {
  for (const PatternProfile& profile : pattern_.profiles) {
    if (!profile.needs.empty() && !Has(profile.needs)) continue;
    for (const PatternBinding& binding : profile.bindings) {
      const PatternAction& action = *pattern_.Find(binding.action);
      const std::string key = SetOf(profile, binding.hand);
      if (sets_.count(key) == 0) {
        XrActionSetCreateInfo info{XR_TYPE_ACTION_SET_CREATE_INFO};
        Copy(Lower(key), info.actionSetName);
        Copy(key, info.localizedActionSetName);
        Must(xrCreateActionSet(instance_, &info, &sets_[key]), "xrCreateActionSet");
      }
      const int hand = action.per_hand ? binding.hand : -1;
      std::vector<Made>& made = actions_[action.name];
      const auto same = [&](const Made& one) { return one.set == key && one.hand == hand; };
      if (std::none_of(made.begin(), made.end(), same))
        made.push_back({key, hand, MakeAction(sets_[key], action, hand)});
    }
  }
}

void Player::DestroyActions() {
  for (const auto& [key, set] : sets_) Must(xrDestroyActionSet(set), "xrDestroyActionSet");
  sets_.clear();
  actions_.clear();
}

XrResult Player::SuggestBindings(const PatternProfile& profile,
                                 const std::vector<XrActionSuggestedBinding>& bindings) const {
  const XrInteractionProfileSuggestedBinding info{XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING, nullptr,
                                                  Path(profile.path), static_cast<std::uint32_t>(bindings.size()),
                                                  bindings.data()};
  return xrSuggestInteractionProfileBindings(instance_, &info);
}

void Player::Suggest() {
  std::vector<std::pair<const PatternProfile*, std::vector<XrActionSuggestedBinding>>> all;
  for (const PatternProfile& profile : pattern_.profiles) {
    if (!profile.needs.empty() && !Has(profile.needs)) continue;
    all.emplace_back(&profile, std::vector<XrActionSuggestedBinding>());
    for (const PatternBinding& binding : profile.bindings) {
      const int hand = pattern_.Find(binding.action)->per_hand ? binding.hand : -1;
      for (const Made& made : actions_.at(binding.action))
        if (made.set == SetOf(profile, binding.hand) && made.hand == hand)
          all.back().second.push_back({made.action, Path(binding.path)});
    }
  }
  const auto suggest = [&](const PatternProfile& profile, const std::vector<XrActionSuggestedBinding>& bindings) {
    const XrResult result = SuggestBindings(profile, bindings);
    if (XR_FAILED(result) && pattern_.rejected == Rejected::kEnds)
      ended_ = profile.path + " was rejected: " + Name(result);
  };
  if (pattern_.suggests_each_alone_first)
    for (const auto& [profile, bindings] : all)
      for (const XrActionSuggestedBinding& one : bindings) suggest(*profile, {one});
  for (const auto& [profile, bindings] : all) suggest(*profile, bindings);
}

void Player::AttachAll() {
  std::vector<XrActionSet> sets;
  for (const auto& [key, set] : sets_) sets.push_back(set);
  const XrSessionActionSetsAttachInfo info{XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO, nullptr,
                                           static_cast<std::uint32_t>(sets.size()), sets.data()};
  Must(xrAttachSessionActionSets(session_, &info), "xrAttachSessionActionSets");
}

std::vector<int> Player::Devices() const {
  std::vector<int> devices = pattern_.hands;
  if (!pattern_.pen.empty()) devices.push_back(kPenDevice);
  return devices;
}

XrPath Player::PathOf(const PatternDevice& device, int index) const {
  return device.at_null || index == kPenDevice ? XR_NULL_PATH : hand_paths_[static_cast<std::size_t>(index)];
}

// Of the current profile, where each has its own.
XrAction Player::ActionOf(const std::string& name, int index) const {
  const auto made = actions_.find(name);
  if (made == actions_.end()) return XR_NULL_HANDLE;
  for (const Made& one : made->second) {
    const bool of_hand = one.hand < 0 || one.hand == index;
    const bool of_set = pattern_.sets != ActionSets::kPerProfile ||
                        "/interaction_profiles/" + one.set == profile_[static_cast<std::size_t>(index)];
    if (of_hand && of_set) return one.action;
  }
  return XR_NULL_HANDLE;
}

void Player::MakeSpaces() {
  for (const int index : Devices()) {
    if (pattern_.sets != ActionSets::kPerProfile && !pattern_.space_per_profile) {
      SpaceOf(DeviceOf(index), index);
      continue;
    }
    // One for each profile, of which the current one's is used.
    for (const PatternProfile& profile : pattern_.profiles) {
      profile_[static_cast<std::size_t>(index)] = profile.path;
      SpaceOf(DeviceOf(index), index);
    }
    profile_[static_cast<std::size_t>(index)].clear();
  }
}

XrSpace Player::SpaceOf(const PatternDevice& device, int index) {
  const bool per_profile = pattern_.sets == ActionSets::kPerProfile || pattern_.space_per_profile;
  const std::pair<int, std::string> key{index, per_profile ? profile(index) : ""};
  if (const auto found = spaces_.find(key); found != spaces_.end()) return found->second;
  const XrAction action = ActionOf(device.pose, index);
  if (action == XR_NULL_HANDLE) return XR_NULL_HANDLE;
  const XrActionSpaceCreateInfo info{XR_TYPE_ACTION_SPACE_CREATE_INFO, nullptr, action, PathOf(device, index),
                                     kIdentity};
  XrSpace space = XR_NULL_HANDLE;
  Must(xrCreateActionSpace(session_, &info, &space), "xrCreateActionSpace");
  return spaces_[key] = space;
}

void Player::MakeBase() {
  const XrReferenceSpaceCreateInfo info{XR_TYPE_REFERENCE_SPACE_CREATE_INFO, nullptr, pattern_.base, kIdentity};
  Must(xrCreateReferenceSpace(session_, &info, &base_), "xrCreateReferenceSpace");
}

XrPath Player::Path(const std::string& text) const {
  XrPath path = XR_NULL_PATH;
  Must(xrStringToPath(instance_, text.c_str(), &path), text);
  return path;
}

std::string Player::Text(XrPath path) const {
  if (path == XR_NULL_PATH) return {};
  char text[XR_MAX_PATH_LENGTH] = {};
  std::uint32_t length = 0;
  Must(xrPathToString(instance_, path, sizeof(text), &length, text), "xrPathToString");
  return text;
}

void Player::PollUntil(XrSessionState state) {
  if (!Eventually([&] { return Poll(), state_ == state; }))
    throw std::runtime_error("the session never became focused");
}

}  // namespace omni::test::patterns
