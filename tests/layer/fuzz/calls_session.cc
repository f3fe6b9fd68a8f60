// The fuzzed calls about sessions, events, frames and spaces.
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>

#include "tests/layer/fuzz/pick.h"
#include "tests/layer/fuzz/sequence.h"
#include "tests/layer/support/app.h"

namespace omni::test {
namespace {

constexpr XrSpaceLocationFlags kOrientationValid = XR_SPACE_LOCATION_ORIENTATION_VALID_BIT;
constexpr XrSpaceLocationFlags kPositionValid = XR_SPACE_LOCATION_POSITION_VALID_BIT;

bool Finite(const XrVector3f& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

bool Unit(const XrQuaternionf& q) {
  const double squared = double{q.x} * q.x + double{q.y} * q.y + double{q.z} * q.z + double{q.w} * q.w;
  return std::fabs(squared - 1.0) < 1e-4;  // false for NaN
}

}  // namespace

std::string Sequence::PoseText(const XrPosef& pose) {
  char text[160];
  std::snprintf(text, sizeof(text), " %.4f %.4f %.4f  %.4f %.4f %.4f %.4f", pose.position.x, pose.position.y,
                pose.position.z, pose.orientation.x, pose.orientation.y, pose.orientation.z, pose.orientation.w);
  return text;
}

void Sequence::MakeSession() {
  if (sessions_.live.size() > 2) return;
  const XrSessionCreateInfo info{Type(XR_TYPE_SESSION_CREATE_INFO), Chain(), 0, random_.Percent(3) ? 77 : system_};
  XrSession session = XR_NULL_HANDLE;
  const XrResult result = f_.CreateSession(instance_, OrNull(&info), OrNull(&session));
  Say("create session", result);
  if (XR_SUCCEEDED(result)) Keep(sessions_, session, session);
}

void Sequence::DropSession() {
  const auto session = Drop(sessions_, f_.DestroySession, "destroy session");
  if (!session) return;
  Bury(spaces_, *session);
  Bury(hands_, *session);
  Bury(models_, *session);
  Bury(assets_, *session);
  Bury(forces_, *session);
  Bury(scenes_, *session);
  waited_.erase(*session);
}

void Sequence::Begin() {
  const XrSessionBeginInfo info{Type(XR_TYPE_SESSION_BEGIN_INFO), Chain(), XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO};
  Say("begin session", f_.BeginSession(Pick(sessions_), OrNull(&info)));
}

void Sequence::End() { Say("end session", f_.EndSession(Pick(sessions_))); }

void Sequence::Exit() {
  if (random_.Percent(30)) Say("request exit", f_.RequestExitSession(Pick(sessions_)));
}

// Follows the session's states as an application does.
void Sequence::Poll() {
  XrEventDataBuffer event{Type(XR_TYPE_EVENT_DATA_BUFFER), nullptr, {}};
  const XrResult result = f_.PollEvent(instance_, OrNull(&event));
  Say("poll", result, result == XR_SUCCESS ? " " + std::to_string(static_cast<int>(event.type)) : "");
  if (result != XR_SUCCESS || event.type != XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED) return;
  XrEventDataSessionStateChanged changed;
  std::memcpy(&changed, &event, sizeof(changed));
  lines_.back() += " state " + std::to_string(static_cast<int>(changed.state));
  if (changed.state != XR_SESSION_STATE_READY) return;
  const XrSessionBeginInfo info{XR_TYPE_SESSION_BEGIN_INFO, nullptr, XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO};
  Say("begin session", f_.BeginSession(changed.session, &info));
}

void Sequence::Frame() {
  const XrSession session = Pick(sessions_);
  XrFrameState state{XR_TYPE_FRAME_STATE, nullptr, 0, 0, XR_FALSE};
  const XrFrameWaitInfo wait{Type(XR_TYPE_FRAME_WAIT_INFO), nullptr};
  if (waited_.count(session) == 0) {
    const XrResult result = f_.WaitFrame(session, OrNull(&wait), OrNull(&state));
    Say("wait frame", result);
    if (XR_SUCCEEDED(result)) waited_.insert(session);
  }
  const XrFrameBeginInfo begin{XR_TYPE_FRAME_BEGIN_INFO, nullptr};
  const XrResult began = f_.BeginFrame(session, &begin);
  Say("begin frame", began);
  if (XR_SUCCEEDED(began)) waited_.erase(session);
  XrCompositionLayerQuad quad{
      XR_TYPE_COMPOSITION_LAYER_QUAD,        Chain(),   0,     Pick(spaces_), XR_EYE_VISIBILITY_BOTH,
      {XR_NULL_HANDLE, {{0, 0}, {1, 1}}, 0}, AnyPose(), {1, 1}};
  const auto* layer =
      static_cast<const XrCompositionLayerBaseHeader*>(static_cast<const void*>(random_.Percent(5) ? nullptr : &quad));
  const XrTime time = state.predictedDisplayTime > 0 ? state.predictedDisplayTime : 1;
  XrFrameEndInfo end{XR_TYPE_FRAME_END_INFO, nullptr, time, XR_ENVIRONMENT_BLEND_MODE_OPAQUE, random_.Below(2), &layer};
  end.type = Type(end.type);
  Say("end frame", f_.EndFrame(session, OrNull(&end)));
}

void Sequence::Views() {
  const XrViewLocateInfo info{Type(XR_TYPE_VIEW_LOCATE_INFO), nullptr, XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO,
                              Now_ns() + kRuntimeOffset_ns, Pick(spaces_)};
  XrViewState state{XR_TYPE_VIEW_STATE, nullptr, 0};
  XrView views[2] = {{XR_TYPE_VIEW, nullptr, {{0, 0, 0, 1}, {0, 0, 0}}, {}},
                     {XR_TYPE_VIEW, nullptr, {{0, 0, 0, 1}, {0, 0, 0}}, {}}};
  std::uint32_t count = 0;
  const XrResult result =
      f_.LocateViews(Pick(sessions_), OrNull(&info), OrNull(&state), random_.Below(3), OrNull(&count), OrNull(views));
  Say("locate views", result, " " + std::to_string(count) + " " + std::to_string(state.viewStateFlags));
  if (XR_FAILED(result)) return;
  for (const XrView& view : views)
    if (!Finite(view.pose.position) || !Unit(view.pose.orientation)) Violation("a view's pose is invalid");
}

XrPosef Sequence::AnyPose() {
  if (random_.Percent(4)) return {{0, 0, 0, 0}, {0, 0, 0}};
  if (random_.Percent(2)) return {{0, 0, 0, 1}, {std::numeric_limits<float>::quiet_NaN(), 0, 0}};
  const auto number = [&] { return static_cast<float>(2 * random_.Unit() - 1); };
  const float angle = number();
  return {{std::sin(angle), 0, 0, std::cos(angle)}, {number(), number(), number()}};
}

void Sequence::ActionSpace() {
  if (spaces_.live.size() > 40) return;
  const XrActionSpaceCreateInfo info{Type(XR_TYPE_ACTION_SPACE_CREATE_INFO), Chain(), Pick(actions_), HandPath(),
                                     AnyPose()};
  XrSpace space = XR_NULL_HANDLE;
  const XrSession session = Pick(sessions_);
  const XrResult result = f_.CreateActionSpace(session, OrNull(&info), OrNull(&space));
  Say("create action space", result);
  if (XR_SUCCEEDED(result)) Keep(spaces_, space, session);
}

void Sequence::ReferenceSpace() {
  if (spaces_.live.size() > 40) return;
  static constexpr XrReferenceSpaceType kTypes[] = {XR_REFERENCE_SPACE_TYPE_VIEW, XR_REFERENCE_SPACE_TYPE_LOCAL,
                                                    XR_REFERENCE_SPACE_TYPE_STAGE,
                                                    static_cast<XrReferenceSpaceType>(77)};
  const XrReferenceSpaceCreateInfo info{Type(XR_TYPE_REFERENCE_SPACE_CREATE_INFO), Chain(), kTypes[random_.Below(4)],
                                        AnyPose()};
  XrSpace space = XR_NULL_HANDLE;
  const XrSession session = Pick(sessions_);
  const XrResult result = f_.CreateReferenceSpace(session, OrNull(&info), OrNull(&space));
  Say("create reference space", result);
  if (XR_SUCCEEDED(result)) Keep(spaces_, space, session);
}

void Sequence::DropSpace() { Drop(spaces_, f_.DestroySpace, "destroy space"); }

void Sequence::CheckPlace(XrSpaceLocationFlags flags, const XrPosef& pose) {
  const bool tracked_is_valid = (!(flags & XR_SPACE_LOCATION_ORIENTATION_TRACKED_BIT) || (flags & kOrientationValid)) &&
                                (!(flags & XR_SPACE_LOCATION_POSITION_TRACKED_BIT) || (flags & kPositionValid));
  if (!tracked_is_valid) Violation("TRACKED without VALID");
  if ((flags & kOrientationValid) && !Unit(pose.orientation)) Violation("an orientation that is not a rotation");
  if ((flags & kPositionValid) && !Finite(pose.position)) Violation("a position that is not finite");
}

void Sequence::CheckSpeed(XrSpaceLocationFlags place, XrSpaceVelocityFlags flags, const XrVector3f& linear,
                          const XrVector3f& angular) {
  if ((flags & XR_SPACE_VELOCITY_LINEAR_VALID_BIT) && !Finite(linear)) Violation("a velocity that is not finite");
  if ((flags & XR_SPACE_VELOCITY_ANGULAR_VALID_BIT) && !Finite(angular))
    Violation("an angular velocity that is not finite");
  if (flags && !place) Violation("a velocity without a position");
}

void Sequence::Locate() {
  const XrTime time = AnyTime();
  XrSpaceVelocity velocity{XR_TYPE_SPACE_VELOCITY, nullptr, 0, {0, 0, 0}, {0, 0, 0}};
  XrBaseOutStructure unknown{static_cast<XrStructureType>(1999999999),
                             reinterpret_cast<XrBaseOutStructure*>(&velocity)};
  const bool wants_velocity = random_.Percent(60);
  XrSpaceLocation location{Type(XR_TYPE_SPACE_LOCATION), nullptr, 0, {{0, 0, 0, 1}, {0, 0, 0}}};
  if (wants_velocity) location.next = random_.Percent(10) ? static_cast<void*>(&unknown) : &velocity;
  const XrSpace space = Pick(spaces_);
  const XrSpace base = SpaceFor(space);
  const XrResult result = f_.LocateSpace(space, base, time, OrNull(&location));
  std::string text;
  if (XR_SUCCEEDED(result)) {
    text = " flags " + std::to_string(location.locationFlags) + "/" + std::to_string(velocity.velocityFlags) +
           PoseText(location.pose);
    CheckPlace(location.locationFlags, location.pose);
    if (wants_velocity)
      CheckSpeed(location.locationFlags, velocity.velocityFlags, velocity.linearVelocity, velocity.angularVelocity);
  }
  Say("locate", result, text);
  Expect("locate", result, {XR_ERROR_VALIDATION_FAILURE, XR_ERROR_HANDLE_INVALID, XR_ERROR_TIME_INVALID});
}

}  // namespace omni::test
