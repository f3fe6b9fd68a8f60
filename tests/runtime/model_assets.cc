// XR_EXT_render_model: the controllers' models as files, each a glTF document with one node that moves.

#include <cstdio>
#include <cstring>
#include <mutex>
#include <string>

#include "tests/runtime/entry_points.h"
#include "tests/runtime/state.h"

namespace omni::runtime {
namespace {

constexpr const char* kNode = "trigger";

// A controller of either hand has the same model in every session.
XrUuidEXT IdOf(int hand) {
  XrUuidEXT id{};
  std::memset(id.data, 0x10 + hand, sizeof(id.data));
  return id;
}

std::string Glb() {
  std::string json = R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"name":"trigger"}]})";
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const auto chunk = static_cast<uint32_t>(json.size());
  const uint32_t words[5] = {0x46546C67, 2, 20 + chunk, chunk, 0x4E4F534A};
  return std::string(reinterpret_cast<const char*>(words), sizeof(words)) + json;
}

}  // namespace

XrResult GetRenderModelPropertiesEXT(XrRenderModelEXT model, const XrRenderModelPropertiesGetInfoEXT* info,
                                     XrRenderModelPropertiesEXT* out) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  OMNI_FIND(RenderModel, found, model);
  OMNI_REQUIRE(info == nullptr || Is(info, XR_TYPE_RENDER_MODEL_PROPERTIES_GET_INFO_EXT), XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(Is(out, XR_TYPE_RENDER_MODEL_PROPERTIES_EXT), XR_ERROR_VALIDATION_FAILURE);
  out->cacheId = IdOf(found->hand);
  out->animatableNodeCount = 1;
  found->session->identified[found->hand] = true;
  return XR_SUCCESS;
}

XrResult GetRenderModelStateEXT(XrRenderModelEXT model, const XrRenderModelStateGetInfoEXT* info,
                                XrRenderModelStateEXT* out) {
  State& state = TheState();
  const std::shared_lock lock(state.mutex);
  OMNI_FIND(RenderModel, found, model);
  OMNI_REQUIRE(Is(info, XR_TYPE_RENDER_MODEL_STATE_GET_INFO_EXT) && Is(out, XR_TYPE_RENDER_MODEL_STATE_EXT),
               XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(out->nodeStateCount == 1 && out->nodeStates != nullptr, XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(info->displayTime > 0, XR_ERROR_TIME_INVALID);
  out->nodeStates[0] = {kIdentity, XR_TRUE};
  return XR_SUCCESS;
}

XrResult CreateRenderModelAssetEXT(XrSession session, const XrRenderModelAssetCreateInfoEXT* info,
                                   XrRenderModelAssetEXT* asset) {
  State& state = TheState();
  const std::unique_lock lock(state.mutex);
  OMNI_FIND(Session, owner, session);
  OMNI_REQUIRE(Is(info, XR_TYPE_RENDER_MODEL_ASSET_CREATE_INFO_EXT) && asset != nullptr, XR_ERROR_VALIDATION_FAILURE);
  for (int hand = 0; hand < kHands; ++hand) {
    const XrUuidEXT id = IdOf(hand);
    if (!owner->identified[hand] || std::memcmp(id.data, info->cacheId.data, sizeof(id.data)) != 0) continue;
    auto created = std::make_shared<RenderModelAsset>();
    created->session = owner;
    created->hand = hand;
    *asset = AddChild<XrRenderModelAssetEXT>(state, *owner, std::move(created));
    return XR_SUCCESS;
  }
  return XR_ERROR_RENDER_MODEL_ASSET_UNAVAILABLE_EXT;
}

XrResult DestroyRenderModelAssetEXT(XrRenderModelAssetEXT asset) { return DestroyChild<RenderModelAsset>(asset); }

XrResult GetRenderModelAssetDataEXT(XrRenderModelAssetEXT asset, const XrRenderModelAssetDataGetInfoEXT*,
                                    XrRenderModelAssetDataEXT* out) {
  State& state = TheState();
  const std::shared_lock lock(state.mutex);
  OMNI_FIND(RenderModelAsset, found, asset);
  OMNI_REQUIRE(Is(out, XR_TYPE_RENDER_MODEL_ASSET_DATA_EXT), XR_ERROR_VALIDATION_FAILURE);
  const std::string glb = Glb();
  return TwoCall(static_cast<uint32_t>(glb.size()), out->bufferCapacityInput, &out->bufferCountOutput, out->buffer,
                 [&glb](uint32_t i, uint8_t& byte) { byte = static_cast<uint8_t>(glb[i]); });
}

XrResult GetRenderModelAssetPropertiesEXT(XrRenderModelAssetEXT asset, const XrRenderModelAssetPropertiesGetInfoEXT*,
                                          XrRenderModelAssetPropertiesEXT* out) {
  State& state = TheState();
  const std::shared_lock lock(state.mutex);
  OMNI_FIND(RenderModelAsset, found, asset);
  OMNI_REQUIRE(Is(out, XR_TYPE_RENDER_MODEL_ASSET_PROPERTIES_EXT) && out->nodePropertyCount == 1 &&
                   out->nodeProperties != nullptr,
               XR_ERROR_VALIDATION_FAILURE);
  std::snprintf(out->nodeProperties[0].uniqueName, sizeof(out->nodeProperties[0].uniqueName), "%s", kNode);
  return XR_SUCCESS;
}

}  // namespace omni::runtime
