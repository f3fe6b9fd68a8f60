// Cost of a ball tip and a shaded normal per tick, on bodies of 1,000 to 100,000 triangles. Prints one row per case;
// times in which the kernel took the thread off its core are left out and counted.
#include <sys/resource.h>

#include <chrono>
#include <cstdio>
#include <vector>

#include "service/haptics/contact/ball/ball_proxy.h"
#include "service/haptics/contact/shading.h"
#include "service/haptics/scene/scene.h"
#include "tests/haptics/scenario.h"

namespace omni::haptics {
namespace {

using Clock = std::chrono::steady_clock;

long Switches() {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  return usage.ru_nivcsw;
}

double Quantile(std::vector<double>& values, double q) {
  const auto rank = static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + rank, values.end());
  return values[static_cast<std::size_t>(rank)];
}

// Microseconds of `call(k)`, k < count.
template <class Call>
std::vector<double> Time_us(int count, int& lost, const Call& call) {
  std::vector<double> times;
  lost = 0;
  for (int k = 0; k < count; ++k) {
    const long before = Switches();
    const auto begin = Clock::now();
    call(k);
    const double us = std::chrono::duration<double, std::micro>(Clock::now() - begin).count();
    if (Switches() == before)
      times.push_back(us);
    else
      ++lost;
  }
  return times;
}

void Print(const char* what, std::uint32_t triangles, double radius_m, double way_m, std::vector<double> us, int lost) {
  std::printf("%-26s %7u %6.2f %6.2f %8.2f %8.2f %8.2f %6d\n", what, triangles, 1e3 * radius_m, 1e3 * way_m,
              Quantile(us, 0.5), Quantile(us, 0.99), Quantile(us, 0.999), lost);
}

constexpr double kBody_m = 0.02;

double Bump(const Vec3& d) { return 1 + 0.02 * std::sin(20 * d.x) * std::sin(17 * d.y) * std::sin(23 * d.z); }

// A bumpy ball, 12 n^2 triangles.
Scene Bumpy(int n) {
  return Built(SceneOf(CubeGrid(n, [](const Vec3& p) {
    const Vec3 d = Normalized(p);
    return (kBody_m * Bump(d)) * d;
  })));
}

// Wanders over the body, `way_m` a tick, pressing by up to `press_m` and leaving it now and then.
void TimeBall(const Scene& scene, double radius_m, double way_m, double press_m) {
  const Surface surface(scene, {});
  const Object& object = scene.objects()[0];
  Random random(1);
  Vec3 d{0, 0, 1}, turn = random.InBox(1);
  constexpr int kTicks = 20000;
  std::vector<Vec3> tips;
  for (int k = 0; k < kTicks; ++k) {
    turn = Normalized(turn + random.InBox(0.1));
    d = Normalized(d + (way_m / kBody_m) * Normalized(Cross(d, turn)));
    tips.push_back((kBody_m * Bump(d) + radius_m - press_m * (0.6 + std::sin(0.01 * k))) * d);
  }
  BallState state = StartBall(surface, object.root, Inside::kBySign, radius_m, tips[0]);
  int lost = 0, unsettled = 0, touches = 0;
  const std::vector<double> us = Time_us(kTicks, lost, [&](int k) {
    const BallContact contact = FollowBall(surface, object.root, radius_m, tips[static_cast<std::size_t>(k)], state);
    unsettled += !contact.settled;
    touches += contact.touch_count > 0;
  });
  char what[64];
  std::snprintf(what, sizeof what, "ball, touching %.0f %%", 100.0 * touches / kTicks);
  Print(what, scene.header().triangle_count, radius_m, way_m, us, lost);
  if (unsettled > 0) std::printf("%26s %d of %d ticks not settled\n", "", unsettled, kTicks);
}

void TimeShading(const Scene& scene) {
  const Surface surface(scene, {});
  Random random(2);
  std::vector<std::uint32_t> triangles;
  for (int k = 0; k < 20000; ++k) {
    triangles.push_back(static_cast<std::uint32_t>(random.Next() % scene.header().triangle_count));
  }
  int lost = 0;
  Vec3 sum;
  for (const bool same : {true, false}) {
    const std::vector<double> us = Time_us(20000, lost, [&](int k) {
      sum = sum + ShadedNormal(surface, triangles[static_cast<std::size_t>(same ? k / 50 : k)], {0.5, 0.3, 0.2});
    });
    Print(same ? "shading, 50 ticks a facet" : "shading, another facet", scene.header().triangle_count, 0, 0, us, lost);
  }
  if (!(Norm(sum) > 0)) std::printf("no normal\n");
}

int Run() {
  std::printf("%-26s %7s %6s %6s %8s %8s %8s %6s\n", "what", "tris", "r mm", "mm", "med us", "p99", "p99.9", "lost");
  for (const int n : {10, 30, 91}) {
    const Scene scene = Bumpy(n);
    for (const double radius_m : {1e-4, 5e-4, 1e-3, 2e-3, 5e-3, 1e-2}) {
      TimeBall(scene, radius_m, 1e-4, 1e-3);
      TimeBall(scene, radius_m, 6e-4, 1e-3);
    }
    TimeShading(scene);
  }
  return 0;
}

}  // namespace
}  // namespace omni::haptics

int main() { return omni::haptics::Run(); }
