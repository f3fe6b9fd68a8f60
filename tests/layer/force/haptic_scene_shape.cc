// XR_OMNIX1_haptic_scene: a scene that follows its space, and its shape as the application reads it.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "service/ipc/surface_publisher.h"
#include "tests/layer/support/scene_scenario.h"

namespace omni::test {
namespace test_haptic_scene_shape {

// In a space at rest it is sent once; in a moving one in every frame, with its velocity.
TEST(HapticScene, PlacementIsResentOnlyInMovingSpace) {
  SceneScenario scenario;
  ASSERT_TRUE(scenario.GetReady());
  const auto frame = [&] {
    scenario.service->Fill();
    XrFrameState state{XR_TYPE_FRAME_STATE};
    EXPECT_EQ(xrWaitFrame(scenario.app->session, nullptr, &state), XR_SUCCESS);
    xrBeginFrame(scenario.app->session, nullptr);
    const XrFrameEndInfo end{XR_TYPE_FRAME_END_INFO,           nullptr, state.predictedDisplayTime,
                             XR_ENVIRONMENT_BLEND_MODE_OPAQUE, 0,       nullptr};
    xrEndFrame(scenario.app->session, &end);
  };
  XrHapticScenePlacementOMNIX1 placement{XR_TYPE_HAPTIC_SCENE_PLACEMENT_OMNIX1,
                                         nullptr,
                                         scenario.app->ReferenceSpace(XR_REFERENCE_SPACE_TYPE_LOCAL),
                                         {{0, 0, 0, 1}, {0.1f, 0.2f, -0.3f}},
                                         1};
  ASSERT_EQ(scenario.f->place(scenario.scene, &placement), XR_SUCCESS);
  ASSERT_TRUE(scenario.Until([&] { return scenario.service->heard().scene_places.size() == 1; }));
  for (int i = 0; i < 20; ++i) frame();
  Pause_ms(50);
  EXPECT_EQ(scenario.service->heard().scene_places.size(), 1u) << "nothing new to send";

  // A head that rises at 0.1 m/s carries the scene with it.
  const float head[7] = {0, 1.6f, 0, 0, 0, 0, 1}, rising[6] = {0, 0.1f, 0, 0, 0, 0};
  ASSERT_EQ(omni_test_set_head(head, rising), 0);
  placement.baseSpace = scenario.app->ReferenceSpace(XR_REFERENCE_SPACE_TYPE_VIEW);
  ASSERT_EQ(scenario.f->place(scenario.scene, &placement), XR_SUCCESS);
  ASSERT_TRUE(scenario.Until([&] {
    frame();
    return scenario.service->heard().scene_places.size() >= 6;
  }));
  const auto places = scenario.service->heard().scene_places;
  for (std::size_t i = 2; i < places.size(); ++i) {
    const protocol::HapticScenePlace &before = places[i - 1], &place = places[i];
    EXPECT_NEAR(place.pose.velocity_m_s[2], 0.1, 1e-4);
    EXPECT_EQ(place.flags, 0u) << "moved, not teleported";
    const double s = 1e-9 * static_cast<double>(place.t_ns - before.t_ns);
    EXPECT_GT(s, 0);
    EXPECT_NEAR(place.pose.position_m[2] - before.pose.position_m[2], 0.1 * s, 1e-5);
  }
  EXPECT_EQ(omni_test_reset(), 0);
}

// One triangle of node 0, in the service's frame (z up) at `scale`.
std::shared_ptr<ipc::SurfacePublisher> OneTriangle(std::uint64_t scene_generation, double scale) {
  static std::uint64_t memories = 0;
  const protocol::SurfacePlan plan{
      .name = "still", .object = 0, .flags = protocol::kSurfaceSoft, .vertex_capacity = 3, .triangle_capacity = 1};
  auto made = ipc::SurfacePublisher::Create(
      {.service_instance = 1, .memory_generation = ++memories, .scene_generation = scene_generation}, {&plan, 1});
  if (!made.ok()) return nullptr;
  const auto s = static_cast<float>(scale);
  const std::array<protocol::SurfacePoint, 3> points{{{0, 0, 0}, {0.1f * s, 0, 0}, {0, -0.2f * s, 0.3f * s}}};
  const std::array<protocol::SurfaceTriangle, 1> triangles{{{0, 1, 2}}};
  ipc::SurfaceUpdate update{.t_ns = Now_ns(), .largest_displacement_m = 0.002 * scale};
  update.vertices_base_m = points;
  update.triangles = triangles;
  EXPECT_EQ((*made)->Publish(0, update), ipc::SurfacePublish::kDone);
  return std::move(*made);
}

class SceneShape : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(scenario.GetReady());
    node = std::uint64_t{scenario.service->heard().scene_loads.back().number} << 32 | 1;
  }
  XrResult Read() {
    const XrHapticNodeMeshGetInfoOMNIX1 info{XR_TYPE_HAPTIC_NODE_MESH_GET_INFO_OMNIX1, nullptr, node};
    mesh = {XR_TYPE_HAPTIC_NODE_MESH_OMNIX1};
    mesh.vertexCapacityInput = 3;
    mesh.vertices = vertices.data();
    mesh.indexCapacityInput = 3;
    mesh.indices = indices.data();
    return scenario.f->mesh(scenario.scene, &info, &mesh);
  }
  void ExpectTheDocuments() const {
    EXPECT_EQ(mesh.vertexCountOutput, 3u);
    EXPECT_EQ(mesh.indexCountOutput, 3u);
    EXPECT_NEAR(vertices[1].x, 0.1f, 1e-7f);
    EXPECT_NEAR(vertices[2].y, 0.3f, 1e-7f) << "up in the document";
    EXPECT_NEAR(vertices[2].z, 0.2f, 1e-7f);
    EXPECT_NEAR(mesh.maxDisplacement, 0.002f, 1e-7f);
  }

