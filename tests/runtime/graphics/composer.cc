#include "tests/runtime/graphics/composer.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>

#include "tests/runtime/frame/views.h"
#include "tests/runtime/graphics/png.h"
#include "tests/runtime/spaces/locate.h"
#include "tests/runtime/system.h"

namespace omni::runtime {
namespace {

constexpr uint64_t kEvery = 10;
constexpr const char* kEyeNames[kEyes] = {"left", "right"};

struct Uv {
  float u;  // from the left edge, 0 to 1
  float v;  // from the upper edge
};

// Where a ray of the eye meets a layer. `X_LE`: the eye in the frame of the layer. Nothing: it does not.
using Projector = std::optional<Uv> (*)(const void* layer, const XrPosef& X_LE, const XrVector3f& direction_E);

bool IsInside(const Uv& at) { return at.u >= 0 && at.u < 1 && at.v >= 0 && at.v < 1; }

// By direction only: the layer is taken to be far away.
std::optional<Uv> ProjectView(const void* layer, const XrPosef& X_LE, const XrVector3f& direction_E) {
  const XrFovf& fov = static_cast<const XrCompositionLayerProjectionView*>(layer)->fov;
  const XrVector3f d = Rotate(X_LE.orientation, direction_E);
  if (!(d.z < 0)) return {};
  const float left = std::tan(fov.angleLeft);
  const float up = std::tan(fov.angleUp);
  const Uv at{(-d.x / d.z - left) / (std::tan(fov.angleRight) - left),
              (up + d.y / d.z) / (up - std::tan(fov.angleDown))};
  return IsInside(at) ? std::optional<Uv>(at) : std::nullopt;
}

// Only the front face, +z, is visible.
std::optional<Uv> ProjectQuad(const void* layer, const XrPosef& X_LE, const XrVector3f& direction_E) {
  const XrExtent2Df& size = static_cast<const XrCompositionLayerQuad*>(layer)->size;
  const XrVector3f d = Rotate(X_LE.orientation, direction_E);
  const XrVector3f& p = X_LE.position;
  if (!(p.z > 0 && d.z < 0)) return {};
  const float t = -p.z / d.z;
  const Uv at{(p.x + t * d.x) / size.width + 0.5F, 0.5F - (p.y + t * d.y) / size.height};
  return IsInside(at) ? std::optional<Uv>(at) : std::nullopt;
}

// A part of an image, and how it lies in the world.
struct Shown {
  XrCompositionLayerFlags flags = 0;
  const XrSwapchainSubImage* part = nullptr;
  XrPosef pose_in_space = kIdentity;
  const void* layer = nullptr;
  Projector project = nullptr;
};

bool IsSeen(XrEyeVisibility visibility, uint32_t eye) {
  return visibility == XR_EYE_VISIBILITY_BOTH ||
         visibility == (eye == 0 ? XR_EYE_VISIBILITY_LEFT : XR_EYE_VISIBILITY_RIGHT);
}

std::optional<Shown> ShownTo(uint32_t eye, const XrCompositionLayerBaseHeader& layer) {
  if (layer.type == XR_TYPE_COMPOSITION_LAYER_PROJECTION) {
    const auto& view = reinterpret_cast<const XrCompositionLayerProjection&>(layer).views[eye];
    return Shown{layer.layerFlags, &view.subImage, view.pose, &view, &ProjectView};
  }
  if (layer.type != XR_TYPE_COMPOSITION_LAYER_QUAD) return {};
  const auto& quad = reinterpret_cast<const XrCompositionLayerQuad&>(layer);
  if (!IsSeen(quad.eyeVisibility, eye)) return {};
  return Shown{layer.layerFlags, &quad.subImage, quad.pose, &quad, &ProjectQuad};
}

// The specification's "Composition Layer Blending".
void Blend(const float* layer, XrCompositionLayerFlags flags, float* composite) {
  const bool blended = (flags & XR_COMPOSITION_LAYER_BLEND_TEXTURE_SOURCE_ALPHA_BIT) != 0;
  const float alpha = blended ? layer[3] : 1;
  const float factor = blended && (flags & XR_COMPOSITION_LAYER_UNPREMULTIPLIED_ALPHA_BIT) != 0 ? alpha : 1;
  for (int i = 0; i < 3; ++i) composite[i] = std::clamp(layer[i] * factor, 0.0F, 1.0F) + composite[i] * (1 - alpha);
  composite[3] = alpha + composite[3] * (1 - alpha);
}

void Paint(const Shown& shown, const Picture& image, const XrPosef& X_LE, const XrFovf& fov, Picture& out) {
  const float left = std::tan(fov.angleLeft);
  const float right = std::tan(fov.angleRight);
  const float up = std::tan(fov.angleUp);
  const float down = std::tan(fov.angleDown);
  for (uint32_t y = 0; y < out.height; ++y) {
    for (uint32_t x = 0; x < out.width; ++x) {
      const float a = (static_cast<float>(x) + 0.5F) / static_cast<float>(out.width);
      const float b = (static_cast<float>(y) + 0.5F) / static_cast<float>(out.height);
      const auto at = shown.project(shown.layer, X_LE, {left + a * (right - left), up + b * (down - up), -1});
      if (!at) continue;
      // The nearest texel; a product may round up to the edge.
      const auto column = std::min(static_cast<uint32_t>(at->u * static_cast<float>(image.width)), image.width - 1);
      const auto row = std::min(static_cast<uint32_t>(at->v * static_cast<float>(image.height)), image.height - 1);
      Blend(&image.rgba[(size_t{row} * image.width + column) * 4], shown.flags,
            &out.rgba[(size_t{y} * out.width + x) * 4]);
    }
  }
}

// False: an image could not be read.
bool PaintLayer(const World& world, Session& session, const XrCompositionLayerBaseHeader& layer, XrTime time,
                uint32_t eye, Picture& out) {
  const std::optional<Shown> shown = ShownTo(eye, layer);
  if (!shown || shown->part->imageRect.extent.width == 0 || shown->part->imageRect.extent.height == 0) return true;
  const Handles& handles = TheState().handles;
  const Located space = Locate(world, session, *handles.Find<Space>(layer.space), time);
  if (!space.valid) return true;
  const Swapchain& swapchain = *handles.Find<Swapchain>(shown->part->swapchain);
  const Picture image = swapchain.images->Read(static_cast<uint32_t>(swapchain.released), shown->part->imageArrayIndex,
                                               shown->part->imageRect);
  if (image.rgba.empty()) return false;
  const XrView view = EyeView(world.HeadAt(time).pose, eye);
  const XrPosef X_WL = Compose(space.motion.pose, Normalized(shown->pose_in_space));
  Paint(*shown, image, Compose(Inverse(X_WL), view.pose), view.fov, out);
  return true;
}

bool SaveEye(const World& world, Session& session, const XrFrameEndInfo& info, uint32_t eye, const std::string& file) {
  Picture picture{kEyeWidth, kEyeHeight, std::vector<float>(size_t{kEyeWidth} * kEyeHeight * 4)};
  for (uint32_t i = 0; i < info.layerCount; ++i) {
    if (!PaintLayer(world, session, *info.layers[i], info.displayTime, eye, picture)) return false;
  }
  return SavePng(picture, file);
}

bool SaveAll(const World& world, Session& session, const XrFrameEndInfo& info, const std::string& folder) {
  for (uint32_t eye = 0; eye < kEyes; ++eye) {
    if (!SaveEye(world, session, info, eye, folder + "/" + kEyeNames[eye] + ".png")) return false;
  }
  return SaveText("frame " + std::to_string(session.frames_shown) + " layers " + std::to_string(info.layerCount) + "\n",
                  folder + "/frame.txt");
}

}  // namespace

XrResult SavePictures(const World& world, Session& session, const XrFrameEndInfo& info) {
  const char* const folder = std::getenv("OMNI_TEST_RUNTIME_PICTURES");
  if (session.graphics == nullptr || info.layerCount == 0) return XR_SUCCESS;
  ++session.frames_shown;
  if (folder == nullptr || *folder == '\0' || session.frames_shown % kEvery != 1) return XR_SUCCESS;
  if (SaveAll(world, session, info, folder)) return XR_SUCCESS;
  std::fprintf(stderr, "omni_test_runtime: no picture; OMNI_TEST_RUNTIME_PICTURES must name a writable folder: %s\n",
               folder);
  return XR_ERROR_RUNTIME_FAILURE;
}

}  // namespace omni::runtime
