// The float half of queries, four lanes at a time (SSE2, which every x86-64 has): what these exclude is excluded for
// certain, because every bound is widened by a slack that covers all roundings. docs/theory/haptics.md (1.6)-(1.9)
#pragma once

#include <emmintrin.h>

#include <algorithm>
#include <array>
#include <cfloat>
#include <cmath>

#include "service/base/vec.h"
#include "service/haptics/geometry/tree.h"

namespace omni::haptics {

using base::Vec3;

// (1.6) Coordinates up to S (of the tree and of the query) and a dozen float operations: an error of at most
// 16 x 2^-24 S in any distance. Twice that is taken.
inline double FloatSlack(double tree_extent_m, double query_extent_m) noexcept {
  return 0x1p-19 * (tree_extent_m + query_extent_m) + 1e-30;
}

inline double LargestComponent(const Vec3& v) noexcept {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

struct Lanes3 {
  __m128 x, y, z;
};

inline Lanes3 Broadcast(const Vec3& v) noexcept {
  return {_mm_set1_ps(static_cast<float>(v.x)), _mm_set1_ps(static_cast<float>(v.y)),
          _mm_set1_ps(static_cast<float>(v.z))};
}
inline Lanes3 operator-(const Lanes3& a, const Lanes3& b) noexcept {
  return {_mm_sub_ps(a.x, b.x), _mm_sub_ps(a.y, b.y), _mm_sub_ps(a.z, b.z)};
}
inline __m128 Dot(const Lanes3& a, const Lanes3& b) noexcept {
  return _mm_add_ps(_mm_add_ps(_mm_mul_ps(a.x, b.x), _mm_mul_ps(a.y, b.y)), _mm_mul_ps(a.z, b.z));
}
inline __m128 Abs(__m128 a) noexcept { return _mm_andnot_ps(_mm_set1_ps(-0.0F), a); }
inline __m128 Select(__m128 mask, __m128 yes, __m128 no) noexcept {
  return _mm_or_ps(_mm_and_ps(mask, yes), _mm_andnot_ps(mask, no));
}

// A distance (>= 0, m) against which float distances are compared: nothing nearer than `distance_m` exceeds it.
inline float SquaredBound(double distance_m, double slack_m) noexcept {
  const double d = (distance_m + slack_m) * (1 + 0x1p-20);
  const double squared = d * d * (1 + 0x1p-20);
  return squared < double{FLT_MAX} ? static_cast<float>(squared) : FLT_MAX;
}

// Squared distance of a point to four of the node's boxes, 0 inside; infinite for unused children.
inline __m128 BoxDistanceSquared(const TreeNode& node, int half, const Lanes3& p) noexcept {
  const auto outside = [&](int axis, __m128 x) noexcept {
    const __m128 below = _mm_sub_ps(_mm_load_ps(node.lower[axis] + 4 * half), x);
    const __m128 above = _mm_sub_ps(x, _mm_load_ps(node.upper[axis] + 4 * half));
    const __m128 d = _mm_max_ps(_mm_max_ps(below, above), _mm_setzero_ps());
    return _mm_mul_ps(d, d);
  };
  return _mm_add_ps(_mm_add_ps(outside(0, p.x), outside(1, p.y)), outside(2, p.z));
}

// A segment as boxes see it: middle, half its vector, both widened by the slack.
struct SegmentLanes {
  Lanes3 middle, half, reach;  // reach = |half| + slack
  __m128 slack;
  SegmentLanes(const Vec3& start, const Vec3& end, double tree_extent_m) noexcept
      : middle(Broadcast(0.5 * (start + end))), half(Broadcast(0.5 * (end - start))) {
    const double extent_m = std::max(LargestComponent(start), LargestComponent(end));
    slack = _mm_set1_ps(static_cast<float>(FloatSlack(tree_extent_m, extent_m)));
    reach = {_mm_add_ps(Abs(half.x), slack), _mm_add_ps(Abs(half.y), slack), _mm_add_ps(Abs(half.z), slack)};
  }
};

// Lanes in which the segment may intersect the box, by separating axes   [Ericson 5.3.3]. Positive comparisons: the
// boxes of unused children give NaN and are not intersected.
inline __m128 MayMeet(const SegmentLanes& s, const Lanes3& lower, const Lanes3& upper) noexcept {
  const __m128 one_half = _mm_set1_ps(0.5F);
  const auto middle = [&](__m128 m, __m128 low, __m128 high) noexcept {
    return _mm_sub_ps(m, _mm_mul_ps(one_half, _mm_add_ps(low, high)));
  };
  const auto extent = [&](__m128 low, __m128 high) noexcept {
    return _mm_add_ps(_mm_mul_ps(one_half, _mm_sub_ps(high, low)), s.slack);
  };
  const Lanes3 m{middle(s.middle.x, lower.x, upper.x), middle(s.middle.y, lower.y, upper.y),
                 middle(s.middle.z, lower.z, upper.z)};
  const Lanes3 e{extent(lower.x, upper.x), extent(lower.y, upper.y), extent(lower.z, upper.z)};
  const auto along = [](__m128 x, __m128 box, __m128 segment) noexcept {
    return _mm_cmple_ps(Abs(x), _mm_add_ps(box, segment));
  };
  const auto across = [](__m128 my, __m128 hz, __m128 mz, __m128 hy, __m128 ey, __m128 rz, __m128 ez,
                         __m128 ry) noexcept {
    const __m128 gap = Abs(_mm_sub_ps(_mm_mul_ps(my, hz), _mm_mul_ps(mz, hy)));
    return _mm_cmple_ps(gap, _mm_add_ps(_mm_mul_ps(ey, rz), _mm_mul_ps(ez, ry)));
  };
  __m128 meet = _mm_and_ps(along(m.x, e.x, s.reach.x), along(m.y, e.y, s.reach.y));
  meet = _mm_and_ps(meet, along(m.z, e.z, s.reach.z));
  meet = _mm_and_ps(meet, across(m.y, s.half.z, m.z, s.half.y, e.y, s.reach.z, e.z, s.reach.y));
  meet = _mm_and_ps(meet, across(m.z, s.half.x, m.x, s.half.z, e.z, s.reach.x, e.x, s.reach.z));
  return _mm_and_ps(meet, across(m.x, s.half.y, m.y, s.half.x, e.x, s.reach.y, e.y, s.reach.x));
}

inline Lanes3 LoadAxes(const float (&box)[3][kTreeWidth], int half) noexcept {
  return {_mm_load_ps(box[0] + 4 * half), _mm_load_ps(box[1] + 4 * half), _mm_load_ps(box[2] + 4 * half)};
}

// Children whose box the segment may intersect, one bit each.
inline int MeetMask(const TreeNode& node, const SegmentLanes& s) noexcept {
  const __m128 low = MayMeet(s, LoadAxes(node.lower, 0), LoadAxes(node.upper, 0));
  const __m128 high = MayMeet(s, LoadAxes(node.lower, 1), LoadAxes(node.upper, 1));
  return _mm_movemask_ps(low) | _mm_movemask_ps(high) << 4;
}

// Children whose box meets the box, one bit each.
inline int MeetMask(const TreeNode& node, const std::array<float, 3>& lower,
                    const std::array<float, 3>& upper) noexcept {
  int mask = 0;
  for (int half = 0; half < 2; ++half) {
    __m128 meet = _mm_castsi128_ps(_mm_set1_epi32(-1));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const __m128 low = _mm_load_ps(node.lower[axis] + 4 * half), high = _mm_load_ps(node.upper[axis] + 4 * half);
      meet = _mm_and_ps(
          meet, _mm_and_ps(_mm_cmple_ps(low, _mm_set1_ps(upper[axis])), _mm_cmpge_ps(high, _mm_set1_ps(lower[axis]))));
    }
    mask |= _mm_movemask_ps(meet) << 4 * half;
  }
  return mask;
}

// Four points (x, y, z), rounded to nearest, one per lane.
inline Lanes3 GatherPoints(const std::array<const double*, kLeafSize>& of) noexcept {
  const auto xy = [&](std::size_t k) noexcept { return _mm_cvtpd_ps(_mm_loadu_pd(of[k])); };
  const auto z = [&](std::size_t k) noexcept {
    return _mm_cvtpd_ps(_mm_loadh_pd(_mm_load_sd(of[k] + 2), of[k + 1] + 2));
  };
  const __m128 low = _mm_movelh_ps(xy(0), xy(1)), high = _mm_movelh_ps(xy(2), xy(3));
  return {_mm_shuffle_ps(low, high, _MM_SHUFFLE(2, 0, 2, 0)), _mm_shuffle_ps(low, high, _MM_SHUFFLE(3, 1, 3, 1)),
          _mm_movelh_ps(z(0), z(2))};
}

// The corners of a leaf's triangles, [corner], one triangle per lane; unused lanes repeat the last.
using LeafCorners = std::array<Lanes3, 3>;

// `place(triangle, k)`: x, y and z of its corner k.
template <class Place>
LeafCorners GatherCorners(const LeafRange& leaf, const Place& place) noexcept {
  LeafCorners corners;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto of = [&](std::uint32_t lane) noexcept { return place(leaf.first + std::min(lane, leaf.count - 1), k); };
    corners[k] = GatherPoints({of(0), of(1), of(2), of(3)});
  }
  return corners;
}

