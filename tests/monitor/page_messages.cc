// Layout of the binary messages: docs/protocol/page.md.
#include "service/monitor/page/page_messages.h"

#include <gtest/gtest.h>

#include <cstring>
#include <set>
#include <string>

#include <nlohmann/json.hpp>

#include "service/base/files/json_document.h"
#include "service/config/files/device_file.h"
#include "service/monitor/page/channels.h"
#include "service/monitor/page/page_text.h"

namespace omni::monitor {
namespace test_monitor_page_messages {

template <class T>
T At(const std::string& message, std::size_t offset) {
  T value{};
  EXPECT_LE(offset + sizeof(T), message.size());
  std::memcpy(&value, message.data() + offset, sizeof(T));
  return value;
}

TEST(Channels, NamesAreUniqueAndEndWithTheirUnit) {
  std::set<std::string> names;
  for (const Channel& channel : Channels()) {
    EXPECT_TRUE(names.insert(channel.name).second) << channel.name;
    EXPECT_GT(std::strlen(channel.label), 0U);
    EXPECT_GT(std::strlen(channel.group), 0U);
  }
}

// Variances along the axis and across become the covariance of the same ellipsoid, however the pen is turned.
TEST(Channels, CovarianceHasTheVarianceAlongTheAxis) {
  const auto value = [](const char* name, const protocol::ToolSample& sample, const protocol::TelemetrySample& t) {
    for (const Channel& channel : Channels()) {
      if (std::string(channel.name) == name) return static_cast<double>(channel.value(sample, t));
    }
    ADD_FAILURE() << name;
    return 0.0;
  };
  protocol::TelemetrySample telemetry;
  telemetry.tip_variance_m2 = {4e-8F, 1e-8F};
  for (int i = 0; i < 8; ++i) {
    protocol::ToolSample sample;
    const double angle = 0.3 * i;
    sample.orientation_base_wxyz = {std::cos(angle / 2), std::sin(angle / 2), 0, 0};  // about x
    const double u[3] = {0, std::sin(angle), -std::cos(angle)};                       // -z turned about x
    const double yy = value("cov_yy_m2", sample, telemetry), yz = value("cov_yz_m2", sample, telemetry),
                 zz = value("cov_zz_m2", sample, telemetry), xx = value("cov_xx_m2", sample, telemetry);
    EXPECT_NEAR(u[1] * u[1] * yy + 2 * u[1] * u[2] * yz + u[2] * u[2] * zz, 1e-8, 1e-14);
    EXPECT_NEAR(xx, 4e-8, 1e-14);
    EXPECT_NEAR(xx + yy + zz, 9e-8, 1e-13);
  }
}

TEST(PageMessages, LiveIsLaidOutAsDocumented) {
  LiveFrame frame;
  frame.lost = 3;
  frame.newest.t_ns = 2'500'000'000;
  frame.newest.flags = 5;
  frame.contacts.count = 1;
  frame.contacts.contacts[0].object = 7;
  frame.contacts.contacts[0].penetration_m = 0.5;
  frame.vehicle.on = 1;
  frame.vehicle.laps = 9;
  frame.vehicle.best_lap_s = 4;
  frame.inputs.components[8].release_count = 6;
  frame.aim.tip_base_m = {0, 0, 0.25};
  frame.times_s = {1.5, 2.5};
  frame.rows.assign(2 * Channels().size(), 0.125F);
  const std::string message = LiveMessage(frame);
  EXPECT_EQ(At<std::uint32_t>(message, 0), 0x47504D4FU);
  EXPECT_EQ(At<std::uint16_t>(message, 4), 1);
  EXPECT_EQ(At<std::uint16_t>(message, 6), kPageVersion);
  EXPECT_EQ(At<std::uint32_t>(message, 8), 2U);
  EXPECT_EQ(At<std::uint32_t>(message, 12), Channels().size());
  EXPECT_EQ(At<std::uint32_t>(message, 16), 5U);
  EXPECT_EQ(At<std::uint32_t>(message, 20), 3U);
  EXPECT_EQ(At<double>(message, 24), 2.5);
  EXPECT_EQ(At<std::uint32_t>(message, 32), 1U);
  EXPECT_EQ(At<std::uint32_t>(message, 36), 1U);
  EXPECT_EQ(At<std::uint32_t>(message, 40), 7U);
  EXPECT_EQ(At<float>(message, 40 + 64), 0.5F);
  EXPECT_EQ(At<std::uint32_t>(message, 312 + 4), 9U);
  EXPECT_EQ(At<float>(message, 356 - 4), 4.0F);
  EXPECT_EQ(At<std::uint32_t>(message, 464 - 4), 6U);
  EXPECT_EQ(At<std::uint32_t>(message, 464), 1U);
  EXPECT_EQ(At<float>(message, 476), 0.25F);
  EXPECT_EQ(At<double>(message, 496), 1.5);
  EXPECT_EQ(At<float>(message, 512), 0.125F);
  EXPECT_EQ(message.size(), 512 + 2 * 4 * Channels().size());
}

TEST(PageMessages, ShapeAndSurfaceAreLaidOutAsDocumented) {
  DrawnShape shape;
  shape.positions = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}};
  shape.normals.assign(3, {0, 0, 1});
  shape.triangles = {{0, 1, 2}};
  EXPECT_EQ(ShapeMessage(1, 2, shape).size(), 44U + 36 + 36 + 12);
  shape.colours.assign(3, {255, 0, 0, 255});
  const std::string message = ShapeMessage(1, 2, shape);
  EXPECT_EQ(message.size(), 44U + 36 + 36 + 12 + 12);
  EXPECT_EQ(At<std::uint32_t>(message, 24), 1U);
  EXPECT_EQ(At<float>(message, 44 + 4), 2.0F);

