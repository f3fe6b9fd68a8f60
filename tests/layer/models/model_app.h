// An application that draws what the user holds, with all extensions for that.
#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <string>
#include <vector>

#include "layer/src/models/pen_model.h"
#include "tests/layer/support/app.h"

namespace omni::test {

inline constexpr const char* kModelExtensions[] = {
    XR_EXT_UUID_EXTENSION_NAME, XR_EXT_RENDER_MODEL_EXTENSION_NAME, XR_EXT_INTERACTION_RENDER_MODEL_EXTENSION_NAME,
    XR_MSFT_CONTROLLER_MODEL_EXTENSION_NAME, XR_FB_RENDER_MODEL_EXTENSION_NAME};

struct ModelApp {
  static AppOptions Options() {
    AppOptions options;
    options.extensions.assign(std::begin(kModelExtensions), std::end(kModelExtensions));
    options.profiles = {kTouch, kSimple};
    return options;
  }
#define OMNI_FUNCTION(member, name) PFN_xr##name member = FunctionOf<PFN_xr##name>(app.instance, "xr" #name)
  App app{Options()};
  OMNI_FUNCTION(enumerate, EnumerateInteractionRenderModelIdsEXT);
  OMNI_FUNCTION(create, CreateRenderModelEXT);
  OMNI_FUNCTION(destroy, DestroyRenderModelEXT);
  OMNI_FUNCTION(create_space, CreateRenderModelSpaceEXT);
  OMNI_FUNCTION(properties, GetRenderModelPropertiesEXT);
  OMNI_FUNCTION(state, GetRenderModelStateEXT);
  OMNI_FUNCTION(create_asset, CreateRenderModelAssetEXT);
  OMNI_FUNCTION(destroy_asset, DestroyRenderModelAssetEXT);
  OMNI_FUNCTION(asset_data, GetRenderModelAssetDataEXT);
  OMNI_FUNCTION(asset_properties, GetRenderModelAssetPropertiesEXT);
  OMNI_FUNCTION(subactions, EnumerateRenderModelSubactionPathsEXT);
  OMNI_FUNCTION(user_path, GetRenderModelPoseTopLevelUserPathEXT);
  OMNI_FUNCTION(key, GetControllerModelKeyMSFT);
  OMNI_FUNCTION(paths_fb, EnumerateRenderModelPathsFB);
  OMNI_FUNCTION(properties_fb, GetRenderModelPropertiesFB);
#undef OMNI_FUNCTION
  XrSpace local = app.ReferenceSpace(XR_REFERENCE_SPACE_TYPE_LOCAL);

