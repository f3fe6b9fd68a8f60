// Meshes that cost as much as they can to be built, and honest ones that are hard, each of about the given number of
// triangles. Equal numbers give equal meshes.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <numbers>
#include <string>
#include <vector>

#include "service/haptics/scene/scene_input.h"

namespace omni::test {

using Soup = haptics::InputObject;

namespace meshes {

using base::Vec3;

// Uniform in [low, high).
class Dice {
 public:
  double Roll(double low, double high) {
    state_ = state_ * 6364136223846793005ULL + 1442695040888963407ULL;
    return low + (high - low) * static_cast<double>(state_ >> 11) * 0x1p-53;
  }
  Vec3 InBox(double half) { return {Roll(-half, half), Roll(-half, half), Roll(-half, half)}; }

 private:
  std::uint64_t state_ = 2026;
};

inline std::uint32_t Put(Soup& soup, const Vec3& p) {
  soup.vertices_base_m.push_back(p);
  return static_cast<std::uint32_t>(soup.vertices_base_m.size() - 1);
}
inline void Join(Soup& soup, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  soup.triangles.push_back({a, b, c});
  soup.triangle_material.push_back(0);
}
inline void Loose(Soup& soup, const Vec3& a, const Vec3& b, const Vec3& c) {
  const std::uint32_t first = Put(soup, a);
  Put(soup, b);
  Put(soup, c);
  Join(soup, first, first + 1, first + 2);
}

// A grid of across x along squares; place(u, v) with u, v in 0 ... 1. `skip(i, j)`: a square that is left out.
template <class Place, class Skip>
void Grid(Soup& soup, std::uint32_t across, std::uint32_t along, bool turned, Place&& place, Skip&& skip) {
  const auto first = static_cast<std::uint32_t>(soup.vertices_base_m.size());
  for (std::uint32_t j = 0; j <= along; ++j) {
    for (std::uint32_t i = 0; i <= across; ++i) Put(soup, place(double(i) / across, double(j) / along));
  }
  for (std::uint32_t j = 0; j < along; ++j) {
    for (std::uint32_t i = 0; i < across; ++i) {
      if (skip(i, j)) continue;
      const std::uint32_t a = first + j * (across + 1) + i, b = a + 1, c = a + across + 1, d = c + 1;
      Join(soup, a, turned ? d : b, turned ? b : d);
      Join(soup, a, turned ? c : d, turned ? d : c);
    }
  }
}
template <class Place>
void Grid(Soup& soup, std::uint32_t across, std::uint32_t along, bool turned, Place&& place) {
  Grid(soup, across, along, turned, place, [](std::uint32_t, std::uint32_t) { return false; });
}

inline std::uint32_t SideOf(std::size_t triangles) {
  return std::max(2U, static_cast<std::uint32_t>(std::sqrt(static_cast<double>(triangles) / 2)));
}

// Closed, with `rings` x `2 rings` squares: 4 rings^2 triangles.
inline void Ball(Soup& soup, const Vec3& centre, double radius, std::uint32_t rings, bool turned) {
  const auto top = Put(soup, centre + Vec3{0, 0, radius}), bottom = Put(soup, centre - Vec3{0, 0, radius});
  const std::uint32_t around = 2 * rings, first = bottom + 1;
  for (std::uint32_t j = 1; j < rings; ++j) {
    for (std::uint32_t i = 0; i < around; ++i) {
      const double u = 2 * std::numbers::pi * i / around, v = std::numbers::pi * j / rings;
      Put(soup, centre + radius * Vec3{std::sin(v) * std::cos(u), std::sin(v) * std::sin(u), std::cos(v)});
    }
  }
  const auto join = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    Join(soup, a, turned ? c : b, turned ? b : c);
  };
  for (std::uint32_t i = 0; i < around; ++i) {
    const std::uint32_t next = (i + 1) % around;
    join(top, first + i, first + next);
    for (std::uint32_t j = 0; j + 2 < rings; ++j) {
      const std::uint32_t row = first + j * around;
      join(row + i, row + around + i, row + around + next);
      join(row + i, row + around + next, row + next);
    }
    const std::uint32_t last = first + (rings - 2) * around;
    join(last + i, bottom, last + next);
  }
}

// A closed prism of six sides from a to b: 24 triangles.
inline void Twig(Soup& soup, const Vec3& a, const Vec3& b, double radius) {
  const Vec3 along = Normalized(b - a);
  const Vec3 x = Normalized(Cross(along, std::abs(along.z) < 0.9 ? Vec3{0, 0, 1} : Vec3{1, 0, 0}));
  const Vec3 y = Cross(along, x);
  const std::uint32_t foot = Put(soup, a), tip = Put(soup, b), first = tip + 1;
  for (int i = 0; i < 6; ++i) {
    const double u = std::numbers::pi * i / 3;
    const Vec3 out = radius * (std::cos(u) * x + std::sin(u) * y);
    Put(soup, a + out);
    Put(soup, b + 0.6 * out);
  }
  for (std::uint32_t i = 0; i < 6; ++i) {
    const std::uint32_t k = first + 2 * i, next = first + 2 * ((i + 1) % 6);
    Join(soup, foot, next, k);
    Join(soup, tip, k + 1, next + 1);
    Join(soup, k, next, next + 1);
    Join(soup, k, next + 1, k + 1);
  }
}

inline Soup CleanBall(std::size_t n) {
  Soup soup;
  Ball(soup, {0, 0, 0.05}, 0.02, std::max(3U, static_cast<std::uint32_t>(std::sqrt(static_cast<double>(n) / 4))),
       false);
  return soup;
}

inline Soup HeightField(std::size_t n) {
  Soup soup;
  const std::uint32_t side = SideOf(n);
  Grid(soup, side, side, false, [](double u, double v) {
    return Vec3{0.05 * (u - 0.5), 0.05 * (v - 0.5), 0.05 + 0.004 * std::sin(9 * u) * std::cos(7 * v)};
  });
  return soup;
}

// A trunk, twigs, and about each twig leaves of two triangles, or of one.
inline Soup Crown(std::size_t n) {
  Soup soup;
  Dice dice;
  Twig(soup, {0, 0, 0.02}, {0, 0, 0.05}, 0.002);
  while (soup.triangles.size() + 100 < n) {
    const Vec3 foot{0, 0, dice.Roll(0.03, 0.05)};
    const Vec3 tip = foot + Vec3{dice.Roll(-0.02, 0.02), dice.Roll(-0.02, 0.02), dice.Roll(0, 0.02)};
    Twig(soup, foot, tip, 0.0002);
    for (int i = 0; i < 40; ++i) {
      const Vec3 at = foot + dice.Roll(0.3, 1) * (tip - foot) + dice.InBox(0.001);
      const Vec3 x = dice.InBox(0.0008), y = dice.InBox(0.0008);
      const std::uint32_t first = Put(soup, at);
      Put(soup, at + x);
      Put(soup, at + y);
      Join(soup, first, first + 1, first + 2);
      if (i % 4 == 0) continue;
      Put(soup, at + x + y + dice.InBox(0.0001));
      Join(soup, first + 1, first + 3, first + 2);
    }
  }
  return soup;
}

// Plates of a hull that overlap, decks, boxes and masts, as they come out of a drawing program: a third of the plates
// inside-out, the masts closed.
inline Soup Ship(std::size_t n) {
  Soup soup;
  Dice dice;
  for (int k = 0; soup.triangles.size() + 64 < n; ++k) {
    const double x = dice.Roll(-0.03, 0.03), low = dice.Roll(0, 0.8), side = k % 2 == 0 ? 1 : -1;
    const bool turned = k % 3 == 0;
    if (k % 10 < 6) {  // a bent plate of the hull
      Grid(soup, 4, 4, turned, [&](double u, double v) {
        const double along = x + 0.006 * u, up = low + 0.25 * v;
        const double width = 0.01 * (1 - 900 * along * along) * std::sqrt(std::max(0.01, up));
        return Vec3{along, side * width, 0.045 + 0.012 * up};
      });
    } else if (k % 10 < 8) {  // a box without bottom
      const Vec3 at{x, dice.Roll(-0.006, 0.006), 0.05 + 0.012 * low};
      Grid(soup, 4, 1, turned, [&](double u, double v) {
        const double angle = 2 * std::numbers::pi * u;
        return at + Vec3{0.002 * std::cos(angle), 0.002 * std::sin(angle), 0.002 * v};
      });
    } else if (k % 10 == 8) {  // a piece of a deck
      Grid(soup, 3, 3, turned, [&](double u, double v) {
        return Vec3{x + 0.008 * u, 0.012 * (v - 0.5), 0.046 + 0.01 * low};
      });
    } else {
      Twig(soup, {x, 0, 0.05}, {x + 0.001, dice.Roll(-0.002, 0.002), 0.065}, 0.0003);
    }
  }
  return soup;
}

inline Soup LooseTriangles(std::size_t n) {
  Soup soup;
  Dice dice;
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 at = Vec3{0, 0, 0.05} + dice.InBox(0.02);
    Loose(soup, at, at + dice.InBox(0.002), at + dice.InBox(0.002));
  }
  return soup;
}

