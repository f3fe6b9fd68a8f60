// Seeded fuzz of a running server: thousands of packets, most of them almost right, while one good client lives on.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "tests/ipc/fixture.h"

namespace omni {
namespace test_ipc_server_property {

using namespace test;
using Bytes = std::vector<unsigned char>;

template <class T>
Bytes BytesOf(const T& message) {
  const auto* begin = reinterpret_cast<const unsigned char*>(&message);
  return Bytes(begin, begin + sizeof(message));
}

Bytes RandomPacket(std::mt19937_64& random) {
  static const std::vector<Bytes> seeds = {BytesOf(protocol::Hello{}),          BytesOf(protocol::Session{}),
                                           BytesOf(protocol::Haptic{}),         BytesOf(protocol::HapticStop{}),
                                           BytesOf(protocol::StatusRequest{}),  BytesOf(protocol::Notice{}),
                                           BytesOf(protocol::Reject{}),         BytesOf(protocol::Welcome{}),
                                           BytesOf(protocol::SurfaceRequest{}), BytesOf(protocol::Surfaces{})};
  Bytes bytes = seeds[1 + random() % (seeds.size() - 1)];
  if (random() % 3 == 0)
    bytes[random() % std::min<std::size_t>(bytes.size(), 40)] = static_cast<unsigned char>(random());
  if (random() % 10 == 0) bytes.resize(1 + random() % 3000, static_cast<unsigned char>(random()));
  return bytes;
}

TEST(ServerFuzz, OtherClientsSurviveRandomPackets) {
  const TempFolder temp;
  Service service(temp.Path("omnid.sock"));
  client::Connection good(InfoFor(temp.Path("omnid.sock"), "good"));
  ASSERT_TRUE(PollUntilConnected(good));
  std::mt19937_64 random(99);
  for (int i = 0; i < 1500; ++i) {
    RawClient raw(temp.Path("omnid.sock"));
    ASSERT_TRUE(raw.connected());
    if (random() % 4 != 0) {
      protocol::Hello hello;
      for (char& c : hello.application) c = static_cast<char>(random());
      hello.application[random() % sizeof(hello.application)] = 0;
      raw.Send(hello);
    }
    for (std::size_t packets = random() % 12; packets > 0; --packets) {
      const Bytes bytes = RandomPacket(random);
      raw.Send(bytes.data(), bytes.size());
    }
    if (i % 100 == 0) {
      good.Poll(base::MonotonicNow_ns());
      ASSERT_TRUE(good.connected()) << good.last_error();
    }
  }
  ASSERT_TRUE(Eventually([&] { return service.handler.ClientCount() == 1; }));
  good.Poll(base::MonotonicNow_ns());
  ASSERT_TRUE(good.connected());
  const int stops = service.handler.Stops();
  ASSERT_TRUE(good.Send(protocol::HapticStop{}));
  EXPECT_TRUE(Eventually([&] { return service.handler.Stops() > stops; }));
  for (const auto& [id, haptic] : service.handler.Haptics()) {
    ASSERT_TRUE(haptic.amplitude >= 0 && haptic.amplitude <= 1 && haptic.frequency_Hz >= 0);
  }
}

}  // namespace test_ipc_server_property
}  // namespace omni
