// XR_OMNIX1_force_feedback: handles, forces, constraints. docs/extensions/XR_OMNIX1_force_feedback.md
#include "layer/src/force/force_feedbacks.h"

#include <algorithm>

#include "layer/src/spaces/locate.h"
#include "service/base/clock.h"

namespace omni::layer {
namespace {

bool Has(XrSpaceLocationFlags flags, XrSpaceLocationFlags bits) { return (flags & bits) == bits; }

// Another application has the device.
bool IsTaken(const ServiceLink& link) { return link.force_standing() == protocol::ForceStanding::kTaken; }

// Finds the place of each space once.
class Places {
 public:
  Places(Locator& locator, const RuntimeClock& clock, const Session& session)
      : locator_(locator), clock_(clock), session_(session) {}

  XrResult Find(XrSpace space, Located& place) {
    for (const auto& [known, at] : found_) {
      if (known != space) continue;
      place = at;
      return XR_SUCCESS;
    }
    const XrResult result = locator_.LocateInBase(session_, space, clock_.ToXr(now_ns_), place);
    if (XR_SUCCEEDED(result)) found_.emplace_back(space, place);
    return result;
  }
  std::int64_t now_ns() const { return now_ns_; }

 private:
  Locator& locator_;
  const RuntimeClock& clock_;
  const Session& session_;
  const std::int64_t now_ns_ = base::MonotonicNow_ns();
  std::vector<std::pair<XrSpace, Located>> found_;
};

// Those whose space can be located. `all_placed`: every one can.
XrResult PlaceConstraints(Places& places, const std::vector<LocalConstraint>& constraints,
                          protocol::ForceConstraints& out, bool& all_placed) {
  all_placed = true;
  out.t_ns = places.now_ns();
  out.count = 0;
  for (const LocalConstraint& constraint : constraints) {
    Located place;
    if (const XrResult result = places.Find(constraint.space, place); XR_FAILED(result)) return result;
    if (Has(place.flags, kValid) && IsFinite(place.motion)) {
      out.constraints[out.count++] = InBase(constraint.shape, KnownMotion(place));
    } else {
      all_placed = false;
    }
  }
  return XR_SUCCESS;
}

}  // namespace

XrResult ForceFeedbacks::Create(XrSession session, const XrForceFeedbackCreateInfoOMNIX1* info,
                                XrForceFeedbackOMNIX1* handle_out) {
  link_.PollNow(base::MonotonicNow_ns());
  const auto record = records_.sessions.Find(session);
  if (!record) return XR_ERROR_HANDLE_INVALID;
  if (!info || info->type != XR_TYPE_FORCE_FEEDBACK_CREATE_INFO_OMNIX1 || !handle_out)
    return XR_ERROR_VALIDATION_FAILURE;
  if (runtime_.PathText(info->topLevelUserPath).empty()) return XR_ERROR_PATH_INVALID;
  const XrPath hand = runtime_.hand_paths[static_cast<std::size_t>(link_.choice().hand)];
  if (info->topLevelUserPath != hand) return XR_ERROR_PATH_UNSUPPORTED;
  if (link_.force_properties().available == 0) return XR_ERROR_FEATURE_UNSUPPORTED;
  if (IsTaken(link_)) return XR_ERROR_FORCE_FEEDBACK_IN_USE_OMNIX1;
  const std::lock_guard lock(mutex_);
  if (!forces_.Values().empty()) return XR_ERROR_FORCE_FEEDBACK_IN_USE_OMNIX1;
  const auto made = std::make_shared<ForceFeedback>(record, StatusNow(*record));
  forces_.Insert(made->handle(), made);
  link_.ClaimForce(true);
  *handle_out = made->handle();
  return XR_SUCCESS;
}

XrResult ForceFeedbacks::Destroy(XrForceFeedbackOMNIX1 force) {
  const std::lock_guard lock(mutex_);
  if (!forces_.Contains(force)) return XR_ERROR_HANDLE_INVALID;
  forces_.Erase(force);
  link_.StopForce();
  link_.ClaimForce(false);
  return XR_SUCCESS;
}

void ForceFeedbacks::EndOf(XrSession session) {
  const std::lock_guard lock(mutex_);
  const std::size_t before = forces_.Values().size();
  forces_.EraseIf([session](const ForceFeedback& force) { return force.session->handle == session; });
  if (forces_.Values().size() == before) return;
  link_.StopForce();
  link_.ClaimForce(false);
}

void ForceFeedbacks::OnFocusLost(const Session& session) {
  for (const auto& force : forces_.Values()) {
    if (force->session.get() != &session) continue;
    {
      const std::lock_guard lock(force->mutex);
      force->constraints.clear();
      ++force->constraint_changes;
    }
    link_.StopForce();
  }
}

void ForceFeedbacks::ForgetSpace(XrSpace space) {
  for (const auto& force : forces_.Values()) {
    const std::lock_guard lock(force->mutex);
    auto& all = force->constraints;
    const auto gone = std::remove_if(all.begin(), all.end(), [space](const auto& c) { return c.space == space; });
    if (gone == all.end()) continue;
    all.erase(gone, all.end());
    ++force->constraint_changes;
    force->sent_connection = 0;  // sent again at the next sync, or here if none is left
    if (all.empty()) link_.SendConstraints(protocol::ForceConstraints{});
  }
}

XrResult ForceFeedbacks::Apply(XrForceFeedbackOMNIX1 handle_in, const XrForceApplyInfoOMNIX1* info) {
  const auto force = forces_.Find(handle_in);
  if (!force) return XR_ERROR_HANDLE_INVALID;
  const bool valid = info && info->type == XR_TYPE_FORCE_APPLY_INFO_OMNIX1 && IsFinite(info->force) &&
                     info->duration > 0 && info->rampDuration >= 0;
  if (!valid) return XR_ERROR_VALIDATION_FAILURE;
  if (info->baseSpace == XR_NULL_HANDLE) return XR_ERROR_HANDLE_INVALID;
  if (!force->session->focused) return XR_SESSION_NOT_FOCUSED;
  if (IsTaken(link_)) return XR_ERROR_FORCE_FEEDBACK_IN_USE_OMNIX1;
  Places places(locator_, clock_, *force->session);
  Located place;
  if (const XrResult result = places.Find(info->baseSpace, place); XR_FAILED(result)) return result;
  const bool directed = Has(place.flags, XR_SPACE_LOCATION_ORIENTATION_VALID_BIT) && IsFinite(place.motion);
  if (!directed) return XR_ERROR_FORCE_FEEDBACK_SPACE_NOT_LOCATABLE_OMNIX1;
  protocol::ForceApply apply;
  apply.t_ns = places.now_ns();
  apply.duration_ns = std::min<std::int64_t>(info->duration, protocol::kLongestForce_ns);
  apply.ramp_ns = std::min<std::int64_t>(info->rampDuration, protocol::kLongestForce_ns);
  glm::dvec3 f = place.motion.X.q * FromXr(info->force);
  const double size = glm::length(f);
  if (size > protocol::kLargestForce_N) f *= protocol::kLargestForce_N / size;
  apply.force_base_N = Clamped(f, protocol::kLargestForce_N);
  link_.SendForce(apply);
  return XR_SUCCESS;
}

XrResult ForceFeedbacks::SetConstraints(XrForceFeedbackOMNIX1 handle_in,
                                        const XrForceFeedbackConstraintsSetInfoOMNIX1* info) {
  const auto force = forces_.Find(handle_in);
  if (!force) return XR_ERROR_HANDLE_INVALID;
  if (!info || info->type != XR_TYPE_FORCE_FEEDBACK_CONSTRAINTS_SET_INFO_OMNIX1) return XR_ERROR_VALIDATION_FAILURE;
  std::vector<LocalConstraint> read;
  if (const XrResult result = ReadConstraints(*info, read); XR_FAILED(result)) return result;
  if (!force->session->focused) return XR_SESSION_NOT_FOCUSED;
  if (IsTaken(link_)) return XR_ERROR_FORCE_FEEDBACK_IN_USE_OMNIX1;
  Places places(locator_, clock_, *force->session);
  protocol::ForceConstraints message;
  bool all_placed = false;
  if (const XrResult result = PlaceConstraints(places, read, message, all_placed); XR_FAILED(result)) return result;
  if (!all_placed) return XR_ERROR_FORCE_FEEDBACK_SPACE_NOT_LOCATABLE_OMNIX1;
  const std::lock_guard lock(force->mutex);
  if (!force->session->focused) return XR_SESSION_NOT_FOCUSED;  // lost meanwhile
  force->constraints = std::move(read);
  ++force->constraint_changes;
  SendConstraints(*force, message);
  return XR_SUCCESS;
}

// The caller holds force.mutex.
void ForceFeedbacks::SendConstraints(ForceFeedback& force, const protocol::ForceConstraints& message) {
  force.sent_connection = link_.SendConstraints(message) ? link_.connection_number() : 0;
  force.sent = message;
}

// Spaces move, and a restarted service knows no constraints.
void ForceFeedbacks::FollowConstraints() {
  for (const auto& force : forces_.Values()) {
    std::vector<LocalConstraint> constraints;
    std::uint64_t changes = 0;
    {
      const std::lock_guard lock(force->mutex);
      constraints = force->constraints;
      changes = force->constraint_changes;
    }
    if (constraints.empty() || !force->session->focused) continue;
    Places places(locator_, clock_, *force->session);
    protocol::ForceConstraints now;
    bool all_placed = false;
    if (XR_FAILED(PlaceConstraints(places, constraints, now, all_placed))) continue;
    const std::lock_guard lock(force->mutex);
    const bool other_ones = force->constraint_changes != changes;  // set, or gone, meanwhile
    const bool same_service = force->sent_connection == link_.connection_number();
    const bool known = same_service && SameConstraints(force->sent, now);
    if (!other_ones && !known) SendConstraints(*force, now);
  }
}

XrResult ForceFeedbacks::Stop(XrForceFeedbackOMNIX1 handle_in) {
  const auto force = forces_.Find(handle_in);
  if (!force) return XR_ERROR_HANDLE_INVALID;
  const std::lock_guard lock(force->mutex);
  force->constraints.clear();
  ++force->constraint_changes;
  link_.StopForce();
  return XR_SUCCESS;
}

}  // namespace omni::layer
