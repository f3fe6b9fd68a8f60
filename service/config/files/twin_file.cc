#include "service/config/files/twin_file.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <system_error>

#include "service/base/limits.h"
#include "service/config/files/built_in_device.h"
#include "service/config/paths.h"
#include "service/config/text/text_file.h"
#include "service/config/text/toml_reader.h"

namespace omni::config {
namespace {

using base::ImperfectionSizes;
using base::RoomEffects;
using base::SensorParameters;
using base::ThermalParameters;
using base::TruthEffects;

template <class T>
struct NumberKey {
  const char* key;
  double T::*field;
  Range range;
  bool required = true;  // else it stays what it is
};
constexpr bool kOptional = false;

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
    {"sensor_offset_T", &ImperfectionSizes::sensor_offset_T, {0, 1e-4}, kOptional},
    {"sensor_offset_T_K", &ImperfectionSizes::sensor_offset_T_K, {0, 1e-5}, kOptional},
    {"sensor_gain_1_K", &ImperfectionSizes::sensor_gain_1_K, {0, 0.01}, kOptional},
    {"hull_radius_m", &ImperfectionSizes::hull_radius_m, {0, 0.01}, kOptional},
    {"core_offset_m", &ImperfectionSizes::core_offset_m, {0, 0.005}, kOptional},
    {"core_size", &ImperfectionSizes::core_size, {0, 0.1}, kOptional},
    {"magnet_size", &ImperfectionSizes::magnet_size, {0, 0.1}, kOptional},
    {"tip_offset_m", &ImperfectionSizes::tip_offset_m, {0, 0.01}, kOptional},
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
    {"flicker_T", &SensorParameters::flicker_T, {0, 1e-4}, kOptional},
};
constexpr NumberKey<TruthEffects> kWarmingKeys[] = {
    {"sensor_warming_K", &TruthEffects::sensor_warming_K, {-50, 100}, kOptional},
};
constexpr Range kTime_s{0, 1e6};
constexpr NumberKey<RoomEffects> kRoomKeys[] = {
    {"turn_rate_rad_s", &RoomEffects::turn_rate_rad_s, {-100, 100}, kOptional},
    {"turn_from_s", &RoomEffects::turn_from_s, kTime_s, kOptional},
    {"turn_s", &RoomEffects::turn_s, kTime_s, kOptional},
    {"mains_T", &RoomEffects::mains_T, {0, 1e-3}, kOptional},
    {"mains_Hz", &RoomEffects::mains_Hz, {1, 500}, kOptional},
    {"mains_third", &RoomEffects::mains_third, {0, 1}, kOptional},
    {"mains_fifth", &RoomEffects::mains_fifth, {0, 1}, kOptional},
    {"scan_lost", &RoomEffects::scan_lost, {0, 0.9}, kOptional},
    {"scan_late", &RoomEffects::scan_late, {0, 0.9}, kOptional},
    {"induction", &RoomEffects::induction, {0, 1}, kOptional},
};
constexpr NumberKey<base::Steel> kSteelKeys[] = {
    {"radius_m", &base::Steel::radius_m, {0, 1}, kOptional},
    {"half_length_m", &base::Steel::half_length_m, {0, 5}, kOptional},
    {"strength", &base::Steel::strength, {0, 1}, kOptional},
    {"from_s", &base::Steel::from_s, kTime_s, kOptional},
};
constexpr NumberKey<base::OtherMagnet> kMagnetKeys[] = {
    {"leaves_s", &base::OtherMagnet::leaves_s, kTime_s, kOptional},
    {"arrives_s", &base::OtherMagnet::arrives_s, kTime_s, kOptional},
};
constexpr NumberKey<base::OtherPen> kOtherPenKeys[] = {
    {"moment_scale", &base::OtherPen::moment_scale, {0.1, 10}},
    {"from_s", &base::OtherPen::from_s, kTime_s, kOptional},
};
constexpr NumberKey<base::FieldStep> kStepKeys[] = {
    {"at_s", &base::FieldStep::at_s, kTime_s},
    {"over_s", &base::FieldStep::over_s, kTime_s, kOptional},
};
constexpr NumberKey<base::SensorFault> kFaultKeys[] = {
    {"value", &base::SensorFault::value, {-1e3, 1e3}, kOptional},
    {"from_s", &base::SensorFault::from_s, kTime_s, kOptional},
};
constexpr Range kPlace_m{-10, 10};
constexpr Range kMoment_Am2{-100, 100};
constexpr double kMagnetLeast_m = 0.02;  // nearer to the origin there is the core
// In the order of the enumerators.
constexpr std::string_view kShapes[] = {"plane", "ball", "bar"};
constexpr std::string_view kFaultKinds[] = {"gain", "stuck", "huge", "swapped", "stopped"};

constexpr Range kNoise_T{0, 1e-3};
constexpr Range kBackground_T{-1e-3, 1e-3};
constexpr std::string_view kBackgrounds[] = {"known", "raw"};
constexpr std::string_view kNames[] = {kIdeal, "room"};

template <class T, std::size_t N>
void ReadNumbers(TableReader& reader, const NumberKey<T> (&keys)[N], T& into, bool complete = true) {
  for (const NumberKey<T>& entry : keys) {
    double& number = into.*entry.field;
    number = reader.Number(entry.key, entry.range,
                           complete && entry.required ? std::nullopt : std::optional<double>(number));
  }
}

// The file's root, and whether it must have everything.
struct TwinText {
  FileProblem& problem;
  TableReader root;
  bool complete = true;
};

// [name]: numbers of `into`, and what `more` reads of the same table.
template <class T, std::size_t N, class More>
void ReadSection(TwinText& text, const char* name, const NumberKey<T> (&keys)[N], T& into, const More& more) {
  if (!text.complete && !text.root.table().contains(name)) return;
  const toml::table* table = text.root.Table(name);
  if (table == nullptr) return;
  TableReader reader(text.problem, *table, name);
  ReadNumbers(reader, keys, into, text.complete);
  more(reader);
  reader.ReportUnknownKeys();
}

template <class T, std::size_t N>
void ReadSection(TwinText& text, const char* name, const NumberKey<T> (&keys)[N], T& into) {
  ReadSection(text, name, keys, into, [](TableReader&) {});
}

// [[key]], or none: `read` fills each from its table.
template <class T, std::size_t N, class Read>
void ReadList(TwinText& text, const char* key, std::size_t most, const NumberKey<T> (&keys)[N], std::vector<T>& into,
              const Read& read) {
  if (!text.root.table().contains(key)) return;
  const auto tables = text.root.Tables(key, 1, most);
  into.clear();
  for (std::size_t i = 0; i < tables.size(); ++i) {
    TableReader reader(text.problem, *tables[i], std::string(key) + "[" + std::to_string(i) + "]");
    T& one = into.emplace_back();
    ReadNumbers(reader, keys, one);
    read(reader, one);
    reader.ReportUnknownKeys();
  }
}

template <class Enumeration, std::size_t N>
Enumeration ReadChoice(TableReader& reader, const char* key, const std::string_view (&allowed)[N]) {
  const std::string chosen = reader.Choice(key, allowed, allowed[0]);
  return static_cast<Enumeration>(std::find(std::begin(allowed), std::end(allowed), chosen) - std::begin(allowed));
}

void ReadSteel(FileProblem& problem, TableReader& reader, base::Steel& steel) {
  steel.shape = ReadChoice<base::SteelShape>(reader, "shape", kShapes);
  steel.position_base_m = reader.Vector("position_base_m", kPlace_m);
  const base::Vec3 d = reader.Vector("direction_base", {-1, 1}, base::Vec3{0, 0, 1});
  const double length = Norm(d);
  if (!(length > 0)) problem.Report(&reader.table(), reader.NameOf("direction_base") + " has no direction");
  if (length > 0) steel.direction_base = {d.x / length, d.y / length, d.z / length};
  if (steel.shape != base::SteelShape::kPlane && !(steel.radius_m > 0)) {
    problem.Report(&reader.table(), reader.NameOf("radius_m") + " must be above 0");
  }
  if (steel.shape == base::SteelShape::kBar && !(steel.half_length_m >= steel.radius_m)) {
    problem.Report(&reader.table(), reader.NameOf("half_length_m") + " must not be below radius_m");
  }
}

void ReadMagnet(FileProblem& problem, TableReader& reader, base::OtherMagnet& magnet) {
  magnet.moment_Am2 = reader.Vector("moment_Am2", kMoment_Am2);
  magnet.to_base_m = reader.Vector("to_base_m", kPlace_m);
  magnet.from_base_m = reader.Vector("from_base_m", kPlace_m, magnet.to_base_m);
  for (const base::Vec3& p : {magnet.from_base_m, magnet.to_base_m}) {
    if (problem.ok() && !(Norm(p) >= kMagnetLeast_m)) {
      problem.Report(&reader.table(), reader.NameOf("to_base_m") + " lies inside the core");
    }
  }
  if (magnet.arrives_s < magnet.leaves_s) {
    problem.Report(&reader.table(), reader.NameOf("arrives_s") + " is before leaves_s");
  }
}

void ReadFault(TableReader& reader, base::SensorFault& fault) {
  fault.kind = ReadChoice<base::SensorFaultKind>(reader, "kind", kFaultKinds);
  const Range sensors{0, base::kSensorCount - 1};
  fault.sensor = reader.Integer("sensor", sensors);
  fault.other = fault.kind == base::SensorFaultKind::kSwapped ? reader.Integer("other", sensors) : fault.sensor;
}

void ReadRoom(TwinText& text, TruthEffects& effects) {
  RoomEffects& room = effects.room;
  if (text.root.table().contains("room")) {
    ReadSection(text, "room", kRoomKeys, room,
                [&](TableReader& reader) { ReadNumbers(reader, kWarmingKeys, effects, text.complete); });
  }
  ReadList(text, "steel", base::kSteelMax, kSteelKeys, room.steel,
           [&](TableReader& reader, base::Steel& steel) { ReadSteel(text.problem, reader, steel); });
  ReadList(text, "magnets", base::kOtherMagnetsMax, kMagnetKeys, room.magnets,
           [&](TableReader& reader, base::OtherMagnet& magnet) { ReadMagnet(text.problem, reader, magnet); });
  ReadList(text, "pens", base::kPensMax, kOtherPenKeys, room.pens, [](TableReader&, base::OtherPen&) {});
  ReadList(text, "field_steps", base::kFieldStepsMax, kStepKeys, room.steps,
           [&](TableReader& reader, base::FieldStep& step) {
             step.change_base_T = reader.Vector("change_base_T", kBackground_T);
           });
  ReadList(text, "sensor_faults", base::kSensorFaultsMax, kFaultKeys, room.faults,
           [&](TableReader& reader, base::SensorFault& fault) { ReadFault(reader, fault); });
}

base::TruthParameters BaseOf(TwinText& text) {
  if (!text.root.table().contains("based_on")) return {};
  text.complete = false;
  return text.root.Choice("based_on", kNames, kNames[0]) == kNames[1] ? RoomTwin() : IdealTwin();
}

}  // namespace

