// The file of base_poses: an invalid one is reported and kept, a reply comes once it is written.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <utility>

#include "service/daemon/clients/base_poses.h"
#include "tests/daemon/base_pose_scenario.h"

namespace omni::daemon {
namespace test_daemon_base_pose_file {

std::string Read(const std::string& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

// Garbage is reported, by file and key, and never overwritten.
TEST(DaemonBasePoseFile, InvalidFileIsReportedAndNeverOverwritten) {
  const TempFolder temp;
  const std::string good = [&] {
    BasePoses base_poses(temp.Path("good.toml"));
    EXPECT_TRUE(base_poses.Execute(Store(kSpaceLocal), kDate_s).ok);
    return Read(temp.Path("good.toml"));
  }();
  const auto broken = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    return text.replace(text.find(from), from.size(), to);
  };
  const std::pair<std::string, std::string> cases[] = {
      {"\x01\x02 garbage", "TOML syntax"},
      {broken("format = 1", "format = 2"), "format = 2 is not known"},
      {broken("space = 2", "space = \"x\""), "alignments[0].space"},
      {broken("[0.10000000000000001", "[nan"), "alignments[0].position_space_m[0]"},
      {broken("rms_mm", "rms"), "alignments[0].rms_mm is missing"},
      {broken("wxyz = [", "wxyz = [0.9, 0.9, 0.9, 0.9] # "), "unit quaternion"}};
  for (const auto& [text, says] : cases) {
    const std::string path = temp.Write("bad.toml", text);
    BasePoses base_poses(path);
    EXPECT_NE(base_poses.problem().find("bad.toml"), std::string::npos);
    EXPECT_NE(base_poses.problem().find(says), std::string::npos) << base_poses.problem();
    const auto done = base_poses.Execute(Store(kSpaceStage), kDate_s);
    EXPECT_FALSE(done.ok);
    EXPECT_NE(done.text.find("move it away"), std::string::npos) << done.text;
    protocol::BasePoseCommand forget;
    forget.action = protocol::BasePoseAction::kForget;
    EXPECT_FALSE(base_poses.Execute(forget, kDate_s).ok);
    EXPECT_EQ(Read(path), text);
  }
}

TEST(DaemonBasePoseFile, StoreFailsIfTheFileCannotBeWritten) {
  const TempFolder temp;
  temp.Write("file", "");
  BasePoses base_poses(temp.Path("file/alignments.toml"));
  const auto done = base_poses.Execute(Store(kSpaceLocal), kDate_s);
  EXPECT_FALSE(done.ok);
  EXPECT_TRUE(base_poses.file().entries.empty());
  BasePoses homeless("");
  EXPECT_NE(homeless.Execute(Store(kSpaceLocal), kDate_s).text.find("XDG_CONFIG_HOME"), std::string::npos);
}

// A reply reports whether the file was written; only a refusal comes at once.
TEST(DaemonBasePoseFile, RepliesOnceTheFileIsWritten) {
  const TempFolder temp;
  const std::string path = temp.Path("a.toml");
  struct Answer {
    std::uint32_t number;
    bool done;
    std::string text;
  };
  std::vector<Answer> answers;
  BasePoseWriter writer([&](ipc::ClientId, std::uint32_t number, bool done, const std::string& text) {
    answers.push_back({number, done, text});
  });
  BasePoses base_poses(path, writer.write());
  const auto execute = [&](std::uint32_t number, const protocol::BasePoseCommand& command) {
    writer.ReplyWhenWritten(1, number, base_poses.Execute(command, kDate_s));
  };
  const auto take = [&](std::size_t count) {
    while (answers.size() < count) writer.HandleWritten(base_poses);
  };
  execute(1, Store(kSpaceLocal));
  EXPECT_TRUE(answers.empty());
  EXPECT_EQ(base_poses.file().entries.size(), 1U) << "in use at once";
  protocol::BasePoseCommand forget = Store(kSpaceStage);
  forget.action = protocol::BasePoseAction::kForget;
  execute(2, forget);
  ASSERT_EQ(answers.size(), 1U) << "nothing to wait for: no such alignment is stored";
  EXPECT_FALSE(answers[0].done);
  take(2);
  EXPECT_TRUE(answers[1].done && answers[1].number == 1);
  EXPECT_EQ(BasePoses(path).file().entries.size(), 1U);

  std::filesystem::remove(path);
  std::filesystem::create_directory(path);
  execute(3, Store(kSpaceStage));
  take(3);
  EXPECT_FALSE(answers[2].done);
  EXPECT_NE(answers[2].text.find("a.toml: cannot be written: it is a folder"), std::string::npos) << answers[2].text;
  EXPECT_NE(base_poses.problem().find("it is a folder"), std::string::npos);
  std::filesystem::remove(path);
  execute(4, Store(kSpaceStage));
  take(4);
  EXPECT_TRUE(answers[3].done);
  EXPECT_EQ(base_poses.problem(), "");
  EXPECT_EQ(BasePoses(path).file().entries.size(), 2U);
}

}  // namespace test_daemon_base_pose_file
}  // namespace omni::daemon