  SceneScenario scenario;
  XrHapticNodeIdOMNIX1 node = XR_NULL_HAPTIC_NODE_ID_OMNIX1;
  XrHapticNodeMeshOMNIX1 mesh{XR_TYPE_HAPTIC_NODE_MESH_OMNIX1};
  std::vector<XrVector3f> vertices = std::vector<XrVector3f>(3);
  std::vector<std::uint32_t> indices = std::vector<std::uint32_t>(3);
};

TEST_F(SceneShape, MeshComesOnlyFromTheActiveScene) {
  EXPECT_EQ(Read(), XR_ERROR_HAPTIC_SCENE_NOT_READY_OMNIX1);
  scenario.service->SetSurfaces(OneTriangle(8, 1));  // of the scene before
  for (int i = 0; i < 20; ++i) {
    Pause_ms(10);
    ASSERT_EQ(Read(), XR_ERROR_HAPTIC_SCENE_NOT_READY_OMNIX1);
  }
  scenario.service->SetSurfaces(OneTriangle(9, 1));
  EXPECT_TRUE(scenario.Until([&] { return Read() == XR_SUCCESS; }));
  ExpectTheDocuments();
  node += 1;
  EXPECT_EQ(Read(), XR_ERROR_HAPTIC_NODE_INVALID_OMNIX1) << "its shape does not change";
}

// [Results] "a capacity is neither 0 nor enough; nothing was written but the counts"
TEST_F(SceneShape, InsufficientCapacityWritesOnlyCounts) {
  scenario.service->SetSurfaces(OneTriangle(9, 1));
  ASSERT_TRUE(scenario.Until([&] { return Read() == XR_SUCCESS; }));
  const XrHapticNodeMeshGetInfoOMNIX1 info{XR_TYPE_HAPTIC_NODE_MESH_GET_INFO_OMNIX1, nullptr, node};
  for (const bool vertices_fit : {false, true}) {
    vertices.assign(3, {7, 7, 7});
    mesh = {XR_TYPE_HAPTIC_NODE_MESH_OMNIX1};
    mesh.maxDisplacement = 7;
    mesh.vertexCapacityInput = vertices_fit ? 3 : 2;
    mesh.vertices = vertices.data();
    mesh.indexCapacityInput = vertices_fit ? 2 : 0;
    mesh.indices = indices.data();
    EXPECT_EQ(scenario.f->mesh(scenario.scene, &info, &mesh), XR_ERROR_SIZE_INSUFFICIENT);
    EXPECT_EQ(mesh.vertexCountOutput, 3u);
    EXPECT_EQ(mesh.indexCountOutput, 3u);
    EXPECT_EQ(mesh.maxDisplacement, 7);
    EXPECT_EQ(vertices[0].x, 7);
  }
  mesh.indexCapacityInput = 0;
  EXPECT_EQ(scenario.f->mesh(scenario.scene, &info, &mesh), XR_SUCCESS) << "the vertices alone";
  EXPECT_EQ(vertices[0].x, 0);
}

// Until a scene of another scale is ready, the previous one is rendered and read.
TEST_F(SceneShape, VerticesAreInDocumentMetresAtEveryScale) {
  scenario.service->SetSurfaces(OneTriangle(9, 1));
  ASSERT_TRUE(scenario.Until([&] { return Read() == XR_SUCCESS; }));
  const XrHapticScenePlacementOMNIX1 larger{XR_TYPE_HAPTIC_SCENE_PLACEMENT_OMNIX1,
                                            nullptr,
                                            scenario.app->ReferenceSpace(XR_REFERENCE_SPACE_TYPE_LOCAL),
                                            {{0, 0, 0, 1}, {0, 0, 0}},
                                            4};
  ASSERT_EQ(scenario.f->place(scenario.scene, &larger), XR_SUCCESS);
  ASSERT_EQ(scenario.State().status, XR_HAPTIC_SCENE_STATUS_LOADING_OMNIX1);
  ASSERT_EQ(Read(), XR_SUCCESS);
  ExpectTheDocuments();
  const std::uint32_t number = scenario.service->heard().scene_loads.back().number;
  scenario.SayState(number, protocol::HapticSceneStatus::kReady, 10, "", 4);
  scenario.service->SetSurfaces(OneTriangle(10, 4));
  ASSERT_TRUE(scenario.Until([&] { return scenario.State().status == XR_HAPTIC_SCENE_STATUS_READY_OMNIX1; }));
  ASSERT_TRUE(scenario.Until([&] { return Read() == XR_SUCCESS; }));
  ExpectTheDocuments();
}

}  // namespace test_haptic_scene_shape
}  // namespace omni::test
