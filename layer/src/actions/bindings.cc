// Suggested bindings and the profile that is current.
#include <algorithm>
#include <string>

#include "layer/src/actions/input.h"

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

bool Bindings::OnlyOurs(const Profile& profile) const {
  return !profile.extension.empty() && runtime_.OnlyOurs(profile.extension);
}

// A path that an extension of ours adds to a profile that the runtime knows.
bool Bindings::OnlyOurs(const Profile& profile, std::string_view full_path) const {
  return AnyHandHas(profile, full_path, runtime_.enabled()) &&
         !AnyHandHas(profile, full_path, runtime_.enabled_below());
}

// The runtime's checks of its own profiles, for those that it does not know.
XrResult Bindings::CheckSuggestions(const Profile& profile, const std::vector<XrActionSuggestedBinding>& suggested) {
  if (suggested.empty()) return XR_ERROR_VALIDATION_FAILURE;
  for (const XrActionSuggestedBinding& binding : suggested) {
    const auto action = records_.actions.Find(binding.action);
    if (!action) return XR_ERROR_HANDLE_INVALID;
    const std::string path = runtime_.PathText(binding.binding);
    if (path.empty()) return XR_ERROR_PATH_INVALID;
    if (!AnyHandHas(profile, path, runtime_.enabled())) return XR_ERROR_PATH_UNSUPPORTED;
    if (action->set->attached) return XR_ERROR_ACTIONSETS_ALREADY_ATTACHED;
  }
  return XR_SUCCESS;
}

// To the next layer, without the paths of `known` that only we know: they would make it reject the whole call.
XrResult Bindings::Forward(const XrInteractionProfileSuggestedBinding& suggested, const Profile* known) {
  std::vector<XrActionSuggestedBinding> ours;
  std::vector<XrActionSuggestedBinding> theirs;
  for (const XrActionSuggestedBinding& binding : BindingsOf(suggested)) {
    const bool only_ours = known && OnlyOurs(*known, runtime_.PathText(binding.binding));
    (only_ours ? ours : theirs).push_back(binding);
  }
  if (ours.empty()) return runtime_.next.SuggestInteractionProfileBindings(runtime_.handle, &suggested);
  const XrResult checked = CheckSuggestions(*known, ours);
  if (XR_FAILED(checked) || theirs.empty()) return checked;
  XrInteractionProfileSuggestedBinding info = suggested;
  info.countSuggestedBindings = static_cast<std::uint32_t>(theirs.size());
  info.suggestedBindings = theirs.data();
  return runtime_.next.SuggestInteractionProfileBindings(runtime_.handle, &info);
}

// A second suggestion for a profile replaces the first.
void Bindings::Record(const std::string& profile_path, const XrInteractionProfileSuggestedBinding& suggested,
                      const std::vector<BindingThreshold>& thresholds) {
  std::vector<Suggestion> entries;
  for (const XrActionSuggestedBinding& binding : BindingsOf(suggested)) {
    auto action = records_.actions.Find(binding.action);
    if (!action) continue;
    Suggestion entry{std::move(action), runtime_.PathText(binding.binding), std::nullopt};
    for (const BindingThreshold& t : thresholds)
      if (t.action == binding.action && t.binding == binding.binding) entry.threshold = t.threshold;
    entries.push_back(std::move(entry));
  }
  const std::lock_guard lock(mutex_);
  suggestions_[profile_path] = std::move(entries);
}

XrResult Bindings::SuggestInteractionProfileBindings(const XrInteractionProfileSuggestedBinding* suggested) {
  link_.SignalAlive();
  if (!suggested || suggested->type != XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING)
    return runtime_.next.SuggestInteractionProfileBindings(runtime_.handle, suggested);
  const std::string path = runtime_.PathText(suggested->interactionProfile);
  const auto found = std::find_if(profiles_.begin(), profiles_.end(), [&](const Profile& p) { return p.path == path; });
  const Profile* known = found == profiles_.end() ? nullptr : &*found;
  const std::vector<BindingThreshold> thresholds =
      ReadThresholds(*suggested, {runtime_.HasExtension(XR_KHR_BINDING_MODIFICATION_EXTENSION_NAME),
                                  runtime_.HasExtension(XR_VALVE_ANALOG_THRESHOLD_EXTENSION_NAME)});
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

Suggestions Bindings::Suggested() const {
  const std::lock_guard lock(mutex_);
  return suggestions_;
}

XrPath Bindings::ProfileBelow(XrSession session, XrPath user_path) const {
  XrInteractionProfileState below{XR_TYPE_INTERACTION_PROFILE_STATE, nullptr, XR_NULL_PATH};
  const XrResult result = runtime_.next.GetCurrentInteractionProfile(session, user_path, &below);
  return XR_SUCCEEDED(result) ? below.interactionProfile : XR_NULL_PATH;
}

// The runtime reports its own changes; we report the pen's, if they change the profile that the application sees.
// `before` and `after` differ.
void Bindings::NotifyProfileChange(Session& session, XrPath user_path, const Profile* before, const Profile* after) {
  if (!session.running) return;
  const XrPath below = before && after ? XR_NULL_PATH : ProfileBelow(session.handle, user_path);
  const auto shown = [&](const Profile* profile) { return profile ? runtime_.PathOf(profile->path) : below; };
  if (shown(before) != shown(after)) session.profile_event_due = true;
}

XrResult Bindings::GetCurrentInteractionProfile(XrSession session, XrPath user_path, XrInteractionProfileState* state) {
  const XrResult result = runtime_.next.GetCurrentInteractionProfile(session, user_path, state);
  link_.SignalAlive();
  if (XR_FAILED(result)) return result;
  const auto record = records_.sessions.Find(session);
  if (!record) return result;
  const std::shared_lock lock(record->mutex);
  if (const Profile* profile = record->actions.ProfileAt(user_path))
    state->interactionProfile = runtime_.PathOf(profile->path);
  return result;
}

}  // namespace omni::layer
