// What an application shows its user: which physical sources feed an action, and their names.
#include <algorithm>
#include <cstring>
#include <string>

#include "layer/src/actions/input.h"
#include "layer/src/entry/two_call.h"

namespace omni::layer {
namespace {

bool StartsWith(std::string_view text, std::string_view prefix) { return text.substr(0, prefix.size()) == prefix; }

// The name of a component of the profile, empty if it has none.
std::string ComponentName(const Profile& profile, Hand hand, std::string_view local) {
  for (const Component& c : profile.components)
    if (c.IsOnHand(hand) && c.path == local) return c.name;
  for (const PoseComponent& pose : profile.poses)
    if (pose.path == local) return pose.name;
  if (std::find(profile.haptics.begin(), profile.haptics.end(), local) != profile.haptics.end()) return "Vibration";
  // A two-axis source has a path of its own, above its axes.
  for (const Component& c : profile.components)
    if (c.path == std::string(local) + "/x") return c.name.substr(0, c.name.rfind(' '));
  return {};
}

std::string JoinName(XrInputSourceLocalizedNameFlags which, Hand hand, const Profile& profile,
                     const std::string& part) {
  std::string name;
  const auto append = [&name](const std::string& text) { name += (name.empty() ? "" : " ") + text; };
  if (which & XR_INPUT_SOURCE_LOCALIZED_NAME_USER_PATH_BIT) append(hand == Hand::kLeft ? "Left hand" : "Right hand");
  if (which & XR_INPUT_SOURCE_LOCALIZED_NAME_INTERACTION_PROFILE_BIT) append(profile.title);
  if (which & XR_INPUT_SOURCE_LOCALIZED_NAME_COMPONENT_BIT) append(part);
  return name;
}

}  // namespace

XrResult Input::EnumerateBoundSourcesForAction(XrSession session, const XrBoundSourcesForActionEnumerateInfo* info,
                                               uint32_t capacity, uint32_t* count, XrPath* sources) {
  link_.SignalAlive();
  const auto record = records_.sessions.Find(session);
  const auto action = record && info ? records_.actions.Find(info->action) : nullptr;
  std::vector<std::string> pen;
  bool owns = false;
  Hand hand = Hand::kRight;
  if (action) {
    const std::shared_lock lock(record->mutex);
    hand = record->actions.hand();
    owns = record->actions.pen_owns_hand() && record->actions.attached(*action->set);
    if (owns) pen = record->actions.BoundSources(*action);
  }
  if (!owns) return runtime_.next.EnumerateBoundSourcesForAction(session, info, capacity, count, sources);

  std::vector<XrPath> all;
  const XrResult result = EnumerateBelow(all, XrPath{XR_NULL_PATH}, [&](auto below_capacity, auto* below, auto* out) {
    return runtime_.next.EnumerateBoundSourcesForAction(session, info, below_capacity, below, out);
  });
  if (XR_FAILED(result)) return result;
  // The pen's hand has no other device while the pen is present.
  all.erase(std::remove_if(all.begin(), all.end(),
                           [&](XrPath path) { return StartsWith(runtime_.PathText(path), UserPath(hand)); }),
            all.end());
  for (const std::string& path : pen)
    if (const XrPath source = runtime_.PathOf(path); source != XR_NULL_PATH) all.push_back(source);
  return Fill(all.data(), all.size(), capacity, count, sources);
}

XrResult Input::GetInputSourceLocalizedName(XrSession session, const XrInputSourceLocalizedNameGetInfo* info,
                                            uint32_t capacity, uint32_t* count, char* text) {
  link_.SignalAlive();
  constexpr XrInputSourceLocalizedNameFlags kKnown = XR_INPUT_SOURCE_LOCALIZED_NAME_USER_PATH_BIT |
                                                     XR_INPUT_SOURCE_LOCALIZED_NAME_INTERACTION_PROFILE_BIT |
                                                     XR_INPUT_SOURCE_LOCALIZED_NAME_COMPONENT_BIT;
  const auto record = records_.sessions.Find(session);
  const bool readable = record && info && info->type == XR_TYPE_INPUT_SOURCE_LOCALIZED_NAME_GET_INFO;
  const std::string path = readable ? runtime_.PathText(info->sourcePath) : std::string();
  if (!path.empty()) {
    const std::shared_lock lock(record->mutex);
    const Hand hand = record->actions.hand();
    const std::string_view user = UserPath(hand);
    const Profile* profile = record->actions.profile();
    const bool of_pen = profile && StartsWith(path, std::string(user) + "/");
    const std::string part = of_pen ? ComponentName(*profile, hand, path.substr(user.size())) : std::string();
    if (!part.empty()) {
      const XrInputSourceLocalizedNameFlags which = info->whichComponents;
      if (which == 0 || (which & ~kKnown) != 0) return XR_ERROR_VALIDATION_FAILURE;
      const std::string name = JoinName(which, hand, *profile, part);
      return Fill(name.c_str(), name.size() + 1, capacity, count, text);
    }
  }
  return runtime_.next.GetInputSourceLocalizedName(session, info, capacity, count, text);
}

}  // namespace omni::layer