base::Result<base::TruthParameters> ParseTwin(const std::string& text, const std::string& name) {
  const base::Result<toml::table> parsed = ParseToml(text, name);
  if (!parsed.ok()) return base::Error{parsed.error()};
  FileProblem problem(name);
  TwinText file{problem, TableReader(problem, *parsed, "")};
  base::TruthParameters twin = BaseOf(file);
  TruthEffects& effects = twin.effects;
  ReadSection(file, "imperfections", kImperfectionKeys, twin.imperfections);
  ReadSection(file, "sensor", kSensorKeys, twin.sensor, [&](TableReader& reader) {
    if (file.complete || reader.table().contains("noise_uhp_T")) {
      reader.Numbers("noise_uhp_T", kNoise_T, twin.sensor.noise_uhp_T);
    }
    if (file.complete || reader.table().contains("noise_lp_T")) {
      reader.Numbers("noise_lp_T", kNoise_T, twin.sensor.noise_lp_T);
    }
  });
  ReadSection(file, "thermal", kThermalKeys, twin.thermal);
  ReadSection(file, "core", kCoreKeys, effects);
  ReadSection(file, "background", kBackgroundKeys, effects, [&](TableReader& reader) {
    const std::optional<base::Vec3> before = effects.earth_field_base_T;
    effects.earth_field_base_T =
        reader.Vector("earth_field_base_T", kBackground_T, file.complete ? std::nullopt : before);
    const std::string_view known = effects.background_known ? kBackgrounds[0] : kBackgrounds[1];
    effects.background_known = reader.Choice("background", kBackgrounds, known) == kBackgrounds[0];
  });
  ReadSection(file, "pen", kPenKeys, effects);
  ReadSection(file, "driver", kDriverKeys, effects);
  ReadRoom(file, effects);
  file.root.ReportUnknownKeys();
  if (!problem.ok()) return base::Error{problem.message()};
  return twin;
}

