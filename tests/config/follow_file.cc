// follow.toml: what the base follows.
#include "service/config/files/follow_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <utility>

#include "service/config/text/text_file.h"
#include "tests/support/process/temp_folder.h"

namespace omni::config {
namespace test_config_follow_file {

TEST(FollowFile, ReadsWhatWasWritten) {
  std::mt19937 random(8);
  std::normal_distribution<> normal;
  for (int i = 0; i < 100; ++i) {
    FollowSettings written{.follows = "/user/hand/left",
                           .position_source_m = {normal(random), normal(random), normal(random)},
                           .orientation_source = {normal(random), normal(random), normal(random), normal(random)}};
    base::Quat& q = written.orientation_source;
    const double norm = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
    q = {q.w / norm, q.x / norm, q.y / norm, q.z / norm};
    const auto read = ParseFollow(WriteFollow(written), "follow.toml");
    ASSERT_TRUE(read.ok()) << read.error();
    EXPECT_EQ(read->follows, written.follows);
    EXPECT_LT(base::Distance(read->position_source_m, written.position_source_m), 1e-12);
    EXPECT_NEAR(read->orientation_source.z, q.z, 1e-12);
  }
}

TEST(FollowFile, WithoutAFileTheBaseStands) {
  const test::TempFolder temp;
  const auto read = LoadFollowFile(temp.Path("follow.toml"));
  ASSERT_TRUE(read.ok());
  EXPECT_FALSE(read->has_value());
}

TEST(FollowFile, NamesWhatIsWrong) {
  const std::string rest = "position_source_m = [0.0, 0.0, 0.1]\norientation_source_wxyz = ";
  const auto error = [](const std::string& text) {
    const auto read = ParseFollow(text, "follow.toml");
    return read.ok() ? std::string() : read.error();
  };
  EXPECT_EQ(error("[base]\nfollows = \"/user/hand/left\"\n" + rest + "[1.0, 0.0, 0.0, 0.0]\n"), "");
  for (const auto& [text, part] : std::initializer_list<std::pair<std::string, const char*>>{
           {"", "base"},
           {"[base]\n" + rest + "[1.0, 0.0, 0.0, 0.0]\n", "base.follows"},
           {"[base]\nfollows = \"x\"\n" + rest + "[1.0, 1.0, 0.0, 0.0]\n", "unit quaternion"},
           {"[base]\nfollows = \"x\"\n" + rest + "[0.0, 0.0, 0.0, 0.0]\n", "unit quaternion"},
           {"[base]\nfollows = \"x\"\nspeed = 1\n" + rest + "[1.0, 0.0, 0.0, 0.0]\n", "speed"}}) {
    const std::string said = error(text);
    EXPECT_NE(said.find(part), std::string::npos) << part << " not in: " << said;
    EXPECT_NE(said.find("follow.toml"), std::string::npos) << said;
  }
}

}  // namespace test_config_follow_file
}  // namespace omni::config