// As long as the whole, a thousandth as wide.
inline Soup Needles(std::size_t n) {
  Soup soup;
  Dice dice;
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 at = Vec3{0, 0, 0.05} + dice.InBox(0.02);
    Loose(soup, at, at + dice.InBox(0.00002), Vec3{0, 0, 0.05} + dice.InBox(0.02));
  }
  return soup;
}

// Boxes of four walls, inside-out, that overlap: open parts that enclose something.
inline Soup OpenBoxes(std::size_t n) {
  Soup soup;
  Dice dice;
  while (soup.triangles.size() < n) {
    const Vec3 at = Vec3{0, 0, 0.05} + dice.InBox(0.01);
    Grid(soup, 4, 1, true, [&](double u, double v) {
      const double angle = 2 * std::numbers::pi * u;
      return at + Vec3{0.006 * std::cos(angle), 0.006 * std::sin(angle), 0.006 * v};
    });
  }
  return soup;
}

// Shells in shells, each turned the other way than the one around it.
inline Soup Onion(std::size_t n) {
  Soup soup;
  const std::size_t shells = std::max<std::size_t>(1, n / 36);
  for (std::size_t k = 0; k < shells; ++k) {
    const double share = 1 - 0.9 * static_cast<double>(k) / static_cast<double>(shells);
    Ball(soup, {0, 0, 0.05}, 0.02 * share, 3, k % 2 == 0);
  }
  return soup;
}

