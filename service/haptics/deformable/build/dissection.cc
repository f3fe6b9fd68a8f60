#include "service/haptics/deformable/build/dissection.h"

namespace omni::haptics {
namespace {

constexpr std::size_t kSmallSet = 24;

double Coordinate(const Vec3& v, int axis) { return axis == 0 ? v.x : (axis == 1 ? v.y : v.z); }

struct Dissection {
  const std::vector<Vec3>& position;
  const std::vector<std::vector<std::uint32_t>>& neighbours;
  std::vector<std::uint32_t> side;  // of every node: 2 call + half
  std::vector<std::uint32_t> order;
  std::uint32_t calls = 0;

  int LongestAxis(const std::vector<std::uint32_t>& nodes) const {
    Vec3 lower = position[nodes[0]];
    Vec3 upper = lower;
    for (const std::uint32_t n : nodes) {
      lower = Min(lower, position[n]);
      upper = Max(upper, position[n]);
    }
    const Vec3 e = upper - lower;
    return e.x >= e.y && e.x >= e.z ? 0 : (e.y >= e.z ? 1 : 2);
  }

  // Halves first, then the nodes of the lower half that touch the upper one.
  void Run(std::vector<std::uint32_t> nodes) {
    if (nodes.size() <= kSmallSet) {
      order.insert(order.end(), nodes.begin(), nodes.end());
      return;
    }
    const int axis = LongestAxis(nodes);
    const auto middle = nodes.begin() + static_cast<std::ptrdiff_t>(nodes.size() / 2);
    std::nth_element(nodes.begin(), middle, nodes.end(), [&](std::uint32_t a, std::uint32_t b) {
      const double ca = Coordinate(position[a], axis);
      const double cb = Coordinate(position[b], axis);
      return ca < cb || (ca == cb && a < b);
    });
    const std::uint32_t upper_mark = 2 * ++calls + 1;
    std::vector<std::uint32_t> upper(middle, nodes.end());
    for (const std::uint32_t n : upper) side[n] = upper_mark;
    std::vector<std::uint32_t> lower;
    std::vector<std::uint32_t> between;
    for (auto n = nodes.begin(); n != middle; ++n) {
      const auto& around = neighbours[*n];
      const bool touches =
          std::any_of(around.begin(), around.end(), [&](std::uint32_t m) { return side[m] == upper_mark; });
      (touches ? between : lower).push_back(*n);
    }
    nodes = {};
    Run(std::move(lower));
    Run(std::move(upper));
    order.insert(order.end(), between.begin(), between.end());
  }
};

}  // namespace

std::vector<std::uint32_t> DissectionOrder(const std::vector<Vec3>& position, std::vector<std::uint32_t> nodes,
                                           const std::vector<std::vector<std::uint32_t>>& neighbours) {
  Dissection dissection{position, neighbours, std::vector<std::uint32_t>(position.size(), 0), {}, 0};
  dissection.order.reserve(nodes.size());
  dissection.Run(std::move(nodes));
  return std::move(dissection.order);
}

}  // namespace omni::haptics
