#include "service/config/twin_file.h"

#include "service/config/built_in_device.h"
#include "service/config/text_file.h"
#include "service/config/toml_reader.h"

namespace omni::config {
namespace {

using base::ImperfectionSizes;
using base::SensorParameters;
using base::ThermalParameters;
using base::TruthEffects;

template <class T>
struct NumberKey {
  const char* key;
  double T::*field;
  Range range;
};

constexpr NumberKey<ImperfectionSizes> kImperfectionKeys[] = {
    {"sensor_position_m", &ImperfectionSizes::sensor_position_m, {0, 0.01}},
    {"sensor_gain", &ImperfectionSizes::sensor_gain, {0, 0.2}},
    {"sensor_rotation_rad", &ImperfectionSizes::sensor_rotation_rad, {0, 0.5}},
    {"sensor_nonlinearity", &ImperfectionSizes::sensor_nonlinearity, {0, 0.05}},
    {"magnet_moment", &ImperfectionSizes::magnet_moment, {0, 0.2}},
    {"coil_strength", &ImperfectionSizes::coil_strength, {0, 0.2}},
    {"coil_axis_rad", &ImperfectionSizes::coil_axis_rad, {0, 0.5}},
    {"coil_size", &ImperfectionSizes::coil_size, {0, 0.02}},
    {"current_gain", &ImperfectionSizes::current_gain, {0, 0.2}},
    {"current_offset_A", &ImperfectionSizes::current_offset_A, {0, 1}},
};
constexpr NumberKey<ThermalParameters> kThermalKeys[] = {
    {"copper_J_K", &ThermalParameters::copper_J_K, {0.1, 1e5}},
    {"body_J_K", &ThermalParameters::body_J_K, {0.1, 1e6}},
    {"copper_to_body_W_K", &ThermalParameters::copper_to_body_W_K, {1e-3, 1e3}},
    {"body_to_air_W_K", &ThermalParameters::body_to_air_W_K, {1e-3, 1e3}},
    {"air_C", &ThermalParameters::air_C, {-20, 60}},
    {"resistance_per_K", &ThermalParameters::resistance_per_K, {0, 0.02}},
};
constexpr NumberKey<TruthEffects> kCoreKeys[] = {
    {"remanence_Am2", &TruthEffects::remanence_Am2, {0, 1}},
    {"core_conductivity_S_m", &TruthEffects::core_conductivity_S_m, {0, 1e8}},
    {"core_permeability", &TruthEffects::core_permeability, {1, 1e6}},
};
constexpr NumberKey<TruthEffects> kBackgroundKeys[] = {
    {"ambient_drift_T", &TruthEffects::ambient_drift_T, {0, 1e-3}},
    {"run_s", &TruthEffects::run_s, {1e-3, 1e6}},
};
constexpr NumberKey<TruthEffects> kPenKeys[] = {
    {"magnet_warming_K", &TruthEffects::magnet_warming_K, {-50, 100}},
    {"magnet_per_K", &TruthEffects::magnet_per_K, {-0.01, 0.01}},
};
constexpr NumberKey<TruthEffects> kDriverKeys[] = {
    {"pwm_frequency_Hz", &TruthEffects::pwm_frequency_Hz, {0, 1e7}},
    {"pwm_residual", &TruthEffects::pwm_residual, {0, 1}},
};
constexpr NumberKey<SensorParameters> kSensorKeys[] = {
    {"oscillator_spread", &SensorParameters::oscillator_spread, {0, 0.1}},
};
constexpr Range kNoise_T{0, 1e-3};
constexpr Range kBackground_T{-1e-3, 1e-3};
constexpr std::string_view kBackgrounds[] = {"known", "raw"};

template <class T, std::size_t N>
void ReadNumbers(TableReader& reader, const NumberKey<T> (&keys)[N], T& into) {
  for (const NumberKey<T>& entry : keys) into.*entry.field = reader.Number(entry.key, entry.range);
}

// [name]: numbers of `into`, and what `more` reads of the same table.
template <class T, std::size_t N, class More>
void ReadSection(FileProblem& problem, TableReader& root, const char* name, const NumberKey<T> (&keys)[N], T& into,
                 const More& more) {
  const toml::table* table = root.Table(name);
  if (table == nullptr) return;
  TableReader reader(problem, *table, name);
  ReadNumbers(reader, keys, into);
  more(reader);
  reader.Finish();
}

template <class T, std::size_t N>
void ReadSection(FileProblem& problem, TableReader& root, const char* name, const NumberKey<T> (&keys)[N], T& into) {
  ReadSection(problem, root, name, keys, into, [](TableReader&) {});
}

}  // namespace

base::Result<base::TruthParameters> ParseTwin(const std::string& text, const std::string& name) {
  const base::Result<toml::table> parsed = ParseToml(text, name);
  if (!parsed.ok()) return base::Error{parsed.error()};
  FileProblem problem(name);
  TableReader root(problem, *parsed, "");
  base::TruthParameters twin;
  TruthEffects& effects = twin.effects;
  ReadSection(problem, root, "imperfections", kImperfectionKeys, twin.imperfections);
  ReadSection(problem, root, "sensor", kSensorKeys, twin.sensor, [&](TableReader& reader) {
    reader.Numbers("noise_uhp_T", kNoise_T, twin.sensor.noise_uhp_T);
    reader.Numbers("noise_lp_T", kNoise_T, twin.sensor.noise_lp_T);
  });
  ReadSection(problem, root, "thermal", kThermalKeys, twin.thermal);
  ReadSection(problem, root, "core", kCoreKeys, effects);
  ReadSection(problem, root, "background", kBackgroundKeys, effects, [&](TableReader& reader) {
    effects.earth_field_base_T = reader.Vector("earth_field_base_T", kBackground_T);
    effects.background_known = reader.Choice("background", kBackgrounds, "known") == "known";
  });
  ReadSection(problem, root, "pen", kPenKeys, effects);
  ReadSection(problem, root, "driver", kDriverKeys, effects);
  root.Finish();
  if (!problem.ok()) return base::Error{problem.message()};
  return twin;
}

base::Result<base::TruthParameters> LoadTwinFile(const std::string& path) {
  const base::Result<std::string> text = ReadTextFile(path);
  if (!text.ok()) return base::Error{text.error()};
  return ParseTwin(*text, path);
}

const base::TruthParameters& DefaultTwin() {
  static const base::TruthParameters twin = ParsedBuiltIn(ParseTwin, kBuiltInTwinText, "manifests/device/twin.toml");
  return twin;
}

}  // namespace omni::config
