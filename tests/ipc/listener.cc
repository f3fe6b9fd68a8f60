// The listening socket: one omnid per path, in a folder of its user.
#include "service/ipc/listener.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>

#include "service/protocol/socket_path.h"
#include "tests/ipc/fixture.h"

namespace omni::ipc {
namespace test_ipc_listener {

using test::TempFolder;

std::string ErrorOf(const std::string& path) {
  const auto opened = Listener::Open(path);
  return opened ? "opened" : opened.error();
}

mode_t ModeOf(const std::string& path) {
  struct stat info {};
  EXPECT_EQ(::lstat(path.c_str(), &info), 0);
  return info.st_mode & 07777u;
}

TEST(Listener, CreatesPrivateFolderAndSocket) {
  const TempFolder temp;
  const std::string path = temp.Path("omni/omnid.sock");
  const auto opened = Listener::Open(path);
  ASSERT_TRUE(opened) << opened.error();
  EXPECT_EQ(ModeOf(temp.Path("omni")), 0700u);
  EXPECT_EQ(ModeOf(path), 0600u);
  EXPECT_EQ(opened->path(), path);
}

TEST(Listener, RemovesTheSocketButNotTheFolder) {
  const TempFolder temp;
  const std::string path = temp.Path("omni/omnid.sock");
  { ASSERT_TRUE(Listener::Open(path)); }
  EXPECT_NE(::access(path.c_str(), F_OK), 0);
  EXPECT_EQ(::access((temp.Path("omni")).c_str(), F_OK), 0);
}

TEST(Listener, AdoptedSocketStaysWhereItIs) {
  const TempFolder temp;
  const std::string path = temp.Path("omnid.sock");
  const protocol::SocketAddress at = protocol::AddressOf(path);
  base::UniqueFd socket(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0));
  ASSERT_EQ(::bind(socket.get(), reinterpret_cast<const sockaddr*>(&at.address), at.bytes), 0);
  EXPECT_EQ(protocol::FindService(path), protocol::ServiceState::kAbsent);
  ASSERT_EQ(::listen(socket.get(), 1), 0);
  EXPECT_EQ(protocol::FindService(path), protocol::ServiceState::kOnDemand);
  EXPECT_NE(ErrorOf(path).find("systemctl --user start omnid"), std::string::npos) << "it is not taken from systemd";
  EXPECT_EQ(::access(path.c_str(), F_OK), 0);
  {
    const auto adopted = Listener::Adopt(base::UniqueFd(::dup(socket.get())), path);
    ASSERT_TRUE(adopted) << adopted.error();
    EXPECT_EQ(protocol::FindService(path), protocol::ServiceState::kRuns);
    EXPECT_NE(ErrorOf(path).find("already serves"), std::string::npos);
  }
  EXPECT_EQ(protocol::FindService(path), protocol::ServiceState::kOnDemand);
  EXPECT_EQ(::access(path.c_str(), F_OK), 0);
}

TEST(Listener, RejectsSecondListenerWithPidOfTheFirst) {
  const TempFolder temp;
  auto first = std::make_unique<base::Result<Listener>>(Listener::Open(temp.Path("omnid.sock")));
  ASSERT_TRUE(*first);
  const std::string error = ErrorOf(temp.Path("omnid.sock"));
  EXPECT_NE(error.find("pid " + std::to_string(::getpid())), std::string::npos) << error;
  EXPECT_NE(error.find(temp.Path("omnid.sock")), std::string::npos) << error;
  EXPECT_TRUE(test::RawClient(temp.Path("omnid.sock")).connected()) << "the first lost its socket";
  first.reset();
  EXPECT_EQ(ErrorOf(temp.Path("omnid.sock")), "opened");
}

TEST(Listener, ReplacesTheSocketOfADeadOmnid) {
  const TempFolder temp;
  const protocol::SocketAddress at = protocol::AddressOf(temp.Path("omnid.sock"));
  {
    const base::UniqueFd dead(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0));
    ASSERT_EQ(::bind(dead.get(), reinterpret_cast<const sockaddr*>(&at.address), at.bytes), 0);
  }
  ASSERT_EQ(::access(temp.Path("omnid.sock").c_str(), F_OK), 0);
  const auto opened = Listener::Open(temp.Path("omnid.sock"));
  ASSERT_TRUE(opened) << opened.error();
  EXPECT_TRUE(test::RawClient(temp.Path("omnid.sock")).connected());
}

TEST(Listener, NeverRemovesWhatIsNoSocket) {
  const TempFolder temp;
  std::ofstream(temp.Path("omnid.sock")) << "precious";
  EXPECT_NE(ErrorOf(temp.Path("omnid.sock")).find("is not a socket"), std::string::npos);
  EXPECT_EQ(std::filesystem::file_size(temp.Path("omnid.sock")), 8u);
}

TEST(Listener, RejectsFoldersThatAreSymlinkedOpenOrMissing) {
  const TempFolder temp;
  const std::string real = temp.Path("real");
  const std::string link = temp.Path("link");
  ASSERT_EQ(::mkdir(real.c_str(), 0700), 0);
  ASSERT_EQ(::symlink(real.c_str(), link.c_str()), 0);
  EXPECT_NE(ErrorOf(link + "/omnid.sock").find("symbolic link"), std::string::npos);
  ASSERT_EQ(::chmod(real.c_str(), 0755), 0);
  EXPECT_NE(ErrorOf(real + "/omnid.sock").find("mode 0755"), std::string::npos);
  EXPECT_NE(ErrorOf(temp.Path("no/such/omnid.sock")).find("OMNI_SOCKET"), std::string::npos);
}

TEST(Listener, RejectsASymlinkAsLockFile) {
  const TempFolder temp;
  const std::string victim = temp.Path("victim");
  std::ofstream(victim) << "precious";
  ASSERT_EQ(::symlink(victim.c_str(), protocol::LockPathOf(temp.Path("omnid.sock")).c_str()), 0);
  EXPECT_NE(ErrorOf(temp.Path("omnid.sock")).find("lock file"), std::string::npos);
  EXPECT_EQ(std::filesystem::file_size(victim), 8u);
}

TEST(Listener, RejectsOverlongPaths) {
  const std::string error = ErrorOf("/tmp/" + std::string(120, 'x') + "/omnid.sock");
  EXPECT_NE(error.find("the limit is 107"), std::string::npos) << error;
}

TEST(Listener, LockPathReplacesTheSockSuffix) {
  EXPECT_EQ(protocol::LockPathOf("/x/omnid.sock"), "/x/omnid.lock");
  EXPECT_EQ(protocol::LockPathOf("/x/other"), "/x/other.lock");
}

}  // namespace test_ipc_listener
}  // namespace omni::ipc