  std::vector<XrRenderModelIdEXT> Ids() const {
    std::uint32_t count = 0;
    EXPECT_EQ(enumerate(app.session, nullptr, 0, &count, nullptr), XR_SUCCESS);
    std::vector<XrRenderModelIdEXT> ids(count);
    if (count > 0) {
      EXPECT_EQ(enumerate(app.session, nullptr, count, &count, ids.data()), XR_SUCCESS);
    }
    return ids;
  }
  XrRenderModelEXT Make(XrRenderModelIdEXT id, XrResult wanted = XR_SUCCESS) const {
    const XrRenderModelCreateInfoEXT info{XR_TYPE_RENDER_MODEL_CREATE_INFO_EXT, nullptr, id, 0, nullptr};
    XrRenderModelEXT model = XR_NULL_HANDLE;
    EXPECT_EQ(create(app.session, &info, &model), wanted) << id;
    return model;
  }
  std::string UserPathOf(XrRenderModelEXT model) const {
    const XrPath both[] = {app.left, app.right};
    const XrInteractionRenderModelTopLevelUserPathGetInfoEXT info{
        XR_TYPE_INTERACTION_RENDER_MODEL_TOP_LEVEL_USER_PATH_GET_INFO_EXT, nullptr, 2, both};
    XrPath path = XR_NULL_PATH;
    EXPECT_EQ(user_path(model, &info, &path), XR_SUCCESS);
    return app.Text(path);
  }
  // The model of that hand, or none.
  XrRenderModelEXT ModelAt(const std::string& hand) const {
    for (const XrRenderModelIdEXT id : Ids())
      if (const XrRenderModelEXT model = Make(id); UserPathOf(model) == hand) return model;
    return XR_NULL_HANDLE;
  }
  XrRenderModelPropertiesEXT PropertiesOf(XrRenderModelEXT model) const {
    XrRenderModelPropertiesEXT out{XR_TYPE_RENDER_MODEL_PROPERTIES_EXT, nullptr, {}, 0};
    EXPECT_EQ(properties(model, nullptr, &out), XR_SUCCESS);
    return out;
  }
  XrRenderModelAssetEXT AssetOf(const XrUuidEXT& id, XrResult wanted = XR_SUCCESS) const {
    const XrRenderModelAssetCreateInfoEXT info{XR_TYPE_RENDER_MODEL_ASSET_CREATE_INFO_EXT, nullptr, id};
    XrRenderModelAssetEXT asset = XR_NULL_HANDLE;
    EXPECT_EQ(create_asset(app.session, &info, &asset), wanted);
    return asset;
  }
  std::vector<std::uint8_t> BytesOf(XrRenderModelAssetEXT asset) const {
    XrRenderModelAssetDataEXT data{XR_TYPE_RENDER_MODEL_ASSET_DATA_EXT, nullptr, 0, 0, nullptr};
    EXPECT_EQ(asset_data(asset, nullptr, &data), XR_SUCCESS);
    std::vector<std::uint8_t> bytes(data.bufferCountOutput);
    data.bufferCapacityInput = data.bufferCountOutput;
    data.buffer = bytes.data();
    EXPECT_EQ(asset_data(asset, nullptr, &data), XR_SUCCESS);
    return bytes;
  }
  std::vector<std::string> NodesOf(XrRenderModelAssetEXT asset, std::uint32_t count) const {
    std::vector<XrRenderModelAssetNodePropertiesEXT> nodes(count);
    XrRenderModelAssetPropertiesEXT out{XR_TYPE_RENDER_MODEL_ASSET_PROPERTIES_EXT, nullptr, count, nodes.data()};
    EXPECT_EQ(asset_properties(asset, nullptr, &out), XR_SUCCESS);
    std::vector<std::string> names;
    for (const XrRenderModelAssetNodePropertiesEXT& node : nodes) names.emplace_back(node.uniqueName);
    return names;
  }
  std::vector<XrRenderModelNodeStateEXT> StateOf(XrRenderModelEXT model, std::uint32_t count) const {
    std::vector<XrRenderModelNodeStateEXT> nodes(count);
    const XrRenderModelStateGetInfoEXT info{XR_TYPE_RENDER_MODEL_STATE_GET_INFO_EXT, nullptr,
                                            Now_ns() + kRuntimeOffset_ns};
    XrRenderModelStateEXT out{XR_TYPE_RENDER_MODEL_STATE_EXT, nullptr, count, nodes.data()};
    EXPECT_EQ(state(model, &info, &out), XR_SUCCESS);
    return nodes;
  }
  // Drawn from the pen's own file.
  bool IsPen(XrRenderModelEXT model) const {
    return std::memcmp(PropertiesOf(model).cacheId.data, layer::EmbeddedPenModel().id.data, XR_UUID_SIZE_EXT) == 0;
  }
  XrSpace SpaceOf(XrRenderModelEXT model) const {
    const XrRenderModelSpaceCreateInfoEXT info{XR_TYPE_RENDER_MODEL_SPACE_CREATE_INFO_EXT, nullptr, model};
    XrSpace space = XR_NULL_HANDLE;
    EXPECT_EQ(create_space(app.session, &info, &space), XR_SUCCESS);
    return space;
  }
  bool Shown(XrSpace space) const {
    XrSpaceLocation location{XR_TYPE_SPACE_LOCATION};
    EXPECT_EQ(xrLocateSpace(space, local, Now_ns() + kRuntimeOffset_ns, &location), XR_SUCCESS);
    return location.locationFlags != 0;
  }
  XrControllerModelKeyMSFT Key(XrPath hand) const {
    XrControllerModelKeyStateMSFT out{XR_TYPE_CONTROLLER_MODEL_KEY_STATE_MSFT};
    EXPECT_EQ(key(app.session, hand, &out), XR_SUCCESS);
    return out.modelKey;
  }
  std::vector<std::string> PathsFB() const {
    std::uint32_t count = 0;
    EXPECT_EQ(paths_fb(app.session, 0, &count, nullptr), XR_SUCCESS);
    std::vector<XrRenderModelPathInfoFB> infos(count, {XR_TYPE_RENDER_MODEL_PATH_INFO_FB, nullptr, XR_NULL_PATH});
    EXPECT_EQ(paths_fb(app.session, count, &count, infos.data()), XR_SUCCESS);
    std::vector<std::string> out;
    for (const XrRenderModelPathInfoFB& info : infos) out.push_back(app.Text(info.path));
    return out;
  }
  int TakeChangeEvents() {
    app.events.clear();
    app.Poll();
    return app.CountEvents(XR_TYPE_EVENT_DATA_INTERACTION_RENDER_MODELS_CHANGED_EXT);
  }
  // Syncs until `hand` shows a profile of the pen (touch) or of the runtime's simple controller.
  bool Until(FakeService& service, XrPath hand, const char* profile) {
    return app.SyncUntil(service, [&] { return app.Profile(hand) == profile; });
  }
};

}  // namespace omni::test
