// alignments.toml and marks.toml: round trips, and the error of each mistake.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "service/config/files/alignment_file.h"
#include "service/config/files/device_file.h"

namespace omni::config {
namespace test_config_alignments {

AlignmentFile Example() {
  AlignmentFile file;
  file.uncalibrated = UncalibratedPolicy::kCalibrated;
  for (int i = 0; i < 3; ++i) {
    file.entries.push_back({.runtime = "Runtime \"" + std::to_string(i) + "\\n",
                            .system = "H\xC3\xA4\x64set",
                            .space = 2 + i,
                            .orientation_space = {0.5, -0.5, 0.5, 0.5},
                            .position_space_m = {1.0 / 3, -2, 1e-9 * i},
                            .measured_orientation_space = {0.5, -0.5, 0.5, 0.5},
                            .measured_position_space_m = {1.0 / 3, -2 - 0.1 * i, 1e-9 * i},
                            .method = "touch",
                            .date = "2026-11-22T10:00:00Z",
                            .samples = 5,
                            .rms_mm = 1.2345678901234567,
                            .expected_error_mm = 0.9,
                            .rotation_deg = 0.3,
                            .recentred = i,
                            .doubtful = i == 1});
    if (i == 1) file.entries.back().field_base_T = base::Vec3{1e-6 / 3, -4e-5, 2e-5};
    file.entries.back().base_moved = i == 1;
  }
  return file;
}

TEST(ConfigAlignments, WriteThenParseRoundTripsExactly) {
  const AlignmentFile written = Example();
  const auto read = ParseAlignments(WriteAlignments(written), "test.toml");
  ASSERT_TRUE(read.ok()) << read.error();
  EXPECT_EQ(read->uncalibrated, written.uncalibrated);
  ASSERT_EQ(read->entries.size(), written.entries.size());
  for (std::size_t i = 0; i < written.entries.size(); ++i) {
    const AlignmentEntry& a = written.entries[i];
    const AlignmentEntry& b = read->entries[i];
    EXPECT_EQ(a.runtime, b.runtime);
    EXPECT_EQ(a.system, b.system);
    EXPECT_EQ(a.space, b.space);
    EXPECT_EQ(a.orientation_space, b.orientation_space);
    EXPECT_EQ(a.position_space_m, b.position_space_m);
    EXPECT_EQ(a.measured_orientation_space, b.measured_orientation_space);
    EXPECT_EQ(a.measured_position_space_m, b.measured_position_space_m);
    EXPECT_EQ(a.method, b.method);
    EXPECT_EQ(a.date, b.date);
    EXPECT_EQ(a.samples, b.samples);
    EXPECT_EQ(a.rms_mm, b.rms_mm);
    EXPECT_EQ(a.expected_error_mm, b.expected_error_mm);
    EXPECT_EQ(a.rotation_deg, b.rotation_deg);
    EXPECT_EQ(a.recentred, b.recentred);
    EXPECT_EQ(a.doubtful, b.doubtful);
    EXPECT_EQ(a.base_moved, b.base_moved);
    ASSERT_EQ(a.field_base_T.has_value(), b.field_base_T.has_value());
    if (a.field_base_T) {
      EXPECT_LT(base::Distance(*a.field_base_T, *b.field_base_T), 1e-18);
    }
  }
}

// Files from before the measured pose was stored: the present one is the best that is known of it.
TEST(ConfigAlignments, MissingMeasuredPoseDefaultsToThePresentOne) {
  std::string text = WriteAlignments(Example());
  for (std::size_t at = text.find("\nmeasured_"); at != std::string::npos; at = text.find("\nmeasured_")) {
    text.erase(at, text.find('\n', at + 1) - at);
  }
  const auto read = ParseAlignments(text, "test.toml");
  ASSERT_TRUE(read.ok()) << read.error();
  for (const AlignmentEntry& entry : read->entries) {
    EXPECT_EQ(entry.measured_position_space_m, entry.position_space_m);
    EXPECT_EQ(entry.measured_orientation_space, entry.orientation_space);
  }
}

TEST(ConfigAlignments, RejectsIncompleteMeasuredPose) {
  std::string text = WriteAlignments(Example());
  const std::size_t at = text.find("\nmeasured_orientation_space_wxyz");
  text.erase(at, text.find('\n', at + 1) - at);
  EXPECT_NE(ParseAlignments(text, "test.toml").error().find("measured_orientation_space_wxyz is missing"),
            std::string::npos);
}

TEST(ConfigAlignments, EmptyOrMissingFileHasNoAlignments) {
  const auto read = ParseAlignments("format = 1\n", "test.toml");
  ASSERT_TRUE(read.ok()) << read.error();
  EXPECT_TRUE(read->entries.empty());
  EXPECT_EQ(read->uncalibrated, UncalibratedPolicy::kFrontOfUser);
  EXPECT_TRUE(LoadAlignmentFile("/no/such/folder/alignments.toml").ok());
}

// Any file is rejected with its name in the error, or every number is finite and in range.
TEST(ConfigAlignments, MutatedFilesAreRejectedOrInRange) {
  std::mt19937 random(3);
  const std::string good = WriteAlignments(Example());
  int refused = 0;
  for (int i = 0; i < 3000; ++i) {
    std::string text = good;
    for (auto n = 1 + random() % 3; n > 0; --n) {
      const std::size_t at = random() % text.size();
      if (random() % 3 == 0) {
        text.erase(at, 1 + random() % 12);
      } else if (random() % 2 == 0) {
        text[at] = static_cast<char>(random() % 256);
      } else {
        text.insert(at, text.substr(random() % text.size(), random() % 30));
      }
      if (text.empty()) text = "x";
    }
    const auto read = ParseAlignments(text, "mutant.toml");
    if (!read.ok()) {
      ++refused;
      ASSERT_NE(read.error().find("mutant.toml"), std::string::npos) << read.error();
      continue;
    }
    for (const AlignmentEntry& entry : read->entries) {
      const base::Quat& q = entry.orientation_space;
      ASSERT_NEAR(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z, 1, 3e-3);
      for (const double p : {entry.position_space_m.x, entry.position_space_m.y, entry.position_space_m.z}) {
        ASSERT_LE(std::abs(p), 100);
      }
      const base::Quat& m = entry.measured_orientation_space;
      ASSERT_NEAR(m.w * m.w + m.x * m.x + m.y * m.y + m.z * m.z, 1, 3e-3);
      ASSERT_FALSE(entry.runtime.empty() || entry.system.empty());
    }
  }
  EXPECT_GT(refused, 1000);
  EXPECT_LT(refused, 2950);
}

TEST(ConfigMarks, BuiltInMarksHaveNoRotationalSymmetry) {
  const auto& marks = DefaultMarks();
  ASSERT_EQ(marks.size(), 5U);
  // On the ring, and no rotation of the ring maps marks to marks: a wrong first mark is noticed.
  std::vector<double> angles;
  for (std::size_t i = 0; i < 4; ++i) {
    const base::Vec3& p = marks[i].position_base_m;
    EXPECT_NEAR(std::hypot(p.x, p.y), 0.08, 1e-4);
    angles.push_back(std::atan2(p.y, p.x));
  }
  for (std::size_t turn = 1; turn < 4; ++turn) {
    double most = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      const double a = angles[(i + turn) % 4] - angles[i], b = angles[turn % 4] - angles[0];
      most = std::max(most, std::abs(std::remainder(a - b, 2 * 3.14159265358979)));
    }
    EXPECT_GT(0.08 * most, 0.015) << "15 mm at least, turned by " << turn;
  }
}

TEST(ConfigMarks, ErrorsNameMarkAndKey) {
  const auto error = [](const std::string& text) { return ParseMarks(text, "m.toml").error(); };
  const std::string two =
      "[[marks]]\nname=\"a\"\nposition_base_m=[0,0,0]\n[[marks]]\nname=\"b\"\nposition_base_m=[0,0.1,0]\n";
  EXPECT_NE(error(two).find("3 to 12 tables [[marks]]"), std::string::npos);
  EXPECT_NE(error(two + "[[marks]]\nname=\"c\"\nposition_base_m=[0,0,9]\n").find("marks[2].position_base_m[2] = 9"),
            std::string::npos);
  EXPECT_NE(error(two + "[[marks]]\nname=\"c\"\nplace=1\nposition_base_m=[0,0,0]\n").find("marks[2].place is unknown"),
            std::string::npos);
}

}  // namespace test_config_alignments
}  // namespace omni::config
