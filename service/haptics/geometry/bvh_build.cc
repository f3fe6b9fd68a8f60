#include "service/haptics/geometry/bvh_build.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace omni::haptics {
namespace {

constexpr std::uint32_t kLeafSize = 4;
constexpr int kBins = 16;
constexpr int kSahDepth = 36;  // deeper splits are by median: 36 + log2(kMaxTriangles) < kMaxBvhDepth

double Axis(const Vec3& v, int axis) { return axis == 0 ? v.x : (axis == 1 ? v.y : v.z); }

double HalfArea(const Box& b) {
  const Vec3 d = b.upper - b.lower;
  return d.x >= 0 ? d.x * d.y + d.y * d.z + d.z * d.x : 0;
}

float RoundDown(double x) {
  const auto f = static_cast<float>(x);
  return double{f} <= x ? f : std::nextafter(f, -std::numeric_limits<float>::infinity());
}

float RoundUp(double x) {
  const auto f = static_cast<float>(x);
  return double{f} >= x ? f : std::nextafter(f, std::numeric_limits<float>::infinity());
}

struct Split {
  int axis = -1;
  int bin = 0;
  double cost = std::numeric_limits<double>::infinity();
};

struct Bin {
  Box box;
  std::uint32_t count = 0;
};

class Builder {
 public:
  Builder(const std::vector<Box>& boxes, std::uint32_t first_triangle, std::vector<BvhNode>& nodes,
          std::vector<std::uint32_t>& leaves)
      : boxes_(boxes), first_triangle_(first_triangle), nodes_(nodes), leaves_(leaves), order_(boxes.size()) {
    std::iota(order_.begin(), order_.end(), 0U);
    centres_.reserve(boxes.size());
    for (const Box& b : boxes) centres_.push_back(0.5 * (b.lower + b.upper));
  }

  std::uint32_t Build() {
    const auto root = static_cast<std::uint32_t>(nodes_.size());
    nodes_.emplace_back();
    Fill(root, 0, static_cast<std::uint32_t>(order_.size()), 0);
    return root;
  }

 private:
  // Recursion is as deep as the tree, at most kMaxBvhDepth.
  void Fill(std::uint32_t node, std::uint32_t begin, std::uint32_t end, int depth) {  // NOLINT(misc-no-recursion)
    Box box, centres;
    for (std::uint32_t i = begin; i < end; ++i) {
      box.Add(boxes_[order_[i]]);
      centres.Add(centres_[order_[i]]);
    }
    BvhNode filled{{RoundDown(box.lower.x), RoundDown(box.lower.y), RoundDown(box.lower.z)},
                   0,
                   {RoundUp(box.upper.x), RoundUp(box.upper.y), RoundUp(box.upper.z)},
                   0};
    if (end - begin <= kLeafSize) {
      filled.first = static_cast<std::uint32_t>(leaves_.size());
      filled.count = end - begin;
      for (std::uint32_t i = begin; i < end; ++i) leaves_.push_back(first_triangle_ + order_[i]);
      nodes_[node] = filled;
      return;
    }
    const std::uint32_t middle = Partition(begin, end, centres, depth);
    filled.first = static_cast<std::uint32_t>(nodes_.size());
    nodes_[node] = filled;
    nodes_.emplace_back();
    nodes_.emplace_back();
    Fill(filled.first, begin, middle, depth + 1);
    Fill(filled.first + 1, middle, end, depth + 1);
  }

  std::uint32_t Partition(std::uint32_t begin, std::uint32_t end, const Box& centres, int depth) {
    const Split split = depth < kSahDepth ? BestSplit(begin, end, centres) : Split{};
    if (split.axis < 0) return Median(begin, end, centres);
    const auto middle = std::partition(order_.begin() + begin, order_.begin() + end, [&](std::uint32_t t) {
      return BinOf(centres_[t], centres, split.axis) <= split.bin;
    });
    return static_cast<std::uint32_t>(middle - order_.begin());
  }

  std::uint32_t Median(std::uint32_t begin, std::uint32_t end, const Box& centres) {
    const Vec3 d = centres.upper - centres.lower;
    const int axis = d.x >= d.y && d.x >= d.z ? 0 : (d.y >= d.z ? 1 : 2);
    const std::uint32_t middle = begin + (end - begin) / 2;
    std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                     [&](std::uint32_t a, std::uint32_t b) {
                       const double x = Axis(centres_[a], axis), y = Axis(centres_[b], axis);
                       return x != y ? x < y : a < b;
                     });
    return middle;
  }

  static int BinOf(const Vec3& centre, const Box& centres, int axis) {
    const double lower = Axis(centres.lower, axis);
    const double extent = Axis(centres.upper, axis) - lower;
    return std::min(kBins - 1, static_cast<int>(kBins * (Axis(centre, axis) - lower) / extent));
  }

  // cost = A_left n_left + A_right n_right, least over 3 axes x 15 planes   [Wald 2007]
  Split BestSplit(std::uint32_t begin, std::uint32_t end, const Box& centres) const {
    Split best;
    for (int axis = 0; axis < 3; ++axis) {
      if (!(Axis(centres.upper, axis) - Axis(centres.lower, axis) > 0)) continue;
      std::array<Bin, kBins> bins;
      for (std::uint32_t i = begin; i < end; ++i) {
        Bin& bin = bins[static_cast<std::size_t>(BinOf(centres_[order_[i]], centres, axis))];
        bin.box.Add(boxes_[order_[i]]);
        ++bin.count;
      }
      std::array<double, kBins> right_cost{};
      Bin right;
      for (std::size_t k = kBins - 1; k > 0; --k) {
        right.box.Add(bins[k].box);
        right.count += bins[k].count;
        right_cost[k - 1] =
            right.count > 0 ? HalfArea(right.box) * right.count : std::numeric_limits<double>::infinity();
      }
      Bin left;
      for (std::size_t k = 0; k + 1 < kBins; ++k) {
        left.box.Add(bins[k].box);
        left.count += bins[k].count;
        if (left.count == 0) continue;
        const double cost = HalfArea(left.box) * left.count + right_cost[k];
        if (cost < best.cost) best = {axis, static_cast<int>(k), cost};
      }
    }
    return best;
  }

  const std::vector<Box>& boxes_;
  std::uint32_t first_triangle_;
  std::vector<BvhNode>& nodes_;
  std::vector<std::uint32_t>& leaves_;
  std::vector<std::uint32_t> order_;
  std::vector<Vec3> centres_;
};

}  // namespace

std::uint32_t AppendBvh(const std::vector<Box>& boxes, std::uint32_t first_triangle, std::vector<BvhNode>& nodes,
                        std::vector<std::uint32_t>& leaf_triangles) {
  return Builder(boxes, first_triangle, nodes, leaf_triangles).Build();
}

}  // namespace omni::haptics
