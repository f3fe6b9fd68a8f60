// Seeded fuzz of the gate: random and mutated packets, each in memory of exactly its size so that a sanitizer sees any
// read beyond it. What comes through satisfies the contract.
#include "service/protocol/validate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <random>
#include <type_traits>
#include <vector>

#include "service/protocol/state_memory.h"
#include "service/protocol/surface_memory.h"
#include "service/protocol/text.h"

namespace omni::protocol {
namespace {

using Bytes = std::vector<unsigned char>;

template <class T>
Bytes BytesOf(const T& message) {
  Bytes bytes(sizeof(message));
  std::memcpy(bytes.data(), &message, sizeof(message));
  return bytes;
}

Bytes WaveformBytes() {
  Waveform waveform;
  waveform.kind = WaveformKind::kPcm;
  waveform.sample_rate_Hz = 1000;
  waveform.count = 5;
  waveform.header.size = sizeof(waveform) + 5 * sizeof(float);
  Bytes bytes = BytesOf(waveform);
  bytes.resize(waveform.header.size);  // silence
  return bytes;
}

std::vector<Bytes> Seeds() {
  Welcome welcome;
  welcome.client_id = 1;
  welcome.state_bytes = sizeof(StateMemory);
  welcome.life_bytes = kLifePageBytes;
  Surfaces surfaces;
  surfaces.total_bytes = 4096;
  surfaces.memory_generation = 3;
  MessageHeader reply;
  reply.type = MessageType::kStatusReply;
  reply.size = sizeof(reply);
  return {BytesOf(Hello{}),  BytesOf(welcome),        BytesOf(Reject{}),        BytesOf(Session{}),
          BytesOf(Haptic{}), BytesOf(HapticStop{}),   BytesOf(StatusRequest{}), BytesOf(Notice{}),
          BytesOf(reply),    BytesOf(SceneCommand{}), BytesOf(SceneReply{}),    BytesOf(SurfaceRequest{}),
          BytesOf(surfaces), WaveformBytes()};
}

Bytes Mutated(Bytes bytes, std::mt19937_64& random) {
  const auto below = [&random](std::size_t n) { return static_cast<std::size_t>(random() % n); };
  for (std::size_t i = below(6); i > 0 && !bytes.empty(); --i) {
    bytes[below(4) == 0 ? below(bytes.size()) : below(std::min<std::size_t>(bytes.size(), 48))] =
        static_cast<unsigned char>(random());
  }
  if (below(8) == 0) bytes.resize(below(2 * bytes.size() + 40));
  if (below(2) == 0 && bytes.size() >= sizeof(MessageHeader)) {  // repair the size: deeper checks get their turn
    const auto size = static_cast<std::uint32_t>(bytes.size());
    std::memcpy(bytes.data() + offsetof(MessageHeader, size), &size, sizeof(size));
  }
  return bytes;
}

// The contract of each alternative.
struct Contract {
  std::size_t size;
  void operator()(const Invalid& invalid) const {
    EXPECT_TRUE(IsTerminated(invalid.reason));
    EXPECT_NE(invalid.reason[0], 0);
  }
  void operator()(const Hello& hello) const {
    EXPECT_TRUE(IsTerminated(hello.application) && IsTerminated(hello.engine));
    EXPECT_TRUE(hello.role == ClientRole::kApplication || hello.role == ClientRole::kMonitor);
  }
  void operator()(const Haptic& haptic) const {
    EXPECT_TRUE(std::isfinite(haptic.amplitude) && std::isfinite(haptic.frequency_Hz));
    EXPECT_TRUE(haptic.amplitude >= 0 && haptic.amplitude <= 1 && haptic.duration_ns >= -1);
  }
  void operator()(const Session& session) const { EXPECT_LE(static_cast<unsigned>(session.state), 2u); }
  void operator()(const Notice& notice) const { EXPECT_TRUE(IsTerminated(notice.text) && notice.level <= 2); }
  void operator()(const Reject& reject) const { EXPECT_TRUE(IsTerminated(reject.reason)); }
  void operator()(const Welcome& welcome) const { EXPECT_NE(welcome.client_id, 0u); }
  void operator()(const StatusReply& reply) const { EXPECT_EQ(reply.json.size(), size - sizeof(MessageHeader)); }
  void operator()(const SurfaceRequest& request) const { EXPECT_LE(request.wanted, 1u); }
  void operator()(const Surfaces& surfaces) const {
    EXPECT_LE(surfaces.total_bytes, kMaxSurfaceBytes);
    EXPECT_EQ(surfaces.total_bytes == 0, surfaces.memory_generation == 0);
  }
  void operator()(const ShapedHaptic& haptic) const {
    EXPECT_EQ(size, sizeof(Waveform) + haptic.waveform.count * sizeof(float));
    for (std::size_t i = 0; i < haptic.waveform.count; ++i) EXPECT_LE(std::abs(haptic.sample(i)), 1.0F);
  }
  void operator()(const SceneCommand& command) const {
    EXPECT_TRUE(IsTerminated(command.object));
    EXPECT_TRUE(command.action >= SceneAction::kEdits && command.action <= SceneAction::kSave);
  }
  void operator()(const SceneAnswer& answer) const {
    EXPECT_EQ(answer.text.size(), size - sizeof(SceneReply));
    EXPECT_TRUE(answer.reply.done == 1 || answer.reply.file_bytes == 0);
  }
  template <class T>
  void operator()(const T&) const {
    EXPECT_EQ(size, sizeof(T));
  }
};

TEST(ValidateFuzz, HundredThousandPackets) {
  std::mt19937_64 random(20261);
  const std::vector<Bytes> seeds = Seeds();
  std::size_t accepted = 0;
  for (int i = 0; i < 100'000; ++i) {
    Bytes bytes;
    if (i % 10 == 0) {
      bytes.resize(random() % 400);
      std::generate(bytes.begin(), bytes.end(), [&] { return static_cast<unsigned char>(random()); });
    } else {
      bytes = Mutated(seeds[random() % seeds.size()], random);
    }
    const std::unique_ptr<unsigned char[]> exact(new unsigned char[bytes.size()]);
    std::copy(bytes.begin(), bytes.end(), exact.get());
    const Message message = Validate(exact.get(), bytes.size());
    std::visit(Contract{bytes.size()}, message);
    accepted += message.index() != 0;
    if (HasFailure()) FAIL() << "packet " << i;
  }
  // Both outcomes must have had their share, or this test tests nothing.
  EXPECT_GT(accepted, 10'000u);
  EXPECT_LT(accepted, 90'000u);
}

TEST(ValidateFuzz, PrintableIsIdempotentAndFreeOfControls) {
  std::mt19937_64 random(7);
  for (int i = 0; i < 20'000; ++i) {
    std::string text(random() % 40, '\0');
    for (char& c : text) c = static_cast<char>(random());
    const std::string once = Printable(text);
    EXPECT_EQ(once, Printable(once));
    EXPECT_EQ(once.size(), text.size());
    for (const char c : once) {
      EXPECT_TRUE(static_cast<unsigned char>(c) >= 0x20 && c != 0x7F);
    }
  }
}

}  // namespace
}  // namespace omni::protocol
