// The fuzzed calls about render models: ids, models, their spaces, their files.
#include <cmath>
#include <cstring>

#include "tests/layer/fuzz/pick.h"
#include "tests/layer/fuzz/sequence.h"

namespace omni::test {
namespace {

constexpr std::uint32_t kMostModels = 4;  // that a sequence has at a time
constexpr std::uint32_t kModelRoom = 4;   // for ids, paths and nodes
constexpr std::uint8_t kModelUntouched = 0xA7;

}  // namespace

void Sequence::ModelIds() {
  XrRenderModelIdEXT ids[kModelRoom] = {};
  std::uint32_t count = 0;
  const XrInteractionRenderModelIdsEnumerateInfoEXT info{XR_TYPE_INTERACTION_RENDER_MODEL_IDS_ENUMERATE_INFO_EXT,
                                                         Chain()};
  const XrResult result = own_.EnumerateInteractionRenderModelIdsEXT(
      MainSession(), random_.Percent(50) ? &info : nullptr, random_.Percent(80) ? kModelRoom : random_.Below(3),
      OrNull(&count), OrNull(&ids[0]));
  Say("model ids", result, " " + std::to_string(count));
  Expect("model ids", result,
         {XR_ERROR_VALIDATION_FAILURE, XR_ERROR_HANDLE_INVALID, XR_ERROR_SIZE_INSUFFICIENT,
          XR_ERROR_SESSION_NOT_RUNNING, XR_ERROR_SESSION_LOST, XR_ERROR_INSTANCE_LOST});
  if (result != XR_SUCCESS) return;
  for (const XrRenderModelIdEXT id : ids)
    if (id != XR_NULL_RENDER_MODEL_ID_EXT) model_ids_.push_back(id);
}

void Sequence::MakeModel() {
  if (models_.live.size() >= kMostModels) return;
  if (model_ids_.empty()) ModelIds();
  const XrRenderModelIdEXT id =
      model_ids_.empty() || random_.Percent(10) ? XrRenderModelIdEXT{random_.Below(40)} : model_ids_.back();
  const char* const names[] = {"KHR_texture_basisu"};
  const XrRenderModelCreateInfoEXT info{Type(XR_TYPE_RENDER_MODEL_CREATE_INFO_EXT), Chain(), id, 1, names};
  const XrSession session = MainSession();
  XrRenderModelEXT model = XR_NULL_HANDLE;
  const XrResult result = own_.CreateRenderModelEXT(session, OrNull(&info), OrNull(&model));
  Say("make model", result);
  Expect("make model", result,
         {XR_ERROR_VALIDATION_FAILURE, XR_ERROR_HANDLE_INVALID, XR_ERROR_RENDER_MODEL_ID_INVALID_EXT,
          XR_ERROR_SESSION_LOST, XR_ERROR_INSTANCE_LOST});
  if (XR_SUCCEEDED(result)) Keep(models_, model, session);
}

void Sequence::DropModel() { Drop(models_, own_.DestroyRenderModelEXT, "drop model"); }

void Sequence::ModelProperties() {
  if (Lacks(models_)) return;
  XrRenderModelPropertiesEXT properties{Type(XR_TYPE_RENDER_MODEL_PROPERTIES_EXT), nullptr, {}, 99};
  const XrResult result = own_.GetRenderModelPropertiesEXT(Pick(models_), nullptr, OrNull(&properties));
  Say("model properties", result, " " + std::to_string(properties.animatableNodeCount));
  Expect("model properties", result,
         {XR_ERROR_VALIDATION_FAILURE, XR_ERROR_HANDLE_INVALID, XR_ERROR_INSTANCE_LOST, XR_ERROR_SESSION_LOST});
  if (XR_SUCCEEDED(result)) cache_ids_.push_back(properties.cacheId);
}

void Sequence::ModelState() {
  if (Lacks(models_)) return;
  XrRenderModelNodeStateEXT nodes[kModelRoom] = {};
  const XrRenderModelStateGetInfoEXT info{Type(XR_TYPE_RENDER_MODEL_STATE_GET_INFO_EXT), Chain(), AnyTime()};
  XrRenderModelStateEXT state{Type(XR_TYPE_RENDER_MODEL_STATE_EXT), nullptr, 1 + random_.Below(2), OrNull(&nodes[0])};
  const XrResult result = own_.GetRenderModelStateEXT(Pick(models_), OrNull(&info), OrNull(&state));
  Say("model state", result);
  Expect("model state", result,
         {XR_ERROR_VALIDATION_FAILURE, XR_ERROR_HANDLE_INVALID, XR_ERROR_TIME_INVALID, XR_ERROR_INSTANCE_LOST,
          XR_ERROR_SESSION_LOST});
  for (std::uint32_t i = 0; result == XR_SUCCESS && i < state.nodeStateCount; ++i)
    CheckPlace(XR_SPACE_LOCATION_ORIENTATION_VALID_BIT | XR_SPACE_LOCATION_POSITION_VALID_BIT, nodes[i].nodePose);
}

void Sequence::ModelSpace() {
  if (Lacks(models_)) return;
  const XrRenderModelEXT model = Pick(models_);
  const auto owner = session_of_.find(model);
  const XrSession session = owner == session_of_.end() || random_.Percent(10) ? MainSession() : owner->second;
  const XrRenderModelSpaceCreateInfoEXT info{Type(XR_TYPE_RENDER_MODEL_SPACE_CREATE_INFO_EXT), Chain(), model};
  XrSpace space = XR_NULL_HANDLE;
  const XrResult result = own_.CreateRenderModelSpaceEXT(session, OrNull(&info), OrNull(&space));
  Say("model space", result);
  Expect("model space", result,
         {XR_ERROR_VALIDATION_FAILURE, XR_ERROR_HANDLE_INVALID, XR_ERROR_INSTANCE_LOST, XR_ERROR_SESSION_LOST});
  if (XR_SUCCEEDED(result)) Keep(spaces_, space, session);
}

void Sequence::ModelPaths() {
  if (Lacks(models_)) return;
  XrPath paths[kModelRoom] = {};
  std::uint32_t count = 0;
  const XrRenderModelEXT model = Pick(models_);
  XrResult result = own_.EnumerateRenderModelSubactionPathsEXT(
      model, nullptr, random_.Percent(70) ? kModelRoom : random_.Below(2), OrNull(&count), OrNull(&paths[0]));
  Say("model subaction paths", result, " " + std::to_string(count));
  const XrPath asked[] = {Interned("/user/hand/left"), HandPath()};
  const XrInteractionRenderModelTopLevelUserPathGetInfoEXT info{
      Type(XR_TYPE_INTERACTION_RENDER_MODEL_TOP_LEVEL_USER_PATH_GET_INFO_EXT), Chain(), 1 + random_.Below(2), asked};
  XrPath path = XR_NULL_PATH;
  result = own_.GetRenderModelPoseTopLevelUserPathEXT(model, OrNull(&info), OrNull(&path));
  Say("model user path", result, " " + Text(path));
  Expect("model user path", result,
         {XR_ERROR_VALIDATION_FAILURE, XR_ERROR_HANDLE_INVALID, XR_ERROR_PATH_INVALID, XR_ERROR_PATH_UNSUPPORTED,
          XR_ERROR_INSTANCE_LOST, XR_ERROR_SESSION_LOST});
}

void Sequence::MakeAsset() {
  if (cache_ids_.empty()) ModelProperties();
  XrUuidEXT id{};
  if (!cache_ids_.empty()) id = cache_ids_.back();
  if (random_.Percent(10)) id.data[random_.Below(16)] ^= 1;
  const XrRenderModelAssetCreateInfoEXT info{Type(XR_TYPE_RENDER_MODEL_ASSET_CREATE_INFO_EXT), Chain(), id};
  const XrSession session = MainSession();
  XrRenderModelAssetEXT asset = XR_NULL_HANDLE;
  const XrResult result = own_.CreateRenderModelAssetEXT(session, OrNull(&info), OrNull(&asset));
  Say("make asset", result);
  Expect("make asset", result,
         {XR_ERROR_VALIDATION_FAILURE, XR_ERROR_HANDLE_INVALID, XR_ERROR_RENDER_MODEL_ASSET_UNAVAILABLE_EXT,
          XR_ERROR_INSTANCE_LOST, XR_ERROR_SESSION_LOST});
  if (XR_SUCCEEDED(result)) Keep(assets_, asset, session);
}

void Sequence::DropAsset() { Drop(assets_, own_.DestroyRenderModelAssetEXT, "drop asset"); }

// Nothing is written behind the capacity.
void Sequence::AssetData() {
  if (Lacks(assets_)) return;
  std::vector<std::uint8_t> bytes(60'000, kModelUntouched);
  const std::uint32_t capacity = random_.Percent(50) ? 50'000 : random_.Below(300);
  XrRenderModelAssetDataEXT data{Type(XR_TYPE_RENDER_MODEL_ASSET_DATA_EXT), nullptr, capacity, 0, OrNull(bytes.data())};
  const XrResult result = own_.GetRenderModelAssetDataEXT(Pick(assets_), nullptr, OrNull(&data));
  Say("asset data", result, " " + std::to_string(data.bufferCountOutput));
  Expect("asset data", result,
         {XR_ERROR_VALIDATION_FAILURE, XR_ERROR_HANDLE_INVALID, XR_ERROR_SIZE_INSUFFICIENT, XR_ERROR_INSTANCE_LOST,
          XR_ERROR_SESSION_LOST});
  if (bytes[capacity] != kModelUntouched) Violation("asset data beyond the capacity");
}

void Sequence::AssetNodes() {
  if (Lacks(assets_)) return;
  XrRenderModelAssetNodePropertiesEXT nodes[kModelRoom] = {};
  XrRenderModelAssetPropertiesEXT properties{Type(XR_TYPE_RENDER_MODEL_ASSET_PROPERTIES_EXT), nullptr,
                                             1 + random_.Below(2), OrNull(&nodes[0])};
  const XrResult result = own_.GetRenderModelAssetPropertiesEXT(Pick(assets_), nullptr, OrNull(&properties));
  Say("asset nodes", result, std::string(" ") + nodes[0].uniqueName);
  Expect("asset nodes", result,
         {XR_ERROR_VALIDATION_FAILURE, XR_ERROR_HANDLE_INVALID, XR_ERROR_INSTANCE_LOST, XR_ERROR_SESSION_LOST});
}

}  // namespace omni::test