  protocol::SurfaceFrame frame;
  frame.largest_displacement_m = 0.002;
  const protocol::SurfacePoint points[] = {{1, 2, 3}};
  const std::string surface = SurfaceMessage(1, 5, frame, points, {});
  EXPECT_EQ(surface.size(), 56U + 12);
  EXPECT_EQ(At<std::uint32_t>(surface, 12), 5U);
  EXPECT_EQ(At<float>(surface, 24), 1.0F);
  EXPECT_EQ(At<float>(surface, 52), 0.002F);
  EXPECT_EQ(At<float>(surface, 56 + 8), 3.0F);
}

// Names come from files of strangers: no text of theirs breaks a message.
TEST(PageText, ForeignNamesStayText) {
  auto view = std::make_shared<SceneView>();
  view->parts.push_back({.name = "a\xff\"}<script>", .object = -1});
  const std::string text =
      SceneText({.number = 1, .name = "\xc3\x28.glb", .state = SceneState::kReady, .text = "\x01", .view = view}, true);
  const nlohmann::json message = nlohmann::json::parse(text);
  EXPECT_EQ(message["state"], "ready");
  EXPECT_EQ(message["parts"].size(), 1U);
}

TEST(PageText, StatusIsPassedOnOnlyIfItIsJson) {
  EXPECT_EQ(nlohmann::json::parse(StatusText(true, "", base::ParseJsonOrNull(R"({"a":1})"), 3))["status"]["a"], 1);
  EXPECT_TRUE(nlohmann::json::parse(StatusText(true, "", base::ParseJsonOrNull("{\"a\":"), -1))["status"].is_null());
}

TEST(PageText, StrokesAreThoseOfAllObjects) {
  EXPECT_EQ(StrokesOf(R"({"objects":[{"strokes":2},{"strokes":3},{}]})"), 5);
  EXPECT_EQ(StrokesOf(R"({"objects":[]})"), 0);
  for (const char* other : {"", "[]", "{}", R"({"objects":7})", R"({"objects":[{"strokes":-1}]})"}) {
    EXPECT_EQ(StrokesOf(other), -1) << other;
  }
}

TEST(PageText, HelloListsWhatThePageNeeds) {
  const nlohmann::json hello =
      nlohmann::json::parse(HelloText({.version = "1", .control = true, .device = config::DefaultDevice()}));
  EXPECT_EQ(hello["channels"].size(), Channels().size());
  EXPECT_EQ(hello["base"]["coils"].size(), 3U);
  EXPECT_EQ(hello["base"]["sensors"].size(), 8U);
  EXPECT_EQ(hello["material_fields"].size(), base::kLiveMaterialFields);
  EXPECT_GT(hello["device_faults"].size(), 10U);
}

}  // namespace test_monitor_page_messages
}  // namespace omni::monitor
