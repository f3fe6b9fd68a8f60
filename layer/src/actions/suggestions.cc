// Suggested bindings and the profile that is current.
#include <algorithm>
#include <string>

#include "layer/src/instance/instance.h"

namespace omni::layer {
namespace {

bool AnyHandHas(const Profile& profile, std::string_view full_path, const std::vector<std::string>& enabled) {
  for (const Hand side : {Hand::kLeft, Hand::kRight}) {
    const std::string_view user = UserPath(side);
    if (full_path.substr(0, user.size()) == user) return HasPath(profile, side, full_path.substr(user.size()), enabled);
  }
  return false;
}

std::vector<XrActionSuggestedBinding> BindingsOf(const XrInteractionProfileSuggestedBinding& suggested) {
  if (!suggested.suggestedBindings) return {};
  return {suggested.suggestedBindings, suggested.suggestedBindings + suggested.countSuggestedBindings};
}

}  // namespace

bool Instance::OnlyOurs(const Profile& profile) const {
  return !profile.extension.empty() &&
         std::find(only_ours_.begin(), only_ours_.end(), profile.extension) != only_ours_.end();
}

// A path that an extension of ours adds to a profile that the runtime knows.
bool Instance::OnlyOurs(const Profile& profile, std::string_view full_path) const {
  return AnyHandHas(profile, full_path, enabled_) && !AnyHandHas(profile, full_path, enabled_below_);
}

// The runtime's checks of its own profiles, for those that it does not know.
XrResult Instance::CheckSuggestions(const Profile& profile, const std::vector<XrActionSuggestedBinding>& suggested) {
  if (suggested.empty()) return XR_ERROR_VALIDATION_FAILURE;
  for (const XrActionSuggestedBinding& binding : suggested) {
    const auto action = actions.Find(binding.action);
    if (!action) return XR_ERROR_HANDLE_INVALID;
    const std::string path = PathText(binding.binding);
    if (path.empty()) return XR_ERROR_PATH_INVALID;
    if (!AnyHandHas(profile, path, enabled_)) return XR_ERROR_PATH_UNSUPPORTED;
    if (action->set->attached) return XR_ERROR_ACTIONSETS_ALREADY_ATTACHED;
  }
  return XR_SUCCESS;
}

// To the next layer, without the paths of `known` that only we know: they would make it reject the whole call.
XrResult Instance::Forward(const XrInteractionProfileSuggestedBinding& suggested, const Profile* known) {
  std::vector<XrActionSuggestedBinding> ours;
  std::vector<XrActionSuggestedBinding> theirs;
  for (const XrActionSuggestedBinding& binding : BindingsOf(suggested)) {
    const bool only_ours = known && OnlyOurs(*known, PathText(binding.binding));
    (only_ours ? ours : theirs).push_back(binding);
  }
  if (ours.empty()) return next.SuggestInteractionProfileBindings(handle, &suggested);
  const XrResult checked = CheckSuggestions(*known, ours);
  if (XR_FAILED(checked) || theirs.empty()) return checked;
  XrInteractionProfileSuggestedBinding info = suggested;
  info.countSuggestedBindings = static_cast<std::uint32_t>(theirs.size());
  info.suggestedBindings = theirs.data();
  return next.SuggestInteractionProfileBindings(handle, &info);
}

// A second suggestion for a profile replaces the first.
void Instance::Record(const std::string& profile_path, const XrInteractionProfileSuggestedBinding& suggested,
                      const std::vector<BindingThreshold>& thresholds) {
  std::vector<Suggestion> entries;
  for (const XrActionSuggestedBinding& binding : BindingsOf(suggested)) {
    auto action = actions.Find(binding.action);
    if (!action) continue;
    Suggestion entry{std::move(action), PathText(binding.binding), std::nullopt};
    for (const BindingThreshold& t : thresholds)
      if (t.action == binding.action && t.binding == binding.binding) entry.threshold = t.threshold;
    entries.push_back(std::move(entry));
  }
  const std::lock_guard lock(suggestions_mutex_);
  suggestions_[profile_path] = std::move(entries);
}

XrResult Instance::SuggestInteractionProfileBindings(const XrInteractionProfileSuggestedBinding* suggested) {
  link.Beat();
  if (!suggested || suggested->type != XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING)
    return next.SuggestInteractionProfileBindings(handle, suggested);
  const std::string path = PathText(suggested->interactionProfile);
  const auto found = std::find_if(profiles.begin(), profiles.end(), [&](const Profile& p) { return p.path == path; });
  const Profile* known = found == profiles.end() ? nullptr : &*found;
  const std::vector<BindingThreshold> thresholds = ReadThresholds(
      *suggested,
      {Enabled(XR_KHR_BINDING_MODIFICATION_EXTENSION_NAME), Enabled(XR_VALVE_ANALOG_THRESHOLD_EXTENSION_NAME)});
  XrResult result = XR_SUCCESS;
  if (known && OnlyOurs(*known)) {
    result = CheckSuggestions(*known, BindingsOf(*suggested));
    if (XR_SUCCEEDED(result)) result = CheckThresholds(*suggested, thresholds);
  } else {
    result = Forward(*suggested, known);
  }
  if (XR_SUCCEEDED(result)) Record(path, *suggested, thresholds);
  return result;
}

XrResult Instance::GetCurrentInteractionProfile(XrSession session, XrPath user_path, XrInteractionProfileState* state) {
  const XrResult result = next.GetCurrentInteractionProfile(session, user_path, state);
  link.Beat();
  if (XR_FAILED(result)) return result;
  const auto record = sessions.Find(session);
  if (!record) return result;
  const std::shared_lock lock(record->mutex);
  if (const Profile* profile = record->actions.ProfileAt(user_path)) state->interactionProfile = PathOf(profile->path);
  return result;
}

}  // namespace omni::layer