// Closed boxes, all inside-out, each overlapping many others.
inline Soup TurnedBalls(std::size_t n) {
  Soup soup;
  Dice dice;
  while (soup.triangles.size() < n) Ball(soup, Vec3{0, 0, 0.05} + dice.InBox(0.01), 0.006, 3, true);
  return soup;
}

inline Soup Fan(std::size_t n) {  // all around one vertex
  Soup soup;
  const std::uint32_t hub = Put(soup, {0, 0, 0.055});
  for (std::size_t i = 0; i <= n; ++i) {
    const double u = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(n + 1);
    const std::uint32_t rim = Put(soup, {0.02 * std::cos(u), 0.02 * std::sin(u), 0.05});
    if (i > 0) Join(soup, hub, rim - 1, rim);
  }
  return soup;
}

inline Soup Book(std::size_t n) {  // all along one edge
  Soup soup;
  Put(soup, {0, 0, 0.05});
  Put(soup, {0, 0, 0.06});
  for (std::size_t i = 0; i < n; ++i) {
    const double u = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(n);
    Join(soup, 0, 1, Put(soup, {0.02 * std::cos(u), 0.02 * std::sin(u), 0.055}));
  }
  return soup;
}

// All but one vertex in a cube so small that its places are hardly distinct.
inline Soup Crowd(std::size_t n) {
  Soup soup;
  Dice dice;
  Loose(soup, {0, 0, 0.05}, {0.02, 0, 0.05}, {0, 0.02, 0.05});
  for (std::size_t i = 1; i < n; ++i) {
    const Vec3 at{0, 0, 0.05};
    Loose(soup, at + dice.InBox(6e-8), at + dice.InBox(6e-8), at + dice.InBox(6e-8));
  }
  return soup;
}

