// Packets with descriptors.
#include "service/protocol/packet_socket.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/socket.h>

#include <array>
#include <vector>

namespace omni::protocol {
namespace test_protocol_packet_socket {

// Not a fixture: a sanitizer's check of a call through a pointer with virtual functions needs a free descriptor itself.
struct Ends {
  Ends() {
    int pair[2] = {-1, -1};
    EXPECT_EQ(::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, pair), 0);
    mine.Reset(pair[0]);
    yours.Reset(pair[1]);
  }
  Received Receive(std::size_t room) { return ReceivePacket(yours.get(), buffer.data(), buffer.size(), fds, room); }

  base::UniqueFd mine, yours;
  std::array<char, 64> buffer{};
  base::UniqueFd fds[kMaxPassedFds];
};

TEST(PacketSocket, SaysWhatIsTooMuch) {
  Ends ends;
  const std::array<int, 2> two{ends.mine.get(), ends.mine.get()};
  std::array<char, 65> long_one{};
  ASSERT_EQ(SendPacket(ends.mine.get(), "hello", 5), SendResult::kSent);
  EXPECT_EQ(ends.Receive(2).result, ReceiveResult::kPacket);
  ASSERT_EQ(SendPacket(ends.mine.get(), long_one.data(), long_one.size()), SendResult::kSent);
  EXPECT_EQ(ends.Receive(2).result, ReceiveResult::kTooLong);
  ASSERT_EQ(SendPacket(ends.mine.get(), "hello", 5, two.data(), 2), SendResult::kSent);
  EXPECT_EQ(ends.Receive(1).result, ReceiveResult::kTooLong);
  ASSERT_EQ(SendPacket(ends.mine.get(), "hello", 5, two.data(), 2), SendResult::kSent);
  const Received both = ends.Receive(4);
  EXPECT_EQ(both.result, ReceiveResult::kPacket);
  EXPECT_EQ(both.fd_count, 2U);
}

// A process with all its descriptors in use is not sent "a packet that is too long".
TEST(PacketSocket, FullProcessIsNamed) {
  Ends ends;
  const std::array<int, 2> two{ends.mine.get(), ends.mine.get()};
  ASSERT_EQ(SendPacket(ends.mine.get(), "hello", 5, two.data(), 2), SendResult::kSent);
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
  const base::UniqueFd next(::dup(ends.mine.get()));
  rlimit full = before;
  full.rlim_cur = static_cast<rlim_t>(next.get()) + 1;  // all lower numbers are taken
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &full), 0);
  const Received received = ends.Receive(4);
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &before), 0);
  EXPECT_EQ(received.result, ReceiveResult::kNoRoom);
}

}  // namespace test_protocol_packet_socket
}  // namespace omni::protocol
