// Evaluates a finished run: the loop's recording against the twin's truth, and what the application saw.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "service/base/result.h"
#include "service/base/vec.h"
#include "service/device/recording/recording_reader.h"
#include "service/haptics/scene/scene.h"
#include "service/tools/common/files.h"

namespace omni::tools {

constexpr double kTracked_m = 0.003;
constexpr double kContact_N = 0.010;  // rendered force of a tick that counts as contact

// A pose that the tracker published while tracking.
struct TrackedPosition {
  double t_ns = 0;
  base::Vec3 magnet_base_m;
  double sigma_m = 0;  // published standard deviation of the whole vector; 0: unknown
};

// |magnet centre - truth|, base frame, not aligned, each estimate against the truth at its own stamp.
struct TrackingErrors {
  std::uint64_t compared_ticks = 0;  // tracked ticks with a true pose to compare with
  // Not measured: NaN.
  double mean_mm = 0, p95_mm = 0, max_mm = 0;
  double sigma_median_mm = 0;  // published
  double silent_share = 0;     // of ticks that are wrong by more than five published standard deviations
};
// Precondition: `truth` is a recording of the twin.
TrackingErrors CompareTracking(const std::vector<TrackedPosition>& tracked, const CsvTable& truth);

// How the base is used in a run, from the twin's truth: how near the housing the pen is while the coils push, and the
// force that it feels.
constexpr double kPushed_N = 0.05;  // force of the coils from which on they push
constexpr int kReached_ticks = 5;   // a force counts as reached that lasts so long

// What is not measured is NaN: the coils never pushed, or the recording has no forces.
struct ForceUse {
  double reached_N = 0;                                    // magnetic force on the pen meanwhile
  double gap_mean_mm = 0, gap_p95_mm = 0, gap_max_mm = 0;  // from the magnet to the hull
};
// Precondition: `truth` is a recording of the twin.
ForceUse MeasureUse(const CsvTable& truth);

struct RunReport {
  std::string scene;
  std::string app;
  std::string profile;  // empty: none became current
  std::uint64_t ticks = 0;
  std::uint64_t late_ticks = 0;
  TrackingErrors tracking;
  // Of the ticks with the pen there: tracked with three published standard deviations of at most kTracked_m, and
  // tracked less well. NaN: the recording has no standard deviations.
  double tracked_fraction = 0, coarse_fraction = 0;
  std::uint64_t contact_ticks = 0;  // rendered force over kContact_N
  double peak_force_N = 0;          // commanded
  ForceUse use;
  std::uint64_t haptic_pulses = 0;  // that reached the coil command
  std::uint64_t select_edges = 0;   // false -> true seen by the app's own xrGetActionState
  double pose_valid_fraction = 0;   // of the app's locates after the first valid one
  double locate_ns_median = 0;
  bool simulation = true;  // the truth comes from the digital twin
};

struct RunFiles {
  std::string loop, truth, app;
};

// One of them: the option that names it, and where it comes from.
struct RunFileEntry {
  const char* option;
  std::string RunFiles::*path;
  const char* what;
};
inline constexpr RunFileEntry kRunFiles[] = {
    {"--loop", &RunFiles::loop, "the ticks: the CSV file of `omnid --record`"},
    {"--truth", &RunFiles::truth, "the twin's truth: the CSV file of `omnid --twin-record`"},
    {"--app", &RunFiles::app, "what the application saw: the JSON file of `omni_probe --json`"}};

// The recordings, kept for the picture.
struct RunData {
  CsvTable loop;
  CsvTable truth;
};

// Errors: "--loop: FILE: what is wrong; expected ...".
base::Result<RunReport> MakeReport(const std::string& scene, const RunFiles& files, RunData& data);

nlohmann::json ToJson(const RunReport& report);

// Failed expectations, one line each; empty: the run passed.
std::vector<std::string> Shortcomings(const RunReport& report);

// A scene as a picture of a run shows it: the triangles that are seen from one side, shaded, the furthest first.

// An orthographic view. right, up: unit, at right angles; what is seen is within half_m of the centre.
struct SceneView {
  base::Vec3 centre_m, right, up;
  double half_m = 0.05;
};

struct DrawnTriangle {
  base::Vec3 corners_m[3];
  double brightness = 1;  // 0 to 1: of the side that is seen
};

// What covers no cell of a grid of `cells` x `cells` over the view is left out.
std::vector<DrawnTriangle> SeenTriangles(const haptics::Scene& scene, const SceneView& view, int cells);

// A run as an SVG picture: the tip's path in side and top view with contacts, force and inputs over time.

// `scene` may be empty: then only the hull and the path are drawn.
std::string DrawRun(const RunReport& report, const RunData& data, const haptics::Scene& scene, double hull_radius_m);

// Summary of a device recording, as text and as JSON.

// Several lines, each with its newline.
std::string RecordingText(const std::string& path, const device::RecordingSummary& summary);
nlohmann::ordered_json RecordingJson(const std::string& path, const device::RecordingSummary& summary);

}  // namespace omni::tools
