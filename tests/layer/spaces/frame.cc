// xrEndFrame: layers in spaces of the pen.
#include <array>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>

#include "tests/layer/spaces/fixture.h"

namespace omni::test {
namespace test_spaces_frame {

using layer::Pose;

const XrCompositionLayerBaseHeader* Header(const void* layer) {
  return static_cast<const XrCompositionLayerBaseHeader*>(layer);
}

Pose Recorded(const float pose[7]) {
  return {{pose[0], pose[1], pose[2]}, glm::dquat(pose[6], pose[3], pose[4], pose[5])};
}

XrPosef SomePose(float angle) {
  return {{0, std::sin(angle / 2), 0, std::cos(angle / 2)}, {0.1f, 0.2f * angle, -0.3f}};
}

class SpacesFrame : public SpacesTest {
 protected:
  void SetUp() override {
    SpacesTest::SetUp();
    AppOptions options;
    options.extensions = {
        XR_KHR_COMPOSITION_LAYER_CUBE_EXTENSION_NAME, XR_KHR_COMPOSITION_LAYER_CYLINDER_EXTENSION_NAME,
        XR_KHR_COMPOSITION_LAYER_EQUIRECT_EXTENSION_NAME, XR_KHR_COMPOSITION_LAYER_EQUIRECT2_EXTENSION_NAME};
    app = std::make_unique<App>(options);
    Start(*app);
    service.Fill();
    shown_ns = Now_ns() - 20'000'000;  // in the past, where the path is known exactly
  }

  // Shows one frame; the runtime's record of it is in `frame`.
  XrResult Show(const std::vector<const XrCompositionLayerBaseHeader*>& layers,
                XrEnvironmentBlendMode mode = XR_ENVIRONMENT_BLEND_MODE_OPAQUE) {
    XrFrameState state{XR_TYPE_FRAME_STATE};
    EXPECT_EQ(xrWaitFrame(app->session, nullptr, &state), XR_SUCCESS);
    EXPECT_GE(xrBeginFrame(app->session, nullptr), XR_SUCCESS);
    info = {XR_TYPE_FRAME_END_INFO,
            nullptr,
            ToXrTime(shown_ns),
            mode,
            static_cast<std::uint32_t>(layers.size()),
            layers.empty() ? nullptr : layers.data()};
    service.Fill();
    const XrResult result = xrEndFrame(app->session, &info);
    EXPECT_EQ(omni_test_frame(&frame), 0);
    return result;
  }

  // Where a pose in the pen's space is in the space that was passed to the runtime.
  void ExpectMoved(const float recorded[7], const XrPosef& pose, std::uint64_t space) {
    const Pose truth = layer::Compose(InLocal(Lissajous(1e-9 * static_cast<double>(shown_ns))).X, layer::FromXr(pose));
    const Seen anchor = Locate(reinterpret_cast<XrSpace>(space), local, shown_ns);
    ASSERT_EQ(anchor.result, XR_SUCCESS) << "a space of this session that the runtime knows";
    const Pose seen = layer::Compose(layer::FromXr(anchor.location.pose), Recorded(recorded));
    EXPECT_LT(glm::length(seen.p - truth.p), 1e-5);
    EXPECT_LT(Angle(seen.q, truth.q), 1e-3);
  }

