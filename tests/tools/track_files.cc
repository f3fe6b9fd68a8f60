// Recordings: what is read, and the error for each mistake.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "service/tools/track/track.h"
#include "service/tools/track/track_table.h"
#include "tests/support/process/temp_folder.h"

namespace omni::tools {
namespace test_tools_track_files {

class TrackFiles : public testing::Test {
 protected:
  base::Calibration Four() const {
    base::Calibration array;
    array.device = "four";
    array.sensors.resize(4);
    array.sensor_noise_T = {1e-6, 1e-6, 1e-6};
    return array;
  }
  std::string ReadingsError(const std::string& text) const {
    const auto recording = ReadRecording(folder_.Write("readings.csv", text), Four());
    EXPECT_FALSE(recording.ok()) << text;
    return recording.ok() ? std::string() : recording.error();
  }
  std::string TruthError(const std::string& text) const {
    const auto truth = ReadTruth(folder_.Write("truth.csv", text));
    EXPECT_FALSE(truth.ok()) << text;
    return truth.ok() ? std::string() : truth.error();
  }
  const test::TempFolder folder_;
};

const char* const kHeader = "pose,sensor,bx_uT,by_uT,bz_uT\n";
const char* const kPose = "7,0,10,20,30\n7,1,-10,0,5\n7,2,1,2,3\n7,3,4,5,6\n";

void ExpectWords(const std::string& error, std::initializer_list<const char*> words) {
  for (const char* word : words) EXPECT_NE(error.find(word), std::string::npos) << word << " not in: " << error;
}

TEST_F(TrackFiles, ReadsAnyUnitAndWindowsLineEnds) {
  for (const auto& [unit, factor] : {std::pair{"T", 1e-3}, {"mT", 1e-3}, {"uT", 1e-6}, {"G", 1e-4}, {"mG", 1e-7}}) {
    const std::string u = unit;
    std::string rows;
    for (int i = 0; i < 4; ++i) rows += "3," + std::to_string(i) + (u == "T" ? ",0.001,-0.002,0\r\n" : ",1,-2,0\r\n");
    const auto recording =
        ReadRecording(folder_.Write("r.csv", "pose, sensor,bx_" + u + ",by_" + u + ",bz_" + u + "\r\n" + rows), Four());
    if (u == "mG") {  // 1 mG is below this array's noise
      EXPECT_FALSE(recording.ok());
      continue;
    }
    ASSERT_TRUE(recording.ok()) << recording.error();
    ASSERT_EQ(recording->poses.size(), 1U);
    EXPECT_EQ(recording->poses[0].number, 3U);
    EXPECT_NEAR(recording->poses[0].field_sensor_T[2].y, -2 * factor, 1e-15);
  }
}

// As spreadsheets, instruments and scripts write the same numbers.
TEST_F(TrackFiles, ReadsOrdinarySpellings) {
  const std::string rows = "7,0,10,20,30\n7,1,-10,0,5\n7,2,1,2,3\n7,3,4,5,6\n";
  const struct {
    const char *what, *header;
    std::string rows;
  } files[] = {
      {"byte order mark", "\xEF\xBB\xBFpose,sensor,bx_uT,by_uT,bz_uT\n", rows},
      {"upper case", "Pose,Sensor,Bx_uT,By_uT,Bz_uT\n", rows},
      {"units in round brackets", "pose,sensor,Bx (uT),By (uT),Bz (uT)\n", rows},
      {"units in brackets", "pose,sensor,bx [\u00b5T],by [\u00b5T],bz [\u00b5T]\n", rows},
      {"Greek mu", "pose,sensor,bx_\u03bcT,by_\u03bcT,bz_\u03bcT\n", rows},
      {"quoted header", "\"pose\",\"sensor\",\"bx_uT\",\"by_uT\",\"bz_uT\"\n", rows},
      {"quoted numbers", kHeader, "7,0,\"10\",\"20\",\"30\"\n7,1,-10,0,5\n7,2,1,2,3\n7,3,4,5,6\n"},
      {"signs", kHeader, "7,0,+10,+20.0,+3e1\n7,1,-10,0,5\n7,2,1,2,3\n7,3,4,5,6\n"},
      {"comments", "# Teslameter 3000\npose,sensor,bx_uT,by_uT,bz_uT\n# start\n", rows},
      {"nT", "pose,sensor,bx_nT,by_nT,bz_nT\n",
       "7,0,10000,20000,30000\n7,1,-10000,0,5000\n7,2,1000,2000,3000\n7,3,4000,5000,6000\n"},
      {"columns that are not used", "time,pose,sensor,bx_uT,by_uT,bz_uT,note,\n",
       "12:00:01,7,0,10,20,30,\"left, high\",\n,7,1,-10,0,5,nan,\n,7,2,1,2,3,,\n,7,3,4,5,6,,\n"},
  };
  for (const auto& file : files) {
    SCOPED_TRACE(file.what);
    const auto recording = ReadRecording(folder_.Write("r.csv", file.header + file.rows), Four());
    ASSERT_TRUE(recording.ok()) << recording.error();
    ASSERT_EQ(recording->poses.size(), 1U);
    EXPECT_NEAR(recording->poses[0].field_sensor_T[0].z, 30e-6, 1e-15);
    EXPECT_NEAR(recording->poses[0].field_sensor_T[1].x, -10e-6, 1e-15);
  }
}

TEST_F(TrackFiles, NamesAWrongSeparator) {
  ExpectWords(ReadingsError("pose;sensor;bx_uT;by_uT;bz_uT\n7;0;10;20;30\n"), {":1: ", "\";\"", "commas"});
  ExpectWords(ReadingsError("pose\tsensor\tbx_uT\tby_uT\tbz_uT\n7\t0\t10\t20\t30\n"), {":1: ", "a tab", "commas"});
  ExpectWords(ReadingsError("pose sensor bx_uT by_uT bz_uT\n7 0 10 20 30\n"), {":1: ", "a space", "commas"});
  ExpectWords(ReadingsError("pose,sensor,bx_uT,by_uT,bz_uT\n7,0,1,5,2,5,3,5\n"), {":2: ", "decimal commas"});
}

TEST_F(TrackFiles, CurrentColumnsAreAllOrNone) {
  std::string rows;
  for (int i = 0; i < 4; ++i) rows += "0," + std::to_string(i) + ",10,20,30,1.5,-2,0\n";
  const std::string header = "pose,sensor,bx_uT,by_uT,bz_uT,i0_A,i1_A,i2_A\n";
  const auto recording = ReadRecording(folder_.Write("r.csv", header + rows), Four());
  ASSERT_TRUE(recording.ok()) << recording.error();
  EXPECT_TRUE(recording->has_currents);
  EXPECT_EQ(recording->poses[0].current_A[1], -2);
  ExpectWords(ReadingsError("pose,sensor,bx_uT,by_uT,bz_uT,i0_A\n0,0,1,1,1,0\n"), {"i0_A", "only 1"});
}

TEST_F(TrackFiles, ErrorsForBadReadingsNameTheCause) {
  const std::string good = std::string(kHeader) + kPose;
  ExpectWords(ReadingsError("pose,sensor,bx_uT,by_uT\n"), {"header but no rows"});
  ExpectWords(ReadingsError("pose,sensor,bx_uT,by_uT\n0,0,1,1\n"), {"bz", "missing", "bz_uT", "pose, sensor"});
  ExpectWords(ReadingsError("pose,sensor,bx,by,bz\n0,0,1,1,1\n"), {"bx", "unit", "bx_mT"});
  ExpectWords(ReadingsError("pose,sensor,bx_uT,by_mT,bz_uT\n0,0,1,1,1\n"), {"one unit"});
  ExpectWords(ReadingsError("pose,bx_uT,by_uT,bz_uT\n0,1,1,1\n"), {"sensor", "missing"});
  ExpectWords(ReadingsError(std::string(kHeader) + "0,0,nan,1,1\n"), {"readings.csv:2", "bx_uT", "nan", "finite"});
  ExpectWords(ReadingsError(std::string(kHeader) + "0,0,inf,1,1\n"), {"not finite"});
  ExpectWords(ReadingsError(std::string(kHeader) + "0,0,,1,1\n"), {"bx_uT", "is empty"});
  ExpectWords(ReadingsError(std::string(kHeader) + "0,0,1x,1,1\n"), {"1x", "not a number"});
  ExpectWords(ReadingsError(std::string(kHeader) + "0,0,1,1\n"), {"4 fields", "5 expected"});
  ExpectWords(ReadingsError(std::string(kHeader) + "0,4,1,1,1\n"), {"sensor 4", "4 sensors"});
  ExpectWords(ReadingsError(std::string(kHeader) + "0,0.5,1,1,1\n"), {"sensor = 0.5", "whole"});
  ExpectWords(ReadingsError(std::string(kHeader) + "-1,0,1,1,1\n"), {"pose = -1", "whole"});
  ExpectWords(ReadingsError(good + "7,3,1,1,1\n"), {"sensor 3", "twice"});
  ExpectWords(ReadingsError(good + "8,0,1,1,1\n"), {"pose 8", "lacks sensor 1"});
  std::string tesla = good;
  tesla.replace(tesla.find("bx_uT,by_uT,bz_uT"), 17, "bx_T,by_T,bz_T");
  ExpectWords(ReadingsError(tesla), {"10.0", "unit wrong"});
  ExpectWords(ReadingsError("pose,sensor,bx_uT,by_uT,bz_uT\n0,0,1e-6,0,0\n0,1,0,0,0\n0,2,0,0,0\n0,3,0,0,0\n"),
              {"below the sensors' noise", "unit"});
  EXPECT_FALSE(ReadRecording(folder_.Path("none.csv"), Four()).ok());
  EXPECT_FALSE(ReadRecording(folder_.Path(), Four()).ok());
}

TEST_F(TrackFiles, ErrorsForBadTruthNameTheCause) {
  const std::string header = "pose,x_mm,y_mm,z_mm,ux,uy,uz\n";
  ExpectWords(TruthError("pose,x_mm,y_mm,ux,uy,uz\n0,1,1,0,0,1\n"), {"z with its unit", "z_mm"});
  ExpectWords(TruthError(header + "0,1,1,1,0,0,2\n"), {"length 2"});
  ExpectWords(TruthError(header + "0,1,1,1,0,0,1\n0,1,1,1,0,0,1\n"), {"pose 0", "twice"});
  ExpectWords(TruthError("pose,x_m,y_m,z_m,ux,uy,uz\n0,600,1,1,0,0,1\n"), {"600", "unit wrong"});
  ExpectWords(TruthError("pose,x_m,x_mm,y_m,z_m,ux,uy,uz\n0,1,1,1,1,0,0,1\n"), {"two units"});
  ExpectWords(TruthError("pose,pose,y_m\n0,1,1\n"), {"twice"});
}

TEST_F(TrackFiles, WrittenFilesReadBackEqual) {
  const auto recording = ReadRecording(folder_.Write("r.csv", std::string(kHeader) + kPose), Four());
  ASSERT_TRUE(recording.ok());
  const auto back = ReadRecording(folder_.Write("back.csv", WriteRecording(*recording)), Four());
  ASSERT_TRUE(back.ok()) << back.error();
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(back->poses[0].field_sensor_T[i].z, recording->poses[0].field_sensor_T[i].z, 1e-14);
  }
  const Truth truth{{4, {{0.1, -0.2, 0.3}, {0, 0.6, 0.8}}}};
  const auto truth_back = ReadTruth(folder_.Write("t.csv", WriteTruth(truth)));
  ASSERT_TRUE(truth_back.ok()) << truth_back.error();
  EXPECT_NEAR(truth_back->at(4).position_base_m.y, -0.2, 1e-12);
}

// The public family's layout: gain from the magnetisation that a sensor sees, rotation vector sensor -> common frame.
TEST_F(TrackFiles, ReadsMagnet16Layout) {
  std::string text =
      "sensor,x_mm,y_mm,z_mm,rotvec_x,rotvec_y,rotvec_z,magnetization_A_per_m,ambient_x_uT,ambient_y_uT,ambient_z_uT\n";
  for (int i = 0; i < 5; ++i) {
    text += std::to_string(i) + "," + std::to_string(10 * i) + ",0,5,0,0,1.5707963267948966," +
            (i == 0 ? "1200000" : "950000") + ",30,-5,0\n";
  }
  const auto array = ReadMagnet16Layout(folder_.Write("layout-9.csv", text), {});
  ASSERT_TRUE(array.ok()) << array.error();
  EXPECT_EQ(array->sensors.size(), 5U);
  EXPECT_EQ(array->device, "layout-9");
  EXPECT_NEAR(array->moment_Am2, 1e6 * std::numbers::pi * 25e-6 * 10e-3, 1e-9);
  EXPECT_NEAR(array->sensors[0].gain_sensor_base[1], 1.2, 1e-12);  // its x looks along common y
  EXPECT_NEAR(array->sensors[1].gain_sensor_base[3], -0.95, 1e-12);
  EXPECT_NEAR(array->sensors[3].position_base_m.x, 0.03, 1e-15);
  EXPECT_NEAR(array->sensors[3].background_sensor_T.y, -5e-6, 1e-18);
  text.replace(text.find("950000"), 6, "950");
  ExpectWords(ReadMagnet16Layout(folder_.Write("l.csv", text), {}).error(), {"magnetization_A_per_m", "A/m"});
}

TEST_F(TrackFiles, LoadsOmniAndArrayDeviceFiles) {
  const auto omni = LoadTrackDevice(OMNI_SOURCE_DIR "/manifests/device/omni.toml");
  ASSERT_TRUE(omni.ok()) << omni.error();
  EXPECT_EQ(omni->sensors.size(), 8U);
  EXPECT_NEAR(omni->moment_Am2, 5.119, 1e-3);
  std::string patch =
      "format = \"omni-array 1\"\nname = \"p\"\n[magnet]\nradius_m = 0.01\nhalf_height_m = 0.002\nremanence_T = 1.2\n"
      "[sensor]\nsensor_noise_T = [1e-6, 1e-6, 1e-6]\n";
  for (int i = 0; i < 4; ++i) {
    patch += "[[sensors]]\nposition_base_m = [0.0, 0." + std::to_string(i) + "1, 0.0]\n";
  }
  const auto array = LoadTrackDevice(folder_.Write("patch.toml", patch));
  ASSERT_TRUE(array.ok()) << array.error();
  EXPECT_NEAR(array->moment_Am2, 1.2 * std::numbers::pi * 1e-4 * 0.004 / (4e-7 * std::numbers::pi), 1e-12);
  ExpectWords(LoadTrackDevice(folder_.Write("x.toml", "name = \"x\"\n")).error(), {"omni-array 1"});
}

}  // namespace test_tools_track_files
}  // namespace omni::tools
