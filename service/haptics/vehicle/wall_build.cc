#include "service/haptics/vehicle/wall_map.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "service/haptics/scene/check_scene.h"
#include "service/haptics/scene/scene.h"

namespace omni::haptics {
namespace {

constexpr std::uint32_t kLeafSegments = 4;

struct Point {
  double x, y;
};

// Where an edge cuts the plane. The same bits from both of its triangles: always from its lower end.
Point CutEdge(const Vertex& a, const Vertex& b, double z) {
  const Vertex& low = a.z < b.z ? a : b;
  const Vertex& high = a.z < b.z ? b : a;
  const double share = (z - low.z) / (high.z - low.z);
  return {low.x + share * (high.x - low.x), low.y + share * (high.y - low.y)};
}

void CutTriangle(const SceneParts& parts, const Triangle& triangle, double z, std::vector<WallSegment>& segments) {
  Point ends[2];
  int found = 0;
  for (int k = 0; k < 3; ++k) {
    const Vertex& a = parts.vertices[triangle.vertex[k]];
    const Vertex& b = parts.vertices[triangle.vertex[(k + 1) % 3]];
    if ((a.z < z) != (b.z < z) && found < 2) ends[found++] = CutEdge(a, b, z);
  }
  if (found == 2) segments.push_back({ends[0].x, ends[0].y, ends[1].x, ends[1].y, triangle.material, 0});
}

float RoundedDown(double x) { return std::nextafter(static_cast<float>(x), -std::numeric_limits<float>::infinity()); }
float RoundedUp(double x) { return std::nextafter(static_cast<float>(x), std::numeric_limits<float>::infinity()); }

// Halves the segments at the median of the longer side, so that the depth is that of a balanced tree.
class TreeBuilder {
 public:
  TreeBuilder(SceneParts& parts, const base::WorkWatch& watch)
      : segments_(parts.wall_segments), nodes_(parts.wall_nodes), watch_(watch) {}

  void Build() {
    if (segments_.empty()) return;
    nodes_.push_back({});
    Fill(0, 0, static_cast<std::uint32_t>(segments_.size()));
  }

 private:
  void Fill(std::size_t at, std::uint32_t first, std::uint32_t last) {
    WallNode node = Around(first, last);
    if (last - first <= kLeafSegments) {
      node.first = first;
      node.count = last - first;
      nodes_[at] = node;
      return;
    }
    const bool by_x = node.upper[0] - node.lower[0] > node.upper[1] - node.lower[1];
    const std::uint32_t middle = first + (last - first) / 2;
    const auto place = [by_x](const WallSegment& s) { return by_x ? s.ax + s.bx : s.ay + s.by; };
    std::stable_sort(segments_.begin() + first, segments_.begin() + last,
                     [&](const WallSegment& a, const WallSegment& b) {
                       watch_.Did();
                       return place(a) < place(b);
                     });
    node.first = static_cast<std::uint32_t>(nodes_.size());
    node.count = 0;
    nodes_[at] = node;
    nodes_.resize(nodes_.size() + 2);
    Fill(node.first, first, middle);
    Fill(node.first + 1, middle, last);
  }

  WallNode Around(std::uint32_t first, std::uint32_t last) const {
    double lower[2] = {1e30, 1e30}, upper[2] = {-1e30, -1e30};
    for (std::uint32_t i = first; i < last; ++i) {
      const WallSegment& s = segments_[i];
      lower[0] = std::min({lower[0], s.ax, s.bx});
      lower[1] = std::min({lower[1], s.ay, s.by});
      upper[0] = std::max({upper[0], s.ax, s.bx});
      upper[1] = std::max({upper[1], s.ay, s.by});
    }
    return {{RoundedDown(lower[0]), RoundedDown(lower[1])}, {RoundedUp(upper[0]), RoundedUp(upper[1])}, 0, 0};
  }

  std::vector<WallSegment>& segments_;
  std::vector<WallNode>& nodes_;
  const base::WorkWatch& watch_;
};

std::string Millimetres(double metres) { return NumberText(1e3 * metres) + " mm"; }

}  // namespace

void BuildWalls(SceneParts& parts, const base::WorkWatch& watch) {
  if (parts.header.has_vehicle == 0) return;
  const double z = parts.header.vehicle.start_base_m.z;
  for (const Object& object : parts.objects) {
    if ((object.flags & kCarWall) == 0) continue;
    for (std::uint32_t t = 0; t < object.triangle_count; ++t) {
      watch.Did();
      CutTriangle(parts, parts.triangles[object.first_triangle + t], z, parts.wall_segments);
    }
  }
  TreeBuilder(parts, watch).Build();
}

std::vector<std::string> ExplainWalls(const Scene& scene) {
  std::vector<std::string> lines;
  if (scene.header().has_vehicle == 0) return lines;
  const VehicleInput& car = scene.header().vehicle;
  const WallMap walls = WallsOf(scene);
  if (walls.segments.empty()) {
    lines.emplace_back("vehicle: no car wall at its height; it can drive anywhere");
    return lines;
  }
  lines.push_back("vehicle: " + std::to_string(walls.segments.size()) + " wall segments at its height, " +
                  std::to_string(car.checkpoint_count) + " checkpoints");
  const Wall start = NearestWall(walls, car.start_base_m, car.radius_m);
  if (start.found) {
    lines.push_back("vehicle: starts " + Millimetres(start.distance_m) + " from a car wall, its radius is " +
                    Millimetres(car.radius_m) + "; move the start or the wall");
  }
  for (int k = 0; k < car.checkpoint_count; ++k) {
    if (!NearestWall(walls, car.checkpoints[static_cast<std::size_t>(k)].position_base_m, car.radius_m).found) continue;
    lines.push_back("checkpoint " + std::to_string(k) + ": its middle is nearer to a car wall than the car's radius; " +
                    "move it to the middle of the road");
  }
  return lines;
}

}  // namespace omni::haptics
