// The next layer is called first: it validates, and its answer is returned for all but the pen's hand.
#include "layer/src/models/render_models.h"

#include <algorithm>
#include <string>

#include "layer/src/entry/two_call.h"
#include "layer/src/instance/instance.h"

namespace omni::layer {

// The top-level path of the hand that the pen owns; XR_NULL_PATH: none.
XrPath RenderModels::PensHand(const Session& session) const {
  const std::shared_lock lock(session.mutex);
  return session.actions.pen_owns_hand() ? session.actions.hand_path() : XR_NULL_PATH;
}

XrResult RenderModels::IdsBelow(XrSession session, const XrInteractionRenderModelIdsEnumerateInfoEXT* info,
                                std::vector<XrRenderModelIdEXT>& ids) const {
  return EnumerateBelow(ids, XrRenderModelIdEXT{0}, [&](auto capacity, auto* count, auto* out) {
    return instance_.next.EnumerateInteractionRenderModelIdsEXT(session, info, capacity, count, out);
  });
}

// The hand that the runtime's model belongs to: only a handle of the model can be asked for it.
XrPath RenderModels::HandOf(XrSession session, XrRenderModelIdEXT id, Known& known) const {
  const Dispatch& next = instance_.next;
  if (!next.CreateRenderModelEXT || !next.GetRenderModelPoseTopLevelUserPathEXT) return XR_NULL_PATH;
  const XrRenderModelCreateInfoEXT create{XR_TYPE_RENDER_MODEL_CREATE_INFO_EXT, nullptr, id, 0, nullptr};
  if (known.probe == XR_NULL_HANDLE && XR_FAILED(next.CreateRenderModelEXT(session, &create, &known.probe)))
    known.probe = XR_NULL_HANDLE;
  if (known.probe == XR_NULL_HANDLE) return XR_NULL_PATH;
  const XrInteractionRenderModelTopLevelUserPathGetInfoEXT info{
      XR_TYPE_INTERACTION_RENDER_MODEL_TOP_LEVEL_USER_PATH_GET_INFO_EXT, nullptr,
      static_cast<std::uint32_t>(instance_.hand_paths.size()), instance_.hand_paths.data()};
  XrPath path = XR_NULL_PATH;
  return XR_SUCCEEDED(next.GetRenderModelPoseTopLevelUserPathEXT(known.probe, &info, &path)) ? path : XR_NULL_PATH;
}

XrRenderModelIdEXT RenderModels::NewId() { return ++last_id_; }

// "If a render model ID is made inactive, it will never again become active": neither what was made from it.
void RenderModels::Retire(XrSession session, XrRenderModelIdEXT id) {
  instance_.render_model_handles.ForEach([&](RenderModel& model) {
    if (model.session->handle != session || model.id_below != id) return;
    model.retired = true;
    for (const std::weak_ptr<Space>& weak : model.spaces)
      if (const auto space = weak.lock()) space->served_by.store(kServedByNobody, std::memory_order_release);
  });
}

void RenderModels::Follow(const std::shared_ptr<Session>& session) {
  if (!instance_.next.EnumerateInteractionRenderModelIdsEXT ||
      !instance_.Enabled(XR_EXT_INTERACTION_RENDER_MODEL_EXTENSION_NAME))
    return;
  const XrPath pens_hand = PensHand(*session);
  const std::lock_guard lock(mutex_);
  if (pens_hand == XR_NULL_PATH && ids_.count(session->handle) == 0) return;  // the pen was never here
  std::vector<XrRenderModelIdEXT> below;
  if (XR_FAILED(IdsBelow(session->handle, nullptr, below))) return;
  Ids& ids = ids_[session->handle];
  for (auto it = ids.begin(); it != ids.end();) {
    const bool gone = std::find(below.begin(), below.end(), it->first) == below.end();
    if (gone && it->second.probe != XR_NULL_HANDLE) instance_.next.DestroyRenderModelEXT(it->second.probe);
    it = gone ? ids.erase(it) : std::next(it);
  }
  for (const XrRenderModelIdEXT id : below) {
    Known& known = ids.try_emplace(id, Known{id, XR_NULL_HANDLE, false}).first->second;
    const bool hide = pens_hand != XR_NULL_PATH && HandOf(session->handle, id, known) == pens_hand;
    if (hide == known.hidden) continue;
    known.hidden = hide;
    change_due_ = true;
    if (hide) Retire(session->handle, id);
    if (!hide) known.shown = NewId();
  }
}

void RenderModels::EndOf(XrSession session) {
  const std::lock_guard lock(mutex_);
  instance_.render_model_handles.EraseIf(
      [session](const RenderModel& model) { return model.session->handle == session; });
  ids_.erase(session);
}

// The runtime's id behind the application's. Empty: it is no longer enumerated.
std::optional<XrRenderModelIdEXT> RenderModels::Translate(XrSession session, XrRenderModelIdEXT id) const {
  const auto ids = ids_.find(session);
  if (ids == ids_.end()) return id;
  for (const auto& [below, known] : ids->second)
    if (known.shown == id) return known.hidden ? std::nullopt : std::optional(below);
  const bool replaced = ids->second.count(id) != 0;
  const bool of_ours = id > XrRenderModelIdEXT{0x4F4D'4E49'0000'0000} && id <= last_id_;
  return replaced || of_ours ? std::nullopt : std::optional(id);
}

XrResult RenderModels::EnumerateInteractionRenderModelIdsEXT(XrSession session,
                                                             const XrInteractionRenderModelIdsEnumerateInfoEXT* info,
                                                             uint32_t capacity, uint32_t* count,
                                                             XrRenderModelIdEXT* ids) {
  instance_.link.Beat();
  const std::lock_guard lock(mutex_);
  const auto known = ids_.find(session);
  if (known == ids_.end())
    return instance_.next.EnumerateInteractionRenderModelIdsEXT(session, info, capacity, count, ids);
  std::vector<XrRenderModelIdEXT> all;
  if (const XrResult result = IdsBelow(session, info, all); XR_FAILED(result)) return result;
  std::vector<XrRenderModelIdEXT> shown;
  for (const XrRenderModelIdEXT id : all) {
    const auto found = known->second.find(id);
    const bool hidden = found != known->second.end() && found->second.hidden;
    if (!hidden) shown.push_back(found == known->second.end() ? id : found->second.shown);
  }
  return Fill(shown.data(), shown.size(), capacity, count, ids);
}

XrResult RenderModels::CreateRenderModelEXT(XrSession session, const XrRenderModelCreateInfoEXT* info,
                                            XrRenderModelEXT* model) {
  instance_.link.Beat();
  const auto record = instance_.sessions.Find(session);
  if (!record || !info || info->type != XR_TYPE_RENDER_MODEL_CREATE_INFO_EXT)
    return instance_.next.CreateRenderModelEXT(session, info, model);
  const std::lock_guard lock(mutex_);
  const std::optional<XrRenderModelIdEXT> below = Translate(session, info->renderModelId);
  if (!below) return XR_ERROR_RENDER_MODEL_ID_INVALID_EXT;
  XrRenderModelCreateInfoEXT changed = *info;
  changed.renderModelId = *below;
  const XrResult result = instance_.next.CreateRenderModelEXT(session, &changed, model);
  if (XR_FAILED(result)) return result;
  auto made = std::make_shared<RenderModel>();
  made->session = record;
  made->id_below = *below;
  instance_.render_model_handles.Insert(*model, std::move(made));
  return result;
}

XrResult RenderModels::DestroyRenderModelEXT(XrRenderModelEXT model) {
  const XrResult result = instance_.next.DestroyRenderModelEXT(model);
  instance_.link.Beat();
  if (XR_SUCCEEDED(result)) instance_.render_model_handles.Erase(model);
  return result;
}

XrResult RenderModels::CreateRenderModelSpaceEXT(XrSession session, const XrRenderModelSpaceCreateInfoEXT* info,
                                                 XrSpace* space) {
  const XrResult result = instance_.next.CreateRenderModelSpaceEXT(session, info, space);
  instance_.link.Beat();
  const auto model = XR_SUCCEEDED(result) ? instance_.render_model_handles.Find(info->renderModel) : nullptr;
  if (!model) return result;
  auto made = std::make_shared<Space>();
  made->handle = *space;
  made->session = model->session;
  const std::lock_guard lock(mutex_);
  if (model->retired) made->served_by = kServedByNobody;
  model->spaces.push_back(made);
  instance_.spaces.Insert(*space, std::move(made));
  return result;
}

XrResult RenderModels::EnumerateRenderModelSubactionPathsEXT(XrRenderModelEXT model,
                                                             const XrInteractionRenderModelSubactionPathInfoEXT* info,
                                                             uint32_t capacity, uint32_t* count, XrPath* paths) {
  instance_.link.Beat();
  const auto record = instance_.render_model_handles.Find(model);
  const std::lock_guard lock(mutex_);
  if (record && record->retired) return Fill<XrPath>(nullptr, 0, capacity, count, paths);
  return instance_.next.EnumerateRenderModelSubactionPathsEXT(model, info, capacity, count, paths);
}

XrResult RenderModels::GetRenderModelPoseTopLevelUserPathEXT(
    XrRenderModelEXT model, const XrInteractionRenderModelTopLevelUserPathGetInfoEXT* info, XrPath* path) {
  const XrResult result = instance_.next.GetRenderModelPoseTopLevelUserPathEXT(model, info, path);
  instance_.link.Beat();
  const auto record = XR_SUCCEEDED(result) ? instance_.render_model_handles.Find(model) : nullptr;
  if (!record) return result;
  const std::lock_guard lock(mutex_);
  if (record->retired) *path = XR_NULL_PATH;
  return result;
}

// "May be different from the current interaction profile", but is what the user holds.
XrResult RenderModels::GetControllerModelKeyMSFT(XrSession session, XrPath user_path,
                                                 XrControllerModelKeyStateMSFT* state) {
  const XrResult result = instance_.next.GetControllerModelKeyMSFT(session, user_path, state);
  instance_.link.Beat();
  const auto record = XR_SUCCEEDED(result) ? instance_.sessions.Find(session) : nullptr;
  if (record && user_path == PensHand(*record)) state->modelKey = XR_NULL_CONTROLLER_MODEL_KEY_MSFT;
  return result;
}

bool RenderModels::IsPensModelFB(XrSession session, XrPath path) const {
  const auto record = instance_.sessions.Find(session);
  const XrPath hand = record ? PensHand(*record) : XR_NULL_PATH;
  if (hand == XR_NULL_PATH) return false;
  const bool left = hand == instance_.hand_paths[static_cast<std::size_t>(Hand::kLeft)];
  return instance_.PathText(path) == (left ? "/model_fb/controller/left" : "/model_fb/controller/right");
}

XrResult RenderModels::EnumerateRenderModelPathsFB(XrSession session, uint32_t capacity, uint32_t* count,
                                                   XrRenderModelPathInfoFB* paths) {
  instance_.link.Beat();
  const auto record = instance_.sessions.Find(session);
  if (!record || PensHand(*record) == XR_NULL_PATH)
    return instance_.next.EnumerateRenderModelPathsFB(session, capacity, count, paths);
  std::vector<XrRenderModelPathInfoFB> all;
  const XrRenderModelPathInfoFB empty{XR_TYPE_RENDER_MODEL_PATH_INFO_FB, nullptr, XR_NULL_PATH};
  const XrResult result = EnumerateBelow(all, empty, [&](auto below_capacity, auto* below_count, auto* out) {
    return instance_.next.EnumerateRenderModelPathsFB(session, below_capacity, below_count, out);
  });
  if (XR_FAILED(result)) return result;
  std::erase_if(all, [&](const XrRenderModelPathInfoFB& info) { return IsPensModelFB(session, info.path); });
  return FillBy(all.size(), capacity, count, paths, [&](std::size_t i) { paths[i].path = all[i].path; });
}

// A path that the application enumerated before the pen came: "the model for the device is unavailable", and may become
// available later.
XrResult RenderModels::GetRenderModelPropertiesFB(XrSession session, XrPath path,
                                                  XrRenderModelPropertiesFB* properties) {
  const XrResult result = instance_.next.GetRenderModelPropertiesFB(session, path, properties);
  instance_.link.Beat();
  if (XR_FAILED(result) || !IsPensModelFB(session, path)) return result;
  properties->vendorId = 0;
  properties->modelName[0] = '\0';
  properties->modelKey = 0;  // XR_NULL_RENDER_MODEL_KEY_FB
  properties->modelVersion = 0;
  properties->flags = 0;
  return XR_RENDER_MODEL_UNAVAILABLE_FB;
}

}  // namespace omni::layer