  std::unique_ptr<App> app;
  std::int64_t shown_ns = 0;
  XrFrameEndInfo info{};
  OmniTestFrame frame{};
};

// [xrEndFrame] a quad in the pen's space is drawn where the pen is at displayTime; its chain is kept.
TEST_F(SpacesFrame, QuadFollowsThePen) {
  XrCompositionLayerColorScaleBiasKHR chained{XR_TYPE_COMPOSITION_LAYER_COLOR_SCALE_BIAS_KHR};
  XrCompositionLayerQuad quad{XR_TYPE_COMPOSITION_LAYER_QUAD, &chained, 0, pen};
  quad.pose = SomePose(0.4f);
  quad.size = {0.1f, 0.2f};
  const XrCompositionLayerQuad before = quad;
  ASSERT_EQ(Show({Header(&quad)}), XR_SUCCESS);
  ASSERT_EQ(frame.layer_count, 1u);
  EXPECT_NE(frame.layers[0].space, reinterpret_cast<std::uint64_t>(pen));
  EXPECT_EQ(frame.layers[0].next, &chained);
  ExpectMoved(frame.layers[0].pose, quad.pose, frame.layers[0].space);
  EXPECT_EQ(std::memcmp(&quad, &before, sizeof(quad)), 0) << "the application's own structure";
}

TEST_F(SpacesFrame, ProjectionLayerViewsFollowThePen) {
  XrCompositionLayerDepthInfoKHR depth{XR_TYPE_COMPOSITION_LAYER_DEPTH_INFO_KHR};
  std::array<XrCompositionLayerProjectionView, 2> views{
      XrCompositionLayerProjectionView{XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW, &depth, SomePose(0.1f)},
      XrCompositionLayerProjectionView{XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW, nullptr, SomePose(-0.3f)}};
  const XrCompositionLayerProjection projection{XR_TYPE_COMPOSITION_LAYER_PROJECTION, nullptr, 0, pen, 2, views.data()};
  ASSERT_EQ(Show({Header(&projection)}), XR_SUCCESS);
  ASSERT_EQ(frame.layers[0].views, 2u);
  EXPECT_EQ(frame.layers[0].view_next[0], &depth);
  for (std::size_t i = 0; i < 2; ++i) ExpectMoved(frame.layers[0].view_pose[i], views[i].pose, frame.layers[0].space);
}

TEST_F(SpacesFrame, CylinderEquirectAndCubeLayersFollowThePen) {
  XrCompositionLayerCylinderKHR cylinder{XR_TYPE_COMPOSITION_LAYER_CYLINDER_KHR, nullptr, 0, pen};
  XrCompositionLayerEquirectKHR equirect{XR_TYPE_COMPOSITION_LAYER_EQUIRECT_KHR, nullptr, 0, pen};
  XrCompositionLayerEquirect2KHR equirect2{XR_TYPE_COMPOSITION_LAYER_EQUIRECT2_KHR, nullptr, 0, pen};
  XrCompositionLayerCubeKHR cube{XR_TYPE_COMPOSITION_LAYER_CUBE_KHR, nullptr, 0, pen};
  cylinder.pose = SomePose(0.2f);
  equirect.pose = SomePose(0.5f);
  equirect2.pose = SomePose(-0.6f);
  cube.orientation = SomePose(0.9f).orientation;
  ASSERT_EQ(Show({Header(&cylinder), Header(&equirect), Header(&equirect2), Header(&cube)}), XR_SUCCESS);
  ASSERT_EQ(frame.layer_count, 4u);
  ExpectMoved(frame.layers[0].pose, cylinder.pose, frame.layers[0].space);
  ExpectMoved(frame.layers[1].pose, equirect.pose, frame.layers[1].space);
  ExpectMoved(frame.layers[2].pose, equirect2.pose, frame.layers[2].space);
  const glm::dquat truth = InLocal(Lissajous(1e-9 * static_cast<double>(shown_ns))).X.q *
                           layer::FromXr(XrPosef{cube.orientation, {0, 0, 0}}).q;
  EXPECT_LT(Angle(Recorded(frame.layers[3].pose).q, truth), 1e-3);
}

// A layer whose space cannot be located is not shown; the others are, in order.
TEST_F(SpacesFrame, UnlocatableLayerIsDropped) {
  XrCompositionLayerQuad mine{XR_TYPE_COMPOSITION_LAYER_QUAD, nullptr, 0, pen};
  XrCompositionLayerQuad other{XR_TYPE_COMPOSITION_LAYER_QUAD, nullptr, 0, local};
  mine.pose = other.pose = SomePose(0);
  ASSERT_EQ(app->SyncSets({{app->set, app->left}}), XR_SUCCESS);
  ASSERT_EQ(Show({Header(&mine), Header(&other)}), XR_SUCCESS);
  ASSERT_EQ(frame.layer_count, 1u);
  EXPECT_EQ(frame.layers[0].structure, &other);
  ASSERT_EQ(Show({Header(&mine)}), XR_SUCCESS);
  EXPECT_EQ(frame.layer_count, 0u);
  ASSERT_EQ(app->Sync(), XR_SUCCESS);
  service.SetFlags(0);
  service.Fill();
  shown_ns = Now_ns() + 10'000'000;
  ASSERT_EQ(Show({Header(&mine), Header(&other)}), XR_SUCCESS);
  EXPECT_EQ(frame.layer_count, 1u) << "the pen is not seen any more";
}

// Pass-through: if no layer is in a space of the pen, the application's own structures arrive, in any blend mode.
TEST_F(SpacesFrame, LayersOutsidePenSpacesPassThroughUnchanged) {
  XrCompositionLayerQuad quad{XR_TYPE_COMPOSITION_LAYER_QUAD, nullptr, 0, local};
  quad.pose = SomePose(0.2f);
  for (const auto mode : {XR_ENVIRONMENT_BLEND_MODE_OPAQUE, XR_ENVIRONMENT_BLEND_MODE_ALPHA_BLEND}) {
    ASSERT_EQ(Show({Header(&quad)}, mode), XR_SUCCESS);
    EXPECT_EQ(frame.info, &info);
    EXPECT_EQ(frame.layers[0].structure, &quad);
    EXPECT_EQ(frame.blend_mode, mode);
  }
  ASSERT_EQ(Show({}), XR_SUCCESS);
  EXPECT_EQ(frame.info, &info);
}

// A layer type that we do not know is passed unchanged, for the runtime to check.
TEST_F(SpacesFrame, UnknownLayerTypePassesThroughUnchanged) {
  XrCompositionLayerPassthroughFB unknown{XR_TYPE_COMPOSITION_LAYER_PASSTHROUGH_FB, nullptr, 0, pen, XR_NULL_HANDLE};
  XrCompositionLayerQuad quad{XR_TYPE_COMPOSITION_LAYER_QUAD, nullptr, 0, pen};
  quad.pose = SomePose(0);
  EXPECT_EQ(Show({Header(&quad), Header(&unknown)}), XR_ERROR_LAYER_INVALID);
  ASSERT_EQ(frame.layer_count, 2u);
  EXPECT_EQ(frame.layers[1].structure, &unknown);
  EXPECT_NE(frame.layers[0].structure, &quad);
}

// Errors are the runtime's, also in a layer of ours.
TEST_F(SpacesFrame, InvalidLayersReturnTheRuntimesErrors) {
  XrCompositionLayerQuad quad{XR_TYPE_COMPOSITION_LAYER_QUAD, nullptr, 0, pen};
  EXPECT_EQ(Show({Header(&quad)}), XR_ERROR_POSE_INVALID) << "no orientation";
  quad.pose = SomePose(0);
  EXPECT_EQ(Show({Header(&quad), nullptr}), XR_ERROR_LAYER_INVALID);
  XrCompositionLayerQuad lost{XR_TYPE_COMPOSITION_LAYER_QUAD, nullptr, 0, XR_NULL_HANDLE};
  lost.pose = SomePose(0);
  EXPECT_EQ(Show({Header(&quad), Header(&lost)}), XR_ERROR_HANDLE_INVALID);
  XrCompositionLayerProjection projection{XR_TYPE_COMPOSITION_LAYER_PROJECTION, nullptr, 0, pen, 2, nullptr};
  EXPECT_EQ(Show({Header(&projection)}), XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(xrEndFrame(app->session, nullptr), XR_ERROR_VALIDATION_FAILURE);
  info.displayTime = 0;
  info.layerCount = 0;
  EXPECT_EQ(xrEndFrame(app->session, &info), XR_ERROR_TIME_INVALID);
}

}  // namespace test_spaces_frame
}  // namespace omni::test
