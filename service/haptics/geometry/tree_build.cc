#include "service/haptics/geometry/tree.h"

#include <emmintrin.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cfloat>

namespace omni::haptics {
namespace {

constexpr std::uint32_t kBins = 16;
constexpr std::uint32_t kFullNode = kTreeWidth * kLeafSize;
constexpr std::uint32_t kSmall = kTreeWidth * kFullNode;  // parts this small are divided to fill nodes and leaves
constexpr int kSahLevels = 13;  // deeper nodes split by median: 13 + log8(4e6) < kMaxTreeDepth

struct FloatBox {
  __m128 lower = _mm_set1_ps(FLT_MAX), upper = _mm_set1_ps(-FLT_MAX);
  void Add(__m128 low, __m128 high) {
    lower = _mm_min_ps(lower, low);
    upper = _mm_max_ps(upper, high);
  }
  void Add(const FloatBox& b) { Add(b.lower, b.upper); }
};

// x y + y z + z x, 0 for the empty box.
float HalfArea(const FloatBox& box) {
  alignas(16) float d[4];
  _mm_store_ps(d, _mm_sub_ps(box.upper, box.lower));
  return d[0] >= 0 ? d[0] * d[1] + d[1] * d[2] + d[2] * d[0] : 0;
}

// The fourth lane is no coordinate and is cleared where something is computed: as a float it would be a denormal.
__m128 Lower(const TreePrimitive& p) { return _mm_load_ps(p.lower); }
__m128 Upper(const TreePrimitive& p) { return _mm_load_ps(p.upper); }
__m128 Centre2(const TreePrimitive& p) {  // twice the centre
  const __m128 coordinates = _mm_castsi128_ps(_mm_set_epi32(0, -1, -1, -1));
  return _mm_add_ps(_mm_and_ps(Lower(p), coordinates), _mm_and_ps(Upper(p), coordinates));
}
float Centre2(const TreePrimitive& p, int axis) { return p.lower[axis] + p.upper[axis]; }

struct TreePart {
  std::uint32_t begin = 0, end = 0;
  FloatBox box, centres;  // of the boxes, of twice their centres
  std::uint32_t Size() const { return end - begin; }
};

// Which of kBins slices of the range a primitive's centre lies in, for all three axes.
struct Binning {
  __m128 origin, scale;
  explicit Binning(const FloatBox& centres) : origin(centres.lower) {
    const __m128 extent = _mm_sub_ps(centres.upper, centres.lower);
    const __m128 wide = _mm_cmpgt_ps(extent, _mm_set1_ps(1e-30F));
    scale = _mm_and_ps(
        wide, _mm_div_ps(_mm_set1_ps(kBins), _mm_or_ps(_mm_and_ps(wide, extent), _mm_andnot_ps(wide, _mm_set1_ps(1)))));
  }
  __m128i Of(const TreePrimitive& p) const {
    const __m128 x = _mm_mul_ps(_mm_sub_ps(Centre2(p), origin), scale);
    return _mm_cvttps_epi32(_mm_min_ps(_mm_max_ps(x, _mm_setzero_ps()), _mm_set1_ps(kBins - 1)));
  }
};

struct TreeSplit {
  int axis = -1;
  int bin = 0;  // the last one of the left side
  std::uint32_t left = 0;
  float cost = FLT_MAX;
};

struct TreeBins {
  FloatBox box[3][kBins];
  std::uint32_t count[3][kBins]{};

  void Add(std::span<const TreePrimitive> primitives, const Binning& binning) {
    for (const TreePrimitive& p : primitives) {
      alignas(16) std::int32_t at[4];
      _mm_store_si128(reinterpret_cast<__m128i*>(at), binning.Of(p));
      const __m128 low = Lower(p), high = Upper(p);
      for (int axis = 0; axis < 3; ++axis) {
        box[axis][at[axis]].Add(low, high);
        ++count[axis][at[axis]];
      }
    }
  }

