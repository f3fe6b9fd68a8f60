// The dragon as a solid: which shapes, where, in which colour. Millimetres, x towards the nose, y to its left, z up.
#pragma once

#include <span>
#include <vector>

#include "scenes/generator/mesh/mesh.h"
#include "scenes/generator/mesh/polygonise.h"

namespace omni::scenes {

enum DragonPaint : std::uint32_t { kSkin, kMembrane, kBone, kHorn, kRidge, kEye, kMouth, kPaintCount };

inline constexpr double kDome_mm = 37.5;  // the base's hull, on which it lies ...
inline constexpr double kClear_mm = 0.3;  // ... by so much

// A frame that shapes are given in: p = origin + x forward + y left + z up.
struct Place {
  Vec origin{0.0};
  Vec forward{1, 0, 0}, left{0, 1, 0}, up{0, 0, 1};
  Vec operator()(const Vec& p) const { return origin + forward * p.x + left * p.y + up * p.z; }
};
Place HeadPlace();

// Shapes in the order of their union; the parts are in dragon_body.cc, dragon_head.cc and dragon_wings.cc.
std::vector<Shape> DragonShapes();
void AddBody(std::vector<Shape>& shapes);
void AddLegs(std::vector<Shape>& shapes);
void AddTail(std::vector<Shape>& shapes);
void AddRidges(std::vector<Shape>& shapes);
void AddHead(std::vector<Shape>& shapes);
void AddWings(std::vector<Shape>& shapes);

// A point of the spine from the tail's tip (t = 0) to the head (t = 1), and its radius.
struct SpinePoint {
  Vec position;
  double radius;
};
SpinePoint SpineAt(double t);

// Linear RGB of a surface point with this outward normal.
Vec DragonColour(std::span<const Shape> shapes, const Vec& p, const Vec& normal);

// How much detail matters at `p`: 1 on the trunk, more on the head and the feet.
double DragonImportance(const Vec& p);

}  // namespace omni::scenes
