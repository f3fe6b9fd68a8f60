// Shapes that break renderers: plates, grooves, ridges, stairs, and the same shape in few and in many triangles.
#include <gtest/gtest.h>

#include <vector>

#include "tests/haptics/scenario.h"

namespace omni::haptics {
namespace test_haptics_shapes {

constexpr double kDegree = std::numbers::pi / 180;

Material Smooth() {
  Material m;
  m.static_friction = m.dynamic_friction = 0;
  return m;
}

// A bar along y whose top follows the points (x, z), in millimetres, over a flat bottom. Every piece of the top is cut
// into `along` x `across` squares of the same planes.
struct Profile {
  const char* name;
  std::vector<std::array<double, 2>> top_mm;
};

InputObject Bar(const Profile& profile, int along, int across) {
  constexpr double kBottom_m = -0.025, kHalf_m = 0.02;
  std::vector<std::array<double, 2>> top;
  for (std::size_t i = 0; i + 1 < profile.top_mm.size(); ++i) {
    for (int k = 0; k < along; ++k) {
      const double s = static_cast<double>(k) / along;
      const auto &a = profile.top_mm[i], &b = profile.top_mm[i + 1];
      top.push_back({1e-3 * (a[0] + s * (b[0] - a[0])), 1e-3 * (a[1] + s * (b[1] - a[1]))});
    }
  }
  top.push_back({1e-3 * profile.top_mm.back()[0], 1e-3 * profile.top_mm.back()[1]});
  InputObject bar;
  bar.name = profile.name;
  const auto n = static_cast<std::uint32_t>(top.size()), rows = static_cast<std::uint32_t>(across + 1);
  for (std::uint32_t j = 0; j < rows; ++j) {
    const double y = -kHalf_m + 2 * kHalf_m * j / across;
    for (const auto& p : top) bar.vertices_base_m.push_back({p[0], y, p[1]});
    for (const auto& p : top) bar.vertices_base_m.push_back({p[0], y, kBottom_m});
  }
  const auto top_at = [&](std::uint32_t i, std::uint32_t j) { return j * 2 * n + i; };
  const auto bottom_at = [&](std::uint32_t i, std::uint32_t j) { return j * 2 * n + n + i; };
  const auto quad = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    AddTriangle(bar, a, b, c);
    AddTriangle(bar, a, c, d);
  };
  for (std::uint32_t j = 0; j + 1 < rows; ++j) {
    for (std::uint32_t i = 0; i + 1 < n; ++i) {
      quad(top_at(i, j), top_at(i + 1, j), top_at(i + 1, j + 1), top_at(i, j + 1));
      quad(bottom_at(i, j), bottom_at(i, j + 1), bottom_at(i + 1, j + 1), bottom_at(i + 1, j));
    }
    quad(bottom_at(0, j), top_at(0, j), top_at(0, j + 1), bottom_at(0, j + 1));
    quad(bottom_at(n - 1, j), bottom_at(n - 1, j + 1), top_at(n - 1, j + 1), top_at(n - 1, j));
  }
  for (std::uint32_t i = 0; i + 1 < n; ++i) {
    quad(bottom_at(i, 0), bottom_at(i + 1, 0), top_at(i + 1, 0), top_at(i, 0));
    quad(bottom_at(i, rows - 1), top_at(i, rows - 1), top_at(i + 1, rows - 1), bottom_at(i + 1, rows - 1));
  }
  return bar;
}

// A groove or a ridge whose two sides meet at `opening_deg`.
Profile Groove(const char* name, double opening_deg, double height_mm) {
  const double half_mm = std::abs(height_mm) * std::tan(0.5 * opening_deg * kDegree);
  return {name, {{-20, 0}, {-half_mm, 0}, {0, height_mm}, {half_mm, 0}, {20, 0}}};
}

Profile Stairs() {
  Profile stairs{"stairs", {{-20, 6}}};
  for (int k = 0; k < 5; ++k) {
    stairs.top_mm.push_back({-10.0 + 4 * k, 6.0 - 2 * k});
    stairs.top_mm.push_back({-10.0 + 4 * k + 0.01, 4.0 - 2 * k});
  }
  stairs.top_mm.push_back({20, -4});
  return stairs;
}

std::vector<Profile> Profiles() {
  return {Groove("groove 10", 10, -8),   Groove("groove 30", 30, -8),   Groove("groove 60", 60, -6),
          Groove("groove 90", 90, -5),   Groove("ridge 60", 60, 5),     Groove("ridge 90", 90, 4),
          Groove("ridge 130", 130, 3),   Groove("ridge 150", 150, 2),   Groove("ridge 170", 170, 1),
          Groove("groove 150", 150, -2), Groove("groove 170", 170, -1), Stairs()};
}

double TopAt_m(const Profile& profile, double x_m) {
  const double x = 1e3 * x_m;
  for (std::size_t i = 0; i + 1 < profile.top_mm.size(); ++i) {
    const auto &a = profile.top_mm[i], &b = profile.top_mm[i + 1];
    if (x <= b[0]) return 1e-3 * (a[1] + (x - a[0]) / (b[0] - a[0]) * (b[1] - a[1]));
  }
  return 1e-3 * profile.top_mm.back()[1];
}

// Pressed into the middle and left alone: nothing chatters.
TEST(Shapes, ForceOnARestingPenIsSteady) {
  Random random(501);
  for (const Profile& profile : Profiles()) {
    for (const int along : {1, 6}) {
      Pen pen(Built(SceneOf(Bar(profile, along, along), Smooth())));
      for (int place = 0; place < 20; ++place) {
        const double x = random.Uniform(-0.003, 0.003), y = random.Uniform(-0.01, 0.01);
        const double top = TopAt_m(profile, x);
        pen.Slide({x, y, top + 0.002}, {x, y, top - 0.002}, 80);
        pen.Rest(10);
        const double force = Norm(pen.output.force_base_N);
        if (force < 0.02) continue;
        double low = force, high = force;
        for (int k = 0; k < 100; ++k) {
          pen.Rest(1);
          low = std::min(low, Norm(pen.output.force_base_N));
          high = std::max(high, Norm(pen.output.force_base_N));
        }
        EXPECT_LT(high - low, 0.01 * force) << profile.name << " x " << x;
        pen.MoveTo({x, y, 0.03});
        pen.Rest(10);
      }
    }
  }
}

// The same planes in few and in many triangles give the same force, tick by tick, on the same path.
TEST(Shapes, ForceDoesNotDependOnSubdivisionOfPlanes) {
  Random random(77);
  for (const Profile& profile : Profiles()) {
    Pen coarse(Built(SceneOf(Bar(profile, 1, 1), Smooth()))), fine(Built(SceneOf(Bar(profile, 7, 11), Smooth())));
    double worst = 0, strongest = 0;
    for (int stroke = 0; stroke < 60; ++stroke) {
      const double y = random.Uniform(-0.01, 0.01), depth = random.Uniform(2e-4, 1.8e-3);
      const double from = random.Uniform(-0.008, 0.008), to = random.Uniform(-0.008, 0.008);
      for (int k = 0; k <= 150; ++k) {
        const double s = k / 150.0, x = from + s * (to - from);
        const Vec3 tip{x, y + 0.001 * s, TopAt_m(profile, x) - depth * std::sin(std::numbers::pi * s) + 1e-4};
        coarse.MoveTo(tip);
        fine.MoveTo(tip);
        worst = std::max(worst, Norm(coarse.output.force_base_N - fine.output.force_base_N));
        strongest = std::max(strongest, Norm(coarse.output.force_base_N));
      }
      coarse.MoveTo({0, 0, 0.03});
      fine.MoveTo({0, 0, 0.03});
      coarse.Rest(5);
      fine.Rest(5);
    }
    EXPECT_GT(strongest, 0.2) << profile.name;
    EXPECT_LT(worst, 0.01 * strongest) << profile.name;
  }
}

// Where the sagitta is at most 1 % of the depth, the tessellation has no effect.
TEST(Shapes, ForceDoesNotDependOnTessellationOfCurvedSurfaces) {
  Pen coarse(Built(SceneOf(Sphere(42, 0.03), Smooth()))), fine(Built(SceneOf(Sphere(90, 0.03), Smooth())));
  Random random(5);
  double worst = 0;
  for (int stroke = 0; stroke < 30; ++stroke) {
    const Vec3 a = Normalized(random.InBox(1)), b = Normalized(a + random.InBox(0.3));
    for (int k = 0; k <= 200; ++k) {
      const double s = k / 200.0;
      const double depth = 0.004 * std::sin(std::numbers::pi * s) - 1e-4;
      const Vec3 tip = (0.03 - depth) * Normalized((1 - s) * a + s * b);
      coarse.MoveTo(tip);
      fine.MoveTo(tip);
      if (depth < 0.002) continue;  // sagitta .017 mm
      const double force = Norm(fine.output.force_base_N);
      ASSERT_GT(force, 0.1);
      worst = std::max(worst, Norm(coarse.output.force_base_N - fine.output.force_base_N) / force);
    }
    coarse.MoveTo({0, 0, 0.05});
    fine.MoveTo({0, 0, 0.05});
    coarse.Rest(3);
    fine.Rest(3);
  }
  EXPECT_LT(worst, 0.05);
}

// A plate in any attitude, entered from either side at any speed: pushes back to the side of entry, also when ticks are
// missing for 20 ms.
TEST(Shapes, PlatesKeepTheSideOfEntry) {
  Random random(61);
  for (const double thickness_m : {1e-4, 5e-4, 2e-3}) {
    for (const double speed_m_s : {1.0, 5.0, 20.0}) {
      for (const double gap_s : {1e-3, 20e-3}) {
        for (int round = 0; round < 10; ++round) {
          const Vec3 normal = Normalized(random.InBox(1));
          const Vec3 u = Normalized(Cross(normal, random.InBox(1))), v = Cross(normal, u);
          const auto place = [&](const Vec3& p) {
            return (0.03 * p.x) * u + (0.03 * p.y) * v + (0.5 * thickness_m * p.z) * normal;
          };
          Pen pen(Built(SceneOf(CubeGrid(6, place), Smooth())));
          const double side = round % 2 == 0 ? 1 : -1, step_m = speed_m_s * gap_s;
          double height = random.Uniform(0.001, 0.001 + step_m);
          pen.MoveTo((side * (height + step_m)) * normal);
          pen.MoveTo((side * height) * normal);
          while (height > -0.008) {
            height = std::max(height - step_m, -0.009);
            pen.MoveTo((side * height) * normal);
          }
          pen.Rest(20);
          EXPECT_EQ(pen.output.contact_count, 1) << thickness_m << " " << speed_m_s << " " << gap_s;
          EXPECT_GT(side * Dot(pen.output.force_base_N, normal), 0.1) << thickness_m << " " << speed_m_s;
        }
      }
    }
  }
}

}  // namespace test_haptics_shapes
}  // namespace omni::haptics
