#include "service/tools/calibrate/calibrate_session.h"

#include <algorithm>
#include <array>
#include <cstdio>

namespace omni::tools {
namespace {

constexpr std::size_t kUnfixedShown = 8;

template <class... Arguments>
std::string Format(const char* format, Arguments... arguments) {
  std::array<char, 256> buffer{};
  std::snprintf(buffer.data(), buffer.size(), format, arguments...);
  return buffer.data();
}

std::string UnfixedText(const calibration::Report& report) {
  if (report.unfixed.empty())
    return "not fixed    nothing: the recording determines every parameter better than the nominal geometry\n";
  std::string text =
      Format("not fixed    %zu parameters, known little better than their tolerance:\n", report.unfixed.size());
  for (std::size_t i = 0; i < std::min(kUnfixedShown, report.unfixed.size()); ++i) {
    const calibration::Undetermined& one = report.unfixed[i];
    text += Format("               %-22s +-%.3g %s (tolerance %.3g)\n", one.name.c_str(), one.sigma, one.unit.c_str(),
                   one.tolerance);
  }
  if (report.unfixed.size() > kUnfixedShown)
    text += Format("               and %zu more\n", report.unfixed.size() - kUnfixedShown);
  return text;
}

}  // namespace

std::string StepText(CalibrationStep step, const SessionOptions& options) {
  switch (step) {
    case CalibrationStep::kClear:
      return "1/4  Move the pen and other magnets a metre away.";
    case CalibrationStep::kSweep:
      return "2/4  Leave them there: the coils are swept (they may click).";
    case CalibrationStep::kWave:
      return Format("3/4  Wave the pen all round the base for %.0f s: every side, low and high, upright and tilted.",
                    options.wave_s);
    case CalibrationStep::kTouch:
      return Format("4/4  Touch the hull in %d places, anywhere, pausing a moment at each.", options.touches);
    case CalibrationStep::kDone:
      break;
  }
  return "Computing.";
}

std::string CoverageText(const calibration::Coverage& coverage) {
  std::string text;
  for (int band = calibration::kCoverageBands - 1; band >= 0; --band) {
    text += text.empty() ? "" : " ";
    for (int sector = 0; sector < calibration::kCoverageSectors; ++sector) {
      const int visits = coverage.visits[static_cast<std::size_t>(band) * calibration::kCoverageSectors +
                                         static_cast<std::size_t>(sector)];
      text += visits == 0 ? '.' : visits < 3 ? '+' : '#';
    }
  }
  return text;
}

std::string QualityWord(double expected_error_m) {
  if (expected_error_m <= 0.1e-3) return "excellent";
  if (expected_error_m <= 0.2e-3) return "good";
  return expected_error_m <= 0.5e-3 ? "fair" : "poor";
}

std::string ZeroText(const calibration::Zeroed& zeroed) {
  return Format("zeroed       the field had changed by %.1f uT, individual sensors by up to %.1f uT",
                1e6 * zeroed.uniform_T, 1e6 * zeroed.own_T);
}

std::string TipText(const calibration::Tip& tip, double drawn_m) {
  return Format("tip          %.2f +- %.2f mm from the magnet's centre, %+.2f mm from nominal; it moved by %.2f mm rms",
                1e3 * tip.tip_offset_m, 1e3 * tip.sigma_m, 1e3 * (tip.tip_offset_m - drawn_m), 1e3 * tip.rms_m);
}

std::string ReportText(const calibration::Report& report) {
  std::string text;
  text += Format("quality      %s: %.2f mm rms position error remains, excluding noise\n",
                 QualityWord(report.expected_error_m).c_str(), 1e3 * report.expected_error_m);
  text += Format("data         %d samples, %d touches, %d rejected, %.0f %% of the hemisphere\n", report.samples,
                 report.touches, report.rejected, 100 * report.coverage);
  if (report.rests_in_air > 0) {
    text += Format("             %d rests above the hull could not be used: rest the pen's end on the hull\n",
                   report.rests_in_air);
  }
  text += Format("fit          chi2 per degree of freedom %.2f (%d), coil maps %.2f, touches %.3f mm rms\n",
                 report.chi2_per_dof, report.dof, report.map_chi2_per_reading, 1e3 * report.touch_rms_m);
  text += Format("magnet       moment %+.2f +- %.2f %% from nominal, drift %+.2f %%\n", 100 * report.moment_relative,
                 100 * report.moment_sigma, 200 * report.moment_drift);
  if (report.steel.strength != 0) {
    text += Format("steel        about %.0f mm below the base's centre, %.2f of an iron plate; included from now on\n",
                   -1e3 * report.steel.height_base_m, report.steel.strength);
  }
  text +=
      Format("frame        rotation about the core known to %.3f deg\n", 57.29577951308232 * report.frame_rotation_rad);
  for (std::size_t i = 0; i < report.sensors.size(); ++i) {
    const calibration::SensorReport& sensor = report.sensors[i];
    text += Format("sensor %zu     %.2f mm from nominal, residual %.2f uT rms, chi2 per reading %.2f\n", i,
                   1e3 * sensor.moved_m, 1e6 * sensor.residual_T, sensor.chi2_per_reading);
  }
  text += UnfixedText(report);
  text += Format("computed     %d iterations, %.2f s\n", report.iterations, report.seconds);
  return text;
}

}  // namespace omni::tools
