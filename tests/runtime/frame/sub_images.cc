#include "tests/runtime/frame/sub_images.h"

#include "tests/runtime/system.h"

namespace omni::runtime {
namespace {

XrResult CheckImage(const Session& session, XrSwapchain handle, uint32_t array_index, uint32_t faces, bool depth) {
  OMNI_FIND(Swapchain, swapchain, handle);
  OMNI_REQUIRE(swapchain->session == &session, XR_ERROR_VALIDATION_FAILURE);
  OMNI_REQUIRE(swapchain->released >= 0, XR_ERROR_LAYER_INVALID);
  OMNI_REQUIRE(array_index < swapchain->info.arraySize && swapchain->info.faceCount == faces &&
                   swapchain->images->depth() == depth,
               XR_ERROR_VALIDATION_FAILURE);
  return XR_SUCCESS;
}

XrResult CheckSubImage(const Session& session, const XrSwapchainSubImage& part, bool depth) {
  const XrResult check = CheckImage(session, part.swapchain, part.imageArrayIndex, 1, depth);
  if (XR_FAILED(check)) return check;
  const XrSwapchainCreateInfo& info = TheState().handles.Find<Swapchain>(part.swapchain)->info;
  const XrRect2Di& rect = part.imageRect;
  const bool inside = rect.offset.x >= 0 && rect.offset.y >= 0 && rect.extent.width >= 0 && rect.extent.height >= 0 &&
                      int64_t{rect.offset.x} + rect.extent.width <= int64_t{info.width} &&
                      int64_t{rect.offset.y} + rect.extent.height <= int64_t{info.height};
  OMNI_REQUIRE(inside, XR_ERROR_SWAPCHAIN_RECT_INVALID);
  return XR_SUCCESS;
}

XrResult CheckDepth(const Session& session, const XrCompositionLayerProjectionView& view) {
  if (!session.instance->Enabled(XR_KHR_COMPOSITION_LAYER_DEPTH_EXTENSION_NAME)) return XR_SUCCESS;
  const auto* const depth =
      InChain<XrCompositionLayerDepthInfoKHR>(const_cast<void*>(view.next), XR_TYPE_COMPOSITION_LAYER_DEPTH_INFO_KHR);
  if (depth == nullptr) return XR_SUCCESS;
  const bool window = depth->minDepth >= 0 && depth->minDepth < depth->maxDepth && depth->maxDepth <= 1;
  const bool planes = depth->nearZ > 0 && depth->farZ > 0 && depth->nearZ != depth->farZ;  // infinity is a distance
  OMNI_REQUIRE(window && planes, XR_ERROR_VALIDATION_FAILURE);
  return CheckSubImage(session, depth->subImage, true);
}

XrResult CheckProjection(const Session& session, const XrCompositionLayerProjection& projection) {
  for (uint32_t eye = 0; eye < kEyes; ++eye) {
    const XrCompositionLayerProjectionView& view = projection.views[eye];
    if (const XrResult check = CheckSubImage(session, view.subImage, false); XR_FAILED(check)) return check;
    if (const XrResult check = CheckDepth(session, view); XR_FAILED(check)) return check;
  }
  return XR_SUCCESS;
}

bool IsVisibility(XrEyeVisibility eyes) {
  return eyes == XR_EYE_VISIBILITY_BOTH || eyes == XR_EYE_VISIBILITY_LEFT || eyes == XR_EYE_VISIBILITY_RIGHT;
}

template <class Layer>
XrResult CheckSurface(const Session& session, const XrCompositionLayerBaseHeader& layer) {
  const auto& surface = reinterpret_cast<const Layer&>(layer);
  OMNI_REQUIRE(IsVisibility(surface.eyeVisibility), XR_ERROR_VALIDATION_FAILURE);
  return CheckSubImage(session, surface.subImage, false);
}

XrResult CheckCube(const Session& session, const XrCompositionLayerCubeKHR& cube) {
  OMNI_REQUIRE(IsVisibility(cube.eyeVisibility), XR_ERROR_VALIDATION_FAILURE);
  return CheckImage(session, cube.swapchain, cube.imageArrayIndex, 6, false);
}

}  // namespace

XrResult CheckSubImages(const Session& session, const XrCompositionLayerBaseHeader& layer) {
  if (session.graphics == nullptr) return XR_SUCCESS;
  switch (layer.type) {
    case XR_TYPE_COMPOSITION_LAYER_PROJECTION:
      return CheckProjection(session, reinterpret_cast<const XrCompositionLayerProjection&>(layer));
    case XR_TYPE_COMPOSITION_LAYER_QUAD:
      return CheckSurface<XrCompositionLayerQuad>(session, layer);
    case XR_TYPE_COMPOSITION_LAYER_CUBE_KHR:
      return CheckCube(session, reinterpret_cast<const XrCompositionLayerCubeKHR&>(layer));
    case XR_TYPE_COMPOSITION_LAYER_CYLINDER_KHR:
      return CheckSurface<XrCompositionLayerCylinderKHR>(session, layer);
    case XR_TYPE_COMPOSITION_LAYER_EQUIRECT_KHR:
      return CheckSurface<XrCompositionLayerEquirectKHR>(session, layer);
    default:
      return CheckSurface<XrCompositionLayerEquirect2KHR>(session, layer);
  }
}

}  // namespace omni::runtime
