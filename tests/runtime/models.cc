// Models of the controllers, in three vintages: XR_MSFT_controller_model, XR_FB_render_model and
// XR_EXT_interaction_render_model. What can be drawn is a document with one empty node (model_assets.cc).

#include <algorithm>
#include <cstdio>
#include <mutex>
#include <string>
#include <vector>

#include "tests/runtime/entry_points.h"
#include "tests/runtime/state.h"

namespace omni::runtime {
namespace {

constexpr const char* kModelPathsFB[kHands] = {"/model_fb/controller/left", "/model_fb/controller/right"};

// Differs with hand and device.
uint64_t KeyOf(const State& state, int hand) { return 1000u + 2u * state.world.devices[hand].epoch + hand; }

bool IsEnumerated(const Session& session, XrRenderModelIdEXT id) {
  return std::any_of(session.models.begin(), session.models.end(),
                     [id](const SessionModel& model) { return model.id == id; });
}

}  // namespace

// In xrSyncActions only. A controller that returns has a new id.
void UpdateModels(const World& world, Session& session) {
  bool changed = false;
  for (int hand = 0; hand < kHands; ++hand) {
    const auto known = std::find_if(session.models.begin(), session.models.end(),
                                    [hand](const SessionModel& model) { return model.hand == hand; });
    const bool listed = known != session.models.end();
    if (listed == world.devices[hand].present) continue;
    changed = true;
    if (listed) session.models.erase(known);
    if (listed) continue;
    session.last_model = std::max(session.last_model + 1, world.first_model);
    session.models.push_back({session.last_model, hand});
  }
  if (changed && session.instance->Enabled(XR_EXT_INTERACTION_RENDER_MODEL_EXTENSION_NAME)) {
    Push(*session.instance, XrEventDataInteractionRenderModelsChangedEXT{
                                XR_TYPE_EVENT_DATA_INTERACTION_RENDER_MODELS_CHANGED_EXT, nullptr});
  }
}

bool IsShown(const RenderModel& model) {
  return model.session->state == XR_SESSION_STATE_FOCUSED && IsEnumerated(*model.session, model.id);
}

XrResult EnumerateInteractionRenderModelIdsEXT(XrSession session, const XrInteractionRenderModelIdsEnumerateInfoEXT*,
                                               uint32_t capacity, uint32_t* count, XrRenderModelIdEXT* ids) {
  State& state = TheState();
  const std::shared_lock lock(state.mutex);
  OMNI_FIND(Session, owner, session);
  OMNI_REQUIRE(owner->running, XR_ERROR_SESSION_NOT_RUNNING);
  return TwoCall(static_cast<uint32_t>(owner->models.size()), capacity, count, ids,
                 [owner](uint32_t i, XrRenderModelIdEXT& out) { out = owner->models[i].id; });
}

XrResult CreateRenderModelEXT(XrSession session, const XrRenderModelCreateInfoEXT* info, XrRenderModelEXT* model) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  OMNI_FIND(Session, owner, session);
  OMNI_REQUIRE(Is(info, XR_TYPE_RENDER_MODEL_CREATE_INFO_EXT) && model != nullptr, XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(IsEnumerated(*owner, info->renderModelId), XR_ERROR_RENDER_MODEL_ID_INVALID_EXT);
  auto created = std::make_shared<RenderModel>();
  created->session = owner;
  created->id = info->renderModelId;
  for (const SessionModel& listed : owner->models)
    if (listed.id == created->id) created->hand = listed.hand;
  *model = AddChild<XrRenderModelEXT>(state, *owner, std::move(created));
  return XR_SUCCESS;
}

XrResult DestroyRenderModelEXT(XrRenderModelEXT model) { return DestroyChild<RenderModel>(model); }

XrResult CreateRenderModelSpaceEXT(XrSession session, const XrRenderModelSpaceCreateInfoEXT* info, XrSpace* space) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  OMNI_FIND(Session, owner, session);
  OMNI_REQUIRE(Is(info, XR_TYPE_RENDER_MODEL_SPACE_CREATE_INFO_EXT) && space != nullptr, XR_ERROR_VALIDATION_FAILURE);
  OMNI_FIND(RenderModel, model, info->renderModel);
  auto created = std::make_shared<Space>();
  created->session = owner;
  created->model = state.handles.Share<RenderModel>(info->renderModel);
  *space = AddChild<XrSpace>(state, *owner, std::move(created));
  return XR_SUCCESS;
}

