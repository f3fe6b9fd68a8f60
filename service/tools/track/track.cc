// omni track: a recording of any sensor array, tracked offline. docs/howto/track.md
#include "service/tools/track/track.h"

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>

#include <nlohmann/json.hpp>

#include "service/config/files/array_file.h"
#include "service/tools/common/command_line.h"
#include "service/tools/common/files.h"
#include "service/tools/common/row_table.h"
#include "service/tools/common/terminal.h"

namespace omni::tools {
namespace {

struct TrackArguments {
  std::string device, readings, truth;
  std::string output, residuals, json, convert;
  std::string data, layout;
  double magnet_diameter_mm = 10, magnet_height_mm = 10, noise_uT = 5;
  std::string currents = "auto";
};

struct Loaded {
  base::Calibration array;
  Recording recording;
  Truth truth;
};

base::Result<Loaded> Load(const TrackArguments& arguments) {
  Loaded loaded;
  std::string readings = arguments.readings, truth = arguments.truth;
  if (arguments.data.empty()) {
    auto array = LoadTrackDevice(arguments.device);
    if (!array.ok()) return base::Error{array.error()};
    loaded.array = std::move(*array);
  } else {
    auto array = ReadMagnet16Layout(arguments.data + "/layout-" + arguments.layout + ".csv",
                                    {.magnet_diameter_m = 1e-3 * arguments.magnet_diameter_mm,
                                     .magnet_height_m = 1e-3 * arguments.magnet_height_mm,
                                     .noise_T = 1e-6 * arguments.noise_uT});
    if (!array.ok()) return base::Error{array.error()};
    loaded.array = std::move(*array);
    truth = arguments.data + "/truth-" + readings + ".csv";
    readings = arguments.data + "/readings-" + readings + ".csv";
  }
  auto recording = ReadRecording(readings, loaded.array);
  if (!recording.ok()) return base::Error{recording.error()};
  loaded.recording = std::move(*recording);
  if (!truth.empty()) {
    auto read = ReadTruth(truth);
    if (!read.ok()) return base::Error{read.error()};
    loaded.truth = std::move(*read);
    const bool any = std::any_of(loaded.recording.poses.begin(), loaded.recording.poses.end(),
                                 [&](const RecordedPose& pose) { return loaded.truth.count(pose.number) != 0; });
    if (!any) {
      return base::Error{truth + ": has none of the poses of " + readings +
                         "; the numbers in the column pose must match"};
    }
  }
  return loaded;
}

// Device, readings and truth in our own formats.
std::string Convert(const TrackArguments& arguments, const Loaded& loaded) {
  std::error_code error;
  std::filesystem::create_directories(arguments.convert, error);
  if (error) return arguments.convert + ": cannot be created (" + error.message() + ")";
  std::string problem = WriteText(arguments.convert + "/device.toml", config::WriteArray(loaded.array));
  if (problem.empty()) problem = WriteText(arguments.convert + "/readings.csv", WriteRecording(loaded.recording));
  if (problem.empty() && !loaded.truth.empty()) {
    problem = WriteText(arguments.convert + "/truth.csv", WriteTruth(loaded.truth));
  }
  return problem;
}

base::Result<TrackCurrents> CurrentsOf(const TrackArguments& arguments, const Loaded& loaded) {
  const bool coils = std::any_of(loaded.array.sensors.begin(), loaded.array.sensors.end(),
                                 [](const auto& sensor) { return sensor.current_map_T_A != std::array<double, 9>{}; });
  if (arguments.currents == "hidden") {
    if (coils) return TrackCurrents::kHidden;
    return base::Error{"--currents hidden: the device has no coils (no current maps); leave the option out"};
  }
  if (loaded.recording.has_currents && !coils) {
    return base::Error{"the readings have currents but the device has no coils; add the device's windings or maps"};
  }
  if (arguments.currents == "measured" && !loaded.recording.has_currents) {
    return base::Error{"--currents measured: the readings have no columns i0_A, i1_A, i2_A"};
  }
  const bool assume_zero = arguments.currents == "zero";
  return coils && !loaded.recording.has_currents && !assume_zero ? TrackCurrents::kHidden : TrackCurrents::kMeasured;
}

void PrintFits(const std::vector<TrackedRow>& rows, TrackCurrents currents) {
  std::vector<double> rms_uT, chi2_per_dof, iterations;
  std::size_t found = 0, poor = 0, same = 0;
  for (const TrackedRow& row : rows) {
    found += std::string_view(row.cold.status) == "found" ? 1 : 0;
    poor += std::string_view(row.cold.status) == "poor-fit" ? 1 : 0;
    same += row.same ? 1 : 0;
    if (!row.cold.found) continue;
    rms_uT.push_back(1e6 * row.cold.residual_rms_T);
    if (row.cold.dof > 0) chi2_per_dof.push_back(row.cold.chi2 / row.cold.dof);
    iterations.push_back(row.cold.iterations);
  }
  std::printf("poses            %zu: %zu found, %zu with a poor fit, %zu without an answer\n", rows.size(), found, poor,
              rows.size() - found - poor);
  std::printf("cold = warm      %zu of %zu (within 0.01 mm and 0.01 deg)\n", same, rows.size());
  if (iterations.empty()) {
    std::printf("residual         not measured\n");
  } else {
    std::printf("residual         %.3g uT rms (median of the poses), chi2/dof %.3g (median)\n", Quantile(rms_uT, 0.5),
                Quantile(chi2_per_dof, 0.5));
    std::printf("cold start       %.3g evaluations (median)\n", Quantile(iterations, 0.5));
  }
  if (currents == TrackCurrents::kHidden) std::printf("currents         hidden from the tracker\n");
}

int Report(const TrackArguments& arguments, const Loaded& loaded, const std::vector<TrackedRow>& rows) {
  if (!loaded.truth.empty()) {
    const Rows errors = TrackErrors(rows, loaded.truth);
    std::cout << "\n" << RowTable(errors);
    if (!arguments.json.empty()) {
      const std::string problem = WriteText(arguments.json, RowDocument("track", errors).dump(2) + "\n");
      if (!problem.empty()) return Fail("omni track", problem);
    }
  }
  for (const auto& [path, text] :
       {std::pair{arguments.output, &WritePoses}, std::pair{arguments.residuals, &WriteResiduals}}) {
    if (path.empty()) continue;
    if (const std::string problem = WriteText(path, text(rows)); !problem.empty()) return Fail("omni track", problem);
  }
  const auto lost = std::count_if(rows.begin(), rows.end(), [](const TrackedRow& row) { return !row.cold.found; });
  return lost == 0
             ? kExitOk
             : Fail("omni track", std::to_string(lost) + " poses without an answer; see the column status (-o FILE)");
}

int RunTrack(const TrackArguments& arguments) {
  const auto loaded = Load(arguments);
  if (!loaded.ok()) return Fail("omni track", loaded.error());
  if (!arguments.convert.empty()) {
    const std::string problem = Convert(arguments, *loaded);
    if (!problem.empty()) return Fail("omni track", problem);
  }
  const auto currents = CurrentsOf(arguments, *loaded);
  if (!currents.ok()) return Fail("omni track", currents.error());
  const auto rows = TrackRecording(loaded->array, loaded->recording,
                                   {.currents = *currents, .progress = ProgressOnTerminal("tracked")});
  if (!rows.ok()) return Fail("omni track", rows.error());
  std::printf("device           %s, %zu sensors\n", loaded->array.device.c_str(), loaded->array.sensors.size());
  PrintFits(*rows, *currents);
  std::fflush(stdout);
  return Report(arguments, *loaded, *rows);
}

}  // namespace

void AddTrack(Command& app) {
  Command track = app.AddCommand("track", "track a recording of any sensor array offline");
  auto arguments = std::make_shared<TrackArguments>();
  Option device = track.Add("--device", arguments->device, "device file (.toml) of the array");
  track
      .Add("--readings", arguments->readings,
           "CSV file of the readings; with --data: N of readings-N.csv and truth-N.csv")
      .Required();
  Option truth = track.Add("--truth", arguments->truth, "CSV file of the true poses");
  Option data = track.Add("--data", arguments->data, "folder of layout-N.csv, readings-N.csv, truth-N.csv");
  Option layout = track.Add("--layout", arguments->layout, "with --data: N of layout-N.csv");
  device.Excludes(data);
  truth.Excludes(data);
  data.Needs(layout);
  layout.Needs(data);
  track.Add("--magnet-diameter", arguments->magnet_diameter_mm, "with --data: mm")
      .Range(0.2, 100.0)
      .Needs(data)
      .ShowDefault();
  track.Add("--magnet-height", arguments->magnet_height_mm, "with --data: mm")
      .Range(0.2, 100.0)
      .Needs(data)
      .ShowDefault();
  track.Add("--noise", arguments->noise_uT, "with --data: uT rms per axis").Range(1e-3, 1e4).Needs(data).ShowDefault();
  track
      .Add("--currents", arguments->currents,
           "of the coils: auto (measured if recorded, else hidden), measured, hidden, zero")
      .OneOf({"auto", "measured", "hidden", "zero"})
      .ShowDefault();
  track.Add("-o,--output", arguments->output, "CSV file of poses with covariances");
  track.Add("--residuals", arguments->residuals, "CSV file of residuals by pose and sensor");
  track.Add("--json", arguments->json, "write the errors as {name, commit, machine, rows}");
  track.Add("--convert", arguments->convert, "folder to write device.toml, readings.csv, truth.csv into");
  track.SetAction([arguments, device, data] {
    if (device.given() || data.given()) return RunTrack(*arguments);
    return FailUsage("omni track", "--device or --data is required; see 'omni track --help'");
  });
}

}  // namespace omni::tools
