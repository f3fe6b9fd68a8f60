// Places a model over the base.
#pragma once

#include <glm/mat4x4.hpp>
#include <string>

#include "service/haptics/scene/scene_input.h"
#include "service/scene/gltf/gltf_decode.h"
#include "service/scene/scene_file.h"
#include "service/scene/tags/haptic_tag.h"

namespace omni::scene {

struct Placing {
  double fit_scale = 1;  // by `fit` alone
  // All of it: x_base = scale x + offset_m, x: as authored.
  double scale = 1;
  base::Vec3 offset_m;
};

// Scales and moves everything of `input` as `options` say. With `fit`: longest horizontal extent 50 mm (less if the
// height would exceed 40 mm), centred on the z axis, top of the bounds 15 to 30 mm above the hull: as high as the model
// plus 5 mm, within that. Throws LoadError when there is nothing to fit.
Placing Place(haptics::SceneInput& input, const LoadOptions& options);

// A warning when nothing touchable is where the device can exert force.
void WarnIfOutOfReach(const haptics::SceneInput& input, const LoadOptions& options, Warnings& warnings);

// How exactly coordinates that are floats say where surfaces are: coarse, far from their origin.
class FloatSteps {
 public:
  // What was decoded, as `place` puts it into the scene. The coarsest is remembered.
  void Note(const std::string& pointer, const glm::dmat4& place, const DecodedPrimitive& decoded);
  // One warning, when its steps can be felt; `scale`: of the scene.
  void WarnIfFelt(double scale, Warnings& warnings) const;

 private:
  double step_m_ = 0, reach_m_ = 0;  // between neighbouring coordinates, and how large these are
  std::string pointer_;
};

// A warning when nothing of the scene lies over the base, but would if the file's z axis were up. None for a document
// from an application.
void SuggestUp(const haptics::SceneInput& input, const LoadOptions& options, const Placing& placing,
               Warnings& warnings);

}  // namespace omni::scene