XrResult EnumerateRenderModelSubactionPathsEXT(XrRenderModelEXT model,
                                               const XrInteractionRenderModelSubactionPathInfoEXT*, uint32_t capacity,
                                               uint32_t* count, XrPath* paths) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  OMNI_FIND(RenderModel, found, model);
  Instance& instance = *found->session->instance;
  return TwoCall(IsEnumerated(*found->session, found->id) ? 1 : 0, capacity, count, paths,
                 [&](uint32_t, XrPath& out) { out = InternPath(instance, kHandPaths[found->hand]); });
}

XrResult GetRenderModelPoseTopLevelUserPathEXT(XrRenderModelEXT model,
                                               const XrInteractionRenderModelTopLevelUserPathGetInfoEXT* info,
                                               XrPath* path) {
  State& state = TheState();
  const std::shared_lock lock(state.mutex);
  OMNI_FIND(RenderModel, found, model);
  OMNI_REQUIRE(Is(info, XR_TYPE_INTERACTION_RENDER_MODEL_TOP_LEVEL_USER_PATH_GET_INFO_EXT) && path != nullptr,
               XR_ERROR_VALIDATION_FAILURE);
  *path = XR_NULL_PATH;
  for (uint32_t i = 0; i < info->topLevelUserPathCount; ++i) {
    const bool listed = HandOf(*found->session->instance, info->topLevelUserPaths[i]) == found->hand;
    if (listed && IsEnumerated(*found->session, found->id)) *path = info->topLevelUserPaths[i];
  }
  return XR_SUCCESS;
}

XrResult GetControllerModelKeyMSFT(XrSession session, XrPath user_path, XrControllerModelKeyStateMSFT* out) {
  State& state = TheState();
  const std::shared_lock lock(state.mutex);
  OMNI_FIND(Session, owner, session);
  OMNI_REQUIRE(Is(out, XR_TYPE_CONTROLLER_MODEL_KEY_STATE_MSFT), XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(PathText(*owner->instance, user_path) != nullptr, XR_ERROR_PATH_INVALID);
  const int hand = HandOf(*owner->instance, user_path);
  OMNI_REQUIRE(hand >= 0, XR_ERROR_PATH_UNSUPPORTED);
  const bool there = owner->profile[hand] >= 0;
  out->modelKey = there ? KeyOf(state, hand) : XR_NULL_CONTROLLER_MODEL_KEY_MSFT;
  return XR_SUCCESS;
}

XrResult EnumerateRenderModelPathsFB(XrSession session, uint32_t capacity, uint32_t* count,
                                     XrRenderModelPathInfoFB* paths) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  OMNI_FIND(Session, owner, session);
  return TwoCall(kHands, capacity, count, paths, [owner](uint32_t i, XrRenderModelPathInfoFB& out) {
    out.path = InternPath(*owner->instance, kModelPathsFB[i]);
  });
}

XrResult GetRenderModelPropertiesFB(XrSession session, XrPath path, XrRenderModelPropertiesFB* out) {
  State& state = TheState();
  const std::shared_lock lock(state.mutex);
  OMNI_FIND(Session, owner, session);
  OMNI_REQUIRE(Is(out, XR_TYPE_RENDER_MODEL_PROPERTIES_FB), XR_ERROR_VALIDATION_FAILURE);
  const std::string* const text = PathText(*owner->instance, path);
  for (int hand = 0; text != nullptr && hand < kHands; ++hand) {
    if (*text != kModelPathsFB[hand]) continue;
    const bool there = state.world.devices[hand].present;
    out->vendorId = 7;
    std::snprintf(out->modelName, sizeof(out->modelName), "%s", there ? "controller" : "");
    out->modelKey = there ? KeyOf(state, hand) : 0;
    out->modelVersion = 1;
    out->flags = 1;
    return there ? XR_SUCCESS : XR_RENDER_MODEL_UNAVAILABLE_FB;
  }
  return XR_ERROR_PATH_INVALID;
}

}  // namespace omni::runtime
