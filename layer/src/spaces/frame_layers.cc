#include "layer/src/spaces/frame_layers.h"

#include <cmath>
#include <cstring>
#include <type_traits>

namespace omni::layer {
namespace {

template <class Layer>
struct Tag {
  using Type = Layer;
};

// Calls `visit` with the tag of the structure that `type` names. False: not one of ours.
template <class Visit>
bool WithLayerType(XrStructureType type, Visit visit) {
  switch (type) {
    case XR_TYPE_COMPOSITION_LAYER_PROJECTION:
      visit(Tag<XrCompositionLayerProjection>{});
      return true;
    case XR_TYPE_COMPOSITION_LAYER_QUAD:
      visit(Tag<XrCompositionLayerQuad>{});
      return true;
    case XR_TYPE_COMPOSITION_LAYER_CUBE_KHR:
      visit(Tag<XrCompositionLayerCubeKHR>{});
      return true;
    case XR_TYPE_COMPOSITION_LAYER_CYLINDER_KHR:
      visit(Tag<XrCompositionLayerCylinderKHR>{});
      return true;
    case XR_TYPE_COMPOSITION_LAYER_EQUIRECT_KHR:
      visit(Tag<XrCompositionLayerEquirectKHR>{});
      return true;
    case XR_TYPE_COMPOSITION_LAYER_EQUIRECT2_KHR:
      visit(Tag<XrCompositionLayerEquirect2KHR>{});
      return true;
    default:
      return false;
  }
}

// An invalid orientation is left for the runtime to reject.
XrPosef Moved(const Pose& X_LS, const XrPosef& pose) {
  const XrQuaternionf& q = pose.orientation;
  const double norm = std::sqrt(double{q.x} * q.x + double{q.y} * q.y + double{q.z} * q.z + double{q.w} * q.w);
  if (!(norm >= 0.99 && norm <= 1.01)) return pose;
  return ToXr(Compose(X_LS, FromXr(pose)));
}

}  // namespace

bool FrameLayers::Knows(XrStructureType type) noexcept {
  return WithLayerType(type, [](auto) {});
}

const XrCompositionLayerBaseHeader* FrameLayers::Move(const XrCompositionLayerBaseHeader& layer, XrSpace anchor,
                                                      const Pose& X_LS) {
  Copy& copy = copies_.emplace_back();
  WithLayerType(layer.type, [&](auto tag) {
    using Layer = typename decltype(tag)::Type;
    static_assert(sizeof(Layer) <= sizeof(copy.layer) && std::is_trivially_copyable_v<Layer>);
    Layer moved;
    std::memcpy(&moved, &layer, sizeof(moved));
    moved.space = anchor;
    if constexpr (std::is_same_v<Layer, XrCompositionLayerProjection>) {
      if (moved.views) copy.views.assign(moved.views, moved.views + moved.viewCount);
      for (XrCompositionLayerProjectionView& view : copy.views) view.pose = Moved(X_LS, view.pose);
      if (moved.views) moved.views = copy.views.data();
    } else if constexpr (std::is_same_v<Layer, XrCompositionLayerCubeKHR>) {
      moved.orientation = Moved(X_LS, {moved.orientation, {0, 0, 0}}).orientation;
    } else {
      moved.pose = Moved(X_LS, moved.pose);
    }
    std::memcpy(copy.layer, &moved, sizeof(moved));
  });
  return reinterpret_cast<const XrCompositionLayerBaseHeader*>(copy.layer);
}

}  // namespace omni::layer
