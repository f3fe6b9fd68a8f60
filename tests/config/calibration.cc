// Calibration files: round trips, and the error of each mistake.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <random>
#include <thread>

#include <signal.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include "service/config/paths.h"
#include "tests/support/process/temp_folder.h"
#include "tests/support/rig/example_calibration.h"

namespace omni::config {
namespace test_config_calibration {

using support::ExampleCalibration;
using support::NominalBase;
using support::NominalDevice;

std::string Written(const CalibrationFile& file) { return WriteCalibration(file, NominalDevice()); }
std::string Text() { return Written(ExampleCalibration()); }

std::string Changed(const std::string& from, const std::string& to) {
  std::string text = Text();
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

std::string ErrorOf(const std::string& text, const std::string& serial = "twin-3") {
  const auto parsed = ParseCalibration(text, "test.toml", NominalBase(serial));
  EXPECT_FALSE(parsed.ok());
  return parsed.ok() ? std::string() : parsed.error();
}

std::string ContentOf(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

void ExpectMentions(const std::string& error, std::initializer_list<const char*> words) {
  for (const char* word : words) EXPECT_NE(error.find(word), std::string::npos) << word << " not in: " << error;
}

TEST(ConfigCalibration, WriteThenParseRoundTripsExactly) {
  const base::DeviceGeometry device = NominalDevice();
  const CalibrationFile written = ExampleCalibration();
  const auto read = ParseCalibration(Text(), "test.toml", NominalBase());
  ASSERT_TRUE(read.ok()) << read.error();
  ASSERT_EQ(read->calibration.sensors.size(), written.calibration.sensors.size());
  for (std::size_t i = 0; i < written.calibration.sensors.size(); ++i) {
    const base::SensorCalibration& a = written.calibration.sensors[i];
    const base::SensorCalibration& b = read->calibration.sensors[i];
    EXPECT_EQ(a.position_base_m, b.position_base_m);
    EXPECT_EQ(a.gain_sensor_base, b.gain_sensor_base);
    EXPECT_EQ(a.current_map_T_A, b.current_map_T_A);
    EXPECT_EQ(a.background_sensor_T, b.background_sensor_T);
  }
  EXPECT_EQ(read->calibration.moment_Am2, written.calibration.moment_Am2);
  EXPECT_EQ(read->calibration.core_kappa, written.calibration.core_kappa);
  EXPECT_EQ(read->calibration.core_kept_A, written.calibration.core_kept_A);
  EXPECT_EQ(read->calibration.hull_radius_m, written.calibration.hull_radius_m);
  EXPECT_EQ(read->calibration.core_centre_base_m.z, written.calibration.core_centre_base_m.z);
  EXPECT_EQ(read->calibration.steel.strength, written.calibration.steel.strength);
  EXPECT_EQ(read->calibration.steel.height_base_m, written.calibration.steel.height_base_m);
  EXPECT_EQ(read->quality.touches, 100);
  EXPECT_EQ(read->quality.expected_error_mm, 0.08);
  EXPECT_EQ(read->date, written.date);
  // Not in the file: as the device has them.
  EXPECT_EQ(read->calibration.magnet.radius_m, device.magnet.radius_m);
  EXPECT_EQ(read->calibration.core_radius_m, device.core_radius_m);
  EXPECT_EQ(read->calibration.sensor_noise_T, device.sensor_noise_T);
}

CalibrationFile WithTip(double tip_offset_m) {
  CalibrationFile file = ExampleCalibration();
  file.tip_measured = true;
  file.calibration.magnet.tip_offset_m = tip_offset_m;
  return file;
}

TEST(ConfigCalibration, TipIsNominalUntilMeasured) {
  const double drawn_m = NominalDevice().magnet.tip_offset_m;
  const auto before = ParseCalibration(Text(), "test.toml", NominalBase());
  ASSERT_TRUE(before.ok()) << before.error();
  EXPECT_EQ(Text().find("tip_offset_m"), std::string::npos) << "as older versions wrote it";
  EXPECT_FALSE(before->tip_measured);
  EXPECT_EQ(before->calibration.magnet.tip_offset_m, drawn_m);
  for (const double tip_m : {drawn_m + 1e-3 / 3, drawn_m}) {
    const auto read = ParseCalibration(Written(WithTip(tip_m)), "test.toml", NominalBase());
    ASSERT_TRUE(read.ok()) << read.error();
    EXPECT_TRUE(read->tip_measured);
    EXPECT_EQ(read->calibration.magnet.tip_offset_m, tip_m);
    EXPECT_EQ(read->calibration.magnet.radius_m, NominalDevice().magnet.radius_m);
  }
}

TEST(ConfigCalibration, RejectsImplausibleTip) {
  const auto error_of = [](const std::string& value, bool checksum) {
    std::string text = Written(WithTip(0.006));
    const std::size_t at = text.find("tip_offset_m"), sum = text.find("checksum");
    text.replace(at, text.find('\n', at) - at, "tip_offset_m = " + value);
    if (!checksum) text.erase(sum, text.find('\n', sum) + 1 - sum);
    return ErrorOf(text);
  };
  ExpectMentions(error_of("0.0061", true), {"checksum", "edited"});
  ExpectMentions(error_of("-0.001", false), {"test.toml:", "magnet.tip_offset_m", "-0.001", "[0, 0.2]"});
  ExpectMentions(error_of("nan", false), {"magnet.tip_offset_m"});
  ExpectMentions(error_of("0.0151", false), {"test.toml:", "magnet.tip_offset_m", "+10.1 mm from the drawing",
                                             "the limit is 10 mm", "delete this line", "omni calibrate --tip"});
  const test::TempFolder folder;
  EXPECT_FALSE(SaveCalibrationFile(folder.Path("c.toml"), WithTip(0.02), NominalBase(), false).ok());
}

TEST(ConfigCalibration, RejectsOtherFormatBaseOrGeometry) {
  ExpectMentions(ErrorOf(Changed("format = 2", "format = 3")), {"test.toml", "format = 3", "omni calibrate"});
  ExpectMentions(ErrorOf(Text(), "twin-4"), {"serial", "twin-3", "twin-4", "omni calibrate"});
  ExpectedBase other = NominalBase();
  other.device.sensors[2].position_base_m.z += 1e-4;
  const auto parsed = ParseCalibration(Text(), "test.toml", other);
  ASSERT_FALSE(parsed.ok());
  ExpectMentions(parsed.error(), {"device_hash", "another geometry", "omni calibrate"});
}

TEST(ConfigCalibration, GeometryHashCoversOnlyRelevantFields) {
  const base::DeviceGeometry device = NominalDevice();
  const std::uint64_t hash = GeometryHash(device);
  base::DeviceGeometry limits = device;
  limits.force_max_N = 1;
  limits.sensor_noise_T[0] *= 2;
  EXPECT_EQ(GeometryHash(limits), hash);
  base::DeviceGeometry magnet = device;
  magnet.magnet.remanence_T = 1.31;
  EXPECT_NE(GeometryHash(magnet), hash);
  base::DeviceGeometry turned = device;
  turned.sensors[0].orientation_base_sensor = {0, 1, 0, 0};
  EXPECT_NE(GeometryHash(turned), hash);
  base::DeviceGeometry coil = device;
  coil.coils[1].turns += 1;
  EXPECT_NE(GeometryHash(coil), hash);
}

TEST(ConfigCalibration, RejectsNonFiniteOrOutOfRangeValues) {
  ExpectMentions(ErrorOf(Changed("core_kappa = 0.97", "core_kappa = nan # 0.97")), {"core_kappa", "test.toml:"});
  ExpectMentions(ErrorOf(Changed("core_kept_A = 0.01", "core_kept_A = 0.7 # ")), {"core_kept_A", "[0, 0.1]"});
  ExpectMentions(ErrorOf(Changed("moment_Am2 = 5.", "moment_Am2 = 5e9 # ")), {"moment_Am2", "[0.001, 1000]"});
  ExpectMentions(ErrorOf(Changed("gain_sensor_base = [1.0", "gain_sensor_base = [1001.0")), {"gain_sensor_base[0]"});
  ExpectMentions(ErrorOf(Changed("background_sensor_T = [2", "background_sensor_T = [-inf, 2")),
                 {"background_sensor_T"});
  ExpectMentions(ErrorOf(Changed("touches = 100", "touches = 100\nfriend = 1")), {"quality.friend"});
  ExpectMentions(ErrorOf(Changed("[[sensors]]", "[[sensor]]")), {"sensors", "8 tables"});
  ExpectMentions(ErrorOf(Text().substr(0, 700)), {"test.toml"});
  ExpectMentions(ErrorOf(""), {"format is missing"});
}

// With all gains negated a pen is still tracked, and the force makes it five times as fast.
TEST(ConfigCalibration, RejectsCalibrationsFarFromTheNominalGeometry) {
  using Change = std::function<void(base::Calibration&)>;
  const auto of_sensor = [](std::size_t i, const std::function<void(base::SensorCalibration&)>& change) {
    return [i, change](base::Calibration& c) { change(c.sensors[i]); };
  };
  const auto scale_row = [](std::array<double, 9>& m, std::size_t row, double by) {
    for (std::size_t e = 3 * row; e < 3 * row + 3; ++e) m[e] *= by;
  };
  const auto scale_column = [](std::array<double, 9>& m, std::size_t column, double by) {
    for (std::size_t e = column; e < 9; e += 3) m[e] *= by;
  };
  const std::pair<Change, std::vector<const char*>> cases[] = {
      {[](base::Calibration& c) {
         for (base::SensorCalibration& sensor : c.sensors) {
           for (double& gain : sensor.gain_sensor_base) gain = -gain;
         }
       },
       {"sensors[0].gain_sensor_base", "mirrors", "determinant", "must be above 0"}},
      {of_sensor(3,
                 [&](auto& s) {
                   scale_row(s.gain_sensor_base, 0, -1);
                   scale_row(s.gain_sensor_base, 1, -1);
                 }),
       {"sensors[3].gain_sensor_base", "axis x", "degrees away from the drawing, the limit is 20"}},
      {of_sensor(7,
                 [](auto& s) {
                   auto& g = s.gain_sensor_base;  // its axes are read in another order
                   g = {g[3], g[4], g[5], g[6], g[7], g[8], g[0], g[1], g[2]};
                 }),
       {"sensors[7].gain_sensor_base", "degrees away"}},
      {of_sensor(1, [&](auto& s) { scale_row(s.gain_sensor_base, 2, 1.32); }),
       {"sensors[1].gain_sensor_base", "axis z", "[0.7, 1.3]"}},
      {of_sensor(1, [&](auto& s) { scale_row(s.gain_sensor_base, 1, 0.68); }), {"axis y", "[0.7, 1.3]"}},
      {of_sensor(2, [](auto& s) { s.position_base_m.z += 0.0101; }),
       {"sensors[2].position_base_m", "mm from the drawing, the limit is 10"}},
      {of_sensor(4, [&](auto& s) { scale_column(s.current_map_T_A, 0, -1); }),
       {"sensors[4].current_map_T_A", "coil x at -1.01", "[0.7, 1.4]"}},
      {of_sensor(4, [&](auto& s) { scale_column(s.current_map_T_A, 2, 1.5); }), {"coil z", "[0.7, 1.4]"}},
      {of_sensor(4, [](auto& s) { s.current_map_T_A.fill(0); }), {"coil x at 0 of the drawing"}},
      {of_sensor(5, [](auto& s) { s.background_sensor_T.y = 3.1e-4; }),
       {"sensors[5].background_sensor_T", "the limit is 300", "a magnet was near"}},
      {[](base::Calibration& c) { c.moment_Am2 *= 1.3; }, {"magnet.moment_Am2", "[0.7, 1.3]"}},
      {[](base::Calibration& c) { c.moment_Am2 *= 0.68; }, {"magnet.moment_Am2", "[0.7, 1.3]"}},
      {[](base::Calibration& c) { c.core_kappa = 0.8; }, {"magnet.core_kappa", "the limit is 0.1"}},
      {[](base::Calibration& c) { c.hull_radius_m = 0.0415; }, {"base.hull_radius_m", "4.0 mm", "the limit is 3 mm"}},
      {[](base::Calibration& c) { c.core_centre_base_m.y = -0.01; }, {"base.core_centre_base_m", "10.0 mm"}}};
  for (const auto& [change, words] : cases) {
    CalibrationFile file = ExampleCalibration();
    change(file.calibration);
    const std::string error = ErrorOf(Written(file));
    ExpectMentions(error, {"test.toml:", "omni calibrate --replace"});
    for (const char* word : words) EXPECT_NE(error.find(word), std::string::npos) << word << " not in: " << error;
    const test::TempFolder folder;
    EXPECT_FALSE(SaveCalibrationFile(folder.Path("c.toml"), file, NominalBase(), false).ok());
    EXPECT_FALSE(std::filesystem::exists(folder.Path("c.toml"))) << "a file that would be rejected is not written";
  }
}

// A steel top at 115 mm turns a coil's field at the sensors by up to 28 degrees (simulated).
TEST(ConfigCalibration, AllowsSteelToTurnTheCoilFields) {
  CalibrationFile file = ExampleCalibration();
  file.calibration = NominalBase().drawing;
  auto& map = file.calibration.sensors[6].current_map_T_A;
  const double x = map[2], z = map[8];  // of coil z
  map[2] += 0.6 * z;
  map[8] -= 0.6 * x;
  EXPECT_NE(ErrorOf(Written(file)).find("across the drawing's field"), std::string::npos);
  file.calibration.steel = {1, -0.115};
  EXPECT_TRUE(ParseCalibration(Written(file), "test.toml", NominalBase()).ok());
}

base::SensorCalibration Built(base::SensorCalibration sensor, double tolerances, std::mt19937& random) {
  std::normal_distribution<double> normal;
  const auto within = [&](double tolerance) {
    return tolerance * std::clamp(tolerances * normal(random), -tolerances, tolerances);
  };
  sensor.position_base_m.x += within(1e-3);
  sensor.position_base_m.y += within(1e-3);
  sensor.position_base_m.z += within(1e-3);
  const double turn[3] = {within(0.02), within(0.02), within(0.02)};
  auto& gain = sensor.gain_sensor_base;
  const auto drawn = gain;
  for (std::size_t column = 0; column < 3; ++column) {
    const double v[3] = {drawn[column], drawn[3 + column], drawn[6 + column]};
    for (std::size_t row = 0; row < 3; ++row) {
      const std::size_t next = (row + 1) % 3, after = (row + 2) % 3;
      gain[3 * row + column] += turn[next] * v[after] - turn[after] * v[next];
    }
  }
  for (std::size_t row = 0; row < 3; ++row) {
    const double factor = 1 + within(0.015);
    for (std::size_t e = 3 * row; e < 3 * row + 3; ++e) gain[e] *= factor;
  }
  return sensor;
}

// The tolerances of service/calibration/types.h, up to the five of them at which `omni calibrate` itself gives
// up.
TEST(ConfigCalibration, AcceptsBasesWithinFiveTolerances) {
  std::mt19937 random(3);
  for (int i = 0; i < 300; ++i) {
    CalibrationFile file = ExampleCalibration();
    const double tolerances = 1 + 4.0 * i / 300;
    file.calibration = NominalBase().drawing;
    for (base::SensorCalibration& sensor : file.calibration.sensors) sensor = Built(sensor, tolerances, random);
    file.calibration.moment_Am2 *= i % 2 == 0 ? 1.15 : 0.85;
    file.calibration.core_kappa += i % 2 == 0 ? 0.05 : -0.05;
    const auto parsed = ParseCalibration(Written(file), "test.toml", NominalBase());
    ASSERT_TRUE(parsed.ok()) << parsed.error();
  }
}

TEST(ConfigCalibration, RejectsWrongChecksumAndNotesMissingOne) {
  const std::string edited = Changed("core_kappa = 0.9765625", "core_kappa = 0.9765");
  ExpectMentions(ErrorOf(edited), {"test.toml:2", "checksum", "edited", "delete this line", "omni calibrate --restore",
                                   "omni calibrate --replace"});
  const test::TempFolder folder;
  const auto chosen = [&](const std::string& text) {
    return ChooseCalibration(folder.Write("calibration.toml", text), NominalBase());
  };
  const CalibrationChoice whole = chosen(Text());
  ASSERT_TRUE(whole.file) << whole.problem;
  EXPECT_EQ(whole.note, "");
  const std::string relaid = Changed("core_kappa = 0.9765625", "\n# a comment\n   core_kappa   =  9.765625e-1");
  EXPECT_EQ(chosen(relaid).note, "") << "layout and comments do not count";
  const std::size_t begin = edited.find("checksum"), end = edited.find('\n', begin);
  const CalibrationChoice deliberate = chosen(edited.substr(0, begin) + edited.substr(end + 1));
  ASSERT_TRUE(deliberate.file) << deliberate.problem;
  EXPECT_EQ(deliberate.file->calibration.core_kappa, 0.9765);
  EXPECT_NE(deliberate.note.find("without a checksum"), std::string::npos);
}

TEST(ConfigCalibration, SerialWithQuotesRoundTrips) {
  CalibrationFile file = ExampleCalibration();
  file.serial = "A \"quoted\" \\ serial";
  const auto parsed = ParseCalibration(Written(file), "test.toml", NominalBase(""));
  ASSERT_TRUE(parsed.ok()) << parsed.error();
  EXPECT_EQ(parsed->serial, file.serial);
}

TEST(ConfigCalibration, ChoosesAMatchingFileOrReportsWhyNot) {
  const test::TempFolder folder;
  const std::string path = folder.Path("below/calibration.toml");
  const base::Status saved = SaveCalibrationFile(path, ExampleCalibration(), NominalBase(), false);
  ASSERT_TRUE(saved.ok()) << saved.error();

  const CalibrationChoice used = ChooseCalibration(path, NominalBase());
  EXPECT_TRUE(used.file.has_value());
  EXPECT_TRUE(used.problem.empty());

  const CalibrationChoice refused = ChooseCalibration(path, NominalBase("twin-9"));
  EXPECT_FALSE(refused.file.has_value());
  ExpectMentions(refused.problem, {"calibration.toml", "twin-9", "nominal geometry"});

  const CalibrationChoice missing = ChooseCalibration(folder.Path("none.toml"), NominalBase());
  EXPECT_FALSE(missing.file.has_value());
  ExpectMentions(missing.problem, {"none.toml", "cannot be read"});
}

TEST(ConfigCalibration, ShippedFileIsUsedWhereTheUserHasNoneOfThisBase) {
  const test::TempFolder folder;
  const char* const home = ::getenv("XDG_CONFIG_HOME");
  const std::string before = home == nullptr ? std::string() : home;
  ::setenv("XDG_CONFIG_HOME", folder.Path("home").c_str(), 1);
  const ExpectedBase twin = NominalBase();
  const std::string shipped = folder.Path("shipped.toml");
  ASSERT_TRUE(SaveCalibrationFile(shipped, ExampleCalibration(), twin, false).ok());

  const CalibrationChoice first = ChooseCalibration({}, twin, shipped);
  EXPECT_TRUE(first.file && first.shipped && first.path == shipped) << first.problem;
  EXPECT_TRUE(ChooseCalibration({}, twin).path.empty()) << "never calibrated";

  CalibrationFile other = ExampleCalibration();
  other.serial = "A17";
  ASSERT_TRUE(SaveCalibrationFile(UserCalibrationFile(), other, NominalBase("A17"), false).ok());
  EXPECT_TRUE(ChooseCalibration({}, twin, shipped).shipped) << "the user's is of a real base";
  ASSERT_TRUE(SaveCalibrationFile(UserCalibrationFile(), ExampleCalibration(), twin, true).ok());
  const CalibrationChoice own = ChooseCalibration({}, twin, shipped);
  EXPECT_TRUE(own.file && !own.shipped && own.path == UserCalibrationFile()) << own.problem;
  folder.Write("home/omni/calibration.toml", Changed("core_kappa = 0.9765625", "core_kappa = 0.9765"));
  EXPECT_FALSE(ChooseCalibration({}, twin, shipped).problem.empty()) << "damaged: reported, not replaced";
  if (before.empty()) {
    ::unsetenv("XDG_CONFIG_HOME");
  } else {
    ::setenv("XDG_CONFIG_HOME", before.c_str(), 1);
  }
}

TEST(ConfigCalibration, PreviousFileIsKeptAndCanBeRestored) {
  const test::TempFolder folder;
  const std::string path = folder.Path("calibration.toml"), previous = folder.Path("calibration.previous.toml");
  EXPECT_EQ(PreviousCalibration(path), previous);
  EXPECT_EQ(PreviousCalibration("base"), "base.previous");
  const auto save = [&](const char* date, bool replace) {
    CalibrationFile file = ExampleCalibration();
    file.date = date;
    return SaveCalibrationFile(path, file, NominalBase(), replace);
  };
  const auto dates = [&] {
    const auto date = [](const std::string& of) {
      const auto file = LoadCalibrationFile(of, NominalBase());
      return file.ok() ? file->date : std::string("none");
    };
    return std::pair(date(path), date(previous));
  };
  ASSERT_TRUE(save("first", true).ok()) << "there is no file to keep";
  EXPECT_EQ(dates(), std::pair(std::string("first"), std::string("none")));
  EXPECT_FALSE(save("unasked", false).ok());
  EXPECT_EQ(dates().first, "first");
  EXPECT_FALSE(RestoreCalibrationFile(path, NominalBase()).ok()) << "there is no previous file yet";
  ASSERT_TRUE(save("second", true).ok());
  EXPECT_EQ(dates(), std::pair(std::string("second"), std::string("first")));
  ASSERT_TRUE(RestoreCalibrationFile(path, NominalBase()).ok());
  EXPECT_EQ(dates(), std::pair(std::string("first"), std::string("second")));
  ASSERT_TRUE(RestoreCalibrationFile(path, NominalBase()).ok());
  EXPECT_EQ(dates(), std::pair(std::string("second"), std::string("first"))) << "and back again";
}

TEST(ConfigCalibration, FivePreviousFilesAreKeptAndEachCanBeRestored) {
  const test::TempFolder folder;
  const std::string path = folder.Path("calibration.toml");
  EXPECT_EQ(PreviousCalibration(path, 3), folder.Path("calibration.previous.3.toml"));
  const auto save = [&](int date) {
    CalibrationFile file = ExampleCalibration();
    file.date = std::to_string(date);
    ASSERT_TRUE(SaveCalibrationFile(path, file, NominalBase(), true).ok());
  };
  const auto dates = [&] {  // the newest first
    std::string all;
    for (int number = 0; number <= kPreviousCalibrations + 1; ++number) {
      const auto file = LoadCalibrationFile(number == 0 ? path : PreviousCalibration(path, number), NominalBase());
      all += file.ok() ? file->date : "-";
    }
    return all;
  };
  for (int date = 1; date <= 8; ++date) save(date);
  EXPECT_EQ(dates(), "876543-");
  ASSERT_TRUE(RestoreCalibrationFile(path, NominalBase(), 4).ok());
  EXPECT_EQ(dates(), "476583-");
  ASSERT_TRUE(RestoreCalibrationFile(path, NominalBase(), 4).ok());
  EXPECT_EQ(dates(), "876543-");
  EXPECT_FALSE(RestoreCalibrationFile(path, NominalBase(), 6).ok());
  // A crash between two renames leaves a gap: nothing more than it takes moves on.
  std::filesystem::remove(PreviousCalibration(path, 2));
  save(9);
  EXPECT_EQ(dates(), "987543-");
  // No calibration at all: the previous one becomes it.
  std::filesystem::remove(path);
  ASSERT_TRUE(RestoreCalibrationFile(path, NominalBase()).ok());
  EXPECT_EQ(dates(), "8-7543-");
}

// Killed at any moment: there is a whole calibration under the name, and no other file is torn.
TEST(ConfigCalibration, KilledRestoreLeavesWholeFiles) {
  const test::TempFolder folder;
  const std::string path = folder.Path("calibration.toml");
  for (const char* date : {"first", "second"}) {
    CalibrationFile file = ExampleCalibration();
    file.date = date;
    ASSERT_TRUE(SaveCalibrationFile(path, file, NominalBase(), true).ok());
  }
  for (int round = 0; round < 20; ++round) {
    const pid_t child = ::fork();
    if (child == 0) {
      while (true) static_cast<void>(RestoreCalibrationFile(path, NominalBase()));
    }
    ASSERT_GT(child, 0);
    std::this_thread::sleep_for(std::chrono::milliseconds(3 + round % 5));
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    const auto now = LoadCalibrationFile(path, NominalBase());
    const auto previous = LoadCalibrationFile(PreviousCalibration(path), NominalBase());
    ASSERT_TRUE(now.ok()) << now.error();
    ASSERT_TRUE(previous.ok()) << previous.error();
    EXPECT_NE(now->date, previous->date);
  }
}

TEST(ConfigCalibration, DamagedPreviousFileIsNotRestored) {
  const test::TempFolder folder;
  const std::string path = folder.Write("calibration.toml", Text());
  folder.Write("calibration.previous.toml", Changed("core_kappa = 0.9765625", "core_kappa = 0.9765"));
  const base::Status restored = RestoreCalibrationFile(path, NominalBase());
  ASSERT_FALSE(restored.ok());
  ExpectMentions(restored.error(), {"calibration.previous.toml", "checksum"});
  EXPECT_EQ(ContentOf(path), Text());
}

TEST(ConfigCalibration, SaveErrorNamesTheFile) {
  const test::TempFolder folder;
  folder.Write("file", "x");
  const base::Status saved =
      SaveCalibrationFile(folder.Path("file/calibration.toml"), ExampleCalibration(), NominalBase(), false);
  ASSERT_FALSE(saved.ok());
  ExpectMentions(saved.error(), {"file/calibration.toml", "cannot be written", "there is no folder"});
}

}  // namespace test_config_calibration
}  // namespace omni::config
