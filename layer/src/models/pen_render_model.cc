// The pen's own model: its handles, its file, and the state of its parts.
#include <algorithm>
#include <cstdio>
#include <cstring>
#include <string_view>

#include "layer/src/entry/two_call.h"
#include "layer/src/models/pen_model.h"
#include "layer/src/models/render_models.h"

namespace omni::layer {
namespace {

bool IsPens(const XrUuidEXT& id) { return std::memcmp(id.data, EmbeddedPenModel().id.data, sizeof(id.data)) == 0; }

// The optional structures of later extensions.
template <class Info>
bool Readable(const Info* info, XrStructureType type) {
  return !info || info->type == type;
}

// "/user/hand/left", without a component.
bool IsTopLevel(std::string_view path) {
  return path.starts_with("/user/") && path.find("/input") == std::string_view::npos &&
         path.find("/output") == std::string_view::npos;
}

}  // namespace

XrRenderModelNodeStateEXT StateOf(const PenPart& part, const protocol::InputSnapshot& inputs) noexcept {
  float pressed = 0;
  for (const protocol::InputIndex input : part.inputs)
    pressed = std::max(pressed, inputs.components[static_cast<std::size_t>(input)].value);
  // A NaN leaves `pressed` as it is.
  pressed = std::min(pressed, 1.0f);
  const XrVector3f& t = part.travel_m;
  return {{{0, 0, 0, 1}, {pressed * t.x, pressed * t.y, pressed * t.z}}, XR_TRUE};
}

std::shared_ptr<RenderModel> RenderModels::FindPen(XrRenderModelEXT model) const {
  auto found = handles_.Find(model);
  return found && found->pens() ? found : nullptr;
}

// No runtime in this process can have a handle that is the address of a live record of ours.
XrRenderModelEXT RenderModels::CreatePen(const std::shared_ptr<Session>& session) {
  auto made = std::make_shared<RenderModel>();
  made->session = session;
  const auto handle = reinterpret_cast<XrRenderModelEXT>(made.get());
  handles_.Insert(handle, std::move(made));
  return handle;
}

// A real space of the runtime, as all of the pen's are, so that its handle is valid everywhere.
XrResult RenderModels::CreatePenSpace(const RenderModel& model, XrSpace* space) const {
  const XrReferenceSpaceCreateInfo info{
      XR_TYPE_REFERENCE_SPACE_CREATE_INFO, nullptr, model.session->PreferredAnchor(), {{0, 0, 0, 1}, {0, 0, 0}}};
  return runtime_.next.CreateReferenceSpace(model.session->handle, &info, space);
}

XrResult RenderModels::CheckUserPaths(const XrInteractionRenderModelTopLevelUserPathGetInfoEXT* info,
                                      const XrPath* path) const {
  if (!info || info->type != XR_TYPE_INTERACTION_RENDER_MODEL_TOP_LEVEL_USER_PATH_GET_INFO_EXT || !path ||
      (info->topLevelUserPathCount > 0 && !info->topLevelUserPaths))
    return XR_ERROR_VALIDATION_FAILURE;
  std::vector<XrPath> paths(info->topLevelUserPaths, info->topLevelUserPaths + info->topLevelUserPathCount);
  const bool all_valid =
      std::all_of(paths.begin(), paths.end(), [this](XrPath one) { return IsTopLevel(runtime_.PathText(one)); });
  if (!all_valid) return XR_ERROR_PATH_INVALID;
  std::sort(paths.begin(), paths.end());
  return std::adjacent_find(paths.begin(), paths.end()) == paths.end() ? XR_SUCCESS : XR_ERROR_VALIDATION_FAILURE;
}

XrResult RenderModels::GetRenderModelPropertiesEXT(XrRenderModelEXT model,
                                                   const XrRenderModelPropertiesGetInfoEXT* info,
                                                   XrRenderModelPropertiesEXT* properties) {
  link_.SignalAlive();
  const auto below = runtime_.next.GetRenderModelPropertiesEXT;
  const auto pen = FindPen(model);
  if (!pen) return below ? below(model, info, properties) : XR_ERROR_HANDLE_INVALID;
  if (!Readable(info, XR_TYPE_RENDER_MODEL_PROPERTIES_GET_INFO_EXT) || !properties ||
      properties->type != XR_TYPE_RENDER_MODEL_PROPERTIES_EXT)
    return XR_ERROR_VALIDATION_FAILURE;
  properties->cacheId = EmbeddedPenModel().id;
  properties->animatableNodeCount = static_cast<std::uint32_t>(kPenParts.size());
  const std::lock_guard lock(mutex_);
  sessions_[pen->session->handle].pen_identified = true;
  return XR_SUCCESS;
}

XrResult RenderModels::GetRenderModelStateEXT(XrRenderModelEXT model, const XrRenderModelStateGetInfoEXT* info,
                                              XrRenderModelStateEXT* state) {
  link_.SignalAlive();
  const auto below = runtime_.next.GetRenderModelStateEXT;
  if (!FindPen(model)) return below ? below(model, info, state) : XR_ERROR_HANDLE_INVALID;
  if (!info || info->type != XR_TYPE_RENDER_MODEL_STATE_GET_INFO_EXT || !state ||
      state->type != XR_TYPE_RENDER_MODEL_STATE_EXT || state->nodeStateCount != kPenParts.size() || !state->nodeStates)
    return XR_ERROR_VALIDATION_FAILURE;
  if (!(info->displayTime > 0)) return XR_ERROR_TIME_INVALID;
  protocol::InputSnapshot inputs;
  if (const auto reader = link_.reader(); reader && !reader->ReadInputs(inputs)) inputs = {};
  std::transform(kPenParts.begin(), kPenParts.end(), state->nodeStates,
                 [&](const PenPart& part) { return StateOf(part, inputs); });
  return XR_SUCCESS;
}

// Only an id that this session has returned is good.
XrResult RenderModels::CreateRenderModelAssetEXT(XrSession session, const XrRenderModelAssetCreateInfoEXT* info,
                                                 XrRenderModelAssetEXT* asset) {
  link_.SignalAlive();
  const auto record = records_.sessions.Find(session);
  const auto below = runtime_.next.CreateRenderModelAssetEXT;
  const bool readable = info && info->type == XR_TYPE_RENDER_MODEL_ASSET_CREATE_INFO_EXT && asset;
  if (below && (!record || !readable || !IsPens(info->cacheId))) return below(session, info, asset);
  if (!record) return XR_ERROR_HANDLE_INVALID;
  if (!readable) return XR_ERROR_VALIDATION_FAILURE;
  const std::lock_guard lock(mutex_);
  const bool known = IsPens(info->cacheId) && sessions_[session].pen_identified;
  if (!known) return XR_ERROR_RENDER_MODEL_ASSET_UNAVAILABLE_EXT;
  auto made = std::make_shared<RenderModelAsset>();
  made->session = record;
  *asset = reinterpret_cast<XrRenderModelAssetEXT>(made.get());
  assets_.Insert(*asset, std::move(made));
  return XR_SUCCESS;
}

XrResult RenderModels::DestroyRenderModelAssetEXT(XrRenderModelAssetEXT asset) {
  link_.SignalAlive();
  const auto below = runtime_.next.DestroyRenderModelAssetEXT;
  if (!assets_.Contains(asset)) return below ? below(asset) : XR_ERROR_HANDLE_INVALID;
  assets_.Erase(asset);
  return XR_SUCCESS;
}

XrResult RenderModels::GetRenderModelAssetDataEXT(XrRenderModelAssetEXT asset,
                                                  const XrRenderModelAssetDataGetInfoEXT* info,
                                                  XrRenderModelAssetDataEXT* data) {
  link_.SignalAlive();
  const auto below = runtime_.next.GetRenderModelAssetDataEXT;
  if (!assets_.Contains(asset)) return below ? below(asset, info, data) : XR_ERROR_HANDLE_INVALID;
  if (!Readable(info, XR_TYPE_RENDER_MODEL_ASSET_DATA_GET_INFO_EXT) || !data ||
      data->type != XR_TYPE_RENDER_MODEL_ASSET_DATA_EXT)
    return XR_ERROR_VALIDATION_FAILURE;
  const auto bytes = EmbeddedPenModel().bytes;
  return Fill(bytes.data(), bytes.size(), data->bufferCapacityInput, &data->bufferCountOutput, data->buffer);
}

XrResult RenderModels::GetRenderModelAssetPropertiesEXT(XrRenderModelAssetEXT asset,
                                                        const XrRenderModelAssetPropertiesGetInfoEXT* info,
                                                        XrRenderModelAssetPropertiesEXT* properties) {
  link_.SignalAlive();
  const auto below = runtime_.next.GetRenderModelAssetPropertiesEXT;
  if (!assets_.Contains(asset)) return below ? below(asset, info, properties) : XR_ERROR_HANDLE_INVALID;
  if (!Readable(info, XR_TYPE_RENDER_MODEL_ASSET_PROPERTIES_GET_INFO_EXT) || !properties ||
      properties->type != XR_TYPE_RENDER_MODEL_ASSET_PROPERTIES_EXT ||
      properties->nodePropertyCount != kPenParts.size() || !properties->nodeProperties)
    return XR_ERROR_VALIDATION_FAILURE;
  for (std::size_t i = 0; i < kPenParts.size(); ++i)
    std::snprintf(properties->nodeProperties[i].uniqueName, XR_MAX_RENDER_MODEL_ASSET_NODE_NAME_SIZE_EXT, "%s",
                  kPenParts[i].node);
  return XR_SUCCESS;
}

}  // namespace omni::layer