// Triangles whose box the segment may intersect, one bit per lane.
inline int MeetMask(const LeafCorners& corners, const SegmentLanes& s) noexcept {
  const auto& [a, b, c] = corners;
  const auto least = [](__m128 x, __m128 y, __m128 z) noexcept { return _mm_min_ps(_mm_min_ps(x, y), z); };
  const auto most = [](__m128 x, __m128 y, __m128 z) noexcept { return _mm_max_ps(_mm_max_ps(x, y), z); };
  return _mm_movemask_ps(MayMeet(s, {least(a.x, b.x, c.x), least(a.y, b.y, c.y), least(a.z, b.z, c.z)},
                                 {most(a.x, b.x, c.x), most(a.y, b.y, c.y), most(a.z, b.z, c.z)}));
}

// (1.8) What bounds the distance of p to each of four triangles. A nearest point q is computed in float as in (1.1);
// whatever its error, no point x of the triangle is nearer than min_k u . (v_k - p), u = (q - p) / |q - p|, because
// u . x is linear.
struct TriangleBounds {
  Lanes3 to_nearest;      // q - p
  __m128 least;           // min_k (q - p) . (v_k - p)
  __m128 length_squared;  // |q - p|^2
  // The bound squared; zero or not a number where nothing can be said.
  __m128 DistanceSquared() const noexcept {
    const __m128 squared = _mm_div_ps(_mm_mul_ps(least, least), length_squared);
    const __m128 sound =
        _mm_and_ps(_mm_cmpgt_ps(least, _mm_setzero_ps()), _mm_cmpgt_ps(length_squared, _mm_set1_ps(1e-30F)));
    return _mm_and_ps(sound, squared);
  }
};

