#include "service/tools/recordings/report.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <nlohmann/json.hpp>

#include "service/base/tool_state.h"
#include "service/tools/common/files.h"
#include "service/tools/common/row_table.h"

namespace omni::tools {
namespace {

using nlohmann::json;

// Piecewise linear truth at t_ns; the twin records every device tick. False: outside the recording, or no pen present.
struct Truth {
  const CsvTable& table;
  const std::vector<double>& t_ns;

  bool At(double wanted_ns, double position_m[3]) const {
    const auto after = std::lower_bound(t_ns.begin(), t_ns.end(), wanted_ns);
    if (after == t_ns.end()) return false;
    const auto i1 = static_cast<std::size_t>(after - t_ns.begin());
    const std::size_t i0 = i1 == 0 ? 0 : i1 - 1;
    const std::vector<double>& present = table["present"];
    if (present[i0] < 0.5 || present[i1] < 0.5) return false;
    const double span_ns = t_ns[i1] - t_ns[i0];
    const double s = span_ns > 0 ? (wanted_ns - t_ns[i0]) / span_ns : 0;
    static const char* const kColumns[3] = {"magnet_x_m", "magnet_y_m", "magnet_z_m"};
    for (int axis = 0; axis < 3; ++axis) {
      const std::vector<double>& column = table[kColumns[axis]];
      position_m[axis] = column[i0] + s * (column[i1] - column[i0]);
    }
    return s >= 0;
  }
};

constexpr const char* kSigma = "sigma_m";  // recordings of older versions have none

bool IsTracked(const CsvTable& loop, std::size_t i) {
  return loop["status"][i] == static_cast<double>(base::TrackingStatus::kTracking);
}

std::vector<TrackedPosition> TrackedOf(const CsvTable& loop) {
  const std::vector<double>&x = loop["magnet_x_m"], &y = loop["magnet_y_m"], &z = loop["magnet_z_m"];
  std::vector<TrackedPosition> tracked;
  for (std::size_t i = 0; i < loop.rows(); ++i) {
    if (!IsTracked(loop, i)) continue;
    tracked.push_back({loop["t_ns"][i], {x[i], y[i], z[i]}, loop.HasColumn(kSigma) ? loop[kSigma][i] : 0});
  }
  return tracked;
}

void CountTracked(const CsvTable& loop, const CsvTable& table, RunReport& report) {
  const Truth truth{table, table["t_ns"]};
  std::size_t there = 0, tracked = 0, coarse = 0;
  for (std::size_t i = 0; loop.HasColumn(kSigma) && i < loop.rows(); ++i) {
    double p[3];
    if (!truth.At(loop["t_ns"][i], p)) continue;
    ++there;
    if (!IsTracked(loop, i)) continue;
    ++(3 * loop[kSigma][i] <= kTracked_m ? tracked : coarse);
  }
  report.tracked_fraction = static_cast<double>(tracked) / static_cast<double>(there);
  report.coarse_fraction = static_cast<double>(coarse) / static_cast<double>(there);
}

void CountTicks(const CsvTable& loop, RunReport& report) {
  report.ticks = loop.rows();
  for (std::size_t i = 0; i < loop.rows(); ++i) {
    const double force_N = std::hypot(loop["force_x_N"][i], loop["force_y_N"][i], loop["force_z_N"][i]);
    report.late_ticks += loop["late"][i] > 0.5 ? 1 : 0;
    report.contact_ticks += force_N > kContact_N ? 1 : 0;
    report.peak_force_N = std::max(report.peak_force_N, force_N);
  }
  report.haptic_pulses = static_cast<std::uint64_t>(loop["haptic_pulses"].back());
}

// Why a file cannot be evaluated, with the option that names it.
base::Error NotJudged(const RunFileEntry& entry, const std::string& why) {
  return {std::string(entry.option) + ": " + why + "; expected " + entry.what};
}

base::Result<CsvTable> ReadTable(const RunFiles& files, const RunFileEntry& entry,
                                 const std::vector<std::string>& columns) {
  const std::string& path = files.*entry.path;
  base::Result<CsvTable> table = CsvTable::Read(path);
  if (!table.ok()) return NotJudged(entry, table.error());
  if (const std::string missing = table->MissingColumns(columns); !missing.empty()) {
    return NotJudged(entry, path + ": columns missing: " + missing);
  }
  if (table->rows() == 0) return NotJudged(entry, path + ": no rows after its header");
  return table;
}

base::Status ReadApp(const RunFiles& files, const RunFileEntry& entry, RunReport& report) {
  const std::string& path = files.*entry.path;
  const base::Result<std::string> text = ReadJsonFile(path, kManifestJson);
  if (!text.ok()) return NotJudged(entry, text.error());
  const json app = json::parse(*text);
  if (!app.contains("application") || !app["application"].is_string()) {
    return NotJudged(entry, path + ": /application is missing or not a string");
  }
  for (const char* key : {"select_edges", "pose_valid_fraction", "locate_ns_median"}) {
    const bool number = app.contains(key) && app[key].is_number();
    if (!number) return NotJudged(entry, path + ": /" + key + " is missing or not a number");
  }
  report.app = app["application"];
  if (app.contains("profile") && app["profile"].is_string()) report.profile = app["profile"];
  report.select_edges = app["select_edges"];
  report.pose_valid_fraction = app["pose_valid_fraction"];
  report.locate_ns_median = app["locate_ns_median"];
  return base::Ok{};
}

constexpr double kSilentSigmas = 5;

}  // namespace

TrackingErrors CompareTracking(const std::vector<TrackedPosition>& tracked, const CsvTable& table) {
  const Truth truth{table, table["t_ns"]};
  std::vector<double> errors_mm, sigmas_mm;
  std::size_t silent = 0;
  for (const TrackedPosition& estimate : tracked) {
    double p[3];
    if (!truth.At(estimate.t_ns, p)) continue;
    const base::Vec3& q = estimate.magnet_base_m;
    errors_mm.push_back(1e3 * std::hypot(q.x - p[0], q.y - p[1], q.z - p[2]));
    if (!(estimate.sigma_m > 0)) continue;
    sigmas_mm.push_back(1e3 * estimate.sigma_m);
    if (errors_mm.back() > kSilentSigmas * sigmas_mm.back()) ++silent;
  }
  return {.compared_ticks = errors_mm.size(),
          .mean_mm = Mean(errors_mm),
          .p95_mm = Quantile(errors_mm, 0.95),
          .max_mm = Quantile(errors_mm, 1.0),
          .sigma_median_mm = Quantile(sigmas_mm, 0.5),
          .silent_share = static_cast<double>(silent) / static_cast<double>(sigmas_mm.size())};
}

ForceUse MeasureUse(const CsvTable& table) {
  static const std::vector<std::string> kColumns = {"gap_m",          "force_x_N",      "force_y_N",     "force_z_N",
                                                    "coil_force_x_N", "coil_force_y_N", "coil_force_z_N"};
  if (!table.MissingColumns(kColumns).empty()) return {kNotMeasured, kNotMeasured, kNotMeasured, kNotMeasured};
  const auto size_N = [&](const std::string& of, std::size_t i) {
    return std::hypot(table[of + "_x_N"][i], table[of + "_y_N"][i], table[of + "_z_N"][i]);
  };
  std::vector<double> gaps_mm, felt_N(table.rows());
  for (std::size_t i = 0; i < table.rows(); ++i) {
    if (!(size_N("coil_force", i) > kPushed_N)) continue;
    felt_N[i] = size_N("force", i);
    gaps_mm.push_back(1e3 * table["gap_m"][i]);
  }
  double reached_N = kNotMeasured;
  for (std::size_t i = kReached_ticks; !gaps_mm.empty() && i <= felt_N.size(); ++i) {
    const auto end = felt_N.begin() + static_cast<std::ptrdiff_t>(i);
    reached_N = std::fmax(reached_N, *std::min_element(end - kReached_ticks, end));
  }
  return {reached_N, Mean(gaps_mm), Quantile(gaps_mm, 0.95), Quantile(gaps_mm, 1.0)};
}

base::Result<RunReport> MakeReport(const std::string& scene, const RunFiles& files, RunData& data) {
  const auto& [loop_entry, truth_entry, app_entry] = kRunFiles;
  auto loop = ReadTable(files, loop_entry,
                        {"t_ns", "status", "late", "force_x_N", "force_y_N", "force_z_N", "magnet_x_m", "magnet_y_m",
                         "magnet_z_m", "tip_x_m", "tip_y_m", "tip_z_m", "select", "haptic_pulses"});
  if (!loop.ok()) return base::Error{loop.error()};
  auto truth = ReadTable(files, truth_entry, {"t_ns", "present", "magnet_x_m", "magnet_y_m", "magnet_z_m"});
  if (!truth.ok()) return base::Error{truth.error()};
  data = {.loop = std::move(*loop), .truth = std::move(*truth)};
  RunReport report{.scene = scene};
  report.tracking = CompareTracking(TrackedOf(data.loop), data.truth);
  report.use = MeasureUse(data.truth);
  CountTracked(data.loop, data.truth, report);
  CountTicks(data.loop, report);
  const base::Status app = ReadApp(files, app_entry, report);
  if (!app.ok()) return base::Error{app.error()};
  return report;
}

json ToJson(const RunReport& r) {
  return {{"scene", r.scene},
          {"app", r.app},
          {"profile", r.profile.empty() ? json() : json(r.profile)},
          {"ticks", r.ticks},
          {"late_ticks", r.late_ticks},
          {"compared_ticks", r.tracking.compared_ticks},
          {"tracked_fraction", r.tracked_fraction},
          {"coarse_fraction", r.coarse_fraction},
          {"tracking_mean_mm", r.tracking.mean_mm},
          {"tracking_p95_mm", r.tracking.p95_mm},
          {"tracking_max_mm", r.tracking.max_mm},
          {"contact_ticks", r.contact_ticks},
          {"peak_force_N", r.peak_force_N},
          {"force_reached_N", r.use.reached_N},
          {"gap_mean_mm", r.use.gap_mean_mm},
          {"gap_p95_mm", r.use.gap_p95_mm},
          {"select_edges", r.select_edges},
          {"haptic_pulses", r.haptic_pulses},
          {"pose_valid_fraction", r.pose_valid_fraction},
          {"locate_ns_median", r.locate_ns_median},
          {"simulation", r.simulation}};
}

std::vector<std::string> Shortcomings(const RunReport& r) {
  std::vector<std::string> lines;
  const auto expect = [&](bool holds, const std::string& what) {
    if (!holds) lines.push_back(r.scene + ": " + what);
  };
  expect(r.tracking.compared_ticks > r.ticks / 2, "the pen was tracked in less than half of the ticks");
  expect(r.tracking.p95_mm < 5.0, "tracking error p95 over 5 mm");
  expect(!r.profile.empty(), "no interaction profile became current in the app");
  expect(r.pose_valid_fraction > 0.9, "the app saw a valid pose in less than 90 % of its locates");
  expect(r.contact_ticks > 100, "fewer than 100 ticks with a rendered force");
  expect(r.select_edges > 0, "the app saw no select press");
  expect(r.haptic_pulses > 0, "no haptic pulse reached the coils");
  return lines;
}

}  // namespace omni::tools
