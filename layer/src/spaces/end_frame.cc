// xrEndFrame: layers in spaces of the pen are drawn where the pen is when the frame is shown.
#include "layer/src/spaces/frame_layers.h"
#include "layer/src/spaces/locator.h"

namespace omni::layer {
namespace {

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
  link_.Beat();
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
