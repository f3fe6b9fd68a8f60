// omni-bench race: the shipped track and car, a pen held still at the joystick's centre of a calibrated base in a room,
// and hits of the wall beside it at 20 speeds up to the car's greatest. felt_N: the magnetic force on the pen along the
// push of the hit, from the twin's own record of the truth.
#include <cmath>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <unistd.h>

#include "service/base/force_limit.h"
#include "service/config/files/device_file.h"
#include "service/config/files/twin_file.h"
#include "service/haptics/scene/scene.h"
#include "service/haptics/vehicle/car_force.h"
#include "service/haptics/vehicle/wall_map.h"
#include "service/loop/realtime.h"
#include "service/loop/tick_config.h"
#include "service/scene/scene_file.h"
#include "service/sim/twin/twin.h"
#include "service/tools/calibrate/calibrate_twin.h"
#include "service/tools/common/files.h"
#include "service/tools/scene/scene.h"
#include "tests/bench/haptics/race.h"
#include "tests/bench/harness/bench.h"
#include "tests/bench/harness/work_folder.h"

namespace omni::bench {
namespace {

constexpr int kSpeeds = 20;
constexpr double kSlowest = 0.05;  // of the car's greatest speed
constexpr int kHitTick = 1000;     // the gate is open, the hand has come to rest
constexpr int kHitRunTicks = 1100;
constexpr int kBaselineTicks = 100;  // before the hit: their mean is subtracted
constexpr double kBesideWall_m = 1e-5;

double SpeedOf(double fastest_m_s, int k) {
  return fastest_m_s * std::pow(kSlowest, 1 - static_cast<double>(k) / (kSpeeds - 1));
}

struct HitRun {
  double pulse_N = 0;      // amplitude of the hit
  double commanded_N = 0;  // peak of what was sent to the coils, along the push
  double felt_N = 0;       // peak of the force on the magnet, along the push, over its mean before the hit
  double limit_N = 0;      // what the device can do along it, at that pose
  std::uint32_t hits = 0;
};

base::Result<haptics::Scene> ShippedTrack() {
  scene::LoadReport load;
  auto input = scene::LoadSceneFile(tools::ShippedScene("racetrack"), {}, load);
  if (!input.ok()) return base::Error{input.error()};
  if (!input->vehicle || !input->joystick) return base::Error{"racetrack: has no vehicle or no joystick"};
  haptics::BuildReport report;
  return haptics::BuildScene(*input, report);
}

// Beside the wall nearest to its start, just before a head-on hit.
void Aim(const haptics::Scene& scene, double speed_m_s, base::Vec3& normal, haptics::VehicleState& car) {
  const haptics::Wall wall = haptics::NearestWall(haptics::WallsOf(scene), car.position_base_m, 1);
  const double closer_m = wall.distance_m - scene.header().vehicle.radius_m - kBesideWall_m;
  normal = wall.normal;
  car.position_base_m = car.position_base_m + (-closer_m) * normal;
  car.velocity_base_m_s = (-speed_m_s) * normal;
  car.heading_rad = std::atan2(-normal.y, -normal.x);
}

base::Result<double> RenderedPeak_N(const std::string& recording, const base::Vec3& push) {
  auto truth = tools::CsvTable::Read(recording);
  if (!truth.ok()) return base::Error{truth.error()};
  if (truth->rows() < kHitRunTicks) return base::Error{recording + ": the twin recorded too few ticks"};
  std::vector<double> along_N(truth->rows());
  for (std::size_t i = 0; i < along_N.size(); ++i) {
    along_N[i] = Dot({(*truth)["force_x_N"][i], (*truth)["force_y_N"][i], (*truth)["force_z_N"][i]}, push);
  }
  double mean_N = 0, peak_N = 0;
  for (int i = kHitTick - kBaselineTicks; i < kHitTick; ++i) mean_N += along_N[static_cast<std::size_t>(i)];
  mean_N /= kBaselineTicks;
  for (std::size_t i = kHitTick; i < along_N.size(); ++i) peak_N = std::max(peak_N, along_N[i] - mean_N);
  return peak_N;
}

base::Result<HitRun> RunHit(const haptics::Scene& scene, const loop::TickConfig& config,
                            const base::TruthParameters& room, double speed_m_s, std::uint64_t seed,
                            const std::string& recording) {
  const base::DeviceGeometry& device = config::DefaultDevice();
  sim::HandScript still;
  still.name = "still";
  still.waypoints.push_back({.tip_base_m = scene.header().joystick.centre_base_m});
  std::filesystem::remove(recording);
  auto twin = sim::MakeVirtualTwin(device, {.seed = seed, .script = still, .truth = room, .recording_path = recording},
                                   (kHitRunTicks + 50) * base::kTickPeriod_s);
  const auto state = std::make_unique<loop::LoopState>();
  const auto output = std::make_unique<loop::TickOutput>();
  loop::EnterScene(scene, 1, *state);
  HitRun run;
  base::Vec3 normal, push;
  base::HallScan scan;
  for (int tick = 0; twin->Read(scan, 0) == device::ReadStatus::kScan; ++tick) {
    haptics::VehicleState& car = state->haptics.vehicle;
    if (tick == kHitTick) {
      Aim(scene, speed_m_s, normal, car);
      push = haptics::HitDirection(scene.header().vehicle, normal, scene.header().joystick.centre_base_m);
    }
    loop::Tick(config, scan, {.t_ns = scan.t_ns, .gate = loop::ForceGate::kOpen, .idle = false, .scene_generation = 1},
               scene, *state, *output);
    twin->Write(output->currents);
    if (tick < kHitTick) continue;
    run.commanded_N = std::max(run.commanded_N, Dot(output->wrench.force_N, push));
    for (const haptics::HitPulse& pulse : car.pulses) run.pulse_N = std::max(run.pulse_N, pulse.amplitude_N);
    if (tick > kHitTick) continue;
    run.limit_N =
        base::ForceMax_N(actuation::ComputeDeratedLimit(config.actuation, output->tool, state->actuation.heat), push);
  }
  run.hits = state->haptics.vehicle.hits;
  twin.reset();  // closes the recording
  const auto felt = RenderedPeak_N(recording, push);
  if (!felt.ok()) return base::Error{felt.error()};
  run.felt_N = *felt;
  return run;
}

}  // namespace

base::Result<BenchRows> BenchRace(const BenchOptions& options) {
  loop::FlushDenormals();
  auto scene = ShippedTrack();
  if (!scene.ok()) return base::Error{scene.error()};
  const WorkFolder scratch;
  if (scratch.path().empty()) return base::Error{"no folder for the twin's recordings can be made; check $TMPDIR"};
  BenchRows rows;
  const double fastest_m_s = scene->header().vehicle.speed_max_m_s;
  std::vector<std::uint64_t> seeds = ThreeSeeds(options.seed);
  if (options.quick) seeds.resize(1);
  const auto room = config::FindTwin("");
  if (!room.ok()) return base::Error{room.error()};
  for (const std::uint64_t seed : seeds) {
    const auto calibration = tools::KeptTwinCalibration(config::DefaultDevice(), seed, "");
    if (!calibration.ok()) return base::Error{calibration.error()};
    const loop::TickConfig config = loop::MakeTickConfig(config::DefaultDevice(), *calibration);
    HitRun last;
    for (int k = 0; k < kSpeeds; ++k) {
      const auto run =
          RunHit(*scene, config, *room, SpeedOf(fastest_m_s, k), seed, (scratch.path() / "truth.csv").string());
      if (!run.ok()) return base::Error{run.error()};
      if (run->hits != 1) return base::Error{"the car hit " + std::to_string(run->hits) + " times in place of once"};
      rows.push_back({{"seed", seed},
                      {"speed_m_s", SpeedOf(fastest_m_s, k)},
                      {"pulse_N", run->pulse_N},
                      {"commanded_peak_N", run->commanded_N},
                      {"felt_peak_N", run->felt_N},
                      {"limit_N", run->limit_N},
                      {"commanded_monotone", run->pulse_N > last.pulse_N && run->commanded_N > last.commanded_N},
                      {"felt_monotone", run->felt_N > last.felt_N},
                      {"within_limit", run->pulse_N <= run->limit_N && run->commanded_N <= run->limit_N}});
      last = *run;
    }
  }
  constexpr std::uint64_t kThrows = 100'000;
  BenchRaceWalls(options.seed, options.quick ? kThrows / 100 : kThrows, rows);
  const base::Status timed = BenchRaceCost(rows);
  if (!timed.ok()) return base::Error{timed.error()};
  return rows;
}

}  // namespace omni::bench
