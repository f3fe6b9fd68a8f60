#include "scenes/generator/mesh/polygonise.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace omni::scenes {
namespace {

double Square(const Vec& v) { return glm::dot(v, v); }

// Distance to the hull of two balls   [I. Quilez, "Round cone - exact"]
double RoundConeDistance(const Shape& s, const Vec& p) {
  const Vec ba = s.b - s.a;
  const double l2 = Square(ba);
  const double rr = s.radius_a - s.radius_b;
  const double a2 = l2 - rr * rr;
  if (!(a2 > 0)) {  // one ball holds the other
    return s.radius_a > s.radius_b ? glm::length(p - s.a) - s.radius_a : glm::length(p - s.b) - s.radius_b;
  }
  const double il2 = 1 / l2;
  const Vec pa = p - s.a;
  const double y = glm::dot(pa, ba);
  const double z = y - l2;
  const double x2 = Square(pa * l2 - ba * y);
  const double y2 = y * y * l2;
  const double z2 = z * z * l2;
  const double k = (rr > 0 ? 1 : rr < 0 ? -1 : 0) * rr * rr * x2;
  if ((z > 0 ? 1 : -1) * a2 * z2 > k) return std::sqrt(x2 + z2) * il2 - s.radius_b;
  if ((y > 0 ? 1 : -1) * a2 * y2 < k) return std::sqrt(x2 + y2) * il2 - s.radius_a;
  return (std::sqrt(x2 * a2 * il2) + y * rr) * il2 - s.radius_a;
}

double SegmentSquare(const Vec& p, const Vec& a, const Vec& b) {
  const Vec ab = b - a;
  const double t = std::clamp(glm::dot(p - a, ab) / Square(ab), 0.0, 1.0);
  return Square(p - a - ab * t);
}

// Distance to a triangle, less half its thickness.
double SlabDistance(const Shape& s, const Vec& p) {
  const Vec n = glm::cross(s.b - s.a, s.c - s.a);
  const bool above = glm::dot(glm::cross(n, s.b - s.a), p - s.a) >= 0 &&
                     glm::dot(glm::cross(n, s.c - s.b), p - s.b) >= 0 &&
                     glm::dot(glm::cross(n, s.a - s.c), p - s.c) >= 0;
  const double height = glm::dot(n, p - s.a);
  const double square =
      above ? height * height / Square(n)
            : std::min({SegmentSquare(p, s.a, s.b), SegmentSquare(p, s.b, s.c), SegmentSquare(p, s.c, s.a)});
  return std::sqrt(square) - s.radius_a;
}

// min(a, b), rounded where they differ by less than k; exactly min elsewhere   [I. Quilez, "Smooth minimum", quadratic]
double SmoothMin(double a, double b, double k) {
  const double h = std::max(k - std::abs(a - b), 0.0) / k;
  return std::min(a, b) - h * h * k * 0.25;
}

}  // namespace

Shape RoundCone(const Vec& a, double radius_a, const Vec& b, double radius_b, double blend, std::uint32_t paint) {
  Shape s;
  s.a = a;
  s.b = b;
  s.radius_a = radius_a;
  s.radius_b = radius_b;
  s.blend = blend;
  s.paint = paint;
  s.centre = (a + b) * 0.5;
  s.bound = glm::length(a - b) * 0.5 + std::max(radius_a, radius_b);
  return s;
}

Shape Slab(const Vec& a, const Vec& b, const Vec& c, double half_thickness, double blend, std::uint32_t paint) {
  Shape s;
  s.kind = Shape::Kind::kSlab;
  s.a = a;
  s.b = b;
  s.c = c;
  s.radius_a = half_thickness;
  s.blend = blend;
  s.paint = paint;
  s.centre = (a + b + c) / 3.0;
  s.bound =
      std::max({glm::length(a - s.centre), glm::length(b - s.centre), glm::length(c - s.centre)}) + half_thickness;
  return s;
}

double Distance(const Shape& shape, const Vec& p) {
  return shape.kind == Shape::Kind::kRoundCone ? RoundConeDistance(shape, p) : SlabDistance(shape, p);
}

double Field(std::span<const Shape> shapes, const Vec& p) {
  double d = 1e3;
  for (const Shape& shape : shapes) {
    const double s = Distance(shape, p);
    d = shape.carve ? -SmoothMin(-d, s, shape.blend) : SmoothMin(d, s, shape.blend);
  }
  return d;
}

Vec FieldGradient(std::span<const Shape> shapes, const Vec& p) {
  constexpr double kStep = 0.01;
  Vec g;
  for (int k = 0; k < 3; ++k) {
    Vec q = p;
    q[k] += kStep;
    const double up = Field(shapes, q);
    q[k] -= 2 * kStep;
    g[k] = (up - Field(shapes, q)) / (2 * kStep);
  }
  return g;
}

std::vector<Shape> Near(std::span<const Shape> shapes, const Vec& p, double radius) {
  // A union acts only where two values differ by less than its blend; 2 mm more leave nothing out.
  std::vector<Shape> near;
  for (const Shape& shape : shapes) {
    const double reach = radius + shape.blend + 2;
    if (glm::length(p - shape.centre) - shape.bound <= reach && Distance(shape, p) <= reach) near.push_back(shape);
  }
  return near;
}

}  // namespace omni::scenes
