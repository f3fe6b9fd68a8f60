// Seeded fuzz of the checks: random and mutated packets, each in memory of exactly its size so that a sanitizer sees
// any read beyond it. Accepted messages satisfy the contract.
#include "service/protocol/messages.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <random>
#include <type_traits>
#include <vector>

#include "service/protocol/state_memory.h"
#include "service/protocol/surfaces/surface_memory.h"
#include "service/protocol/text.h"

namespace omni::protocol {
namespace test_protocol_validate_property {

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
  BasePoseRequest base_pose_request;
  base_pose_request.space_count = 2;
  MessageHeader reply;
  reply.type = MessageType::kStatusReply;
  reply.size = sizeof(reply);
  HapticSceneLoad load;
  load.number = 1;
  load.bytes = 100;
  HapticScenePlace place;
  place.number = 1;
  HapticNodes nodes;
  nodes.number = nodes.count = 1;
  HapticMaterial material;
  material.number = 1;
  HapticSceneState state;
  state.number = 1;
  HapticSceneTable table;
  table.number = 1;
  return {BytesOf(load),
          BytesOf(place),
          BytesOf(nodes),
          BytesOf(material),
          BytesOf(state),
          BytesOf(table),
          BytesOf(BaseMotion{}),
          BytesOf(HapticSceneEnd{}),
          BytesOf(HapticSceneEnable{}),
          BytesOf(Hello{}),
          BytesOf(welcome),
          BytesOf(Reject{}),
          BytesOf(Session{}),
          BytesOf(Haptic{}),
          BytesOf(HapticStop{}),
          BytesOf(StatusRequest{}),
          BytesOf(Notice{}),
          BytesOf(reply),
          BytesOf(SceneCommand{}),
          BytesOf(SceneReply{}),
          BytesOf(SurfaceRequest{}),
          BytesOf(EmergencyStop{}),
          BytesOf(surfaces),
          BytesOf(AppSettings{}),
          BytesOf(base_pose_request),
          BytesOf(BasePose{}),
          BytesOf(SpaceChange{}),
          BytesOf(BasePoseCommand{}),
          BytesOf(BasePoseReply{}),
          WaveformBytes()};
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
  void operator()(const EmergencyStop& stop) const { EXPECT_LE(stop.on, 1u); }
  void operator()(const SurfaceRequest& request) const { EXPECT_LE(request.wanted, 1u); }
  void operator()(const Surfaces& surfaces) const {
    EXPECT_LE(surfaces.total_bytes, kMaxSurfaceBytes);
    EXPECT_EQ(surfaces.total_bytes == 0, surfaces.memory_generation == 0);
  }
  static void ExpectPose(const WirePose& pose) {
    double norm2 = 0;
    for (const double x : pose.orientation_wxyz) norm2 += x * x;
    EXPECT_NEAR(norm2, 1, 0.0101);
    for (const double x : pose.position_m) EXPECT_LE(std::abs(x), kFarthestBase_m);
  }
  void operator()(const BasePoseRequest& request) const {
    EXPECT_TRUE(request.space_count >= 1 && request.space_count <= kMaxSpaceTypes);
    EXPECT_TRUE(IsTerminated(request.headset.runtime) && IsTerminated(request.headset.system));
  }
  void operator()(const BasePose& base_pose) const {
    ExpectPose(base_pose.base_space);
    EXPECT_TRUE(base_pose.expected_error_m >= 0 && base_pose.rotation_sigma_rad >= 0);
    EXPECT_LE(base_pose.uncalibrated, Uncalibrated::kOff);
  }
  void operator()(const SpaceChange& change) const {
    if (change.pose_valid == 1) ExpectPose(change.new_in_previous);
    EXPECT_LE(change.pose_valid, 1u);
  }
  void operator()(const BasePoseCommand& command) const {
    ExpectPose(command.base_space);
    EXPECT_TRUE(IsTerminated(command.method) && IsTerminated(command.headset.system));
    EXPECT_TRUE(command.rms_m >= 0 && command.expected_error_m >= 0);
  }
  void operator()(const BaseMotion& motion) const {
    ExpectPose(motion.base_space);
    EXPECT_LE(motion.state, BaseState::kStands);
    EXPECT_TRUE(motion.t_ns >= 0 && IsTerminated(motion.headset.runtime) && IsTerminated(motion.headset.system));
    EXPECT_TRUE(IsWithin(motion.linear_velocity_m_s) && IsWithin(motion.angular_velocity_rad_s));
  }
  void operator()(const BasePoseReply& reply) const { EXPECT_TRUE(IsTerminated(reply.text) && reply.done <= 1); }
  void operator()(const ShapedHaptic& haptic) const {
    EXPECT_EQ(size, sizeof(Waveform) + haptic.waveform.count * sizeof(float));
    for (std::size_t i = 0; i < haptic.waveform.count; ++i) EXPECT_LE(std::abs(haptic.sample(i)), 1.0F);
  }
  void operator()(const SceneCommand& command) const {
    EXPECT_TRUE(IsTerminated(command.object));
    EXPECT_TRUE(command.action >= SceneAction::kEdits && command.action <= SceneAction::kRelease);
  }
  void operator()(const SceneAnswer& answer) const {
    EXPECT_EQ(answer.text.size(), size - sizeof(SceneReply));
    EXPECT_TRUE(answer.reply.done == 1 || answer.reply.file_bytes == 0);
  }
  static bool IsWithin(const std::array<double, 3>& v) {
    return std::all_of(v.begin(), v.end(), [](double x) { return std::abs(x) <= 1e3; });
  }
  static void Check(const ScenePose& pose) {
    const auto& q = pose.rotation_wxyz;
    EXPECT_NEAR(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3], 1, 0.02);
    EXPECT_TRUE(IsWithin(pose.position_m) && IsWithin(pose.velocity_m_s) && IsWithin(pose.angular_velocity_rad_s));
  }
  void operator()(const HapticSceneLoad& load) const {
    EXPECT_TRUE(load.number != 0 && load.bytes >= 1 && load.bytes <= kMaxHapticSceneBytes);
    EXPECT_TRUE(load.scale >= kLeastSceneScale && load.scale <= kMostSceneScale);
  }
  void operator()(const HapticScenePlace& place) const { Check(place.pose); }
  void operator()(const HapticNodes& nodes) const {
    ASSERT_TRUE(nodes.count >= 1 && nodes.count <= kMaxHapticNodesMoved);
    for (std::uint32_t i = 0; i < nodes.count; ++i) {
      EXPECT_LT(nodes.nodes[i].object, kMaxHapticNodes);
      Check(nodes.nodes[i].pose);
    }
  }
  void operator()(const HapticMaterial& material) const {
    EXPECT_TRUE(material.parameters.stiffness_N_m >= 0 && material.parameters.stiffness_N_m <= 2000);
    EXPECT_LT(material.material, kMaxHapticMaterials);
  }
  void operator()(const HapticSceneNews& news) const { EXPECT_EQ(news.text.size(), size - sizeof(HapticSceneState)); }
  void operator()(const HapticSceneRows& rows) const {
    EXPECT_EQ(size, sizeof(HapticSceneTable) + rows.table.node_count * sizeof(HapticNodeRow) +
                        rows.table.material_count * sizeof(base::MaterialParameters));
    for (std::uint32_t i = 0; i < rows.table.node_count; ++i) EXPECT_TRUE(IsTerminated(rows.Node(i).name));
  }
  template <class T>
  void operator()(const T&) const {
    EXPECT_EQ(size, sizeof(T));
  }
};

TEST(ValidateFuzz, AcceptedRandomPacketsAreInRange) {
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
  // Both outcomes must be frequent, or this test tests nothing.
  EXPECT_GT(accepted, 10'000u);
  EXPECT_LT(accepted, 90'000u);
}

TEST(ValidateFuzz, PrintableIsIdempotentWithoutControlCharacters) {
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

}  // namespace test_protocol_validate_property
}  // namespace omni::protocol
