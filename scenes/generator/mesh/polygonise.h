// Zero set of a field -> closed triangle mesh.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "scenes/generator/mesh/mesh.h"

namespace omni::scenes {

// A solid as a signed distance field: smooth union of simple shapes. The zero set of a continuous field is closed,
// so a surface taken from it has no holes, whatever the shapes do to each other.

// All lengths in millimetres here: creatures are easier to think of in them.
struct Shape {
  enum class Kind : std::uint8_t { kRoundCone, kSlab };
  Kind kind = Kind::kRoundCone;
  Vec a{0.0}, b{0.0}, c{0.0};         // cone: ends; slab: corners of a triangle
  double radius_a = 1, radius_b = 1;  // cone: at its ends; slab: radius_a = half thickness
  double blend = 0.5;                 // width of the smooth union with what came before
  bool carve = false;                 // taken away instead of added
  std::uint32_t paint = 0;
  Vec centre{0.0};  // bounding sphere
  double bound = 0;
};

Shape RoundCone(const Vec& a, double radius_a, const Vec& b, double radius_b, double blend, std::uint32_t paint);
Shape Slab(const Vec& a, const Vec& b, const Vec& c, double half_thickness, double blend, std::uint32_t paint);

// Exact distance to one shape.
double Distance(const Shape& shape, const Vec& p);

// Distance-like field of all shapes, in order; its slope is at most 1.
double Field(std::span<const Shape> shapes, const Vec& p);

// Central differences.
Vec FieldGradient(std::span<const Shape> shapes, const Vec& p);

// Shapes that make the field near its zero set, within `radius` of `p`.
std::vector<Shape> Near(std::span<const Shape> shapes, const Vec& p, double radius);

// Marching tetrahedra on a grid of `cell` mm over [lower, upper] (which must hold the solid), vertices then moved onto
// the zero set. Closed and manifold by construction. Result in millimetres.
Mesh Polygonise(std::span<const Shape> shapes, const Vec& lower, const Vec& upper, double cell);

}  // namespace omni::scenes
