// The socket that moves the twin's hand: who may lead, what is accepted, what happens to the rest.
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <memory>
#include <random>
#include <string>

#include "service/client/dial.h"
#include "service/ipc/listener.h"
#include "service/protocol/socket_path.h"
#include "tests/support/process/temp_folder.h"

namespace omni::ipc {
namespace test_ipc_hand {

using client::HandLink;
using test::TempFolder;

protocol::HandAim AimAt(double x_m) { return {.tip_base_m = {x_m, 0, 0.06}}; }

std::unique_ptr<HandListener> Opened(const std::string& path) {
  auto opened = HandListener::Open(path);
  EXPECT_TRUE(opened.ok()) << (opened.ok() ? "" : opened.error());
  return opened.ok() ? std::move(*opened) : nullptr;
}

std::string ErrorOf(const std::string& path) {
  const auto opened = HandListener::Open(path);
  return opened.ok() ? "opened" : opened.error();
}

base::UniqueFd Dialled(const std::string& path) {
  base::UniqueFd socket(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  const protocol::SocketAddress at = protocol::AddressOf(path);
  EXPECT_EQ(::connect(socket.get(), reinterpret_cast<const sockaddr*>(&at.address), at.bytes), 0);
  return socket;
}

TEST(HandListener, ReturnsTheNewestAimOnce) {
  const TempFolder folder;
  const auto listener = Opened(folder.Path("hand.sock"));
  EXPECT_FALSE(listener->Poll());
  HandLink link(folder.Path("hand.sock"));
  ASSERT_TRUE(link.Connect()) << link.problem();
  EXPECT_FALSE(listener->Poll()) << "no aim was sent yet";
  for (const double x_m : {0.01, 0.02, 0.03}) EXPECT_TRUE(link.Send(AimAt(x_m)));
  const auto aim = listener->Poll();
  ASSERT_TRUE(aim);
  EXPECT_EQ(aim->tip_base_m[0], 0.03);
  EXPECT_FALSE(listener->Poll()) << "an aim is returned once";
}

TEST(HandListener, ReadsABoundedNumberOfAimsPerPoll) {
  const TempFolder folder;
  const auto listener = Opened(folder.Path("hand.sock"));
  HandLink link(folder.Path("hand.sock"));
  ASSERT_TRUE(link.Connect());
  constexpr int kSent = HandListener::kAimsPerPoll + 3;
  for (int i = 1; i <= kSent; ++i) ASSERT_TRUE(link.Send(AimAt(1e-3 * i)));
  EXPECT_EQ(listener->Poll()->tip_base_m[0], 1e-3 * HandListener::kAimsPerPoll);
  EXPECT_EQ(listener->Poll()->tip_base_m[0], 1e-3 * kSent);
}

TEST(HandListener, SocketIsPrivateAndRemovedAtTheEnd) {
  const TempFolder folder;
  const std::string path = folder.Path("hand.sock");
  auto listener = Opened(path);
  struct stat info {};
  ASSERT_EQ(::lstat(path.c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 07777u, 0600u);
  listener.reset();
  EXPECT_NE(::access(path.c_str(), F_OK), 0);
}

TEST(HandListener, RejectsFoldersOpenToOtherUsers) {
  const TempFolder folder;
  ASSERT_EQ(::mkdir(folder.Path("open").c_str(), 0755), 0);
  ASSERT_EQ(::symlink(folder.Path().c_str(), folder.Path("link").c_str()), 0);
  for (const std::string& path :
       {folder.Path("open/hand.sock"), folder.Path("link/hand.sock"), folder.Path("missing/hand.sock")}) {
    EXPECT_NE(ErrorOf(path).find("mkdir -p -m 700"), std::string::npos) << ErrorOf(path);
    EXPECT_NE(ErrorOf(path).find(path), std::string::npos);
    EXPECT_FALSE(HandLink(path).Connect()) << "nor does the other end trust it";
  }
  EXPECT_NE(ErrorOf("hand.sock").find("absolute path"), std::string::npos);
  EXPECT_NE(ErrorOf("/tmp/" + std::string(120, 'x')).find("107 bytes"), std::string::npos);
}

TEST(HandListener, ReplacesOnlyDeadSockets) {
  const TempFolder folder;
  const std::string path = folder.Path("hand.sock");
  const protocol::SocketAddress at = protocol::AddressOf(path);
  {
    const base::UniqueFd dead(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0));
    ASSERT_EQ(::bind(dead.get(), reinterpret_cast<const sockaddr*>(&at.address), at.bytes), 0);
  }
  const auto listener = Opened(path);
  HandLink link(path);
  ASSERT_TRUE(link.Connect());
  ASSERT_TRUE(link.Send(AimAt(0.01)));
  ASSERT_TRUE(listener->Poll());
  EXPECT_NE(ErrorOf(path).find("another twin"), std::string::npos) << ErrorOf(path);
  EXPECT_TRUE(link.Send(AimAt(0.02)));
  EXPECT_TRUE(listener->Poll()) << "the attempt did not take the lead";
  std::ofstream(folder.Path("precious")) << "text";
  EXPECT_NE(ErrorOf(folder.Path("precious")).find("not a socket"), std::string::npos);
  EXPECT_EQ(std::filesystem::file_size(folder.Path("precious")), 4U);
}

TEST(HandListener, SecondLeaderWaitsUntilTheFirstDisconnects) {
  const TempFolder folder;
  const auto listener = Opened(folder.Path("hand.sock"));
  HandLink second(folder.Path("hand.sock"));
  {
    HandLink first(folder.Path("hand.sock"));
    ASSERT_TRUE(first.Connect());
    ASSERT_TRUE(second.Connect());
    ASSERT_TRUE(second.Send(AimAt(0.02)));
    ASSERT_TRUE(first.Send(AimAt(0.01)));
    EXPECT_EQ(listener->Poll()->tip_base_m[0], 0.01);
    EXPECT_FALSE(listener->Poll());
  }
  EXPECT_FALSE(listener->Poll()) << "notices that the first one has gone";
  EXPECT_EQ(listener->Poll()->tip_base_m[0], 0.02);
}

TEST(HandListener, DisconnectsClientsThatSendInvalidPackets) {
  const TempFolder folder;
  const auto listener = Opened(folder.Path("hand.sock"));
  std::mt19937_64 random(1);
  for (int i = 0; i < 300; ++i) {
    const base::UniqueFd socket = Dialled(folder.Path("hand.sock"));
    std::string packet(1 + random() % 200, '\0');
    for (char& byte : packet) byte = static_cast<char>(random());
    ASSERT_EQ(::send(socket.get(), packet.data(), packet.size(), MSG_NOSIGNAL), static_cast<ssize_t>(packet.size()));
    EXPECT_FALSE(listener->Poll());
    char byte = 0;
    EXPECT_EQ(::recv(socket.get(), &byte, 1, 0), 0) << "closed";
  }
  HandLink link(folder.Path("hand.sock"));
  ASSERT_TRUE(link.Connect());
  ASSERT_TRUE(link.Send(AimAt(0.01)));
  EXPECT_TRUE(listener->Poll()) << "others are not affected";
}

TEST(HandLink, DetectsThatTheTwinHasExited) {
  const TempFolder folder;
  auto listener = Opened(folder.Path("hand.sock"));
  HandLink link(folder.Path("hand.sock"));
  EXPECT_FALSE(link.Send(AimAt(0)));
  ASSERT_TRUE(link.Connect());
  ASSERT_TRUE(link.Send(AimAt(0)));
  ASSERT_TRUE(listener->Poll());
  listener.reset();
  EXPECT_FALSE(link.Send(AimAt(0)));
  EXPECT_FALSE(link.connected());
  EXPECT_FALSE(link.Connect());
  EXPECT_NE(link.problem().find("--twin-hand"), std::string::npos) << link.problem();
}

// A twin that does not read: aims are lost, the sender does not wait.
TEST(HandLink, SendNeverBlocks) {
  const TempFolder folder;
  const auto listener = Opened(folder.Path("hand.sock"));
  HandLink link(folder.Path("hand.sock"));
  ASSERT_TRUE(link.Connect());
  for (int i = 0; i < 20'000; ++i) ASSERT_TRUE(link.Send(AimAt(0)));
  EXPECT_TRUE(listener->Poll());
}

}  // namespace test_ipc_hand
}  // namespace omni::ipc
