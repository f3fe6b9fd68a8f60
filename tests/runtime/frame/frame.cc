// The frame loop: paced and checked, without a display.

#include <algorithm>
#include <mutex>

#include "tests/runtime/entry_points.h"
#include "tests/runtime/frame/frame_layers.h"
#include "tests/runtime/frame/views.h"
#include "tests/runtime/graphics/composer.h"
#include "tests/runtime/spaces/clock.h"
#include "tests/runtime/spaces/locate.h"
#include "tests/runtime/system.h"

namespace omni::runtime {
namespace {

constexpr XrDuration kFramePeriod_ns = kSecond_ns / 90;
constexpr XrDuration kPollPeriod_ns = 500'000;

bool IsShown(const Session& session) {
  const bool visible = session.state == XR_SESSION_STATE_VISIBLE || session.state == XR_SESSION_STATE_FOCUSED;
  return session.graphics != nullptr && visible;
}

// Every pose that is handed out is renewed: in the base space at display time.
void FillViews(const Motion& head_in_base, XrView* views) {
  for (uint32_t eye = 0; eye < kEyes; ++eye) {
    const XrView view = EyeView(head_in_base.pose, eye);
    views[eye].pose = view.pose;
    views[eye].fov = view.fov;
  }
}

}  // namespace

// Blocks until the next period and, as specified, until the frame that was waited for before has begun.
XrResult WaitFrame(XrSession session, const XrFrameWaitInfo* info, XrFrameState* frame) {
  State& state = TheState();
  OMNI_REQUIRE(info == nullptr || info->type == XR_TYPE_FRAME_WAIT_INFO, XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(Is(frame, XR_TYPE_FRAME_STATE), XR_ERROR_VALIDATION_FAILURE);
  for (;;) {
    XrTime wake = 0;
    {
      const std::unique_lock lock(state.mutex);
      OMNI_FIND(Session, owner, session);
      OMNI_REQUIRE(owner->running, XR_ERROR_SESSION_NOT_RUNNING);
      const XrTime now = Now();
      if (owner->next_frame == 0) owner->next_frame = now;
      if (now >= owner->next_frame && !owner->frame_waited) {
        RunScript(owner->instance->script, now);
        owner->frame_waited = true;
        owner->next_frame = std::max(owner->next_frame + kFramePeriod_ns, now);
        frame->predictedDisplayTime = owner->next_frame + kFramePeriod_ns;
        frame->predictedDisplayPeriod = kFramePeriod_ns;
        frame->shouldRender = IsShown(*owner) ? XR_TRUE : XR_FALSE;
        return XR_SUCCESS;
      }
      wake = std::max(owner->next_frame, now + kPollPeriod_ns);
    }
    SleepUntil(wake);
  }
}

XrResult BeginFrame(XrSession session, const XrFrameBeginInfo* info) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  OMNI_FIND(Session, owner, session);
  OMNI_REQUIRE(info == nullptr || info->type == XR_TYPE_FRAME_BEGIN_INFO, XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(owner->running, XR_ERROR_SESSION_NOT_RUNNING);
  OMNI_REQUIRE(owner->frame_waited, XR_ERROR_CALL_ORDER_INVALID);
  const bool discarded = owner->frame_begun;
  owner->frame_waited = false;
  owner->frame_begun = true;
  return discarded ? XR_FRAME_DISCARDED : XR_SUCCESS;
}

XrResult EndFrame(XrSession session, const XrFrameEndInfo* info) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  OMNI_FIND(Session, owner, session);
  OMNI_REQUIRE(Is(info, XR_TYPE_FRAME_END_INFO), XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(owner->running, XR_ERROR_SESSION_NOT_RUNNING);
  OMNI_REQUIRE(owner->frame_begun, XR_ERROR_CALL_ORDER_INVALID);
  OMNI_REQUIRE(info->displayTime > 0, XR_ERROR_TIME_INVALID);
  OMNI_REQUIRE(IsSupportedBlendMode(info->environmentBlendMode), XR_ERROR_ENVIRONMENT_BLEND_MODE_UNSUPPORTED);
  RecordFrame(*info);
  if (const XrResult check = CheckFrameLayers(*owner, *info); XR_FAILED(check)) return check;
  owner->frame_begun = false;
  owner->in_step = true;
  return SavePictures(state.world, *owner, *info);
}

XrResult LocateViews(XrSession session, const XrViewLocateInfo* info, XrViewState* view_state, uint32_t capacity,
                     uint32_t* count, XrView* views) {
  State& state = TheState();
  const std::shared_lock lock(state.mutex);
  OMNI_FIND(Session, owner, session);
  OMNI_REQUIRE(Is(info, XR_TYPE_VIEW_LOCATE_INFO) && Is(view_state, XR_TYPE_VIEW_STATE), XR_ERROR_VALIDATION_FAILURE);
  OMNI_FIND(Space, base, info->space);
  OMNI_REQUIRE(base->session == owner, XR_ERROR_VALIDATION_FAILURE);
  if (const XrResult check = CheckViewConfiguration(info->viewConfigurationType); XR_FAILED(check)) return check;
  OMNI_REQUIRE(info->displayTime > 0, XR_ERROR_TIME_INVALID);
  for (uint32_t i = 0; views != nullptr && i < capacity; ++i) {
    OMNI_REQUIRE(Is(&views[i], XR_TYPE_VIEW), XR_ERROR_VALIDATION_FAILURE);
  }
  const XrResult sized = TwoCall(kEyes, capacity, count, views, [](uint32_t, XrView&) {});
  if (XR_FAILED(sized)) return sized;
  Space view;
  view.session = owner;
  view.reference = XR_REFERENCE_SPACE_TYPE_VIEW;
  const Located head = LocateIn(state.world, *owner, view, *base, info->displayTime);
  view_state->viewStateFlags = 0;
  if (head.valid) view_state->viewStateFlags |= XR_VIEW_STATE_ORIENTATION_VALID_BIT | XR_VIEW_STATE_POSITION_VALID_BIT;
  if (head.tracked) {
    view_state->viewStateFlags |= XR_VIEW_STATE_ORIENTATION_TRACKED_BIT | XR_VIEW_STATE_POSITION_TRACKED_BIT;
  }
  if (capacity != 0) FillViews(head.motion, views);
  return XR_SUCCESS;
}

}  // namespace omni::runtime
