// omni twin run: the whole loop against the twin in this process, in virtual time. Deterministic: prints a hash. The
// twin records its truth, which is compared after the run. omni twin path: a hand script for any scene.
#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "service/base/files/whole_file.h"
#include "service/config/files/calibration_file.h"
#include "service/config/files/device_file.h"
#include "service/config/files/twin_file.h"
#include "service/daemon/virtual_run.h"
#include "service/loop/tick_config.h"
#include "service/magnetics/nominal.h"
#include "service/sim/twin/twin.h"
#include "service/tools/calibrate/calibrate_twin.h"
#include "service/tools/common/child_program.h"
#include "service/tools/common/command_line.h"
#include "service/tools/common/output.h"
#include "service/tools/common/terminal.h"
#include "service/tools/hand/touch_places.h"
#include "service/tools/recordings/report.h"
#include "service/tools/scene/scene.h"

namespace omni::tools {
namespace {

constexpr double kTicksShown = 500;  // between two updates of the progress

struct RunArguments {
  std::string scene;
  std::string up = "y";
  std::string hand;
  std::string record;
  bool replace = false;
  std::string twin;
  std::string calibration;
  std::uint64_t seed = 1;
  double seconds = 0;
  bool as_json = false;
  bool as_drawn = false;
  bool fit = false;
  bool touch_all = false;
  bool flip_coil_sign = false;
  bool explain = false;
};

struct PathArguments {
  std::string scene, output, up = "y";
  bool calibration = false;
  bool fit = false, touch_all = false;
};

base::Result<sim::HandScript> HandFor(const RunArguments& arguments, const std::string& scene_path,
                                      const haptics::Scene& scene) {
  const std::string file = arguments.hand.empty() ? FindHandScript(scene_path) : arguments.hand;
  if (!file.empty()) return sim::LoadHandScript(file);
  return MakeHandPath(scene, {.places = {.hull_radius_m = config::DefaultDevice().hull_radius_m}});
}

base::Result<loop::TickConfig> ConfigFor(const RunArguments& arguments, const base::DeviceGeometry& device) {
  if (arguments.as_drawn) return loop::MakeTickConfig(device);
  if (arguments.calibration.empty()) {
    const auto kept = KeptTwinCalibration(device, arguments.seed, arguments.twin);
    if (!kept.ok()) return base::Error{kept.error()};
    return loop::MakeTickConfig(device, *kept);
  }
  auto file = config::LoadCalibrationFile(
      arguments.calibration, {.device = device, .drawing = magnetics::NominalCalibration(device), .serial = {}});
  if (!file.ok()) return base::Error{file.error()};
  return loop::MakeTickConfig(device, file->calibration);
}

std::string ErrorsText(const TrackingErrors& errors) {
  if (errors.compared_ticks == 0) return "tracking error   not measured\n";
  char text[256];
  std::snprintf(text, sizeof text,
                "tracking error   mean %.3f mm, p95 %.3f mm, max %.3f mm over %llu ticks\n"
                "published sigma  median %.3f mm; error above 5 sigma in %.2g of the ticks\n",
                errors.mean_mm, errors.p95_mm, errors.max_mm, static_cast<unsigned long long>(errors.compared_ticks),
                errors.sigma_median_mm, errors.silent_share);
  return text;
}

std::string UseText(const ForceUse& use) {
  if (!std::isfinite(use.gap_mean_mm)) return "gap in use       none: the coils never pushed\n";
  return Format("force reached    %.3f N, for %d ms\n", use.reached_N, kReached_ticks) +
         Format("gap in use       mean %.1f mm, p95 %.1f mm, max %.1f mm\n", use.gap_mean_mm, use.gap_p95_mm,
                use.gap_max_mm);
}

// Scans in a row that one hypothesis of the tracker explained.
struct Stretch {
  std::int64_t begin_ns = 0, end_ns = 0;  // stamps of the first and the last scan
  int scans = 0;
  const char* hypothesis = nullptr;  // null: there was no pose
};

void AddScan(std::int64_t t_ns, const char* hypothesis, std::vector<Stretch>& stretches) {
  if (stretches.empty() || stretches.back().hypothesis != hypothesis) stretches.push_back({t_ns, t_ns, 0, hypothesis});
  stretches.back().end_ns = t_ns;
  ++stretches.back().scans;
}

const char* NameOf(const Stretch& stretch) { return stretch.hypothesis ? stretch.hypothesis : "none: no pose"; }

std::string StretchesText(const std::vector<Stretch>& stretches) {
  std::string text = "explained by     from (s)   to (s)    scans\n";
  for (const Stretch& stretch : stretches) {
    text += Format("                 %8.3f %8.3f %8d  %s\n", 1e-9 * static_cast<double>(stretch.begin_ns),
                   1e-9 * static_cast<double>(stretch.end_ns), stretch.scans, NameOf(stretch));
  }
  return text;
}

nlohmann::ordered_json StretchesJson(const std::vector<Stretch>& stretches) {
  auto rows = nlohmann::ordered_json::array();
  for (const Stretch& stretch : stretches) {
    rows.push_back({{"begin_ns", stretch.begin_ns},
                    {"end_ns", stretch.end_ns},
                    {"scans", stretch.scans},
                    {"hypothesis", NameOf(stretch)}});
  }
  return rows;
}

nlohmann::ordered_json RunJson(const RunArguments& arguments, const std::string& scene, double seconds,
                               const daemon::VirtualRunSummary& summary, const TrackingErrors& errors,
                               const ForceUse& use) {
  return {{"simulation", true},
          {"scene", scene},
          {"seed", arguments.seed},
          {"seconds", seconds},
          {"ticks", summary.ticks},
          {"tracked_ticks", summary.tracked_ticks},
          {"contact_ticks", summary.contact_ticks},
          {"select_presses", summary.select_presses},
          {"peak_force_N", summary.peak_force_N},
          {"force_reached_N", use.reached_N},
          {"gap_mm", {{"mean", use.gap_mean_mm}, {"p95", use.gap_p95_mm}, {"max", use.gap_max_mm}}},
          {"compared_ticks", errors.compared_ticks},
          {"error_mm", {{"mean", errors.mean_mm}, {"p95", errors.p95_mm}, {"max", errors.max_mm}}},
          {"sigma_median_mm", errors.sigma_median_mm},
          {"silent_share", errors.silent_share},
          {"hash", Format("%016llx", static_cast<unsigned long long>(summary.hash))}};
}

int RunTwin(const RunArguments& arguments) {
  const base::Result<std::string> found = FindScene(arguments.scene);
  if (!found.ok()) return Fail("omni twin run", found.error());
  const std::string& path = *found;
  auto loaded = LoadLiveScene(path, LoadOptionsOf(arguments));
  if (!loaded.ok()) return Fail("omni twin run", loaded.error());
  for (const std::string& line : loaded->live.lines) Fail("omni twin run", path + ": " + line);
  auto hand = HandFor(arguments, path, loaded->scene);
  if (!hand.ok()) return Fail("omni twin run", hand.error());
  const base::DeviceGeometry& device = config::DefaultDevice();
  const double seconds = arguments.seconds > 0 ? arguments.seconds : hand->duration_s();
  const base::Result<base::TruthParameters> truth = config::FindTwin(arguments.twin);
  if (!truth.ok()) return Fail("omni twin run", truth.error());
  const auto tick = ConfigFor(arguments, device);
  if (!tick.ok()) return Fail("omni twin run", tick.error());
  const base::Result<PrivateFolder> folder = PrivateFolder::Make("omni-twin-run");
  if (!folder.ok()) return Fail("omni twin run", folder.error());
  const std::string recording = arguments.record.empty() ? folder->path() + "/truth.csv" : arguments.record;
  if (const std::string problem = base::NewFileProblem(recording, arguments.replace); !problem.empty()) {
    return Fail("omni twin run", problem);
  }
  if (const auto way = base::RemoveForNew(recording); !way.ok()) return Fail("omni twin run", way.error());
  auto twin = sim::MakeVirtualTwin(device,
                                   {.seed = arguments.seed,
                                    .script = *hand,
                                    .truth = *truth,
                                    .flip_coil_sign = arguments.flip_coil_sign,
                                    .recording_path = recording},
                                   seconds);
  std::vector<TrackedPosition> tracked;
  std::vector<Stretch> stretches;
  const std::function<bool(double)> progress = ProgressOnTerminal("run");
  double ticks = 0;
  const daemon::VirtualRunSummary summary =
      daemon::RunVirtual(*tick, *twin, loaded->scene, {}, [&](const base::HallScan& scan, const loop::TickOutput& out) {
        if (progress && std::fmod(++ticks, kTicksShown) == 0) progress(1e-3 * ticks / seconds);
        if (arguments.explain) AddScan(scan.t_ns, out.tool.hypothesis, stretches);
        if (out.tool.status != base::TrackingStatus::kTracking) return;
        const auto& C = out.tool.covariance;
        tracked.push_back({static_cast<double>(scan.t_ns), out.tool.position_base_m, std::sqrt(C[0] + C[6] + C[12])});
      });
  twin.reset();  // the recording is complete then
  const auto table = CsvTable::Read(recording);
  if (!table.ok()) return Fail("omni twin run", table.error());
  const TrackingErrors errors = CompareTracking(tracked, *table);
  const ForceUse use = MeasureUse(*table);
  if (arguments.as_json) {
    nlohmann::ordered_json run = RunJson(arguments, path, seconds, summary, errors, use);
    if (arguments.explain) run["explained"] = StretchesJson(stretches);
    PrintJson(run);
    return errors.compared_ticks > 0 ? kExitOk : kExitFailed;
  }
  std::printf("scene            %s\n", path.c_str());
  std::printf("what changes     %u soft bodies, %u sculptable surfaces\n", loaded->live.soft_bodies,
              loaded->live.sculpt_sessions);
  std::printf("device           digital twin (a simulation), seed %llu\n",
              static_cast<unsigned long long>(arguments.seed));
  std::printf("ticks            %llu (virtual time, %.3f s)\n", static_cast<unsigned long long>(summary.ticks),
              seconds);
  std::printf("tracked ticks    %llu\n", static_cast<unsigned long long>(summary.tracked_ticks));
  std::printf("contact ticks    %llu\n", static_cast<unsigned long long>(summary.contact_ticks));
  std::printf("select presses   %llu\n", static_cast<unsigned long long>(summary.select_presses));
  std::printf("peak force       %.3f N\n", summary.peak_force_N);
  std::printf("%s", UseText(use).c_str());
  std::printf("%s", ErrorsText(errors).c_str());
  std::printf("hash             %016llx\n", static_cast<unsigned long long>(summary.hash));
  if (arguments.explain) std::printf("%s", StretchesText(stretches).c_str());
  if (errors.compared_ticks > 0) return kExitOk;
  return Fail("omni twin run", "the pen was not tracked in any tick, so there is no error to report");
}

// Long enough to arm a base that was just plugged in and to sweep it before the pen arrives.
constexpr CalibratingHand kCalibratingHand{.away_s = 12};

base::Result<sim::HandScript> PathFor(const PathArguments& arguments) {
  if (arguments.calibration) return MakeCalibratingHand(config::DefaultDevice(), kCalibratingHand);
  if (arguments.scene.empty()) return base::Error{"needs a scene, or --calibration"};
  const base::Result<std::string> found = FindScene(arguments.scene);
  if (!found.ok()) return base::Error{found.error()};
  const std::string& path = *found;
  auto loaded = LoadScene(path, LoadOptionsOf(arguments));
  if (!loaded.ok()) return base::Error{loaded.error()};
  auto hand = MakeHandPath(loaded->scene, {.places = {.hull_radius_m = config::DefaultDevice().hull_radius_m}});
  if (!hand.ok()) return base::Error{path + ": " + hand.error()};
  return hand;
}

int WritePath(const PathArguments& arguments) {
  const base::Result<sim::HandScript> hand = PathFor(arguments);
  if (!hand.ok()) return Fail("omni twin path", hand.error());
  std::ofstream file(arguments.output);
  file << WriteHandScript(*hand);
  file.close();
  return file ? 0 : Fail("omni twin path", arguments.output + ": cannot be written");
}

}  // namespace

void AddTwin(Command& app) {
  Command twin = app.AddCommand("twin", "the digital twin: a simulated base, pen and hand");
  twin.RequireCommand();
  auto arguments = std::make_shared<RunArguments>();
  Command run = twin.AddCommand("run", "run the whole loop on the twin, in virtual time; prints a hash over all ticks");
  run.Add("scene", arguments->scene, "a .glb or .gltf file, or the name of a shipped scene").Required();
  run.Add("--seed", arguments->seed, "seed of noise and imperfections").ShowDefault();
  run.Add("--hand", arguments->hand, "hand script (default: the scene's own, else one that touches it)");
  run.Add("--seconds", arguments->seconds, "default: the script's length");
  run.Add("--record", arguments->record, "CSV file of the twin's truth, a new file");
  run.Add("--replace", arguments->replace, "--record replaces a file that exists");
  const Option twin_option = run.Add("--twin", arguments->twin, config::kTwinHelp);
  run.AddShort("--ideal", arguments->twin, config::kIdeal, config::kIdealHelp).Excludes(twin_option);
  Option calibration =
      run.Add("--calibration", arguments->calibration,
              "calibration.toml of `omni calibrate` with the same seed; default: computed once and cached");
  run.Add("--as-drawn", arguments->as_drawn, "use the nominal geometry, without a calibration").Excludes(calibration);
  AddUp(run, arguments->up);
  run.Add("--fit", arguments->fit, "scale and move the model into reach");
  run.Add("--touch-all", arguments->touch_all, "make a file without haptic tags touchable everywhere (--fit does too)");
  run.Add("--flip-coil-sign", arguments->flip_coil_sign, "wire coil z backwards (a fault, for tests)");
  run.Add("--explain", arguments->explain, "print which of the tracker's hypotheses explained the scans, by stretches");
  run.Add("--json", arguments->as_json, "as JSON");
  run.SetAction(arguments, RunTwin);

  auto path_arguments = std::make_shared<PathArguments>();
  Command path = twin.AddCommand("path", "write a hand script that touches a scene or calibrates the base");
  path.Add("scene", path_arguments->scene, "a .glb or .gltf file, or the name of a shipped scene");
  path.Add("--calibration", path_arguments->calibration,
           "what a person does for omni calibrate instead; needs no scene");
  path.Add("--output,-o", path_arguments->output, "hand script to write").Required();
  AddUp(path, path_arguments->up);
  path.Add("--fit", path_arguments->fit, "scale and move the model into reach");
  path.Add("--touch-all", path_arguments->touch_all,
           "make a file without haptic tags touchable everywhere (--fit does too)");
  path.SetAction(path_arguments, WritePath);
  AddTwinHand(twin);
}

}  // namespace omni::tools
