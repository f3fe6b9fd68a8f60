// The fuzzed calls of XR_OMNIX1_force_feedback.
#include <cmath>
#include <cstring>

#include "tests/layer/fuzz/pick.h"
#include "tests/layer/fuzz/sequence.h"
#include "tests/layer/support/app.h"

namespace omni::test {
namespace {

// Room for any constraint, so that a wrong type reads nothing beyond it. All begin alike.
union AnyConstraint {
  XrForceFeedbackConstraintBaseHeaderOMNIX1 header;
  XrForceFeedbackConstraintLineOMNIX1 line;
  XrForceFeedbackConstraintPlaneOMNIX1 plane;
  XrForceFeedbackConstraintSphereOMNIX1 sphere;
};

constexpr std::uint32_t kMostConstraints = 10;

}  // namespace

void Sequence::MakeForce() {
  if (!own_.CreateForceFeedbackOMNIX1) return;
  const XrForceFeedbackCreateInfoOMNIX1 info{Type(XR_TYPE_FORCE_FEEDBACK_CREATE_INFO_OMNIX1), Chain(),
                                             random_.Percent(70) ? paths_[1] : HandPath()};
  XrForceFeedbackOMNIX1 force = XR_NULL_HANDLE;
  const XrSession session = Pick(sessions_);
  const XrResult result = own_.CreateForceFeedbackOMNIX1(session, OrNull(&info), OrNull(&force));
  Say("create force", result);
  Expect("create force", result,
         {XR_ERROR_VALIDATION_FAILURE, XR_ERROR_HANDLE_INVALID, XR_ERROR_PATH_INVALID, XR_ERROR_PATH_UNSUPPORTED,
          XR_ERROR_FEATURE_UNSUPPORTED, XR_ERROR_FORCE_FEEDBACK_IN_USE_OMNIX1});
  if (XR_SUCCEEDED(result)) Keep(forces_, force, session);
}

void Sequence::DropForce() {
  if (!own_.DestroyForceFeedbackOMNIX1 || random_.Percent(70)) return;
  const XrForceFeedbackOMNIX1 force = Pick(forces_);
  const XrResult result = own_.DestroyForceFeedbackOMNIX1(force);
  Say("destroy force", result);
  Expect("destroy force", result, {XR_ERROR_HANDLE_INVALID});
  if (XR_FAILED(result)) return;
  std::erase(forces_.live, force);
  forces_.dead.push_back(force);
}

void Sequence::Push() {
  if (!own_.ApplyForceOMNIX1 || Lacks(forces_)) return;
  const XrForceFeedbackOMNIX1 force = Pick(forces_);
  const XrForceApplyInfoOMNIX1 info{Type(XR_TYPE_FORCE_APPLY_INFO_OMNIX1),   Chain(),       SpaceFor(force),
                                    {AnyNumber(), AnyNumber(), AnyNumber()}, AnyDuration(), AnyDuration()};
  const XrResult result = own_.ApplyForceOMNIX1(force, OrNull(&info));
  Say("push", result);
  Expect("push", result,
         {XR_ERROR_VALIDATION_FAILURE, XR_ERROR_HANDLE_INVALID, XR_ERROR_FORCE_FEEDBACK_IN_USE_OMNIX1,
          XR_ERROR_FORCE_FEEDBACK_SPACE_NOT_LOCATABLE_OMNIX1, XR_SESSION_NOT_FOCUSED});
}

void Sequence::Constrain() {
  if (!own_.SetForceFeedbackConstraintsOMNIX1 || Lacks(forces_)) return;
  const XrForceFeedbackOMNIX1 force = Pick(forces_);
  AnyConstraint all[kMostConstraints];
  const XrForceFeedbackConstraintBaseHeaderOMNIX1* list[kMostConstraints];
  const std::uint32_t count = random_.Percent(90) ? random_.Below(4) : random_.Below(kMostConstraints + 1);
  for (std::uint32_t i = 0; i < kMostConstraints; ++i) {
    std::memset(&all[i], 0, sizeof(all[i]));
    all[i].sphere = {Type(static_cast<XrStructureType>(2000001010 + static_cast<int>(random_.Below(5)))),
                     nullptr,
                     SpaceFor(force),
                     random_.Percent(50) ? 0 : AnyNumber(),
                     random_.Percent(70) ? 0.5f : AnyNumber(),
                     random_.Percent(70) ? 1 : AnyNumber(),
                     {AnyNumber(), AnyNumber(), AnyNumber()},
                     AnyNumber(),
                     static_cast<XrForceFeedbackSideOMNIX1>(random_.Below(4))};
    if (random_.Percent(40)) all[i].plane.normal = {0, AnyNumber(), AnyNumber()};
    list[i] = OrNull(&all[i].header);
  }
  const XrForceFeedbackConstraintsSetInfoOMNIX1 info{Type(XR_TYPE_FORCE_FEEDBACK_CONSTRAINTS_SET_INFO_OMNIX1), Chain(),
                                                     count, OrNull(&list[0])};
  const XrResult result = own_.SetForceFeedbackConstraintsOMNIX1(force, OrNull(&info));
  Say("constrain", result);
  Expect("constrain", result,
         {XR_ERROR_VALIDATION_FAILURE, XR_ERROR_HANDLE_INVALID, XR_ERROR_LIMIT_REACHED,
          XR_ERROR_FORCE_FEEDBACK_IN_USE_OMNIX1, XR_ERROR_FORCE_FEEDBACK_SPACE_NOT_LOCATABLE_OMNIX1,
          XR_SESSION_NOT_FOCUSED});
}

void Sequence::StopForce() {
  if (!own_.StopForceFeedbackOMNIX1 || Lacks(forces_)) return;
  const XrResult result = own_.StopForceFeedbackOMNIX1(Pick(forces_));
  Say("stop force", result);
  Expect("stop force", result, {XR_ERROR_HANDLE_INVALID});
}

void Sequence::ForceState() {
  if (!own_.GetForceFeedbackStateOMNIX1 || Lacks(forces_)) return;
  const XrForceFeedbackOMNIX1 force = Pick(forces_);
  const XrForceFeedbackStateGetInfoOMNIX1 info{Type(XR_TYPE_FORCE_FEEDBACK_STATE_GET_INFO_OMNIX1), Chain(),
                                               SpaceFor(force), AnyTime()};
  XrForceFeedbackStateOMNIX1 state{Type(XR_TYPE_FORCE_FEEDBACK_STATE_OMNIX1), nullptr, 7, 0, 0, 7, {0, 0, 0}, 0};
  const XrResult result = own_.GetForceFeedbackStateOMNIX1(force, OrNull(&info), OrNull(&state));
  Say("force state", result);
  Expect("force state", result, {XR_ERROR_VALIDATION_FAILURE, XR_ERROR_HANDLE_INVALID, XR_ERROR_TIME_INVALID});
  if (XR_FAILED(result)) return;
  const XrVector3f& f = state.appliedForce;
  if (!std::isfinite(f.x) || !std::isfinite(f.y) || !std::isfinite(f.z)) Violation("a force that is not finite");
  if (state.isActive > XR_TRUE || state.isForceValid > XR_TRUE) Violation("a force state has an invalid boolean");
  if (state.isActive && (state.stateFlags & XR_FORCE_FEEDBACK_STATE_FOCUS_LOST_BIT_OMNIX1) != 0)
    Violation("forces are active without focus");
}

void Sequence::ForceProperties() {
  if (!own_.GetForceFeedbackPropertiesOMNIX1 || Lacks(forces_)) return;
  const XrForceFeedbackOMNIX1 force = Pick(forces_);
  const XrForceFeedbackPropertiesGetInfoOMNIX1 info{Type(XR_TYPE_FORCE_FEEDBACK_PROPERTIES_GET_INFO_OMNIX1), Chain(),
                                                    SpaceFor(force), AnyTime()};
  XrForceFeedbackReachOMNIX1 reach[4];
  XrForceFeedbackPropertiesOMNIX1 out{Type(XR_TYPE_FORCE_FEEDBACK_PROPERTIES_OMNIX1)};
  out.reachCapacityInput = random_.Below(5);
  out.reach = OrNull(&reach[0]);
  const XrResult result = own_.GetForceFeedbackPropertiesOMNIX1(force, OrNull(&info), OrNull(&out));
  Say("force properties", result);
  Expect("force properties", result,
         {XR_ERROR_VALIDATION_FAILURE, XR_ERROR_HANDLE_INVALID, XR_ERROR_TIME_INVALID, XR_ERROR_FEATURE_UNSUPPORTED,
          XR_ERROR_SIZE_INSUFFICIENT});
  if (XR_SUCCEEDED(result)) CheckPlace(out.workspaceLocationFlags, out.workspacePose);
}

// [XrSystemForceFeedbackPropertiesOMNIX1] the application's chain is unchanged, whatever is in it.
void Sequence::SystemSays() {
  XrSystemForceFeedbackPropertiesOMNIX1 ours{XR_TYPE_SYSTEM_FORCE_FEEDBACK_PROPERTIES_OMNIX1};
  XrBaseOutStructure unknown{static_cast<XrStructureType>(1999999999), nullptr};
  if (random_.Percent(50)) ours.next = &unknown;
  XrSystemProperties properties{Type(XR_TYPE_SYSTEM_PROPERTIES), nullptr, 0, 0, {}, {}, {}};
  if (own_.CreateForceFeedbackOMNIX1) properties.next = &ours;
  const void* const before = properties.next;
  const void* const before_that = ours.next;
  const XrResult result = f_.GetSystemProperties(instance_, random_.Percent(5) ? 77 : system_, OrNull(&properties));
  Say("system properties", result);
  if (properties.next != before || ours.next != before_that) Violation("xrGetSystemProperties changed a chain");
  if (XR_SUCCEEDED(result) && ours.supportsForceFeedback > XR_TRUE)
    Violation("supportsForceFeedback is not an XrBool32");
}

}  // namespace omni::test