inline TriangleBounds BoundTriangles(const LeafCorners& corners, const Lanes3& p) noexcept {
  const __m128 zero = _mm_setzero_ps(), one = _mm_set1_ps(1);
  const Lanes3 a = corners[0] - p, b = corners[1] - p, c = corners[2] - p;
  const Lanes3 ab = b - a, ac = c - a;
  const __m128 d1 = _mm_sub_ps(zero, Dot(ab, a)), d2 = _mm_sub_ps(zero, Dot(ac, a));
  const __m128 d3 = _mm_sub_ps(zero, Dot(ab, b)), d4 = _mm_sub_ps(zero, Dot(ac, b));
  const __m128 d5 = _mm_sub_ps(zero, Dot(ab, c)), d6 = _mm_sub_ps(zero, Dot(ac, c));
  const __m128 va = _mm_sub_ps(_mm_mul_ps(d3, d6), _mm_mul_ps(d5, d4));
  const __m128 vb = _mm_sub_ps(_mm_mul_ps(d5, d2), _mm_mul_ps(d1, d6));
  const __m128 vc = _mm_sub_ps(_mm_mul_ps(d1, d4), _mm_mul_ps(d3, d2));
  const auto both = [](__m128 x, __m128 y) noexcept { return _mm_and_ps(x, y); };
  // Weights v, w of b, c as fractions of one denominator: face, then edges, then corners overrule.
  __m128 v = vb, w = vc, sum = _mm_add_ps(_mm_add_ps(va, vb), vc);
  const __m128 on_bc = _mm_sub_ps(d4, d3), off_bc = _mm_sub_ps(d5, d6);
  __m128 at = both(_mm_cmple_ps(va, zero), both(_mm_cmpge_ps(on_bc, zero), _mm_cmpge_ps(off_bc, zero)));
  v = Select(at, off_bc, v);
  w = Select(at, on_bc, w);
  sum = Select(at, _mm_add_ps(on_bc, off_bc), sum);
  at = both(_mm_cmple_ps(vb, zero), both(_mm_cmpge_ps(d2, zero), _mm_cmple_ps(d6, zero)));
  v = _mm_andnot_ps(at, v);
  w = Select(at, d2, w);
  sum = Select(at, _mm_sub_ps(d2, d6), sum);
  at = both(_mm_cmple_ps(vc, zero), both(_mm_cmpge_ps(d1, zero), _mm_cmple_ps(d3, zero)));
  v = Select(at, d1, v);
  w = _mm_andnot_ps(at, w);
  sum = Select(at, _mm_sub_ps(d1, d3), sum);
  at = both(_mm_cmple_ps(d1, zero), _mm_cmple_ps(d2, zero));
  v = _mm_andnot_ps(at, v);
  w = _mm_andnot_ps(at, w);
  sum = Select(at, one, sum);
  at = both(_mm_cmpge_ps(d3, zero), _mm_cmple_ps(d4, d3));
  v = Select(at, one, v);
  w = _mm_andnot_ps(at, w);
  sum = Select(at, one, sum);
  at = both(_mm_cmpge_ps(d6, zero), _mm_cmple_ps(d5, d6));
  v = _mm_andnot_ps(at, v);
  w = Select(at, one, w);
  sum = Select(at, one, sum);
  const __m128 share = _mm_div_ps(one, sum);
  v = _mm_mul_ps(v, share);
  w = _mm_mul_ps(w, share);
  const auto mix = [&](__m128 from, __m128 by_b, __m128 by_c) noexcept {
    return _mm_add_ps(from, _mm_add_ps(_mm_mul_ps(v, by_b), _mm_mul_ps(w, by_c)));
  };
  const Lanes3 q{mix(a.x, ab.x, ac.x), mix(a.y, ab.y, ac.y), mix(a.z, ab.z, ac.z)};
  return {q, _mm_min_ps(_mm_min_ps(Dot(q, a), Dot(q, b)), Dot(q, c)), Dot(q, q)};
}

}  // namespace omni::haptics
