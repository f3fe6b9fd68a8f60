// Every kind of defective mesh: repaired with a line in the report, or rejected with an error; the force of a pen
// wandering through the result is finite and within the limit.
#include <gtest/gtest.h>

#include <limits>

#include "service/haptics/geometry/mesh_repair.h"
#include "service/haptics/geometry/winding_number.h"
#include "service/haptics/scene/check_scene.h"
#include "tests/haptics/scenario.h"

namespace omni::haptics {
namespace test_repair_mesh {

constexpr std::uint32_t kClosedSolid = kClosed | kCollidable;

void Append(InputObject& to, const InputObject& from, const Vec3& by = {}, bool turned = false) {
  const auto first = static_cast<std::uint32_t>(to.vertices_base_m.size());
  for (const Vec3& v : from.vertices_base_m) to.vertices_base_m.push_back(v + by);
  for (const auto& t : from.triangles)
    AddTriangle(to, first + t[0], first + (turned ? t[2] : t[1]), first + (turned ? t[1] : t[2]));
}

InputObject Turned(InputObject object) {
  for (auto& t : object.triangles) std::swap(t[1], t[2]);
  return object;
}

InputObject Without(InputObject object, const std::function<bool(const Vec3& centroid)>& gone) {
  InputObject left = object;
  left.triangles.clear();
  left.triangle_material.clear();
  for (const auto& t : object.triangles) {
    const auto at = [&](std::size_t k) { return object.vertices_base_m[t[k]]; };
    if (!gone((1.0 / 3) * (at(0) + at(1) + at(2)))) AddTriangle(left, t[0], t[1], t[2]);
  }
  return left;
}

// A cube whose top is a grid of 8 x 8 squares while its sides are two triangles each: T-junctions along four edges.
InputObject TopFinerThanSides() {
  const InputObject fine = Block(8, {0.01, 0.01, 0.01}), coarse = Block(1, {0.01, 0.01, 0.01});
  InputObject mixed = Without(fine, [](const Vec3& c) { return c.z < 0.00999; });
  Append(mixed, Without(coarse, [](const Vec3& c) { return c.z > 0.00999; }));
  return mixed;
}

InputObject Needles() {  // a drum of 720 slices: caps of needles 0.17 mm wide and 20 mm long
  InputObject drum;
  constexpr std::uint32_t kSlices = 720;
  drum.vertices_base_m = {{0, 0, 0.01}, {0, 0, -0.01}};
  for (std::uint32_t i = 0; i < kSlices; ++i) {
    const double u = 2 * std::numbers::pi * i / kSlices;
    drum.vertices_base_m.push_back({0.02 * std::cos(u), 0.02 * std::sin(u), 0.01});
    drum.vertices_base_m.push_back({0.02 * std::cos(u), 0.02 * std::sin(u), -0.01});
  }
  for (std::uint32_t i = 0; i < kSlices; ++i) {
    const std::uint32_t a = 2 + 2 * i, b = a + 1, c = 2 + 2 * ((i + 1) % kSlices), d = c + 1;
    AddTriangle(drum, 0, a, c);
    AddTriangle(drum, 1, d, b);
    AddTriangle(drum, a, b, d);
    AddTriangle(drum, a, d, c);
  }
  return drum;
}

struct Defect {
  const char* name;
  std::function<InputObject()> make;
  const char* line;     // of the report; nullptr: none expected
  const char* refusal;  // nullptr: it is built
  std::uint32_t flags;  // of the object, when built; 0: not checked
  bool solid;           // (0, 0, 0) is inside and has a force
};

const double kNan = std::numeric_limits<double>::quiet_NaN();
const double kInfinite = std::numeric_limits<double>::infinity();
const InputObject kBall = Sphere(12, 0.015);

const Defect kDefects[] = {
    {"sound", [] { return kBall; }, nullptr, nullptr, kClosedSolid, true},
    {"inside-out", [] { return Turned(kBall); }, "inside-out", nullptr, kClosedSolid, true},
    {"half-flipped",
     [] {
       InputObject half = kBall;
       for (std::size_t i = 0; i < half.triangles.size(); i += 2) std::swap(half.triangles[i][1], half.triangles[i][2]);
       return half;
     },
     "agree with their neighbours", nullptr, kClosedSolid, true},
    {"unwelded",
     [] {
       InputObject soup;
       for (const auto& t : kBall.triangles) {
         const auto n = static_cast<std::uint32_t>(soup.vertices_base_m.size());
         for (const std::uint32_t v : t) soup.vertices_base_m.push_back(kBall.vertices_base_m[v]);
         AddTriangle(soup, n, n + 1, n + 2);
       }
       return soup;
     },
     "vertices welded", nullptr, kClosedSolid, true},
    {"duplicate",
     [] {
       InputObject twice = kBall;
       Append(twice, kBall);
       return twice;
     },
     "duplicates", nullptr, kClosedSolid, true},
    {"duplicate, turned",
     [] {
       InputObject twice = kBall;
       Append(twice, kBall, {}, true);
       return twice;
     },
     "duplicates", nullptr, kClosedSolid, true},
    {"zero-area",
     [] {
       InputObject flat = kBall;
       flat.vertices_base_m.push_back({0, 0, 0.001});
       flat.vertices_base_m.push_back({0, 0, 0.002});
       const auto n = static_cast<std::uint32_t>(flat.vertices_base_m.size());
       flat.vertices_base_m.push_back({0, 0, 0.003});
       AddTriangle(flat, n - 2, n - 1, n);
       AddTriangle(flat, 3, 3, 7);
       return flat;
     },
     "no area", nullptr, kClosedSolid, true},
    {"NaN",
     [] {
       InputObject bad = kBall;
       bad.vertices_base_m.push_back({kNan, 0, 0});
       AddTriangle(bad, 0, 1, static_cast<std::uint32_t>(bad.vertices_base_m.size()) - 1);
       return bad;
     },
     "not finite", nullptr, kClosedSolid, true},
    {"infinite",
     [] {
       InputObject bad = kBall;
       bad.vertices_base_m[5].y = kInfinite;
       return bad;
     },
     "not finite", nullptr, kClosedSolid, true},  // the hole it leaves is closed
    {"all NaN",
     [] {
       InputObject bad = kBall;
       for (Vec3& v : bad.vertices_base_m) v.x = kNan;
       return bad;
     },
     nullptr, "none of its triangles is finite", 0, false},
    {"1e30 coordinates",
     [] {
       InputObject bad = kBall;
       bad.vertices_base_m[5].y = 1e30;
       return bad;
     },
     nullptr, "the limit is 10 m", 0, false},
    {"open, a small hole", [] { return Without(kBall, [](const Vec3& c) { return c.z > 0.0147; }); },
     "small holes closed", nullptr, kClosedSolid, true},
    {"open, half of it gone", [] { return Without(kBall, [](const Vec3& c) { return c.z > 0.003; }); },
     "the mesh is open", nullptr, kDoubleSided | kCollidable, false},
    {"a sheet with a small hole",
     [] {
       return Without(Block(10, {0.02, 0.02, 0.01}),
                      [](const Vec3& c) { return c.z < 0.0099 || (std::abs(c.x) < 0.003 && std::abs(c.y) < 0.003); });
     },
     "the mesh is open", nullptr, kDoubleSided | kCollidable, false},
    {"self-intersecting",
     [] { return Periodic(60, 30, [](double u, double v) { return TorusPoint(0.008, 0.010, u, v); }); }, nullptr,
     nullptr, kClosedSolid, false},
    {"two bodies through each other",
     [] {
       InputObject two = kBall;
       Append(two, kBall, {0.01, 0, 0}, true);
       return two;
     },
     "inside-out", nullptr, kClosedSolid, true},
    {"non-manifold: a fin",
     [] {
       InputObject fin = kBall;
       fin.vertices_base_m.push_back({0.03, 0.03, 0.03});
       AddTriangle(fin, fin.triangles[0][0], fin.triangles[0][1],
                   static_cast<std::uint32_t>(fin.vertices_base_m.size()) - 1);
       return fin;
     },
     "three or more triangles", nullptr, kDoubleSided | kCollidable | kCracked, true},
    {"two boxes sharing an edge",
     [] {
       InputObject two = Block(2, {0.01, 0.01, 0.01});
       Append(two, Block(2, {0.01, 0.01, 0.01}), {0.02, 0.02, 0});
       return two;
     },
     "three or more triangles", nullptr, kDoubleSided | kCollidable | kCracked, true},
    {"one triangle",
     [] {
       InputObject one;
       one.vertices_base_m = {{-0.01, -0.01, 0}, {0.01, -0.01, 0}, {0, 0.01, 0}};
       AddTriangle(one, 0, 1, 2);
       return one;
     },
     "the mesh is open", nullptr, kDoubleSided | kCollidable, false},
    {"empty", [] { return InputObject{}; }, nullptr, "no triangles", 0, false},
    {"T-junctions", [] { return TopFinerThanSides(); }, "T-junctions", nullptr, kClosedSolid, true},
    {"needles", [] { return Needles(); }, nullptr, nullptr, kClosedSolid, true},
    {"a crack: a zero-area triangle between two",
     [] {
       InputObject cracked = Block(1, {0.01, 0.01, 0.01});
       // The first edge gets a middle on one side only, joined by a triangle without area.
       const auto [a, b, c] = cracked.triangles[0];
       const auto m = static_cast<std::uint32_t>(cracked.vertices_base_m.size());
       cracked.vertices_base_m.push_back(0.5 * (cracked.vertices_base_m[a] + cracked.vertices_base_m[b]));
       cracked.triangles[0] = {a, m, c};
       AddTriangle(cracked, m, b, c);
       AddTriangle(cracked, a, b, m);
       return cracked;
     },
     "T-junctions", nullptr, kClosedSolid, true},
};

bool Says(const BuildReport& report, const std::string& words) {
  return std::any_of(report.lines.begin(), report.lines.end(),
                     [&](const std::string& line) { return line.find(words) != std::string::npos; });
}

double ForceAt(const Scene& scene, const Vec3& tip) {
  Pen pen(scene);
  pen.MoveTo(tip);
  return Norm(pen.output.force_base_N);
}

TEST(RepairMesh, RepairsOrRejectsEveryDefect) {
  for (const Defect& defect : kDefects) {
    SCOPED_TRACE(defect.name);
    BuildReport report;
    SceneInput input = SceneOf(defect.make());
    input.objects[0].source = "/nodes/7";
    const auto scene = BuildScene(input, report);
    if (defect.refusal) {
      ASSERT_FALSE(scene.ok());
      EXPECT_NE(scene.error().find(defect.refusal), std::string::npos) << scene.error();
      continue;
    }
    ASSERT_TRUE(scene.ok()) << scene.error();
    EXPECT_TRUE(CheckScene(*scene).ok()) << CheckScene(*scene).error();
    if (defect.line) {
      EXPECT_TRUE(Says(report, defect.line)) << testing::PrintToString(report.lines);
    }
    if (defect.flags != 0) {
      EXPECT_EQ(scene->objects()[0].flags, defect.flags) << testing::PrintToString(report.lines);
    }
    if (defect.solid) {
      EXPECT_GT(ForceAt(*scene, {0.001, 0.002, 0.003}), 0.1) << "inside";
      EXPECT_EQ(ForceAt(*scene, {0, 0, 0.05}), 0) << "outside";
    }
    // Any walk through it: finite, within the limit.
    Pen pen(*scene);
    Random random(11);
    Vec3 tip{};
    for (int i = 0; i < 400; ++i) {
      const Vec3 next = random.InBox(0.03);
      for (int k = 1; k <= 4; ++k) {
        pen.MoveTo(tip + (k / 4.0) * (next - tip));
        ASSERT_LE(Norm(pen.output.force_base_N), 2.0 * (1 + 1e-12)) << i;  // false for NaN
      }
      tip = next;
    }
  }
}

TEST(RepairMesh, IsDeterministic) {
  for (const Defect& defect : kDefects) {
    if (defect.refusal) continue;
    const Scene a = Built(SceneOf(defect.make())), b = Built(SceneOf(defect.make()));
    EXPECT_TRUE(std::equal(a.block().begin(), a.block().end(), b.block().begin(), b.block().end())) << defect.name;
  }
}

// Nested shells, each as its author meant it, then all inverted: the outside stays the outside.
TEST(RepairMesh, OrientsNestedShellsFromTheOutside) {
  const auto shell = [](double r, bool turned) { return turned ? Turned(Sphere(8, r)) : Sphere(8, r); };
  struct Nest {
    bool turned[3];  // outermost first
    double radius_m[3];
    double inside_at_m[4];  // radii of places, 0 for none ...
    bool solid[4];          // ... and whether they are solid
  };
  // Solid with a cavity with a solid in it; the same inside-out as a whole; a solid in a solid.
  const Nest nests[] = {
      {{false, true, false}, {0.02, 0.014, 0.008}, {0.017, 0.011, 0.004, 0}, {true, false, true, false}},
      {{true, true, false}, {0.02, 0.014, 0.008}, {0.017, 0.011, 0.004, 0}, {true, false, true, false}},
      {{true, false, false}, {0.02, 0.014, 0.008}, {0.017, 0.011, 0.004, 0}, {true, true, true, false}}};
  for (const Nest& nest : nests) {
    InputObject object;
    for (int k = 2; k >= 0; --k) Append(object, shell(nest.radius_m[k], nest.turned[k]));
    RepairCounts counts;
    Mesh mesh = RepairMesh(object, counts);
    ConnectAndOrient(mesh);
    const WindingTree tree(mesh);
    for (int i = 0; i < 3; ++i) {
      const double winding = tree.At({nest.inside_at_m[i], 0.0001, 0.0002}, kNoIndex);
      EXPECT_EQ(winding > 0.5, nest.solid[i]) << i << " " << winding;
    }
    EXPECT_NEAR(tree.At({0.03, 0, 0}, kNoIndex), 0, 0.02);
  }
}

// Half shells whose rims do not meet (0.5 mm apart): open, each inside-out or not, two-sided but front outwards.
TEST(RepairMesh, OrientsOpenPartsOutwards) {
  for (int turned = 0; turned < 4; ++turned) {
    const InputObject upper = Without(kBall, [](const Vec3& c) { return c.z < 0; });
    const InputObject lower = Without(kBall, [](const Vec3& c) { return c.z > 0; });
    InputObject both;
    Append(both, upper, {0, 0, 0.0005}, (turned & 1) != 0);
    Append(both, lower, {}, (turned & 2) != 0);
    RepairCounts counts;
    Mesh mesh = RepairMesh(both, counts);
    const TopologyReport report = ConnectAndOrient(mesh);
    EXPECT_EQ(report.components, 2U);
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      const auto& [a, b, c] = mesh.triangles[t];
      const Vec3 normal = Cross(mesh.vertices[b] - mesh.vertices[a], mesh.vertices[c] - mesh.vertices[a]);
      ASSERT_GT(Dot(normal, mesh.vertices[a]), 0) << turned << " " << t;
    }
  }
}

TEST(RepairMesh, WindingTreeMatchesSumOfSolidAngles) {
  InputObject object = Periodic(40, 20, [](double u, double v) { return TorusPoint(0.02, 0.007, u, v); });
  Append(object, Without(kBall, [](const Vec3& c) { return c.x > 0.004; }), {0.03, 0, 0.01});
  RepairCounts counts;
  const Mesh mesh = RepairMesh(object, counts);
  const WindingTree tree(mesh);
  Random random(5);
  for (int i = 0; i < 500; ++i) {
    const Vec3 p = random.InBox(0.04);
    double sum = 0;
    for (const auto& [a, b, c] : mesh.triangles) {
      sum += SolidAngle(mesh.vertices[a] - p, mesh.vertices[b] - p, mesh.vertices[c] - p) / (4 * std::numbers::pi);
    }
    ASSERT_NEAR(tree.At(p, kNoIndex), sum, 0.03) << i;
  }
}

// A soup of its own, as soft bodies are cut from: triangles without area, alone in a leaf too, have no effect.
TEST(RepairMesh, WindingTreeIgnoresDegenerateTriangles) {
  std::vector<Vec3> vertices = kBall.vertices_base_m;
  std::vector<std::array<std::uint32_t, 3>> triangles = kBall.triangles;
  const WindingTree whole(kBall.vertices_base_m, kBall.triangles);  // references its arguments
  for (std::uint32_t k = 0; k < 40; ++k) {
    vertices.push_back({0.5, 0.5, 0.5 + 1e-4 * k});
    const auto last = static_cast<std::uint32_t>(vertices.size() - 1);
    triangles.push_back({last, last, last});
    triangles.push_back({0, 0, k});
  }
  const WindingTree spoilt(vertices, triangles);
  Random random(6);
  for (int i = 0; i < 300; ++i) {
    const Vec3 p = random.InBox(0.04);
    ASSERT_NEAR(spoilt.At(p), whole.At(p), 0.03) << i;
    if (std::abs(whole.At(p) - 0.5) > 0.1) {
      ASSERT_EQ(spoilt.IsInside(p), whole.IsInside(p)) << i;
    }
  }
  EXPECT_EQ(WindingTree(std::span<const Vec3>(), {}).At({0, 0, 0}), 0);
}

// A hole's filling keeps texture coordinates and materials per triangle, and snapping interpolates them.
TEST(RepairMesh, KeepsPerTriangleDataThroughEveryRepair) {
  InputObject object = TopFinerThanSides();
  object =
      Without(object, [](const Vec3& c) { return c.z > 0.0099 && c.x > 0 && c.x < 0.0025 && c.y > 0 && c.y < 0.0025; });
  object.uv[0].resize(object.triangles.size());
  for (std::size_t t = 0; t < object.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {  // u, v = x, y of the place in cm
      const Vec3& p = object.vertices_base_m[object.triangles[t][k]];
      object.uv[0][t][2 * k] = static_cast<float>(100 * p.x);
      object.uv[0][t][2 * k + 1] = static_cast<float>(100 * p.y);
    }
  }
  RepairCounts counts;
  Mesh mesh = RepairMesh(object, counts);
  const TopologyReport report = ConnectAndOrient(mesh);
  EXPECT_TRUE(report.IsClosed());
  EXPECT_GT(report.snapped, 0U);
  EXPECT_EQ(report.closed_holes, 1U);
  ASSERT_EQ(mesh.uv[0].size(), mesh.triangles.size());
  ASSERT_EQ(mesh.material.size(), mesh.triangles.size());
  EXPECT_TRUE(mesh.uv[1].empty());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& p = mesh.vertices[mesh.triangles[t][k]];
      ASSERT_NEAR(mesh.uv[0][t][2 * k], 100 * p.x, 1e-5) << t;
      ASSERT_NEAR(mesh.uv[0][t][2 * k + 1], 100 * p.y, 1e-5) << t;
    }
  }
}

}  // namespace test_repair_mesh
}  // namespace omni::haptics
