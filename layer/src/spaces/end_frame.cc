// xrEndFrame: layers in spaces of the pen are drawn where the pen is when the frame is shown.
#include <cmath>
#include <cstddef>
#include <cstring>
#include <list>
#include <type_traits>
#include <vector>

#include "layer/src/spaces/locator.h"

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

// Composition layers that an application placed in a space of the pen, converted to a space that the runtime knows:
// copies, alive as long as this object. The application's own structures are never written.
class FrameLayers {
 public:
  // Projection, quad, cube, cylinder, equirect, equirect2. Of other types we do not know where their poses are.
  static bool Knows(XrStructureType type) noexcept;

  // The same layer in the space `anchor`, L. `next` chains are kept. Precondition: Knows(layer.type).
  const XrCompositionLayerBaseHeader* Move(const XrCompositionLayerBaseHeader& layer, XrSpace anchor, const Pose& X_LS);

 private:
  struct Copy {
    alignas(std::max_align_t) std::byte layer[256];
    std::vector<XrCompositionLayerProjectionView> views;
  };
  std::list<Copy> copies_;
};

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

bool ShowsLayers(const XrFrameEndInfo* info) {
  return info && info->type == XR_TYPE_FRAME_END_INFO && info->displayTime > 0 && info->layerCount > 0 && info->layers;
}

// The space of a layer that we can move.
Side LayerSide(const HandleMap<XrSpace, Space>& spaces, const XrCompositionLayerBaseHeader* layer) {
  return layer && FrameLayers::Knows(layer->type) ? SideOf(spaces, layer->space) : Side{};
}

}  // namespace

// If no layer is in a space of the pen, the application's own structure is passed down.
XrResult Locator::EndFrame(XrSession session, const XrFrameEndInfo* info) {
  link_.SignalAlive();
  if (!ShowsLayers(info)) return runtime_.next.EndFrame(session, info);
  const auto is_ours = [&](const XrCompositionLayerBaseHeader* layer) {
    return LayerSide(records_.spaces, layer).ours();
  };
  const bool ours = std::any_of(info->layers, info->layers + info->layerCount, is_ours);
  if (!ours) return runtime_.next.EndFrame(session, info);

  FrameLayers copies;
  std::vector<const XrCompositionLayerBaseHeader*> layers;
  layers.reserve(info->layerCount);
  for (std::uint32_t i = 0; i < info->layerCount; ++i) {
    const Side side = LayerSide(records_.spaces, info->layers[i]);
    if (!side.ours() || side.session()->handle != session) {
      layers.push_back(info->layers[i]);
      continue;
    }
    const PenAt pen = PenAtTime(link_, clock_, *side.session(), info->displayTime);
    const Located X_LS = side.pen() ? pen.Locate(side.X_TS) : Located{};
    if ((X_LS.flags & kValid) != kValid) continue;  // its place is unknown: not shown
    layers.push_back(copies.Move(*info->layers[i], pen.anchor, X_LS.motion.X));
  }
  XrFrameEndInfo changed = *info;
  changed.layerCount = static_cast<std::uint32_t>(layers.size());
  changed.layers = layers.empty() ? nullptr : layers.data();
  return runtime_.next.EndFrame(session, &changed);
}

}  // namespace omni::layer
