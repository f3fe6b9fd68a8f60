// Creation and destruction of spaces; locate.cc says where they are.

#include <algorithm>
#include <mutex>

#include "tests/runtime/entry_points.h"
#include "tests/runtime/state.h"

namespace omni::runtime {
namespace {

std::vector<XrReferenceSpaceType> SupportedSpaces(const State& state, const Session& session) {
  std::vector<XrReferenceSpaceType> offered = {XR_REFERENCE_SPACE_TYPE_VIEW, XR_REFERENCE_SPACE_TYPE_LOCAL};
  if (state.world.has_stage) offered.push_back(XR_REFERENCE_SPACE_TYPE_STAGE);
  if (session.instance->version_1_1) offered.push_back(kLocalFloor);
  return offered;
}

XrSpace Add(State& state, Session& session, std::shared_ptr<Space> space) {
  space->session = &session;
  return AddChild<XrSpace>(state, session, std::move(space));
}

XrResult CheckReferenceType(const State& state, const Session& session, XrReferenceSpaceType type) {
  const std::vector<XrReferenceSpaceType> offered = SupportedSpaces(state, session);
  const bool known = std::find(offered.begin(), offered.end(), type) != offered.end();
  return known ? XR_SUCCESS : XR_ERROR_REFERENCE_SPACE_UNSUPPORTED;
}

}  // namespace

XrResult EnumerateReferenceSpaces(XrSession session, uint32_t capacity, uint32_t* count, XrReferenceSpaceType* types) {
  State& state = TheState();
  const std::shared_lock lock(state.mutex);
  OMNI_FIND(Session, owner, session);
  const std::vector<XrReferenceSpaceType> offered = SupportedSpaces(state, *owner);
  return TwoCall(static_cast<uint32_t>(offered.size()), capacity, count, types,
                 [&](uint32_t i, XrReferenceSpaceType& out) { out = offered[i]; });
}

XrResult GetReferenceSpaceBoundsRect(XrSession session, XrReferenceSpaceType type, XrExtent2Df* bounds) {
  State& state = TheState();
  const std::shared_lock lock(state.mutex);
  OMNI_FIND(Session, owner, session);
  OMNI_REQUIRE(bounds != nullptr, XR_ERROR_VALIDATION_FAILURE);
  if (const XrResult check = CheckReferenceType(state, *owner, type); XR_FAILED(check)) return check;
  *bounds = {0, 0};
  return XR_SPACE_BOUNDS_UNAVAILABLE;
}

XrResult CreateReferenceSpace(XrSession session, const XrReferenceSpaceCreateInfo* info, XrSpace* space) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  OMNI_FIND(Session, owner, session);
  OMNI_REQUIRE(Is(info, XR_TYPE_REFERENCE_SPACE_CREATE_INFO) && space != nullptr, XR_ERROR_VALIDATION_FAILURE);
  if (const XrResult check = CheckReferenceType(state, *owner, info->referenceSpaceType); XR_FAILED(check))
    return check;
  OMNI_REQUIRE(IsValid(info->poseInReferenceSpace), XR_ERROR_POSE_INVALID);
  auto created = std::make_shared<Space>();
  created->reference = info->referenceSpaceType;
  created->offset = Normalized(info->poseInReferenceSpace);
  *space = Add(state, *owner, std::move(created));
  return XR_SUCCESS;
}

// Valid before the action's set is attached; such a space is just not locatable yet.
XrResult CreateActionSpace(XrSession session, const XrActionSpaceCreateInfo* info, XrSpace* space) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  OMNI_FIND(Session, owner, session);
  OMNI_REQUIRE(Is(info, XR_TYPE_ACTION_SPACE_CREATE_INFO) && space != nullptr, XR_ERROR_VALIDATION_FAILURE);
  OMNI_FIND(Action, action, info->action);
  OMNI_REQUIRE(action->set->instance == owner->instance, XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(action->type == XR_ACTION_TYPE_POSE_INPUT, XR_ERROR_ACTION_TYPE_MISMATCH);
  if (info->subactionPath != XR_NULL_PATH) {
    OMNI_REQUIRE(PathText(*owner->instance, info->subactionPath) != nullptr, XR_ERROR_PATH_INVALID);
    const auto& declared = action->subaction_paths;
    const bool known = std::find(declared.begin(), declared.end(), info->subactionPath) != declared.end();
    OMNI_REQUIRE(known, XR_ERROR_PATH_UNSUPPORTED);
  }
  OMNI_REQUIRE(IsValid(info->poseInActionSpace), XR_ERROR_POSE_INVALID);
  auto created = std::make_shared<Space>();
  created->action = state.handles.Share<Action>(info->action);
  created->set = state.handles.Share<ActionSet>(Handles::As<XrActionSet>(action->set->handle));
  created->subaction = info->subactionPath;
  created->offset = Normalized(info->poseInActionSpace);
  *space = Add(state, *owner, std::move(created));
  return XR_SUCCESS;
}

XrResult DestroySpace(XrSpace space) { return DestroyChild<Space>(space); }

}  // namespace omni::runtime
