#include <algorithm>

#include "tests/bench/collision/engine.h"

namespace omni::collision {
namespace {

struct F3 {
  float x, y, z;
};
F3 operator-(const F3& a, const F3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
float Inner(const F3& a, const F3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
float LengthSquared(const F3& a) { return Inner(a, a); }
F3 Along(const F3& a, float s, const F3& d) { return {a.x + s * d.x, a.y + s * d.y, a.z + s * d.z}; }

}  // namespace

// [Ericson, Real-Time Collision Detection, 5.1.5], as Embree's own closest-point tutorial has it.
float NearestInFloat(const float (&a3)[3], const float (&b3)[3], const float (&c3)[3], const float (&p3)[3]) {
  const F3 a{a3[0], a3[1], a3[2]}, b{b3[0], b3[1], b3[2]}, c{c3[0], c3[1], c3[2]}, p{p3[0], p3[1], p3[2]};
  const F3 ab = b - a, ac = c - a, ap = p - a;
  const float d1 = Inner(ab, ap), d2 = Inner(ac, ap);
  if (d1 <= 0 && d2 <= 0) return LengthSquared(ap);
  const F3 bp = p - b;
  const float d3 = Inner(ab, bp), d4 = Inner(ac, bp);
  if (d3 >= 0 && d4 <= d3) return LengthSquared(bp);
  const F3 cp = p - c;
  const float d5 = Inner(ab, cp), d6 = Inner(ac, cp);
  if (d6 >= 0 && d5 <= d6) return LengthSquared(cp);
  const float vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return LengthSquared(p - Along(a, d1 / (d1 - d3), ab));
  const float vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return LengthSquared(p - Along(a, d2 / (d2 - d6), ac));
  const float va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    return LengthSquared(p - Along(b, (d4 - d3) / ((d4 - d3) + (d5 - d6)), c - b));
  }
  const float share = 1 / (va + vb + vc);
  return LengthSquared(p - Along(Along(a, vb * share, ab), vc * share, ac));
}

}  // namespace omni::collision
