#include "tests/bench/collision/oracle.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace omni::collision {
namespace {

using Three = std::array<Vec3, 3>;

double Along(const Vec3& v, int axis) { return axis == 0 ? v.x : (axis == 1 ? v.y : v.z); }

double BoxDistanceSquared(const Vec3& lower, const Vec3& upper, const Vec3& p) {
  const Vec3 d = Max(Max(lower - p, p - upper), Vec3{});
  return SquaredNorm(d);
}

// Does the upward line through p cross the triangle's shadow? By the half-open rule, so that of two triangles at an
// edge exactly one counts; an edge's crossing is computed from its lower end for either triangle.
bool ShadowHolds(const Three& c, double x, double y) {
  bool inside = false;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 *a = &c[k], *b = &c[(k + 1) % 3];
    if ((a->y > y) == (b->y > y)) continue;
    if (a->y > b->y) std::swap(a, b);
    if (x < a->x + (y - a->y) / (b->y - a->y) * (b->x - a->x)) inside = !inside;
  }
  return inside;
}

bool Above(const Three& c, const Vec3& p) {
  const Vec3 n = Cross(c[1] - c[0], c[2] - c[0]);
  return n.z != 0 && Dot(n, c[0] - p) / n.z > 0;
}

}  // namespace

Oracle::Oracle(const Body& body) : body_(body) {
  std::vector<Vec3> centres;
  for (const auto& t : body.triangles) {
    centres.push_back((1.0 / 3) * (body.vertices[t[0]] + body.vertices[t[1]] + body.vertices[t[2]]));
  }
  order_.resize(centres.size());
  std::iota(order_.begin(), order_.end(), 0U);
  Build(0, static_cast<std::uint32_t>(order_.size()), centres);
  for (const std::uint32_t t : order_) {
    const auto& v = body.triangles[t];
    corners_.push_back({body.vertices[v[0]], body.vertices[v[1]], body.vertices[v[2]]});
  }
}

std::uint32_t Oracle::Build(std::uint32_t begin, std::uint32_t end, std::span<const Vec3> centres) {
  const auto index = static_cast<std::uint32_t>(nodes_.size());
  nodes_.push_back({{1e30, 1e30, 1e30}, {-1e30, -1e30, -1e30}, begin, end, 0});
  Node node = nodes_.back();
  for (std::uint32_t i = begin; i < end; ++i) {
    for (const std::uint32_t v : body_.triangles[order_[i]]) {
      node.lower = Min(node.lower, body_.vertices[v]);
      node.upper = Max(node.upper, body_.vertices[v]);
    }
  }
  if (end - begin > 4) {
    const Vec3 d = node.upper - node.lower;
    const int axis = d.x >= d.y && d.x >= d.z ? 0 : (d.y >= d.z ? 1 : 2);
    const std::uint32_t middle = begin + (end - begin) / 2;
    std::nth_element(
        order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
        [&](std::uint32_t a, std::uint32_t b) { return Along(centres[a], axis) < Along(centres[b], axis); });
    Build(begin, middle, centres);
    node.right = Build(middle, end, centres);
  }
  nodes_[index] = node;
  return index;
}

Nearest Oracle::NearestTo(const Vec3& p, std::uint32_t hint) const {
  Nearest best;
  const auto consider = [&](const Three& c, std::uint32_t triangle) {
    const Vec3 q = NearestOnTriangle(c, p);
    const double d = SquaredNorm(p - q);
    if (d < best.distance_squared) best = {d, q, triangle};
  };
  const auto& v = body_.triangles[hint];
  consider({body_.vertices[v[0]], body_.vertices[v[1]], body_.vertices[v[2]]}, hint);
  std::array<std::uint32_t, 64> stack{};
  std::size_t size = 1;
  while (size > 0) {
    const std::uint32_t index = stack[--size];
    const Node& node = nodes_[index];
    if (BoxDistanceSquared(node.lower, node.upper, p) >= best.distance_squared) continue;
    if (node.right == 0) {
      for (std::uint32_t i = node.begin; i < node.end; ++i) consider(corners_[i], order_[i]);
      continue;
    }
    const Node &left = nodes_[index + 1], &right = nodes_[node.right];
    const bool right_first =
        BoxDistanceSquared(right.lower, right.upper, p) < BoxDistanceSquared(left.lower, left.upper, p);
    stack[size++] = right_first ? index + 1 : node.right;
    stack[size++] = right_first ? node.right : index + 1;
  }
  return best;
}

bool Oracle::IsInside(const Vec3& p) const {
  bool inside = false;
  std::array<std::uint32_t, 64> stack{};
  std::size_t size = 1;
  while (size > 0) {
    const std::uint32_t index = stack[--size];
    const Node& node = nodes_[index];
    if (p.x < node.lower.x || p.x > node.upper.x || p.y < node.lower.y || p.y > node.upper.y || p.z > node.upper.z) {
      continue;
    }
    if (node.right == 0) {
      for (std::uint32_t i = node.begin; i < node.end; ++i) {
        if (ShadowHolds(corners_[i], p.x, p.y) && Above(corners_[i], p)) inside = !inside;
      }
      continue;
    }
    stack[size++] = index + 1;
    stack[size++] = node.right;
  }
  return inside;
}

double Oracle::RayLength(const Vec3& from, const Vec3& direction) const {
  double best = 1e300;
  std::array<std::uint32_t, 64> stack{};
  std::size_t size = 1;
  while (size > 0) {
    const std::uint32_t index = stack[--size];
    const Node& node = nodes_[index];
    double enter = 0, leave = best;
    for (int axis = 0; axis < 3; ++axis) {
      const double inverse = 1 / Along(direction, axis);
      const double t0 = (Along(node.lower, axis) - Along(from, axis)) * inverse;
      const double t1 = (Along(node.upper, axis) - Along(from, axis)) * inverse;
      enter = std::max(enter, std::min(t0, t1));
      leave = std::min(leave, std::max(t0, t1));
    }
    if (enter > leave) continue;
    if (node.right != 0) {
      stack[size++] = index + 1;
      stack[size++] = node.right;
      continue;
    }
    for (std::uint32_t i = node.begin; i < node.end; ++i) {  // [Moeller & Trumbore 1997]
      const Three& c = corners_[i];
      const Vec3 e1 = c[1] - c[0], e2 = c[2] - c[0], h = Cross(direction, e2), s = from - c[0], q = Cross(s, e1);
      const double a = Dot(e1, h);
      if (a == 0) continue;
      const double u = Dot(s, h) / a, v = Dot(direction, q) / a, t = Dot(e2, q) / a;
      if (u >= 0 && v >= 0 && u + v <= 1 && t > 1e-7 && t < best) best = t;
    }
  }
  return best;
}

}  // namespace omni::collision
