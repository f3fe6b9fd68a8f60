// What xrEndFrame says of the images of its layers.

#include <functional>
#include <limits>

#include "tests/runtime/cases/graphics/vulkan_fixture.h"

namespace omni::runtime {
namespace {

class ImageLayers : public VulkanTest {
 protected:
  void SetUp() override {
    VulkanTest::SetUp();
    if (session_ == XR_NULL_HANDLE) return;
    color_ = AddSwapchain(ColorInfo());
    XrSwapchainCreateInfo depth = ColorInfo();
    depth.format = VK_FORMAT_D32_SFLOAT;
    depth.usageFlags = XR_SWAPCHAIN_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT;
    depth_ = AddSwapchain(depth);
    XrSwapchainCreateInfo cube = ColorInfo();
    cube.faceCount = 6;
    cube.width = cube.height;
    cube_ = AddSwapchain(cube);
    for (const XrSwapchain swapchain : {color_, depth_, cube_}) Show(swapchain);
    space_ = ReferenceSpace(XR_REFERENCE_SPACE_TYPE_LOCAL);
    RunToFocus();
  }

  XrSwapchainSubImage Part(XrSwapchain swapchain) const { return {swapchain, {{0, 0}, {64, 48}}, 0}; }

  struct Projection {
    XrCompositionLayerDepthInfoKHR depths[2];
    XrCompositionLayerProjectionView views[2];
    XrCompositionLayerProjection layer;
  };
  XrResult End(const std::function<void(Projection&)>& change) {
    Projection all{};
    for (int eye = 0; eye < 2; ++eye) {
      all.depths[eye] = {XR_TYPE_COMPOSITION_LAYER_DEPTH_INFO_KHR, nullptr, Part(depth_), 0, 1, 0.1F, 100};
      all.views[eye] = {
          XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW, &all.depths[eye], kHere, {-1, 1, 1, -1}, Part(color_)};
    }
    all.layer = {XR_TYPE_COMPOSITION_LAYER_PROJECTION, nullptr, 0, space_, 2, all.views};
    change(all);
    return EndFrame(BeginFrame(), {&all.layer});
  }
  XrResult EndQuad(const std::function<void(XrCompositionLayerQuad&)>& change) {
    XrCompositionLayerQuad quad{XR_TYPE_COMPOSITION_LAYER_QUAD, nullptr,      0,     space_,
                                XR_EYE_VISIBILITY_BOTH,         Part(color_), kHere, {1, 1}};
    change(quad);
    return EndFrame(BeginFrame(), {&quad});
  }

