// Where the socket lies, and which folders are refused.
#include "service/protocol/socket_path.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "service/protocol/control.h"
#include "tests/support/process/scoped_variable.h"
#include "tests/support/process/temp_folder.h"

namespace omni::protocol {
namespace test_protocol_socket_path {

TEST(SocketPath, DefaultFollowsTheEnvironment) {
  const test::ScopedVariable runtime("XDG_RUNTIME_DIR", "/run/user/7");
  {
    const test::ScopedVariable own("OMNI_SOCKET", "/x/y.sock");
    EXPECT_EQ(DefaultSocketPath(), "/x/y.sock");
  }
  const test::ScopedVariable none("OMNI_SOCKET", std::nullopt);
  EXPECT_EQ(DefaultSocketPath(), "/run/user/7/omni/omnid.sock");
  // Without it: where systemd puts it, if it is there.
  const std::string uid = std::to_string(::geteuid()), run = "/run/user/" + uid;
  const bool there = CheckFolder(run).state == FolderState::kGood;
  const std::string otherwise = there ? run + "/omni/omnid.sock" : "/tmp/omni-" + uid + "/omnid.sock";
  const test::ScopedVariable relative("XDG_RUNTIME_DIR", "run");
  EXPECT_EQ(DefaultSocketPath(), otherwise);
  const test::ScopedVariable empty("XDG_RUNTIME_DIR", "");
  EXPECT_EQ(DefaultSocketPath(), otherwise);
}

TEST(SocketPath, LimitIs107Bytes) {
  const std::string longest = "/" + std::string(kMaxSocketPathBytes - 1, 'x');
  EXPECT_EQ(PathProblem(longest), "");
  const std::string problem = PathProblem(longest + "x");
  EXPECT_NE(problem.find("108 bytes"), std::string::npos) << problem;
  EXPECT_NE(problem.find("OMNI_SOCKET"), std::string::npos) << problem;
}

TEST(SocketPath, MustBeAnAbsoluteFile) {
  EXPECT_NE(PathProblem(""), "");
  EXPECT_NE(PathProblem("omnid.sock"), "");
  EXPECT_NE(PathProblem("/run/"), "");
  EXPECT_NE(PathProblem(std::string("/a\0b", 4)), "");
}

TEST(SocketPath, SplitsIntoFolderAndAddress) {
  EXPECT_EQ(FolderOf("/a/b/c.sock"), "/a/b");
  EXPECT_EQ(FolderOf("/c.sock"), "/");
  const SocketAddress address = AddressOf("/a/b/c.sock");
  EXPECT_STREQ(address.address.sun_path, "/a/b/c.sock");
  EXPECT_EQ(address.bytes, sizeof(sa_family_t) + 12);
}

TEST(SocketFolder, AcceptsOwnPrivateFolder) {
  const test::TempFolder temp;
  const FolderCheck check = CheckFolder(temp.Path());
  EXPECT_EQ(check.state, FolderState::kGood);
  EXPECT_EQ(check.problem, "");
}

TEST(SocketFolder, ReportsMissingFolderAsMissing) {
  const test::TempFolder temp;
  EXPECT_EQ(CheckFolder(temp.Path("none")).state, FolderState::kMissing);
}

TEST(SocketFolder, RejectsFoldersOpenToOtherUsers) {
  const test::TempFolder temp;
  for (const mode_t mode : {0710u, 0701u, 0755u, 0770u, 01777u}) {
    ASSERT_EQ(::chmod(temp.Path().c_str(), mode), 0);
    const FolderCheck check = CheckFolder(temp.Path());
    EXPECT_EQ(check.state, FolderState::kRefused);
    EXPECT_NE(check.problem.find("chmod 700 " + temp.Path()), std::string::npos) << check.problem;
  }
}

TEST(SocketFolder, RejectsSymlinksAndFiles) {
  const test::TempFolder temp;
  const std::string target = temp.Path("real");
  const std::string link = temp.Path("link");
  ASSERT_EQ(::mkdir(target.c_str(), 0700), 0);
  ASSERT_EQ(::symlink(target.c_str(), link.c_str()), 0);
  const FolderCheck check = CheckFolder(link);
  EXPECT_EQ(check.state, FolderState::kRefused);
  EXPECT_NE(check.problem.find("symbolic link"), std::string::npos);
  EXPECT_EQ(CheckFolder("/dev/null").state, FolderState::kRefused);
}

TEST(SocketFolder, RejectsFoldersOfOtherUsers) {
  const std::string foreign = ::geteuid() == 0 ? std::string() : "/";
  const test::TempFolder temp;
  if (foreign.empty()) {
    ASSERT_EQ(::chown(temp.Path().c_str(), 65534, 65534), 0);
  }
  const FolderCheck check = CheckFolder(foreign.empty() ? temp.Path() : foreign);
  EXPECT_EQ(check.state, FolderState::kRefused);
  EXPECT_NE(check.problem.find("belongs to user"), std::string::npos) << check.problem;
}

}  // namespace test_protocol_socket_path
}  // namespace omni::protocol