base::Result<base::TruthParameters> LoadTwinFile(const std::string& path) {
  const base::Result<std::string> text = ReadTextFile(path);
  if (!text.ok()) return base::Error{text.error()};
  return ParseTwin(*text, path);
}

base::Result<base::TruthParameters> FindTwin(const std::string& name_or_file) {
  if (name_or_file.empty()) return DefaultTwin();
  if (name_or_file == kNames[0]) return IdealTwin();
  if (name_or_file == kNames[1]) return RoomTwin();
  return LoadTwinFile(name_or_file);
}

std::string ShippedCalibration(const std::string& twin, std::uint64_t seed) {
  if (seed != kShippedSeed || !(twin.empty() || twin == kNames[1])) return {};
  const std::string path = DataFolder() + "/device/twin_calibration.toml";
  std::error_code error;
  return std::filesystem::exists(path, error) ? path : std::string();
}

// The room has only what is different, and a file may, too.
base::Result<std::string> TextOfTwin(const std::string& name_or_file) {
  const std::string room = std::string(kBuiltInTwinText) + kBuiltInRoomText;
  if (name_or_file == kNames[0]) return std::string(kBuiltInTwinText);
  if (name_or_file.empty() || name_or_file == kNames[1]) return room;
  base::Result<std::string> text = ReadTextFile(name_or_file);
  if (!text.ok()) return base::Error{text.error()};
  return room + *text;
}

const base::TruthParameters& IdealTwin() {
  static const base::TruthParameters twin = ParsedBuiltIn(ParseTwin, kBuiltInTwinText, "manifests/device/twin.toml");
  return twin;
}

const base::TruthParameters& RoomTwin() {
  static const base::TruthParameters twin = ParsedBuiltIn(ParseTwin, kBuiltInRoomText, "manifests/device/room.toml");
  return twin;
}

}  // namespace omni::config
