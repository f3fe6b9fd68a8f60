// A closed circuit with two walls, a car and a start line. The pen is a joystick above it.
#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <iterator>
#include <numbers>

#include "scenes/generator/models/scene_models.h"

namespace omni::scenes {
namespace {

constexpr double kRoad_m = 0.0398;   // height of the road's surface: the ground lies just over the hull
constexpr double kStick_m = 0.047;   // of the joystick: a gap of 11 mm, over posts and walls
constexpr double kMiddle_m = 0.003;  // of the circuit, in y: the stick moves inside its inner wall
constexpr double kRoadHalfWidth_m = 0.0065;
constexpr double kWallThickness_m = 0.0014, kWallHeight_m = 0.0034;
constexpr double kGround_m = -0.0006, kUnderside_m = -0.0018;  // over the road
constexpr int kAround = 128;

// Centre line: an ellipse with a waist and a bulge, all of one curvature's sign or gently of the other.
Vec Centre(double turn) {
  const double a = 2 * std::numbers::pi * turn;
  const double r = 1 - 0.13 * std::cos(3 * a + 0.6) - 0.05 * std::cos(2 * a);
  return {0.0395 * r * std::cos(a), 0.0240 * r * std::sin(a) + kMiddle_m, kRoad_m};
}

Vec Ahead(double turn) { return glm::normalize(Centre(turn + 1e-4) - Centre(turn - 1e-4)); }
Vec Left(double turn) {
  const Vec t = Ahead(turn);
  return {-t.y, t.x, 0};
}

// A ring of rectangular section between two offsets to the left of the centre line and two heights over the road.
Mesh Ring(double offset_from_m, double offset_to_m, double lower_m, double upper_m) {
  Mesh mesh;
  for (int i = 0; i < kAround; ++i) {
    const double turn = static_cast<double>(i) / kAround;
    const Vec near = Centre(turn) + Left(turn) * offset_from_m, far = Centre(turn) + Left(turn) * offset_to_m;
    for (const Vec& p :
         {near + Vec(0, 0, lower_m), far + Vec(0, 0, lower_m), far + Vec(0, 0, upper_m), near + Vec(0, 0, upper_m)}) {
      mesh.positions.push_back(p);
    }
  }
  for (std::uint32_t i = 0; i < kAround; ++i) {
    const std::uint32_t next = (i + 1) % kAround;
    for (std::uint32_t k = 0; k < 4; ++k) {
      const std::uint32_t a = 4 * i + k, b = 4 * i + (k + 1) % 4, c = 4 * next + (k + 1) % 4, d = 4 * next + k;
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({a, c, d});
    }
  }
  if (SignedVolume6(mesh) < 0) {
    for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
  }
  Weld(mesh);
  return mesh;
}

// A box with its upper face shrunk: `taper` in x and y.
Mesh Box(const Vec& lower, const Vec& upper, double taper_x, double taper_y) {
  Mesh mesh;
  const Vec centre = (lower + upper) * 0.5;
  for (int i = 0; i < 8; ++i) {
    Vec p((i & 1) != 0 ? upper.x : lower.x, (i & 2) != 0 ? upper.y : lower.y, (i & 4) != 0 ? upper.z : lower.z);
    if ((i & 4) != 0) p = {centre.x + (p.x - centre.x) * taper_x, centre.y + (p.y - centre.y) * taper_y, p.z};
    mesh.positions.push_back(p);
  }
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

Mesh Wheel(const Vec& centre, double radius, double half_width) {
  constexpr int kSides = 14;
  Mesh mesh;
  for (int i = 0; i < kSides; ++i) {
    const double a = 2 * std::numbers::pi * i / kSides;
    for (const double y : {-half_width, half_width}) {
      mesh.positions.push_back(centre + Vec(radius * std::cos(a), y, radius * std::sin(a)));
    }
  }
  for (std::uint32_t i = 0; i < kSides; ++i) {
    const std::uint32_t a = 2 * i, b = 2 * ((i + 1) % kSides);
    mesh.triangles.push_back({a, b, b + 1});
    mesh.triangles.push_back({a, b + 1, a + 1});
    if (i > 0 && i + 1 < kSides) {
      mesh.triangles.push_back({0, b, a});
      mesh.triangles.push_back({1, a + 1, b + 1});
    }
  }
  if (SignedVolume6(mesh) < 0) {
    for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
  }
  return mesh;
}

// About 7 mm long, x ahead, its origin between the wheels on the road.
Mesh CarMesh() {
  Mesh car;
  Append(car, Box({-0.0034, -0.0015, 0.0006}, {0.0036, 0.0015, 0.0017}, 0.94, 0.86), 0);
  Append(car, Box({-0.0020, -0.0012, 0.0017}, {0.0012, 0.0012, 0.0028}, 0.62, 0.78), 1);
  Append(car, Box({-0.0036, -0.0016, 0.0024}, {-0.0027, 0.0016, 0.0027}, 1, 1), 0);
  Append(car, Box({-0.0033, -0.0009, 0.0016}, {-0.0029, 0.0009, 0.0025}, 1, 1), 0);
  for (const double x : {-0.0021, 0.0022}) {
    for (const double y : {-0.0016, 0.0016}) Append(car, Wheel({x, y, 0.00085}, 0.00085, 0.00040), 2);
  }
  Weld(car);
  return car;
}

constexpr double kStart = 0.75;                              // turns
constexpr double kCheckpoints[] = {0.95, 0.15, 0.35, 0.55};  // in the order they are driven
constexpr double kStartLine_m = 0.0062;                      // ahead of the car's start
constexpr double kLineWidth_m = 2 * (kRoadHalfWidth_m + kWallThickness_m);

// A box beside the centre line at `turn`, its sides along and across the road.
Mesh BoxAt(double turn, const Vec& lower, const Vec& upper) {
  const Vec ahead = Ahead(turn), left = Left(turn);
  Mesh mesh = Box(lower, upper, 1, 1);
  for (Vec& p : mesh.positions) p = Centre(turn) + ahead * p.x + left * p.y + Vec(0, 0, p.z);
  return mesh;
}

Mesh Slab(double offset_m, double half_along_m, double half_across_m, double along_m) {
  return BoxAt(kStart, {along_m - half_along_m, offset_m - half_across_m, 0.00002},
               {along_m + half_along_m, offset_m + half_across_m, 0.00016});
}

// Two rows of squares across the road.
Mesh StartLine() {
  constexpr int kSquares = 8;
  const double side = 2 * kRoadHalfWidth_m / kSquares;
  Mesh mesh;
  for (int row = 0; row < 2; ++row) {
    for (int i = 0; i < kSquares; ++i) {
      const double offset = -kRoadHalfWidth_m + side * (i + 0.5);
      Append(mesh, Slab(offset, side / 2, side / 2, kStartLine_m + side * row),
             static_cast<std::uint32_t>((i + row) % 2));
    }
  }
  return mesh;
}

// A dashed line across the road and a post on either wall.
Mesh CheckpointMarks() {
  constexpr int kDashes = 5;
  constexpr double kHalfLine_m = 0.0003, kHalfPost_m = 0.0005, kPost_m = 0.0016;
  const double dash = 2 * kRoadHalfWidth_m / (2 * kDashes - 1);
  Mesh mesh;
  for (const double turn : kCheckpoints) {
    for (int i = 0; i < kDashes; ++i) {
      const double from = -kRoadHalfWidth_m + 2 * i * dash;
      Append(mesh, BoxAt(turn, {-kHalfLine_m, from, 0.00002}, {kHalfLine_m, from + dash, 0.00016}), 0);
    }
    for (const double side : {-1.0, 1.0}) {
      const double y = side * (kRoadHalfWidth_m + kWallThickness_m / 2);
      Append(mesh,
             BoxAt(turn, {-kHalfPost_m, y - kHalfPost_m, kWallHeight_m},
                   {kHalfPost_m, y + kHalfPost_m, kWallHeight_m + kPost_m}),
             1);
    }
  }
  return mesh;
}

// Kerbs: short red and white stones along both edges of the road.
Mesh Kerbs() {
  Mesh mesh;
  for (const double edge : {-1.0, 1.0}) {
    const Mesh ring = Ring(edge * (kRoadHalfWidth_m - 0.0009), edge * kRoadHalfWidth_m, 0.00002, 0.0003);
    Append(mesh, ring, 0);
    for (std::size_t i = mesh.triangles.size() - ring.triangles.size(), k = 0; i < mesh.triangles.size(); ++i, ++k) {
      mesh.groups[i] = static_cast<std::uint32_t>(k / 16 % 2);
    }
  }
  return mesh;
}

Mesh Ground() {
  constexpr int kSides = 96;
  Mesh mesh;
  for (int i = 0; i < kSides; ++i) {
    const double a = 2 * std::numbers::pi * i / kSides;
    const double c = std::cos(a), s = std::sin(a);
    // A superellipse of 112 x 84 mm.
    const double r = 1 / std::sqrt(std::sqrt(c * c * c * c + s * s * s * s));
    for (const double z : {kRoad_m + kUnderside_m, kRoad_m + kGround_m})
      mesh.positions.emplace_back(0.056 * r * c, 0.042 * r * s + kMiddle_m, z);
  }
  for (std::uint32_t i = 0; i < kSides; ++i) {
    const std::uint32_t a = 2 * i, b = 2 * ((i + 1) % kSides);
    mesh.triangles.push_back({a, b, b + 1});
    mesh.triangles.push_back({a, b + 1, a + 1});
    if (i > 0 && i + 1 < kSides) {
      mesh.triangles.push_back({0, b, a});
      mesh.triangles.push_back({1, a + 1, b + 1});
    }
  }
  return mesh;
}

}  // namespace

Document RacetrackScene() {
  Document document;
  document.title = "racetrack";
  document.materials = {{"asphalt", {0.060, 0.062, 0.068}, 0.9, 0, nullptr, nullptr},
                        {"wall, outer", {0.640, 0.640, 0.660}, 0.6, 0, nullptr, nullptr},
                        {"wall, inner", {0.110, 0.250, 0.620}, 0.6, 0, nullptr, nullptr},
                        {"car", {0.820, 0.030, 0.020}, 0.3, 0.1, nullptr, nullptr},
                        {"glass", {0.020, 0.030, 0.045}, 0.1, 0, nullptr, nullptr},
                        {"tyre", {0.012, 0.012, 0.013}, 0.9, 0, nullptr, nullptr},
                        {"white", {0.850, 0.850, 0.850}, 0.7, 0, nullptr, nullptr},
                        {"black", {0.010, 0.010, 0.010}, 0.7, 0, nullptr, nullptr},
                        {"red", {0.640, 0.035, 0.030}, 0.7, 0, nullptr, nullptr},
                        {"grass", {0.085, 0.250, 0.060}, 0.95, 0, nullptr, nullptr},
                        {"post", {0.900, 0.480, 0.020}, 0.6, 0, nullptr, nullptr}};
  const double edge = kRoadHalfWidth_m, thick = kWallThickness_m;
  document.meshes = {{"road", Ring(-edge, edge, kGround_m, 0.0), {0}, nullptr},
                     {"outer wall", Ring(-edge - thick, -edge, kGround_m, kWallHeight_m), {1}, nullptr},
                     {"inner wall", Ring(edge, edge + thick, kGround_m, kWallHeight_m), {2}, nullptr},
                     {"car", CarMesh(), {3, 4, 5}, nullptr},
                     {"start line", StartLine(), {6, 7}, nullptr},
                     {"kerbs", Kerbs(), {8, 6}, nullptr},
                     {"ground", Ground(), {9}, nullptr},
                     {"checkpoints", CheckpointMarks(), {6, 10}, nullptr}};
  for (OutMesh& mesh : document.meshes) mesh.mesh = SplitCreases(mesh.mesh, 35);
  const OrderedJson wall = {{"role", "wall"}, {"stiffness", 500.0}, {"staticFriction", 0.4}, {"dynamicFriction", 0.3}};
  const auto heading = [](double turn) { return std::atan2(Ahead(turn).y, Ahead(turn).x); };
  document.nodes = {{"road", 0, Vec(0.0), 0, {{"role", "track"}}, {}},
                    {"outer wall", 1, Vec(0.0), 0, wall, {}},
                    {"inner wall", 2, Vec(0.0), 0, wall, {}},
                    {"car",
                     3,
                     Centre(kStart),
                     heading(kStart),
                     {{"role", "vehicle"},
                      {"radius", 0.0018},
                      {"wheelbase", 0.0043},
                      {"speedMax", 0.06},
                      {"acceleration", 0.12},
                      {"steerMax", 0.55},
                      {"hitForce", 2.0},
                      {"hitSpeed", 0.03},
                      {"hitToBase", 0.75},
                      {"hitDuration", 0.03},
                      {"grip", 0.06},
                      {"startLine", kStartLine_m},
                      {"lineWidth", kLineWidth_m}},
                     {}},
                    {"start line", 4, Vec(0.0), 0, {{"role", "ignore"}}, {}},
                    {"kerbs", 5, Vec(0.0), 0, {{"role", "ignore"}}, {}},
                    {"ground", 6, Vec(0.0), 0, {{"role", "ignore"}}, {}},
                    {"joystick",
                     std::nullopt,
                     Vec(0, 0, kStick_m),
                     0,
                     {{"role", "joystick"},
                      {"stiffness", 25.0},
                      {"damping", 0.4},
                      {"range", 0.015},
                      {"deadZone", 0.0015},
                      {"radialDetents", 2},
                      {"detentForce", 0.03}},
                     {}},
                    {"checkpoint marks", 7, Vec(0.0), 0, {{"role", "ignore"}}, {}}};
  for (std::size_t i = 0; i < std::size(kCheckpoints); ++i) {
    document.nodes.push_back({"checkpoint " + std::to_string(i + 1),
                              std::nullopt,
                              Centre(kCheckpoints[i]),
                              heading(kCheckpoints[i]),
                              {{"role", "checkpoint"}, {"width", kLineWidth_m}},
                              {}});
  }
  return document;
}

}  // namespace omni::scenes
