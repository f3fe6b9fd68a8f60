// omni-bench race, side tables: whether anything gets through a wall, and the cost of a tick of the race.
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "service/haptics/scene/scene.h"
#include "service/haptics/vehicle/car.h"
#include "service/sim/fields/random.h"
#include "service/tools/scene/scene.h"
#include "tests/bench/haptics/race.h"
#include "tests/bench/harness/idle_timing.h"

namespace omni::bench {
namespace {

constexpr double kRadius_m = 0.001;
constexpr int kTicksPerThrow = 20;
constexpr std::uint64_t kThrowsPerChamber = 200;

// A closed star: walls of no thickness between corners at random distances, so with corners from needles to nearly
// flat, inwards and outwards.
struct Chamber {
  std::vector<base::Vec3> corners;
  haptics::Scene scene;

  bool Holds(const base::Vec3& p) const {  // crossings of the ray to +x
    bool inside = false;
    for (std::size_t i = 0, j = corners.size() - 1; i < corners.size(); j = i++) {
      const base::Vec3 &a = corners[i], &b = corners[j];
      if ((a.y > p.y) != (b.y > p.y) && p.x < a.x + (b.x - a.x) * (p.y - a.y) / (b.y - a.y)) inside = !inside;
    }
    return inside;
  }
};

Chamber MakeChamber(sim::Random& random) {
  Chamber chamber;
  const int count = 5 + static_cast<int>(random.Uniform(0, 20));
  for (int k = 0; k < count; ++k) {
    const double angle = 2 * std::numbers::pi * (k + random.Uniform(0, 0.9)) / count;
    const double r = random.Uniform(0.003, 0.05);
    chamber.corners.push_back({r * std::cos(angle), r * std::sin(angle), 0});
  }
  haptics::SceneInput input;
  input.name = "chamber";
  input.materials.emplace_back().restitution = random.Uniform(0, 1);
  haptics::InputObject wall;
  wall.name = "wall";
  wall.car_wall = wall.double_sided = true;
  for (const base::Vec3& c : chamber.corners) {
    wall.vertices_base_m.push_back({c.x, c.y, -0.001});
    wall.vertices_base_m.push_back({c.x, c.y, 0.001});
  }
  const auto vertices = static_cast<std::uint32_t>(wall.vertices_base_m.size());
  for (std::uint32_t a = 0; a < vertices; a += 2) {
    const std::uint32_t b = (a + 2) % vertices;
    wall.triangles.push_back({a, b, b + 1});
    wall.triangles.push_back({a, b + 1, a + 1});
    wall.triangle_material.insert(wall.triangle_material.end(), 2, 0);
  }
  input.objects.push_back(std::move(wall));
  input.vehicle.emplace().radius_m = kRadius_m;
  haptics::BuildReport report;
  auto built = haptics::BuildScene(input, report);
  if (built.ok()) chamber.scene = std::move(built.value());
  return chamber;
}

struct Counts {
  std::uint64_t throws = 0, ticks = 0, hits = 0, passed = 0, overlapped = 0;
  double fastest_m_s = 0;
};

void ThrowCar(const Chamber& chamber, sim::Random& random, Counts& counts) {
  const haptics::VehicleInput& car = chamber.scene.header().vehicle;
  const haptics::WallMap walls = haptics::WallsOf(chamber.scene);
  haptics::VehicleState state;
  haptics::StartCar(car, state);
  const double speed_m_s = std::pow(10, random.Uniform(-2, 2)), way = random.Uniform(-3.2, 3.2);
  state.velocity_base_m_s = {speed_m_s * std::cos(way), speed_m_s * std::sin(way), 0};
  state.heading_rad = random.Uniform(-3.2, 3.2);
  counts.fastest_m_s = std::max(counts.fastest_m_s, speed_m_s);
  ++counts.throws;
  for (int tick = 0; tick < kTicksPerThrow; ++tick) {
    haptics::MoveCar(car, walls, chamber.scene.materials(), random.Uniform(0, 5e-3), state);
    ++counts.ticks;
    if (!chamber.Holds(state.position_base_m)) {
      ++counts.passed;
      break;
    }
    counts.overlapped += haptics::NearestWall(walls, state.position_base_m, kRadius_m * (1 - 1e-6)).found;
  }
  counts.hits += state.hits;
}

// Steers along the middle of the shipped track by the walls on both sides.
haptics::Thumbstick Steer(const haptics::WallMap& walls, const haptics::VehicleState& state) {
  const base::Vec3 ahead{std::cos(state.heading_rad), std::sin(state.heading_rad), 0}, left{-ahead.y, ahead.x, 0};
  const auto room_m = [&](const base::Vec3& way) {
    return haptics::FirstTouch(walls, state.position_base_m, 0.03 * way, 1e-4).share;
  };
  const double difference = room_m(0.7 * ahead + 0.7 * left) - room_m(0.7 * ahead - 0.7 * left);
  return {std::clamp(-2 * difference, -0.7, 0.7), 0.7};
}

}  // namespace

void BenchRaceWalls(std::uint64_t seed, std::uint64_t throws, BenchRows& rows) {
  sim::Random random(seed);
  Counts counts;
  std::uint64_t chambers = 0;
  while (counts.throws < throws) {
    const Chamber chamber = MakeChamber(random);
    const haptics::VehicleInput& car = chamber.scene.header().vehicle;
    if (haptics::NearestWall(haptics::WallsOf(chamber.scene), car.start_base_m, 1.1 * kRadius_m).found ||
        !chamber.Holds(car.start_base_m)) {
      continue;
    }
    ++chambers;
    for (std::uint64_t k = 0; k < kThrowsPerChamber && counts.throws < throws; ++k) {
      ThrowCar(chamber, random, counts);
    }
  }
  rows.push_back({{"table", "walls"},
                  {"chambers", chambers},
                  {"throws", counts.throws},
                  {"ticks", counts.ticks},
                  {"fastest_m_s", counts.fastest_m_s},
                  {"hits", counts.hits},
                  {"passed_through", counts.passed},
                  {"overlapping_ticks", counts.overlapped}});
}

base::Status BenchRaceCost(BenchRows& rows) {
  auto loaded = tools::LoadScene(tools::ShippedScene("racetrack"), {});
  if (!loaded.ok()) return base::Error{loaded.error()};
  const haptics::VehicleInput& car = loaded->scene.header().vehicle;
  const haptics::WallMap walls = haptics::WallsOf(loaded->scene);
  struct Situation {
    const char* name;
    bool steered;       // along the road; else straight on, and then along a wall
    double thrown_m_s;  // new in every tick
  };
  for (const Situation& situation :
       {Situation{"on the road", true, 0}, Situation{"along a wall", false, 0}, Situation{"thrown at 2 m/s", false, 2},
        Situation{"thrown at 100 m/s", false, 100}}) {
    // The path is driven first; ticks are then timed from states along it, so that steering is not timed.
    std::vector<haptics::VehicleState> states(2000);
    std::vector<haptics::Thumbstick> sticks(states.size());
    haptics::VehicleState state;
    haptics::StartCar(car, state);
    for (std::size_t i = 0; i < states.size(); ++i) {
      sticks[i] = situation.steered ? Steer(walls, state) : haptics::Thumbstick{0.1, 0.7};
      for (int k = 0; k < 5; ++k) {
        if (situation.thrown_m_s > 0) {
          const double way = 0.7 * static_cast<double>(i) + k;
          state.velocity_base_m_s = situation.thrown_m_s * base::Vec3{std::cos(way), std::sin(way), 0};
        }
        states[i] = state;
        haptics::DriveCar(car, walls, loaded->scene.materials(), sticks[i], 1e-3, state);
      }
    }
    const IdleTiming timing = TimeWhenIdle(200, 20, 50, [&](std::uint64_t i) {
      haptics::VehicleState copy = states[i % states.size()];
      haptics::DriveCar(car, walls, loaded->scene.materials(), sticks[i % states.size()], 1e-3, copy);
    });
    rows.push_back({{"table", "cost"},
                    {"situation", situation.name},
                    {"walls", walls.segments.size()},
                    {"hits_on_the_way", state.hits},
                    {"ns_median", 1e3 * timing.us_median},
                    {"ns_p99", 1e3 * timing.us_p99},
                    {"quiet_batches", timing.quiet_batches}});
  }
  return base::Ok{};
}

}  // namespace omni::bench
