// Head: skull, snout, open jaws with teeth, brows, eyes, horns, cheek spikes and fins.
#include <glm/geometric.hpp>

#include "scenes/generator/models/dragon_shape.h"

namespace omni::scenes {
namespace {

struct HeadCone {
  Vec a;
  double radius_a;
  Vec b;
  double radius_b;
  double blend;
  DragonPaint paint;
  bool mirrored;
};

const HeadCone kCones[] = {
    // skull, neck joint
    {{-1.0, 0, 0.2}, 4.3, {4.6, 0, 0.2}, 3.7, 1.5, kSkin, false},
    {{-3.0, 0, -0.6}, 3.9, {1.0, 0, -1.4}, 3.6, 1.5, kSkin, false},
    {{0.6, 2.4, -1.6}, 2.3, {4.2, 1.9, -1.8}, 1.7, 1.5, kSkin, true},
    // upper jaw: flat and broad, with a raised bridge and nose
    {{4.6, 1.1, 0.0}, 2.6, {14.0, 1.0, -1.1}, 1.55, 1.2, kSkin, true},
    {{4.0, 0, 1.6}, 2.0, {13.6, 0, 0.1}, 1.35, 1.2, kSkin, false},
    {{13.6, 1.1, 0.1}, 1.25, {14.6, 1.1, -0.3}, 1.05, 0.6, kSkin, true},
    // lower jaw, opened
    {{1.2, 1.4, -3.4}, 1.9, {12.2, 0.7, -7.0}, 0.95, 0.7, kSkin, true},
    {{1.2, 0, -3.7}, 2.0, {12.4, 0, -7.2}, 1.0, 0.7, kSkin, false},
    // tongue
    {{3.0, 0, -3.0}, 1.1, {9.6, 0, -4.9}, 0.6, 0.4, kMouth, false},
    // brows
    {{-0.6, 2.9, 3.0}, 1.25, {6.2, 2.3, 2.6}, 0.75, 0.6, kSkin, true},
    // eyes
    {{4.1, 2.75, 1.45}, 1.35, {4.3, 2.8, 1.45}, 1.35, 0.15, kEye, true},
    // horns, swept back
    {{-1.6, 2.4, 3.2}, 1.75, {-5.6, 3.7, 6.0}, 1.4, 0.8, kHorn, true},
    {{-5.6, 3.7, 6.0}, 1.4, {-10.4, 4.8, 7.6}, 1.05, 0.3, kHorn, true},
    {{-10.4, 4.8, 7.6}, 1.05, {-14.6, 5.2, 9.6}, 0.7, 0.3, kHorn, true},
    {{-14.6, 5.2, 9.6}, 0.7, {-17.6, 5.0, 12.8}, 0.3, 0.3, kHorn, true},
    // cheek spikes
    {{-1.4, 3.5, -1.2}, 1.2, {-6.6, 6.0, -0.6}, 0.3, 0.6, kHorn, true},
    {{-0.6, 3.3, -3.2}, 1.1, {-5.0, 5.2, -4.6}, 0.3, 0.6, kHorn, true},
    // nose horn, chin spikes
    {{11.6, 0, 0.6}, 0.95, {11.2, 0, 3.0}, 0.3, 0.6, kHorn, false},
    {{8.6, 0, -6.4}, 0.9, {6.4, 0, -9.4}, 0.3, 0.5, kHorn, false},
    {{5.0, 0, -5.4}, 0.9, {2.8, 0, -8.0}, 0.3, 0.5, kHorn, false},
    // teeth
    {{13.6, 1.5, -1.9}, 0.65, {13.7, 1.45, -4.0}, 0.28, 0.2, kHorn, true},
    {{11.4, 1.8, -1.9}, 0.55, {11.4, 1.75, -3.4}, 0.28, 0.2, kHorn, true},
    {{9.2, 2.1, -1.9}, 0.55, {9.2, 2.0, -3.2}, 0.28, 0.2, kHorn, true},
    {{7.2, 2.3, -1.8}, 0.5, {7.2, 2.2, -2.9}, 0.28, 0.2, kHorn, true},
    {{12.3, 0.95, -6.7}, 0.6, {12.6, 1.0, -4.9}, 0.28, 0.2, kHorn, true},
    {{10.0, 1.2, -6.0}, 0.5, {10.2, 1.25, -4.6}, 0.28, 0.2, kHorn, true},
};

}  // namespace

Place HeadPlace() {
  Place place;
  place.origin = {33.0, 2.3, 67.0};
  place.forward = glm::normalize(Vec(0.955, 0.20, -0.16));
  place.left = glm::normalize(glm::cross(Vec(0, 0, 1), place.forward));
  place.up = glm::cross(place.forward, place.left);
  return place;
}

void AddHead(std::vector<Shape>& shapes) {
  const Place head = HeadPlace();
  const Vec flip(1, -1, 1);
  for (const HeadCone& cone : kCones) {
    shapes.push_back(RoundCone(head(cone.a), cone.radius_a, head(cone.b), cone.radius_b, cone.blend, cone.paint));
    if (!cone.mirrored) continue;
    shapes.push_back(
        RoundCone(head(cone.a * flip), cone.radius_a, head(cone.b * flip), cone.radius_b, cone.blend, cone.paint));
  }
  for (const double side : {-1.0, 1.0}) {
    // Fin behind the cheek.
    shapes.push_back(Slab(head({-1.0, side * 3.4, 1.2}), head({-7.8, side * 8.4, 3.2}), head({-3.4, side * 4.6, -2.6}),
                          0.45, 0.4, kMembrane));
    shapes.push_back(Slab(head({-3.4, side * 4.6, -2.6}), head({-7.8, side * 8.4, 3.2}), head({-6.0, side * 6.6, -1.4}),
                          0.45, 0.4, kMembrane));
    shapes.push_back(RoundCone(head({-1.0, side * 3.4, 1.2}), 0.9, head({-7.8, side * 8.4, 3.2}), 0.4, 0.4, kBone));
    // Nostrils.
    Shape nostril = RoundCone(head({15.3, side * 1.5, 0.3}), 0.6, head({14.2, side * 1.5, 0.7}), 0.4, 0.3, kMouth);
    nostril.carve = true;
    shapes.push_back(nostril);
  }
}

}  // namespace omni::scenes
