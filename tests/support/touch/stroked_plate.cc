#include "tests/support/touch/stroked_plate.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <vector>

#include "service/config/files/device_file.h"
#include "service/config/files/twin_file.h"
#include "service/daemon/virtual_run.h"
#include "service/haptics/scene/scene.h"
#include "service/sim/twin/twin.h"
#include "service/tools/common/files.h"
#include "tests/support/touch/ripple.h"

namespace omni::test {
namespace {

constexpr double kHalf_m = 0.025, kTop_m = 0.055, kBottom_m = 0.045;
constexpr double kReach_m = 0.018;   // strokes from -kReach_m to kReach_m along x
constexpr double kPress_m = 0.0025;  // below the surface, of the hand's aim
constexpr double kRest_s = 2, kSettle_s = 1;
constexpr double kJudged = 0.7;  // of a stroke, in the middle
constexpr int kPairs = 2;        // of strokes there and back

base::Result<haptics::Scene> SceneOf(const GratedPlate& grated) {
  haptics::InputObject plate;
  plate.name = "plate";
  for (int k = 0; k < 8; ++k) {
    plate.vertices_base_m.push_back(
        {(k & 1) != 0 ? kHalf_m : -kHalf_m, (k & 2) != 0 ? kHalf_m : -kHalf_m, (k & 4) != 0 ? kTop_m : kBottom_m});
  }
  plate.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                     {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  plate.triangle_material.assign(plate.triangles.size(), 0);
  haptics::Material material;
  material.stiffness_N_m = 600;
  material.static_friction = 1.25 * grated.friction;
  material.dynamic_friction = grated.friction;
  material.texture_amplitude_m = grated.amplitude_m;
  material.texture_wavelength_m = grated.wavelength_m;
  haptics::SceneInput input;
  input.objects.push_back(plate);
  input.materials.push_back(material);
  haptics::BuildReport report;
  return haptics::BuildScene(input, report);
}

struct Times {
  double rest_s = 0, first_s = 0, stroke_s = 0;
};

sim::HandScript StrokingHand(double speed_m_s, Times& times) {
  sim::HandScript hand;
  hand.name = "strokes";
  hand.stiffness_N_m = 150;
  hand.damping_Ns_m = 3;
  hand.mass_kg = 0.12;
  hand.tremor_m = 5e-5;
  times.stroke_s = 2 * kReach_m / speed_m_s;
  const auto add = [&](double s, double x, double height_m) {
    hand.waypoints.push_back({s, {x, 0, kTop_m + height_m}, {0, 0, -1}, true});
  };
  add(0, -kReach_m, 0.012);
  add(1, -kReach_m, 0.001);
  add(0.6, -kReach_m, -kPress_m);
  add(kSettle_s + kRest_s, -kReach_m, -kPress_m);
  times.rest_s = 1.6 + kSettle_s;
  times.first_s = times.rest_s + kRest_s;
  for (int k = 0; k < kPairs; ++k) {
    add(times.stroke_s, kReach_m, -kPress_m);
    add(times.stroke_s, -kReach_m, -kPress_m);
  }
  add(0.3, -kReach_m, -kPress_m);
  add(0.3, -kReach_m, 0.012);
  return hand;
}

// What the twin recorded, by its own time.
struct Truth {
  std::vector<double> t_s, x_m, z_N;

  std::size_t IndexAt(double t) const {
    return static_cast<std::size_t>(std::lower_bound(t_s.begin(), t_s.end(), t) - t_s.begin());
  }
  std::size_t FurthestIn(double from_s, double to_s, double sign) const {
    const auto at = [&](double t) { return x_m.begin() + static_cast<std::ptrdiff_t>(IndexAt(t)); };
    const auto further = [sign](double a, double b) { return sign * a < sign * b; };
    return static_cast<std::size_t>(std::max_element(at(from_s), at(to_s), further) - x_m.begin());
  }
  StrokeForce Between(std::size_t from, std::size_t to) const {
    const auto cut = [&](const std::vector<double>& v) {
      return std::vector(v.begin() + static_cast<std::ptrdiff_t>(from), v.begin() + static_cast<std::ptrdiff_t>(to));
    };
    return {cut(x_m), cut(z_N)};
  }
};

base::Result<Truth> ReadTruth(const std::string& recording) {
  const auto table = tools::CsvTable::Read(recording);
  if (!table.ok()) return base::Error{table.error()};
  Truth truth{.t_s = (*table)["t_ns"], .x_m = (*table)["tip_x_m"], .z_N = (*table)["coil_force_z_N"]};
  const double start_ns = truth.t_s.front();
  for (double& t : truth.t_s) t = 1e-9 * (t - start_ns);
  return truth;
}

// Rms without what is slower than 4 Hz.
double Buzz_N(const std::vector<double>& force_N) {
  constexpr std::size_t kHalf = 125;
  std::vector<double> fast;
  for (std::size_t i = kHalf; i + kHalf < force_N.size(); ++i) {
    const auto at = force_N.begin() + static_cast<std::ptrdiff_t>(i);
    fast.push_back(*at - std::accumulate(at - kHalf, at + kHalf + 1, 0.0) / (2 * kHalf + 1));
  }
  return Rms(fast);
}

// One stroke there and back, from `from_s` on.
void Judge(const Truth& truth, double from_s, double stroke_s, double wavelength_m, FeltGrating& felt) {
  constexpr double kLate_s = 0.3;  // a hand is late
  const double half_s = from_s + stroke_s, end_s = half_s + stroke_s;
  const std::size_t far = truth.FurthestIn(from_s, end_s, 1);
  const std::size_t first = truth.FurthestIn(from_s - kLate_s, truth.t_s[far], -1);
  const std::size_t last = truth.FurthestIn(truth.t_s[far], end_s + kLate_s, -1);
  const double low_m = std::max(truth.x_m[first], truth.x_m[last]), length_m = truth.x_m[far] - low_m;
  const double step_m = wavelength_m / kPerWave;
  const auto ripple = [&](std::size_t from, std::size_t to) {
    return WithoutWander(ForceByPlace(truth.Between(from, to), low_m + 0.5 * (1 - kJudged) * length_m, step_m,
                                      static_cast<std::size_t>(kJudged * length_m / step_m)));
  };
  const auto there = ripple(first, far), back = ripple(far, last);
  felt.in_band += (ShareInBand(there) + ShareInBand(back)) / (2 * kPairs);
  felt.correlation += Correlation(there, back) / kPairs;
  felt.delivered_N += (Rms(there) + Rms(back)) / (2 * kPairs);
}

}  // namespace

base::Result<FeltGrating> StrokePlate(const loop::TickConfig& config, const GratedPlate& plate, double speed_m_s,
                                      std::uint64_t seed, const std::filesystem::path& recording) {
  const auto scene = SceneOf(plate);
  if (!scene.ok()) return base::Error{scene.error()};
  const auto room = config::FindTwin("");
  if (!room.ok()) return base::Error{room.error()};
  Times times;
  const sim::HandScript hand = StrokingHand(speed_m_s, times);
  std::filesystem::remove(recording);
  auto twin = sim::MakeVirtualTwin(config::DefaultDevice(),
                                   {.seed = seed, .script = hand, .truth = *room, .recording_path = recording.string()},
                                   hand.duration_s());
  daemon::RunVirtual(config, *twin, *scene);
  twin.reset();  // completes the recording
  const auto truth = ReadTruth(recording.string());
  if (!truth.ok()) return base::Error{truth.error()};
  FeltGrating felt;
  felt.rest_N = Buzz_N(truth->Between(truth->IndexAt(times.rest_s), truth->IndexAt(times.first_s)).force_N);
  for (int k = 0; k < kPairs; ++k) {
    Judge(*truth, times.first_s + 2 * k * times.stroke_s, times.stroke_s, plate.wavelength_m, felt);
  }
  return felt;
}

}  // namespace omni::test