  // cost = A_left n_left + A_right n_right, n in leaves, least over 3 axes x 15 planes   [Wald 2007]   (1.5)
  TreeSplit Best() const {
    const auto leaves = [](std::uint32_t n) {
      const std::uint32_t whole = (n + kLeafSize - 1) / kLeafSize;
      return static_cast<float>(whole);
    };
    TreeSplit best;
    for (int axis = 0; axis < 3; ++axis) {
      std::array<float, kBins> right_cost{};
      FloatBox right;
      std::uint32_t n = 0;
      for (std::uint32_t k = kBins - 1; k > 0; --k) {
        right.Add(box[axis][k]);
        n += count[axis][k];
        right_cost[k - 1] = n > 0 ? HalfArea(right) * leaves(n) : FLT_MAX;
      }
      FloatBox left;
      n = 0;
      for (std::uint32_t k = 0; k + 1 < kBins; ++k) {
        left.Add(box[axis][k]);
        n += count[axis][k];
        if (n == 0 || right_cost[k] == FLT_MAX) continue;
        const float cost = HalfArea(left) * leaves(n) + right_cost[k];
        if (cost < best.cost) best = {axis, static_cast<int>(k), n, cost};
      }
    }
    return best;
  }
};

int LongestAxis(const FloatBox& box) {
  alignas(16) float d[4];
  _mm_store_ps(d, _mm_sub_ps(box.upper, box.lower));
  return d[0] >= d[1] && d[0] >= d[2] ? 0 : (d[1] >= d[2] ? 1 : 2);
}

class TreeBuilder {
 public:
  TreeBuilder(std::span<TreePrimitive> primitives, std::uint32_t first, std::vector<TreeNode>& nodes,
              const base::WorkWatch& watch)
      : primitives_(primitives), first_(first), nodes_(nodes), watch_(watch) {}

  BuiltTree Build() {
    const TreePart all = Measured(0, static_cast<std::uint32_t>(primitives_.size()));
    BuiltTree tree;
    tree.root = Append(all, 1);
    alignas(16) float corner[4];
    _mm_store_ps(corner, all.box.lower);
    std::copy_n(corner, 3, tree.lower);
    _mm_store_ps(corner, all.box.upper);
    std::copy_n(corner, 3, tree.upper);
    return tree;
  }

 private:
  // Recursion is as deep as the tree, at most kMaxTreeDepth.
  std::uint32_t Append(const TreePart& range, int level) {  // NOLINT(misc-no-recursion)
    const auto index = static_cast<std::uint32_t>(nodes_.size());
    nodes_.emplace_back();
    std::array<TreePart, kTreeWidth> parts;
    const std::size_t count = Divide(range, level, parts);
    TreeNode node;
    for (std::size_t k = 0; k < kTreeWidth; ++k) {
      PutBox(node, k, k < count ? parts[k].box : FloatBox{});
      node.child[k] = kNoChild;
      if (k >= count) continue;
      node.child[k] = parts[k].Size() <= kLeafSize ? Leaf(parts[k]) : Append(parts[k], level + 1);
    }
    nodes_[index] = node;
    return index;
  }

  // Splits the part with the largest box until there are eight. What fits into one leaf, or, under a larger node, into
  // one node full of leaves, stays whole: half-empty nodes cost memory and a visit each.
  std::size_t Divide(const TreePart& range, int level, std::array<TreePart, kTreeWidth>& parts) {
    const std::uint32_t whole = range.Size() <= kFullNode ? kLeafSize : kFullNode;
    parts[0] = range;
    std::size_t count = 1;
    while (count < kTreeWidth) {
      std::size_t widest = kTreeWidth;
      float area = -1;
      for (std::size_t k = 0; k < count; ++k) {
        if (parts[k].Size() <= whole) continue;
        // By median the largest counts, so that every level divides by eight.
        const float size = level <= kSahLevels ? HalfArea(parts[k].box) : static_cast<float>(parts[k].Size());
        if (size > area) {
          area = size;
          widest = k;
        }
      }
      if (widest == kTreeWidth) break;
      const auto [left, right] = SplitInTwo(parts[widest], level);
      // Keeps the parts in the order of their primitives.
      for (std::size_t k = count; k > widest + 1; --k) parts[k] = parts[k - 1];
      parts[widest] = left;
      parts[widest + 1] = right;
      ++count;
    }
    return count;
  }

  std::pair<TreePart, TreePart> SplitInTwo(const TreePart& range, int level) {
    watch_.Did(1 + range.Size() / 64);  // some nanoseconds each
    if (level > kSahLevels) return AtCount(range, LongestAxis(range.centres), range.Size() / 2);
    if (range.Size() <= 2 * kLeafSize) return AtCount(range, LongestAxis(range.centres), kLeafSize);
    const Binning binning(range.centres);
    TreeBins bins;
    bins.Add(primitives_.subspan(range.begin, range.Size()), binning);
    const TreeSplit split = bins.Best();
    if (split.axis < 0) return AtCount(range, LongestAxis(range.centres), range.Size() / 2);
    if (range.Size() <= kSmall) return AtCount(range, split.axis, split.left);
    return AtBin(range, binning, split);
  }

  std::pair<TreePart, TreePart> AtBin(const TreePart& range, const Binning& binning, const TreeSplit& split) {
    std::pair<TreePart, TreePart> parts;
    auto& [left, right] = parts;
    const auto is_left = [&](const TreePrimitive& p) {
      alignas(16) std::int32_t at[4];
      _mm_store_si128(reinterpret_cast<__m128i*>(at), binning.Of(p));
      return at[split.axis] <= split.bin;
    };
    std::uint32_t i = range.begin, j = range.end;
    while (true) {
      for (; i < j && is_left(primitives_[i]); ++i) Grow(left, primitives_[i]);
      for (; i < j && !is_left(primitives_[j - 1]); --j) Grow(right, primitives_[j - 1]);
      if (i >= j) break;
      std::swap(primitives_[i], primitives_[j - 1]);
    }
    left.begin = range.begin;
    left.end = right.begin = i;
    right.end = range.end;
    return parts;
  }