inline Soup OnePlace(std::size_t n) {  // a plate, and all other corners in two places
  Soup soup = HeightField(32);
  for (std::size_t i = 32; i < n; ++i) Loose(soup, {0, 0, 0.05}, {0.001, 0, 0.05}, {0, 0, 0.05});
  return soup;
}

inline Soup Same(std::size_t n) {  // the same triangle, corners in turn
  Soup soup;
  const std::array<Vec3, 3> c{Vec3{0, 0, 0.05}, Vec3{0.02, 0, 0.05}, Vec3{0, 0.02, 0.05}};
  for (std::size_t i = 0; i < n; ++i) Loose(soup, c[i % 3], c[(i + 1) % 3], c[(i + 2) % 3]);
  return soup;
}

inline Soup Plane(std::size_t n) {  // all in one plane, through each other
  Soup soup;
  Dice dice;
  const auto flat = [&] { return Vec3{dice.Roll(-0.02, 0.02), dice.Roll(-0.02, 0.02), 0.05}; };
  for (std::size_t i = 0; i < n; ++i) Loose(soup, flat(), flat(), flat());
  return soup;
}

inline Soup Pierced(std::size_t n) {  // a bent sheet with a hole in every third square
  Soup soup;
  const std::uint32_t side = SideOf(n + n / 8);
  Grid(
      soup, side, side, false,
      [](double u, double v) {
        return Vec3{0.05 * (u - 0.5), 0.05 * (v - 0.5), 0.05 + 0.004 * std::sin(9 * u) * std::cos(7 * v)};
      },
      [](std::uint32_t i, std::uint32_t j) { return i % 3 == 1 && j % 3 == 1; });
  return soup;
}

// Closed but for as many holes of 64 edges as fit.
inline Soup LargeHoles(std::size_t n) {
  Soup soup;
  const std::uint32_t holes = std::max(1U, static_cast<std::uint32_t>(std::sqrt(static_cast<double>(n) / 700)));
  const std::uint32_t side = 19 * holes;
  const auto hole = [](std::uint32_t i) { return i % 19 >= 2 && i % 19 < 18; };
  for (const double down : {0.0, 1.0}) {
    Grid(
        soup, side, side, down > 0,
        [&](double u, double v) {
          const double bump = 1 - std::max(std::abs(2 * u - 1), std::abs(2 * v - 1));
          return Vec3{0.05 * (u - 0.5), 0.05 * (v - 0.5), 0.05 + (down > 0 ? -1 : 1) * 0.01 * bump};
        },
        [&](std::uint32_t i, std::uint32_t j) { return down == 0 && hole(i) && hole(j); });
  }
  return soup;
}

// Long triangles side by side, and on their common line the corners of all others.
inline Soup Junctions(std::size_t n) {
  Soup soup;
  Dice dice;
  for (std::size_t i = 0; i < n / 2; ++i) {
    Loose(soup, {dice.Roll(-0.03, -0.02), 0, 0.05}, {dice.Roll(0.02, 0.03), 0, 0.05},
          {dice.Roll(-0.02, 0.02), 0.01, dice.Roll(0.05, 0.06)});
    const double x = dice.Roll(-0.019, 0.019);
    Loose(soup, {x, 0, 0.05}, {x, -0.01, 0.05}, {x + 0.0001, -0.01, dice.Roll(0.05, 0.06)});
  }
  return soup;
}

// The same, the lines different ones: pairs of edge and vertex that are near along one axis, and not on each other.
inline Soup Rails(std::size_t n) {
  Soup soup;
  Dice dice;
  for (std::size_t i = 0; i < n; ++i) {
    const double y = dice.Roll(-0.02, 0.02), z = dice.Roll(0.05, 0.06);
    Loose(soup, {dice.Roll(-0.021, -0.02), y, z}, {dice.Roll(0.02, 0.021), y, z},
          {dice.Roll(-0.02, 0.02), y, z + 1e-4});
  }
  return soup;
}

