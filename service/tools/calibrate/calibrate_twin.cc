#include "service/tools/calibrate/calibrate_twin.h"

#include <cstdio>
#include <ctime>
#include <functional>

#include "service/config/files/twin_file.h"
#include "service/config/paths.h"
#include "service/magnetics/nominal.h"
#include "service/sim/fields/imperfections.h"
#include "service/sim/fields/random.h"
#include "service/sim/twin/twin.h"
#include "service/tools/calibrate/calibrate_session.h"

namespace omni::tools {
namespace {

constexpr double kDurationMax_s = 300;  // the scripted hand finishes long before
constexpr double kClockStart_s = 1;     // of the twin's stamps

}  // namespace

base::Result<TwinCalibration> CalibrateTwin(const base::DeviceGeometry& device, std::uint64_t seed,
                                            const base::TruthParameters& truth, const SessionOptions& options,
                                            const SessionObserver& observer) {
  // A little more than required: some windows are too jerky to count, and some touches too short.
  const CalibratingHand hand{
      .wave_s = 1.1 * options.wave_s + 1, .touches = options.touches * 4 / 3 + 5, .seed = seed + 1};
  const sim::TwinOptions twin{
      .seed = seed, .script = MakeCalibratingHand(WithHeldTip(device, seed, truth), hand), .truth = truth};
  const auto transport = sim::MakeVirtualTwin(device, twin, kDurationMax_s);
  CalibrationSession session(device, options);
  const auto seen = [&] {
    if (observer) observer(session);
  };
  if (const base::Status ran = RunSession(*transport, session, seen); !ran.ok()) return base::Error{ran.error()};
  auto outcome = session.Finish();
  if (!outcome.ok()) return base::Error{outcome.error()};
  const auto& samples = session.recording().samples;
  return TwinCalibration{std::move(*outcome), 0.5 * (samples.front().t_s + samples.back().t_s) - kClockStart_s};
}

base::DeviceGeometry WithHeldTip(const base::DeviceGeometry& device, std::uint64_t seed,
                                 const base::TruthParameters& truth) {
  sim::Random random(seed);
  base::DeviceGeometry held = device;
  held.magnet.tip_offset_m =
      sim::TrueSizes(device, sim::DrawImperfections(truth.imperfections, random)).magnet.tip_offset_m;
  return held;
}

namespace {

std::string Now() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  ::gmtime_r(&now, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

}  // namespace

config::CalibrationFile CalibrationFileOf(const calibration::Outcome& outcome, const std::string& serial) {
  const calibration::Report& report = outcome.report;
  return {.calibration = outcome.calibration,
          .serial = serial,
          .date = Now(),
          .quality = {.expected_error_mm = 1e3 * report.expected_error_m,
                      .frame_rotation_deg = 57.29577951308232 * report.frame_rotation_rad,
                      .chi2_per_dof = report.chi2_per_dof,
                      .coverage = report.coverage,
                      .samples = report.samples,
                      .touches = report.touches,
                      .unfixed = static_cast<int>(report.unfixed.size())}};
}

base::Result<base::Calibration> KeptTwinCalibration(const base::DeviceGeometry& device, std::uint64_t seed,
                                                    const std::string& twin) {
  const base::Result<base::TruthParameters> truth = config::FindTwin(twin);
  if (!truth.ok()) return base::Error{truth.error()};
  const std::string serial = "twin-" + std::to_string(seed);
  const config::ExpectedBase of{.device = device, .drawing = magnetics::NominalCalibration(device), .serial = serial};
  if (const std::string shipped = config::ShippedCalibration(twin, seed); !shipped.empty()) {
    if (const auto file = config::LoadCalibrationFile(shipped, of); file.ok()) return file->calibration;
  }
  const auto text = config::TextOfTwin(twin);
  if (!text.ok()) return base::Error{text.error()};
  char known_by[32];
  std::snprintf(known_by, sizeof known_by, "%016zx", std::hash<std::string>{}(*text));
  const std::string folder = config::CacheFolder();
  const std::string path = folder + "/twins/" + serial + "-" + known_by + "-" OMNI_VERSION ".toml";
  if (!folder.empty()) {
    if (const auto kept = config::LoadCalibrationFile(path, of); kept.ok()) return kept->calibration;
  }
  std::fprintf(stderr, "calibrating the digital twin (a simulation), seed %llu: done once, takes half a minute\n",
               static_cast<unsigned long long>(seed));
  const auto done = CalibrateTwin(device, seed, *truth);
  if (!done.ok()) return base::Error{"the twin could not be calibrated: " + done.error()};
  const base::Status saved =
      folder.empty() ? base::Error{"there is no cache folder"}
                     : config::SaveCalibrationFile(path, CalibrationFileOf(done->outcome, serial), of, true);
  if (!saved.ok()) std::fprintf(stderr, "the calibration is not cached: %s\n", saved.error().c_str());
  return done->outcome.calibration;
}

}  // namespace omni::tools