  // The `left` primitives with the smallest centres on one side; about so many, so that leaves are full where
  // primitives are few, and no more nodes of leaves are needed than before.
  std::pair<TreePart, TreePart> AtCount(const TreePart& range, int axis, std::uint32_t left) {
    const std::uint32_t n = range.Size();
    left = WholeLeaves(left, kLeafSize, n - 1);
    if (n > kFullNode && n <= kSmall) {
      const std::uint32_t nodes = (n + kFullNode - 1) / kFullNode;
      const std::uint32_t on_left = std::clamp((left + kFullNode / 2) / kFullNode, 1U, nodes - 1);
      const std::uint32_t most_right = (nodes - on_left) * kFullNode;
      left = WholeLeaves(left, n > most_right ? n - most_right : 1, on_left * kFullNode);
    }
    TreePrimitive* const first = primitives_.data() + range.begin;
    std::nth_element(first, first + left, first + n, [axis](const TreePrimitive& a, const TreePrimitive& b) {
      const float x = Centre2(a, axis), y = Centre2(b, axis);
      return x != y ? x < y : a.triangle < b.triangle;
    });
    return {Measured(range.begin, range.begin + left), Measured(range.begin + left, range.end)};
  }

  // The multiple of kLeafSize next to `wanted` within [least, most]; precondition: there is one.
  static std::uint32_t WholeLeaves(std::uint32_t wanted, std::uint32_t least, std::uint32_t most) {
    const auto leaves = [](std::uint32_t n) { return n / kLeafSize; };
    return kLeafSize * std::clamp(leaves(wanted + kLeafSize / 2), leaves(least + kLeafSize - 1), leaves(most));
  }

  static void Grow(TreePart& range, const TreePrimitive& p) {
    range.box.Add(Lower(p), Upper(p));
    const __m128 centre = Centre2(p);
    range.centres.Add(centre, centre);
  }

  TreePart Measured(std::uint32_t begin, std::uint32_t end) const {
    TreePart range;
    range.begin = begin;
    range.end = end;
    for (std::uint32_t i = begin; i < end; ++i) Grow(range, primitives_[i]);
    return range;
  }

  static void PutBox(TreeNode& node, std::size_t k, const FloatBox& box) {
    alignas(16) float low[4], high[4];
    _mm_store_ps(low, box.lower);
    _mm_store_ps(high, box.upper);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      node.lower[axis][k] = low[axis];
      node.upper[axis][k] = high[axis];
    }
  }

  std::uint32_t Leaf(const TreePart& range) const {
    const auto leaf = primitives_.subspan(range.begin, range.Size());
    const bool moves = std::any_of(leaf.begin(), leaf.end(), [](const TreePrimitive& p) { return p.moves != 0; });
    return LeafRange{first_ + range.begin, range.Size(), moves}.Child();
  }

  std::span<TreePrimitive> primitives_;
  const std::uint32_t first_;
  std::vector<TreeNode>& nodes_;
  const base::WorkWatch& watch_;
};

}  // namespace

TreePrimitive MakePrimitive(std::span<const Vec3> points, std::uint32_t triangle, bool moves) {
  TreePrimitive p{{FLT_MAX, FLT_MAX, FLT_MAX}, triangle, {-FLT_MAX, -FLT_MAX, -FLT_MAX}, moves ? 1U : 0U};
  for (const Vec3& v : points) {
    const float x[3] = {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
    for (std::size_t k = 0; k < 3; ++k) {
      p.lower[k] = std::min(p.lower[k], x[k]);
      p.upper[k] = std::max(p.upper[k], x[k]);
    }
  }
  for (std::size_t k = 0; k < 3; ++k) {  // 2^-23 |x| is one to two units in the last place, rounding took at most half
    p.lower[k] -= 0x1p-23F * std::abs(p.lower[k]) + 1e-30F;
    p.upper[k] += 0x1p-23F * std::abs(p.upper[k]) + 1e-30F;
  }
  return p;
}

BuiltTree AppendTree(std::span<TreePrimitive> primitives, std::uint32_t first, std::vector<TreeNode>& nodes,
                     const base::WorkWatch& watch) {
  nodes.reserve(nodes.size() + primitives.size() / 18 + 1);
  return TreeBuilder(primitives, first, nodes, watch).Build();
}

}  // namespace omni::haptics
