// Suggested bindings and the profile that is current.
#pragma once

#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "layer/src/actions/binding_modifications.h"
#include "layer/src/actions/session_actions.h"
#include "layer/src/instance/runtime.h"
#include "layer/src/instance/session.h"

namespace omni::layer {

class Bindings {
 public:
  Bindings(const Runtime& runtime, const Records& records, ServiceLink& link, const std::vector<Profile>& profiles)
      : runtime_(runtime), records_(records), link_(link), profiles_(profiles) {}

  XrResult SuggestInteractionProfileBindings(const XrInteractionProfileSuggestedBinding* suggested);
  XrResult GetCurrentInteractionProfile(XrSession session, XrPath user_path, XrInteractionProfileState* state);

  // All that were suggested until now.
  Suggestions Suggested() const;

  // What the runtime alone would show for a hand.
  XrPath ProfileBelow(XrSession session, XrPath user_path) const;
  // `before` and `after` differ: an event is due if the application sees another profile than before.
  void NotifyProfileChange(Session& session, XrPath user_path, const Profile* before, const Profile* after);

 private:
  bool OnlyOurs(const Profile& profile) const;
  bool OnlyOurs(const Profile& profile, std::string_view full_path) const;
  XrResult CheckSuggestions(const Profile& profile, const std::vector<XrActionSuggestedBinding>& suggested);
  XrResult Forward(const XrInteractionProfileSuggestedBinding& suggested, const Profile* known);
  void Record(const std::string& profile_path, const XrInteractionProfileSuggestedBinding& suggested,
              const std::vector<BindingThreshold>& thresholds);

  const Runtime& runtime_;
  const Records& records_;
  ServiceLink& link_;
  const std::vector<Profile>& profiles_;
  mutable std::mutex mutex_;
  Suggestions suggestions_;
};

}  // namespace omni::layer