inline Soup Spiral(std::size_t n) {  // one strip, its turns side by side, each with the corners of the next on its edge
  Soup soup;
  const std::size_t turns = std::max<std::size_t>(2, n / 400);
  for (std::size_t i = 0; i <= n / 2; ++i) {
    const double u = static_cast<double>(i) / 200.5, r = 0.005 + 0.015 * u / static_cast<double>(turns);
    const double wide = 0.015 / static_cast<double>(turns);
    const Vec3 out{std::cos(2 * std::numbers::pi * u), std::sin(2 * std::numbers::pi * u), 0};
    const std::uint32_t a = Put(soup, Vec3{0, 0, 0.05} + r * out), b = Put(soup, Vec3{0, 0, 0.05} + (r + wide) * out);
    if (i == 0) continue;
    Join(soup, a - 2, b - 2, b);
    Join(soup, a - 2, b, a);
  }
  return soup;
}

}  // namespace meshes

struct MeshBomb {
  const char* name;
  Soup (*make)(std::size_t triangles);
};

// What all others are compared with.
inline constexpr MeshBomb kCleanMesh{"ball", meshes::CleanBall};

inline constexpr std::array kMeshBombs = {
    MeshBomb{"height field", meshes::HeightField},
    MeshBomb{"tree crown", meshes::Crown},
    MeshBomb{"ship", meshes::Ship},
    MeshBomb{"loose triangles", meshes::LooseTriangles},
    MeshBomb{"needles", meshes::Needles},
    MeshBomb{"open boxes", meshes::OpenBoxes},
    MeshBomb{"onion", meshes::Onion},
    MeshBomb{"inside-out balls", meshes::TurnedBalls},
    MeshBomb{"fan around a vertex", meshes::Fan},
    MeshBomb{"triangles along one edge", meshes::Book},
    MeshBomb{"crowd in one cell", meshes::Crowd},
    MeshBomb{"corners in two places", meshes::OnePlace},
    MeshBomb{"the same triangle", meshes::Same},
    MeshBomb{"all in one plane", meshes::Plane},
    MeshBomb{"many small holes", meshes::Pierced},
    MeshBomb{"many large holes", meshes::LargeHoles},
    MeshBomb{"T-junctions on one line", meshes::Junctions},
    MeshBomb{"rails", meshes::Rails},
    MeshBomb{"spiral", meshes::Spiral},
};

// As a glTF file: one tagged node with one primitive.
inline std::string MeshFile(const Soup& soup) {
  const std::size_t vertices = soup.vertices_base_m.size(), corners = 3 * soup.triangles.size();
  std::string bin(12 * vertices + 4 * corners, '\0');
  char* to = bin.data();
  for (const base::Vec3& p : soup.vertices_base_m) {  // glTF is y up
    const float place[3] = {static_cast<float>(p.x), static_cast<float>(p.z), static_cast<float>(-p.y)};
    std::memcpy(to, place, sizeof place);
    to += sizeof place;
  }
  if (corners > 0) std::memcpy(to, soup.triangles.data(), 4 * corners);
  const auto number = [](std::size_t x) { return std::to_string(x); };
  std::string json =
      R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0,"extras":{"haptic":true}}],)"
      R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],"buffers":[{"byteLength":)" +
      number(bin.size()) + R"(}],"bufferViews":[{"buffer":0,"byteLength":)" + number(12 * vertices) +
      R"(},{"buffer":0,"byteOffset":)" + number(12 * vertices) + R"(,"byteLength":)" + number(4 * corners) +
      R"(}],"accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":)" + number(vertices) +
      R"(,"min":[-10,-10,-10],"max":[10,10,10]},{"bufferView":1,"componentType":5125,"type":"SCALAR","count":)" +
      number(corners) + "}]}";
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const auto word = [](std::size_t x) {
    const auto value = static_cast<std::uint32_t>(x);
    std::string bytes(4, '\0');
    std::memcpy(bytes.data(), &value, 4);
    return bytes;
  };
  return word(0x46546C67) + word(2) + word(28 + json.size() + bin.size()) + word(json.size()) + word(0x4E4F534A) +
         json + word(bin.size()) + word(0x004E4942) + bin;
}

}  // namespace omni::test
