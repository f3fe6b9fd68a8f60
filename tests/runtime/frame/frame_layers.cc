#include "tests/runtime/frame/frame_layers.h"

#include <algorithm>
#include <cmath>

#include "tests/runtime/frame/sub_images.h"
#include "tests/runtime/system.h"

namespace omni::runtime {
namespace {

OmniTestFrame recorded{};

// Where a layer of this type has its pose. Null extension: core.
struct LayerType {
  XrStructureType type;
  const char* extension;
  XrPosef (*pose)(const XrCompositionLayerBaseHeader& layer);
};

template <class Layer>
XrPosef PoseOf(const XrCompositionLayerBaseHeader& layer) {
  return reinterpret_cast<const Layer&>(layer).pose;
}

constexpr LayerType kLayerTypes[] = {
    {XR_TYPE_COMPOSITION_LAYER_PROJECTION, nullptr, [](const XrCompositionLayerBaseHeader&) { return kIdentity; }},
    {XR_TYPE_COMPOSITION_LAYER_QUAD, nullptr, &PoseOf<XrCompositionLayerQuad>},
    {XR_TYPE_COMPOSITION_LAYER_CUBE_KHR, XR_KHR_COMPOSITION_LAYER_CUBE_EXTENSION_NAME,
     [](const XrCompositionLayerBaseHeader& layer) {
       return XrPosef{reinterpret_cast<const XrCompositionLayerCubeKHR&>(layer).orientation, {0, 0, 0}};
     }},
    {XR_TYPE_COMPOSITION_LAYER_CYLINDER_KHR, XR_KHR_COMPOSITION_LAYER_CYLINDER_EXTENSION_NAME,
     &PoseOf<XrCompositionLayerCylinderKHR>},
    {XR_TYPE_COMPOSITION_LAYER_EQUIRECT_KHR, XR_KHR_COMPOSITION_LAYER_EQUIRECT_EXTENSION_NAME,
     &PoseOf<XrCompositionLayerEquirectKHR>},
    {XR_TYPE_COMPOSITION_LAYER_EQUIRECT2_KHR, XR_KHR_COMPOSITION_LAYER_EQUIRECT2_EXTENSION_NAME,
     &PoseOf<XrCompositionLayerEquirect2KHR>},
};

const LayerType* FindLayerType(XrStructureType type) {
  const auto* const found = std::find_if(std::begin(kLayerTypes), std::end(kLayerTypes),
                                         [type](const LayerType& known) { return known.type == type; });
  return found == std::end(kLayerTypes) ? nullptr : found;
}

const XrCompositionLayerProjection* AsProjection(const XrCompositionLayerBaseHeader& layer) {
  if (layer.type != XR_TYPE_COMPOSITION_LAYER_PROJECTION) return nullptr;
  return reinterpret_cast<const XrCompositionLayerProjection*>(&layer);
}

XrResult CheckViews(const XrCompositionLayerProjection& projection) {
  OMNI_REQUIRE(projection.viewCount == kEyes && projection.views != nullptr, XR_ERROR_VALIDATION_FAILURE);
  for (uint32_t eye = 0; eye < kEyes; ++eye) {
    OMNI_REQUIRE(projection.views[eye].type == XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW, XR_ERROR_VALIDATION_FAILURE);
    OMNI_REQUIRE(IsValid(projection.views[eye].pose), XR_ERROR_POSE_INVALID);
  }
  return XR_SUCCESS;
}

XrResult CheckLayer(const Session& session, const XrCompositionLayerBaseHeader* layer) {
  OMNI_REQUIRE(layer != nullptr, XR_ERROR_LAYER_INVALID);
  const LayerType* const type = FindLayerType(layer->type);
  OMNI_REQUIRE(type != nullptr && (type->extension == nullptr || session.instance->Enabled(type->extension)),
               XR_ERROR_LAYER_INVALID);
  OMNI_FIND(Space, space, layer->space);
  OMNI_REQUIRE(space->session == &session, XR_ERROR_VALIDATION_FAILURE);
  if (const auto* const projection = AsProjection(*layer)) {
    if (const XrResult check = CheckViews(*projection); XR_FAILED(check)) return check;
  }
  OMNI_REQUIRE(IsValid(type->pose(*layer)), XR_ERROR_POSE_INVALID);
  return CheckSubImages(session, *layer);
}

void CopyPose(const XrPosef& pose, float out[7]) {
  const float values[7] = {pose.position.x,    pose.position.y,    pose.position.z,   pose.orientation.x,
                           pose.orientation.y, pose.orientation.z, pose.orientation.w};
  std::copy_n(values, 7, out);
}

void RecordLayer(const XrCompositionLayerBaseHeader* layer, OmniTestLayer& out) {
  out = {};
  out.structure = layer;
  if (layer == nullptr) return;
  out.type = layer->type;
  out.space = Handles::Bits(layer->space);
  out.next = layer->next;
  if (const LayerType* const type = FindLayerType(layer->type)) CopyPose(type->pose(*layer), out.pose);
  const auto* const projection = AsProjection(*layer);
  if (projection == nullptr || projection->views == nullptr) return;
  out.views = std::min(projection->viewCount, uint32_t{OMNI_TEST_MAX_VIEWS});
  for (uint32_t i = 0; i < out.views; ++i) {
    CopyPose(projection->views[i].pose, out.view_pose[i]);
    out.view_next[i] = projection->views[i].next;
  }
}

}  // namespace

XrResult CheckFrameLayers(const Session& session, const XrFrameEndInfo& info) {
  OMNI_REQUIRE(info.layerCount <= XR_MIN_COMPOSITION_LAYERS_SUPPORTED, XR_ERROR_LAYER_LIMIT_EXCEEDED);
  OMNI_REQUIRE(info.layerCount == 0 || info.layers != nullptr, XR_ERROR_LAYER_INVALID);
  for (uint32_t i = 0; i < info.layerCount; ++i) {
    if (const XrResult check = CheckLayer(session, info.layers[i]); XR_FAILED(check)) return check;
  }
  return XR_SUCCESS;
}

void RecordFrame(const XrFrameEndInfo& info) {
  recorded = {};
  recorded.info = &info;
  recorded.next = info.next;
  recorded.display_time = info.displayTime;
  recorded.blend_mode = info.environmentBlendMode;
  recorded.layer_count = info.layerCount;
  for (uint32_t i = 0; info.layers != nullptr && i < std::min(info.layerCount, uint32_t{OMNI_TEST_MAX_LAYERS}); ++i) {
    RecordLayer(info.layers[i], recorded.layers[i]);
  }
}

const OmniTestFrame& RecordedFrame() { return recorded; }
void ForgetFrame() { recorded = {}; }

}  // namespace omni::runtime
