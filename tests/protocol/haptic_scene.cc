// Messages about an application's own scene: what is accepted, and what is not.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <string>

#include "service/protocol/haptic_scene.h"
#include "service/protocol/messages.h"
#include "service/protocol/text.h"

namespace omni::protocol {
namespace test_protocol_haptic_scene {

template <class T>
std::string ReasonOf(const T& message) {
  const Message taken = Validate(&message, sizeof(message));
  const auto* invalid = std::get_if<Invalid>(&taken);
  return invalid == nullptr ? std::string() : invalid->reason;
}

template <class T>
T Numbered() {
  T message;
  message.number = 3;
  return message;
}

HapticSceneLoad Sound() {
  HapticSceneLoad load = Numbered<HapticSceneLoad>();
  load.bytes = 1000;
  return load;
}

TEST(HapticSceneMessages, AcceptsValidMessages) {
  EXPECT_EQ(ReasonOf(Sound()), "");
  EXPECT_EQ(ReasonOf(Numbered<HapticSceneEnd>()), "");
  EXPECT_EQ(ReasonOf(Numbered<HapticScenePlace>()), "");
  EXPECT_EQ(ReasonOf(Numbered<HapticSceneEnable>()), "");
  HapticNodes nodes = Numbered<HapticNodes>();
  nodes.count = kMaxHapticNodesMoved;
  EXPECT_EQ(ReasonOf(nodes), "");
  HapticMaterial material = Numbered<HapticMaterial>();
  material.parameters = {};
  EXPECT_EQ(ReasonOf(material), "");
  EXPECT_EQ(ReasonOf(Numbered<HapticSceneState>()), "");
  EXPECT_EQ(ReasonOf(Numbered<HapticSceneTable>()), "");
}

TEST(HapticSceneMessages, RejectsFieldsOutOfRange) {
  const double nan = std::nan(""), infinity = std::numeric_limits<double>::infinity();
  const auto load = [](auto change) {
    HapticSceneLoad message = Sound();
    change(message);
    return ReasonOf(message);
  };
  EXPECT_NE(load([](auto& m) { m.number = 0; }).find("number"), std::string::npos);
  EXPECT_NE(load([](auto& m) { m.flags = 4; }).find("flags"), std::string::npos);
  EXPECT_NE(load([](auto& m) { m.bytes = 0; }).find("bytes"), std::string::npos);
  EXPECT_NE(load([](auto& m) { m.bytes = kMaxHapticSceneBytes + 1; }).find("bytes"), std::string::npos);
  for (const double scale : {0.0, -1.0, 1e5, nan, infinity}) {
    EXPECT_NE(load([&](auto& m) { m.scale = scale; }).find("scale"), std::string::npos) << scale;
  }
  const auto place = [](auto change) {
    HapticScenePlace message = Numbered<HapticScenePlace>();
    change(message);
    return ReasonOf(message);
  };
  EXPECT_NE(place([](auto& m) { m.t_ns = -1; }).find("t_ns"), std::string::npos);
  EXPECT_NE(place([](auto& m) { m.flags = 2; }).find("flags"), std::string::npos);
  EXPECT_NE(place([](auto& m) { m.pose.rotation_wxyz = {}; }).find("unit"), std::string::npos);
  EXPECT_NE(place([&](auto& m) { m.pose.rotation_wxyz[2] = nan; }).find("unit"), std::string::npos);
  EXPECT_NE(place([&](auto& m) { m.pose.position_m[1] = nan; }).find("position"), std::string::npos);
  EXPECT_NE(place([&](auto& m) { m.pose.velocity_m_s[0] = infinity; }).find("velocity"), std::string::npos);
  EXPECT_NE(place([&](auto& m) { m.pose.angular_velocity_rad_s[2] = -1e4; }).find("velocity"), std::string::npos);
  HapticNodes nodes = Numbered<HapticNodes>();
  EXPECT_NE(ReasonOf(nodes).find("count"), std::string::npos);
  nodes.count = kMaxHapticNodesMoved + 1;
  EXPECT_NE(ReasonOf(nodes).find("count"), std::string::npos);
  nodes.count = 2;
  nodes.nodes[1].object = kMaxHapticNodes;
  EXPECT_NE(ReasonOf(nodes).find("64"), std::string::npos);
  nodes.nodes[1].object = 5;
  nodes.nodes[1].pose.position_m[0] = nan;
  EXPECT_NE(ReasonOf(nodes).find("position"), std::string::npos);
  nodes.count = 1;
  EXPECT_EQ(ReasonOf(nodes), "") << "nodes behind the count are ignored";
  HapticMaterial material = Numbered<HapticMaterial>();
  material.parameters = {};
  material.parameters.stiffness_N_m = 2001;
  EXPECT_NE(ReasonOf(material).find("stiffness is not in 0..2000"), std::string::npos);
  material.parameters = {};
  material.material = kMaxHapticMaterials;
  EXPECT_NE(ReasonOf(material).find("256"), std::string::npos);
}

// A table of `nodes` rows and `materials` parameters as its bytes.
std::string TableBytes(std::uint32_t nodes, std::uint32_t materials) {
  HapticSceneTable table = Numbered<HapticSceneTable>();
  table.node_count = nodes;
  table.material_count = materials;
  std::string bytes(sizeof(table), '\0');
  for (std::uint32_t i = 0; i < nodes; ++i) {
    HapticNodeRow row;
    row.gltf_node = static_cast<std::int32_t>(7 * i);
    SetField(row.name, "node " + std::to_string(i));
    bytes.append(reinterpret_cast<const char*>(&row), sizeof(row));
  }
  for (std::uint32_t i = 0; i < materials; ++i) {
    base::MaterialParameters parameters;
    parameters.stiffness_N_m = 5.0 * i;
    bytes.append(reinterpret_cast<const char*>(&parameters), sizeof(parameters));
  }
  table.header.size = static_cast<std::uint32_t>(bytes.size());
  std::memcpy(bytes.data(), &table, sizeof(table));
  return bytes;
}

TEST(HapticSceneMessages, TableIsDecodedRowByRow) {
  for (const auto& [nodes, materials] :
       {std::pair{0U, 0U}, {1U, 0U}, {3U, 5U}, {kMaxHapticNodes, kMaxHapticMaterials}}) {
    const std::string bytes = TableBytes(nodes, materials);
    const Message taken = Validate(bytes.data(), bytes.size());
    const auto* rows = std::get_if<HapticSceneRows>(&taken);
    ASSERT_NE(rows, nullptr) << nodes << " " << materials;
    for (std::uint32_t i = 0; i < nodes; ++i) {
      EXPECT_EQ(rows->Node(i).gltf_node, static_cast<std::int32_t>(7 * i));
      EXPECT_EQ(std::string(rows->Node(i).name), "node " + std::to_string(i));
    }
    for (std::uint32_t i = 0; i < materials; ++i) EXPECT_EQ(rows->Material(i).stiffness_N_m, 5.0 * i);
  }
}

TEST(HapticSceneMessages, RejectsTablesOfTheWrongSize) {
  std::string bytes = TableBytes(3, 2);
  for (const std::size_t cut : {std::size_t{1}, sizeof(base::MaterialParameters), sizeof(HapticNodeRow)}) {
    std::string other = bytes.substr(0, bytes.size() - cut);
    const auto size = static_cast<std::uint32_t>(other.size());
    std::memcpy(other.data() + offsetof(MessageHeader, size), &size, sizeof(size));
    const Message taken = Validate(other.data(), other.size());
    EXPECT_TRUE(std::holds_alternative<Invalid>(taken)) << cut;
  }
  std::memset(bytes.data() + sizeof(HapticSceneTable) + offsetof(HapticNodeRow, name), 'x', 48);
  const Message taken = Validate(bytes.data(), bytes.size());
  const auto* invalid = std::get_if<Invalid>(&taken);
  ASSERT_NE(invalid, nullptr);
  EXPECT_NE(std::string(invalid->reason).find("node 0: name"), std::string::npos) << invalid->reason;
}

TEST(HapticSceneMessages, StateHoldsItsText) {
  HapticSceneState state = Numbered<HapticSceneState>();
  const std::string text = "/meshes/0: is broken\nline two";
  state.header.size = static_cast<std::uint32_t>(sizeof(state) + text.size());
  std::string bytes(reinterpret_cast<const char*>(&state), sizeof(state));
  bytes += text;
  const Message taken = Validate(bytes.data(), bytes.size());
  const auto* news = std::get_if<HapticSceneNews>(&taken);
  ASSERT_NE(news, nullptr);
  EXPECT_EQ(news->text, text);
  state = Numbered<HapticSceneState>();
  for (const double scale : {0.0, -1.0, 2e4, std::nan("")}) {
    state.scale = scale;
    EXPECT_NE(ReasonOf(state), "") << scale;
  }
}

}  // namespace test_protocol_haptic_scene
}  // namespace omni::protocol
