// Suggested bindings and the profile that is current.
#include <algorithm>
#include <string>

#include "layer/src/instance.h"

namespace omni::layer {

bool Instance::OnlyOurs(const Profile& profile) const {
  return !profile.extension.empty() && OnlyOurs(std::string_view(profile.extension));
}

bool Instance::ProfileHasPath(const Profile& profile, std::string_view full_path) const {
  for (const Hand side : {Hand::kLeft, Hand::kRight}) {
    const std::string_view user = UserPath(side);
    if (full_path.substr(0, user.size()) == user)
      return HasPath(profile, side, full_path.substr(user.size()), enabled_);
  }
  return false;
}

// What the runtime checks for its own profiles, for those that it does not know.
XrResult Instance::CheckSuggestions(const Profile& profile, const XrInteractionProfileSuggestedBinding& suggested) {
  if (suggested.countSuggestedBindings == 0 || !suggested.suggestedBindings) return XR_ERROR_VALIDATION_FAILURE;
  for (std::uint32_t i = 0; i < suggested.countSuggestedBindings; ++i) {
    const XrActionSuggestedBinding& binding = suggested.suggestedBindings[i];
    const auto action = actions.Find(binding.action);
    if (!action) return XR_ERROR_HANDLE_INVALID;
    if (action->set->attached) return XR_ERROR_ACTIONSETS_ALREADY_ATTACHED;
    const std::string path = PathText(binding.binding);
    if (path.empty()) return XR_ERROR_PATH_INVALID;
    if (!ProfileHasPath(profile, path)) return XR_ERROR_PATH_UNSUPPORTED;
  }
  return XR_SUCCESS;
}

XrResult Instance::Suggest(const XrInteractionProfileSuggestedBinding* suggested) {
  link.Beat();
  const bool readable = suggested && suggested->type == XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING;
  const std::string path = readable ? PathText(suggested->interactionProfile) : std::string();
  const auto profile = std::find_if(profiles.begin(), profiles.end(), [&](const Profile& p) { return p.path == path; });
  const bool ours = profile != profiles.end() && OnlyOurs(*profile);
  const XrResult result =
      ours ? CheckSuggestions(*profile, *suggested) : next.SuggestInteractionProfileBindings(handle, suggested);
  if (XR_FAILED(result) || !readable) return result;
  std::vector<Suggestion> entries;
  for (std::uint32_t i = 0; i < suggested->countSuggestedBindings; ++i) {
    const XrActionSuggestedBinding& binding = suggested->suggestedBindings[i];
    if (auto action = actions.Find(binding.action)) entries.push_back({std::move(action), PathText(binding.binding)});
  }
  const std::lock_guard lock(suggestions_mutex_);
  suggestions_[path] = std::move(entries);  // a second suggestion for a profile replaces the first
  return result;
}

XrResult Instance::CurrentProfile(XrSession session, XrPath user_path, XrInteractionProfileState* state) {
  const XrResult result = next.GetCurrentInteractionProfile(session, user_path, state);
  link.Beat();
  if (XR_FAILED(result) || user_path != hand_path) return result;
  const auto record = sessions.Find(session);
  if (!record) return result;
  const std::shared_lock lock(record->mutex);
  if (const Profile* profile = record->actions.profile()) state->interactionProfile = PathOf(profile->path);
  return result;
}

}  // namespace omni::layer
