// Where the next layer has a function it is called first: it validates, and its answer is returned for all but the pen.
#include "layer/src/models/render_models.h"

#include <algorithm>
#include <string>

#include "layer/src/entry/two_call.h"

namespace omni::layer {
namespace {

// Its spaces cannot be located any more.
void Hide(const RenderModel& model) {
  for (const std::weak_ptr<Space>& weak : model.spaces)
    if (const auto space = weak.lock()) space->served_by.store(kServedByNobody, std::memory_order_release);
}

}  // namespace

// The top-level path of the hand that the pen owns; XR_NULL_PATH: none.
XrPath RenderModels::PensHand(const Session& session) const {
  const std::shared_lock lock(session.mutex);
  return session.actions.pen_owns_hand() ? session.actions.hand_path() : XR_NULL_PATH;
}

XrResult RenderModels::IdsBelow(XrSession session, const XrInteractionRenderModelIdsEnumerateInfoEXT* info,
                                std::vector<XrRenderModelIdEXT>& ids) const {
  const auto enumerate = runtime_.next.EnumerateInteractionRenderModelIdsEXT;
  if (!enumerate) return XR_SUCCESS;
  return EnumerateBelow(ids, XrRenderModelIdEXT{0}, [&](auto capacity, auto* count, auto* out) {
    return enumerate(session, info, capacity, count, out);
  });
}

// The hand that the runtime's model belongs to: only a handle of the model can be asked for it.
XrPath RenderModels::HandOf(XrSession session, XrRenderModelIdEXT id, Known& known) const {
  const Dispatch& next = runtime_.next;
  if (!next.CreateRenderModelEXT || !next.GetRenderModelPoseTopLevelUserPathEXT) return XR_NULL_PATH;
  const XrRenderModelCreateInfoEXT create{XR_TYPE_RENDER_MODEL_CREATE_INFO_EXT, nullptr, id, 0, nullptr};
  if (known.probe == XR_NULL_HANDLE && XR_FAILED(next.CreateRenderModelEXT(session, &create, &known.probe)))
    known.probe = XR_NULL_HANDLE;
  if (known.probe == XR_NULL_HANDLE) return XR_NULL_PATH;
  const XrInteractionRenderModelTopLevelUserPathGetInfoEXT info{
      XR_TYPE_INTERACTION_RENDER_MODEL_TOP_LEVEL_USER_PATH_GET_INFO_EXT, nullptr,
      static_cast<std::uint32_t>(runtime_.hand_paths.size()), runtime_.hand_paths.data()};
  XrPath path = XR_NULL_PATH;
  return XR_SUCCEEDED(next.GetRenderModelPoseTopLevelUserPathEXT(known.probe, &info, &path)) ? path : XR_NULL_PATH;
}

// Never one that the runtime has enumerated in this session.
XrRenderModelIdEXT RenderModels::NewId(Models& models) {
  do ++last_id_;
  while (models.seen_below.count(last_id_) != 0);
  models.made.insert(last_id_);
  return last_id_;
}

// "If a render model ID is made inactive, it will never again become active": neither what was made from it.
void RenderModels::Retire(XrSession session, XrRenderModelIdEXT id_below) {
  handles_.ForEach([&](RenderModel& model) {
    if (model.session->handle != session || model.id_below != id_below) return;
    model.retired = true;
    Hide(model);
  });
}

void RenderModels::FollowBelow(XrSession session, const std::vector<XrRenderModelIdEXT>& below, XrPath pens_hand,
                               Models& models) {
  for (auto it = models.below.begin(); it != models.below.end();) {
    const bool gone = std::find(below.begin(), below.end(), it->first) == below.end();
    if (gone && it->second.probe != XR_NULL_HANDLE) runtime_.next.DestroyRenderModelEXT(it->second.probe);
    it = gone ? models.below.erase(it) : std::next(it);
  }
  models.seen_below.insert(below.begin(), below.end());
  for (const XrRenderModelIdEXT id : below) {
    const auto [found, is_new] = models.below.try_emplace(id, Known{id, XR_NULL_HANDLE, false});
    Known& known = found->second;
    if (is_new && models.made.count(id) != 0) known.shown = NewId(models);
    const bool hide = pens_hand != XR_NULL_PATH && HandOf(session, id, known) == pens_hand;
    if (hide == known.hidden) continue;
    known.hidden = hide;
    change_due_ = true;
    if (hide) Retire(session, id);
    if (!hide) known.shown = NewId(models);
  }
}

void RenderModels::FollowPen(XrSession session, bool owns_hand, Models& models) {
  if (owns_hand == (models.pen != XR_NULL_RENDER_MODEL_ID_EXT)) return;
  change_due_ = true;
  if (!owns_hand) Retire(session, XR_NULL_RENDER_MODEL_ID_EXT);
  models.pen = owns_hand ? NewId(models) : XR_NULL_RENDER_MODEL_ID_EXT;
}

void RenderModels::UpdateAfterSync(const std::shared_ptr<Session>& session) {
  if (!runtime_.HasExtension(XR_EXT_INTERACTION_RENDER_MODEL_EXTENSION_NAME)) return;
  const XrPath pens_hand = PensHand(*session);
  const std::lock_guard lock(mutex_);
  Models& models = sessions_[session->handle];
  if (pens_hand == XR_NULL_PATH && !models.followed) return;
  std::vector<XrRenderModelIdEXT> below;
  if (XR_FAILED(IdsBelow(session->handle, nullptr, below))) return;
  models.followed = true;
  FollowBelow(session->handle, below, pens_hand, models);
  FollowPen(session->handle, pens_hand != XR_NULL_PATH, models);
}

void RenderModels::EndOf(XrSession session) {
  const std::lock_guard lock(mutex_);
  handles_.EraseIf([session](const RenderModel& model) { return model.session->handle == session; });
  assets_.EraseIf([session](const RenderModelAsset& asset) { return asset.session->handle == session; });
  sessions_.erase(session);
}

// The runtime's id behind the application's. Empty: it is no longer enumerated.
std::optional<XrRenderModelIdEXT> RenderModels::Translate(XrSession session, XrRenderModelIdEXT id) const {
  const auto models = sessions_.find(session);
  if (models == sessions_.end()) return id;
  for (const auto& [below, known] : models->second.below)
    if (known.shown == id) return known.hidden ? std::nullopt : std::optional(below);
  const bool replaced = models->second.below.count(id) != 0;
  return replaced || models->second.made.count(id) != 0 ? std::nullopt : std::optional(id);
}

XrResult RenderModels::EnumerateInteractionRenderModelIdsEXT(XrSession session,
                                                             const XrInteractionRenderModelIdsEnumerateInfoEXT* info,
                                                             uint32_t capacity, uint32_t* count,
                                                             XrRenderModelIdEXT* ids) {
  link_.SignalAlive();
  const auto record = records_.sessions.Find(session);
  const auto below = runtime_.next.EnumerateInteractionRenderModelIdsEXT;
  if (!below && !record) return XR_ERROR_HANDLE_INVALID;
  if (!below && info && info->type != XR_TYPE_INTERACTION_RENDER_MODEL_IDS_ENUMERATE_INFO_EXT)
    return XR_ERROR_VALIDATION_FAILURE;
  if (!below && !record->running) return XR_ERROR_SESSION_NOT_RUNNING;
  const std::lock_guard lock(mutex_);
  const auto found = sessions_.find(session);
  if (below && (found == sessions_.end() || !found->second.followed)) {
    const XrResult result = below(session, info, capacity, count, ids);
    if (XR_SUCCEEDED(result) && record && capacity > 0)
      sessions_[session].seen_below.insert(ids, ids + std::min(*count, capacity));
    return result;
  }
  std::vector<XrRenderModelIdEXT> shown;
  if (found == sessions_.end()) return Fill(shown.data(), shown.size(), capacity, count, ids);
  std::vector<XrRenderModelIdEXT> all;
  if (const XrResult result = IdsBelow(session, info, all); XR_FAILED(result)) return result;
  const Models& models = found->second;
  for (const XrRenderModelIdEXT id : all) {
    const auto known = models.below.find(id);
    const bool hidden = known != models.below.end() && known->second.hidden;
    if (!hidden) shown.push_back(known == models.below.end() ? id : known->second.shown);
  }
  if (models.pen != XR_NULL_RENDER_MODEL_ID_EXT) shown.push_back(models.pen);
  return Fill(shown.data(), shown.size(), capacity, count, ids);
}

XrResult RenderModels::CreateRenderModelEXT(XrSession session, const XrRenderModelCreateInfoEXT* info,
                                            XrRenderModelEXT* model) {
  link_.SignalAlive();
  const auto record = records_.sessions.Find(session);
  const auto below = runtime_.next.CreateRenderModelEXT;
  const bool readable = info && info->type == XR_TYPE_RENDER_MODEL_CREATE_INFO_EXT && model &&
                        (info->gltfExtensionCount == 0 || info->gltfExtensions);
  if (below && (!record || !readable)) return below(session, info, model);
  if (!record) return XR_ERROR_HANDLE_INVALID;
  if (!readable) return XR_ERROR_VALIDATION_FAILURE;
  const std::lock_guard lock(mutex_);
  const XrRenderModelIdEXT pen = sessions_[session].pen;
  if (pen != XR_NULL_RENDER_MODEL_ID_EXT && info->renderModelId == pen) {
    *model = CreatePen(record);
    return XR_SUCCESS;
  }
  const std::optional<XrRenderModelIdEXT> id = Translate(session, info->renderModelId);
  if (!below || !id) return XR_ERROR_RENDER_MODEL_ID_INVALID_EXT;
  XrRenderModelCreateInfoEXT changed = *info;
  changed.renderModelId = *id;
  const XrResult result = below(session, &changed, model);
  if (XR_FAILED(result)) return result;
  auto made = std::make_shared<RenderModel>();
  made->session = record;
  made->id_below = *id;
  handles_.Insert(*model, std::move(made));
  return result;
}

XrResult RenderModels::DestroyRenderModelEXT(XrRenderModelEXT model) {
  link_.SignalAlive();
  if (const auto pen = FindPen(model)) {
    const std::lock_guard lock(mutex_);
    Hide(*pen);
    handles_.Erase(model);
    return XR_SUCCESS;
  }
  if (!runtime_.next.DestroyRenderModelEXT) return XR_ERROR_HANDLE_INVALID;
  const XrResult result = runtime_.next.DestroyRenderModelEXT(model);
  if (XR_SUCCEEDED(result)) handles_.Erase(model);
  return result;
}

XrResult RenderModels::CreateRenderModelSpaceEXT(XrSession session, const XrRenderModelSpaceCreateInfoEXT* info,
                                                 XrSpace* space) {
  link_.SignalAlive();
  const bool readable = info && info->type == XR_TYPE_RENDER_MODEL_SPACE_CREATE_INFO_EXT && space;
  const auto below = runtime_.next.CreateRenderModelSpaceEXT;
  const auto pen = readable ? FindPen(info->renderModel) : nullptr;
  XrResult result = XR_SUCCESS;
  if (pen) {
    result = pen->session->handle == session ? CreatePenSpace(*pen, space) : XR_ERROR_VALIDATION_FAILURE;
  } else if (below) {
    result = below(session, info, space);
  } else {
    result = !readable && records_.sessions.Contains(session) ? XR_ERROR_VALIDATION_FAILURE : XR_ERROR_HANDLE_INVALID;
  }
  const auto model = XR_SUCCEEDED(result) ? handles_.Find(info->renderModel) : nullptr;
  if (!model) return result;
  auto made = std::make_shared<Space>();
  made->handle = *space;
  made->session = model->session;
  made->focused_only = model->pens();
  const std::lock_guard lock(mutex_);
  if (pen) made->served_by = model->session->actions.tool_pose();
  if (model->retired) made->served_by = kServedByNobody;
  model->spaces.push_back(made);
  records_.spaces.Insert(*space, std::move(made));
  return result;
}

XrResult RenderModels::EnumerateRenderModelSubactionPathsEXT(XrRenderModelEXT model,
                                                             const XrInteractionRenderModelSubactionPathInfoEXT* info,
                                                             uint32_t capacity, uint32_t* count, XrPath* paths) {
  link_.SignalAlive();
  const auto record = handles_.Find(model);
  const auto below = runtime_.next.EnumerateRenderModelSubactionPathsEXT;
  if (!below && (!record || !record->pens())) return XR_ERROR_HANDLE_INVALID;
  const std::lock_guard lock(mutex_);
  if (record && record->retired) return Fill<XrPath>(nullptr, 0, capacity, count, paths);
  if (!record || !record->pens()) return below(model, info, capacity, count, paths);
  if (info && info->type != XR_TYPE_INTERACTION_RENDER_MODEL_SUBACTION_PATH_INFO_EXT)
    return XR_ERROR_VALIDATION_FAILURE;
  const std::shared_lock session_lock(record->session->mutex);
  const XrPath hand = record->session->actions.hand_path();
  return Fill(&hand, record->session->actions.FeedsSubaction() ? 1 : 0, capacity, count, paths);
}

XrResult RenderModels::GetRenderModelPoseTopLevelUserPathEXT(
    XrRenderModelEXT model, const XrInteractionRenderModelTopLevelUserPathGetInfoEXT* info, XrPath* path) {
  link_.SignalAlive();
  const auto record = handles_.Find(model);
  const auto below = runtime_.next.GetRenderModelPoseTopLevelUserPathEXT;
  if (record && record->pens()) {
    if (const XrResult result = CheckUserPaths(info, path); XR_FAILED(result)) return result;
    *path = XR_NULL_PATH;
    const XrPath hand = PensHand(*record->session);
    const XrPath* const end = info->topLevelUserPaths + info->topLevelUserPathCount;
    if (hand != XR_NULL_PATH && std::find(info->topLevelUserPaths, end, hand) != end) *path = hand;
  } else if (!below) {
    return XR_ERROR_HANDLE_INVALID;
  } else if (const XrResult result = below(model, info, path); XR_FAILED(result) || !record) {
    return result;
  }
  const std::lock_guard lock(mutex_);
  if (record->retired) *path = XR_NULL_PATH;
  return XR_SUCCESS;
}

// "May be different from the current interaction profile", but is what the user holds.
XrResult RenderModels::GetControllerModelKeyMSFT(XrSession session, XrPath user_path,
                                                 XrControllerModelKeyStateMSFT* state) {
  const XrResult result = runtime_.next.GetControllerModelKeyMSFT(session, user_path, state);
  link_.SignalAlive();
  const auto record = XR_SUCCEEDED(result) ? records_.sessions.Find(session) : nullptr;
  if (record && user_path == PensHand(*record)) state->modelKey = XR_NULL_CONTROLLER_MODEL_KEY_MSFT;
  return result;
}

bool RenderModels::IsPensModelFB(XrSession session, XrPath path) const {
  const auto record = records_.sessions.Find(session);
  const XrPath hand = record ? PensHand(*record) : XR_NULL_PATH;
  if (hand == XR_NULL_PATH) return false;
  const bool left = hand == runtime_.hand_paths[static_cast<std::size_t>(Hand::kLeft)];
  return runtime_.PathText(path) == (left ? "/model_fb/controller/left" : "/model_fb/controller/right");
}

XrResult RenderModels::EnumerateRenderModelPathsFB(XrSession session, uint32_t capacity, uint32_t* count,
                                                   XrRenderModelPathInfoFB* paths) {
  link_.SignalAlive();
  const auto record = records_.sessions.Find(session);
  if (!record || PensHand(*record) == XR_NULL_PATH)
    return runtime_.next.EnumerateRenderModelPathsFB(session, capacity, count, paths);
  std::vector<XrRenderModelPathInfoFB> all;
  const XrRenderModelPathInfoFB empty{XR_TYPE_RENDER_MODEL_PATH_INFO_FB, nullptr, XR_NULL_PATH};
  const XrResult result = EnumerateBelow(all, empty, [&](auto below_capacity, auto* below_count, auto* out) {
    return runtime_.next.EnumerateRenderModelPathsFB(session, below_capacity, below_count, out);
  });
  if (XR_FAILED(result)) return result;
  std::erase_if(all, [&](const XrRenderModelPathInfoFB& info) { return IsPensModelFB(session, info.path); });
  return FillBy(all.size(), capacity, count, paths, [&](std::size_t i) { paths[i].path = all[i].path; });
}

// A path that the application enumerated before the pen came: "the model for the device is unavailable", and may become
// available later.
XrResult RenderModels::GetRenderModelPropertiesFB(XrSession session, XrPath path,
                                                  XrRenderModelPropertiesFB* properties) {
  const XrResult result = runtime_.next.GetRenderModelPropertiesFB(session, path, properties);
  link_.SignalAlive();
  if (XR_FAILED(result) || !IsPensModelFB(session, path)) return result;
  properties->vendorId = 0;
  properties->modelName[0] = '\0';
  properties->modelKey = 0;  // XR_NULL_RENDER_MODEL_KEY_FB
  properties->modelVersion = 0;
  properties->flags = 0;
  return XR_RENDER_MODEL_UNAVAILABLE_FB;
}

}  // namespace omni::layer