  XrSwapchain color_ = XR_NULL_HANDLE;
  XrSwapchain depth_ = XR_NULL_HANDLE;
  XrSwapchain cube_ = XR_NULL_HANDLE;
  XrSpace space_ = XR_NULL_HANDLE;
};

TEST_F(ImageLayers, FramesAreRenderedOnlyWhileVisible) {
  auto frame = Make<XrFrameState>(XR_TYPE_FRAME_STATE);
  ASSERT_EQ(xrWaitFrame(session_, nullptr, &frame), XR_SUCCESS);
  EXPECT_EQ(frame.shouldRender, XR_TRUE);
  ASSERT_EQ(xrBeginFrame(session_, nullptr), XR_SUCCESS);
  ASSERT_EQ(EndFrame(frame.predictedDisplayTime, {}), XR_SUCCESS);
  ASSERT_EQ(xrRequestExitSession(session_), XR_SUCCESS);
  PollStates();
  ASSERT_EQ(xrWaitFrame(session_, nullptr, &frame), XR_SUCCESS);
  EXPECT_EQ(frame.shouldRender, XR_FALSE);
}

TEST_F(ImageLayers, SessionIsSynchronizedByItsFirstFrame) {
  ASSERT_EQ(xrDestroySession(session_), XR_SUCCESS);
  ASSERT_EQ(CreateSession(&binding_, &session_), XR_SUCCESS);
  PollStates();
  auto info = Make<XrSessionBeginInfo>(XR_TYPE_SESSION_BEGIN_INFO);
  info.primaryViewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
  ASSERT_EQ(xrBeginSession(session_, &info), XR_SUCCESS);
  EXPECT_TRUE(PollStates().empty());
  ASSERT_EQ(EndFrame(BeginFrame(), {}), XR_SUCCESS);
  EXPECT_EQ(PollStates().size(), 3U);
}

TEST_F(ImageLayers, PartsOfImagesMustLieWithinThem) {
  struct Case {
    XrResult result;
    std::function<void(XrSwapchainSubImage&)> change;
  };
  constexpr int32_t kMost = std::numeric_limits<int32_t>::max();
  const Case cases[] = {
      {XR_SUCCESS, [](auto&) {}},
      {XR_SUCCESS, [](auto& part) { part.imageArrayIndex = 1; }},
      {XR_SUCCESS,
       [](auto& part) {
         part.imageRect = {{63, 47}, {1, 1}};
       }},
      {XR_ERROR_VALIDATION_FAILURE, [](auto& part) { part.imageArrayIndex = 2; }},
      {XR_ERROR_SWAPCHAIN_RECT_INVALID, [](auto& part) { part.imageRect.extent.width = 65; }},
      {XR_ERROR_SWAPCHAIN_RECT_INVALID, [](auto& part) { part.imageRect.extent.height = 49; }},
      {XR_ERROR_SWAPCHAIN_RECT_INVALID, [](auto& part) { part.imageRect.extent.width = -1; }},
      {XR_ERROR_SWAPCHAIN_RECT_INVALID, [](auto& part) { part.imageRect.extent.height = -1; }},
      {XR_ERROR_SWAPCHAIN_RECT_INVALID, [](auto& part) { part.imageRect.offset.x = -1; }},
      {XR_ERROR_SWAPCHAIN_RECT_INVALID, [](auto& part) { part.imageRect.offset.y = 1; }},
      {XR_ERROR_SWAPCHAIN_RECT_INVALID,
       [](auto& part) {
         part.imageRect = {{kMost, kMost}, {kMost, kMost}};
       }},
      {XR_ERROR_HANDLE_INVALID, [](auto& part) { part.swapchain = XR_NULL_HANDLE; }},
      {XR_ERROR_VALIDATION_FAILURE, [this](auto& part) { part = Part(depth_); }},
      {XR_ERROR_VALIDATION_FAILURE,
       [this](auto& part) {
         part = {cube_, {{0, 0}, {1, 1}}, 0};
       }},
  };
  for (const Case& one : cases) {
    const auto number = &one - cases;
    EXPECT_EQ(EndQuad([&](auto& quad) { one.change(quad.subImage); }), one.result) << "quad, case " << number;
    for (int eye = 0; eye < 2; ++eye) {
      EXPECT_EQ(End([&](Projection& all) { one.change(all.views[eye].subImage); }), one.result)
          << "eye " << eye << ", case " << number;
    }
  }
}

TEST_F(ImageLayers, DepthsAreCheckedWhereTheirExtensionIsEnabled) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  struct Case {
    XrResult result;
    std::function<void(XrCompositionLayerDepthInfoKHR&)> change;
  };
  const Case cases[] = {
      {XR_SUCCESS, [](auto& depth) { depth.farZ = kInfinity; }},
      {XR_SUCCESS, [](auto& depth) { std::swap(depth.nearZ, depth.farZ); }},
      {XR_ERROR_VALIDATION_FAILURE, [](auto& depth) { depth.minDepth = -0.1F; }},
      {XR_ERROR_VALIDATION_FAILURE, [](auto& depth) { depth.maxDepth = 1.1F; }},
      {XR_ERROR_VALIDATION_FAILURE, [](auto& depth) { depth.minDepth = depth.maxDepth; }},
      {XR_ERROR_VALIDATION_FAILURE, [](auto& depth) { depth.nearZ = 0; }},
      {XR_ERROR_VALIDATION_FAILURE, [](auto& depth) { depth.nearZ = depth.farZ; }},
      {XR_ERROR_VALIDATION_FAILURE, [](auto& depth) { depth.farZ = std::numeric_limits<float>::quiet_NaN(); }},
      {XR_ERROR_VALIDATION_FAILURE, [this](auto& depth) { depth.subImage = Part(color_); }},
      {XR_ERROR_SWAPCHAIN_RECT_INVALID, [](auto& depth) { depth.subImage.imageRect.extent.width = 65; }},
      {XR_ERROR_HANDLE_INVALID, [](auto& depth) { depth.subImage.swapchain = XR_NULL_HANDLE; }},
  };
  for (const Case& one : cases)
    EXPECT_EQ(End([&](Projection& all) { one.change(all.depths[1]); }), one.result) << "case " << &one - cases;
}

TEST_F(ImageLayers, SwapchainsMustHaveReleasedAnImage) {
  const XrSwapchain fresh = AddSwapchain(ColorInfo());
  const auto use = [&](auto& quad) { quad.subImage.swapchain = fresh; };
  EXPECT_EQ(EndQuad(use), XR_ERROR_LAYER_INVALID);
  ASSERT_EQ(Acquire(fresh), XR_SUCCESS);
  EXPECT_EQ(EndQuad(use), XR_ERROR_LAYER_INVALID);
  ASSERT_EQ(Wait(fresh), XR_SUCCESS);
  EXPECT_EQ(EndQuad(use), XR_ERROR_LAYER_INVALID);
  ASSERT_EQ(Release(fresh), XR_SUCCESS);
  EXPECT_EQ(EndQuad(use), XR_SUCCESS);
  ASSERT_EQ(Acquire(fresh), XR_SUCCESS);
  EXPECT_EQ(EndQuad(use), XR_SUCCESS) << "the image that was released last is still there";
  ASSERT_EQ(xrDestroySwapchain(fresh), XR_SUCCESS);
  EXPECT_EQ(EndQuad(use), XR_ERROR_HANDLE_INVALID);
}

TEST_F(ImageLayers, SwapchainsOfAnotherSessionAreRejected) {
  XrSession other = XR_NULL_HANDLE;
  ASSERT_EQ(CreateSession(&binding_, &other), XR_SUCCESS);
  std::swap(session_, other);
  const XrSwapchain theirs = AddSwapchain(ColorInfo());
  std::swap(session_, other);
  Show(theirs);
  EXPECT_EQ(EndQuad([&](auto& quad) { quad.subImage.swapchain = theirs; }), XR_ERROR_VALIDATION_FAILURE);
}

TEST_F(ImageLayers, EyesAndCubesAreChecked) {
  EXPECT_EQ(EndQuad([](auto& quad) { quad.eyeVisibility = XR_EYE_VISIBILITY_MAX_ENUM; }), XR_ERROR_VALIDATION_FAILURE);
  XrCompositionLayerCubeKHR cube{
      XR_TYPE_COMPOSITION_LAYER_CUBE_KHR, nullptr, 0, space_, XR_EYE_VISIBILITY_LEFT, cube_, 1, kHere.orientation};
  EXPECT_EQ(EndFrame(BeginFrame(), {&cube}), XR_SUCCESS);
  cube.imageArrayIndex = 2;
  EXPECT_EQ(EndFrame(BeginFrame(), {&cube}), XR_ERROR_VALIDATION_FAILURE);
  cube.imageArrayIndex = 0;
  cube.swapchain = color_;
  EXPECT_EQ(EndFrame(BeginFrame(), {&cube}), XR_ERROR_VALIDATION_FAILURE);
}

}  // namespace
}  // namespace omni::runtime
