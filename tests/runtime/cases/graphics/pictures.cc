// The saved pictures, judged by where a pinhole camera would see the layers.

#include <stb/stb_image.h>
#include <stdlib.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <random>

#include "tests/runtime/cases/graphics/vulkan_fixture.h"
#include "tests/support/process/temp_folder.h"

namespace omni::runtime {
namespace {

// Linear light, and what 8-bit sRGB makes of it: red, green, blue.
struct Color {
  VkClearColorValue linear;
  int srgb[3];
};
const Color kGray{{{0.2158605F, 0.2158605F, 0.2158605F, 1}}, {128, 128, 128}};
const Color kOrange{{{1, 0.2158605F, 0, 1}}, {255, 128, 0}};
const Color kGreen{{{0, 1, 0, 1}}, {0, 255, 0}};
const Color kBlue{{{0, 0, 1, 1}}, {0, 0, 255}};
const Color kBlack{{{0, 0, 0, 1}}, {0, 0, 0}};

struct Saved {
  int width = 0;
  int height = 0;
  std::unique_ptr<stbi_uc, void (*)(void*)> bytes{nullptr, stbi_image_free};

  void ExpectColor(int x, int y, const Color& color) const {
    for (int i = 0; i < 3; ++i)
      EXPECT_NEAR(bytes.get()[(y * width + x) * 3 + i], color.srgb[i], 1) << "at " << x << ", " << y << ", part " << i;
  }
};

class Pictures : public VulkanTest {
 protected:
  void SetUp() override {
    setenv("OMNI_TEST_RUNTIME_PICTURES", folder_.Path("").c_str(), 1);
    VulkanTest::SetUp();
    if (session_ != XR_NULL_HANDLE) Begin();
  }
  void TearDown() override {
    VulkanTest::TearDown();
    unsetenv("OMNI_TEST_RUNTIME_PICTURES");
  }

  // The next frame with layers is saved.
  void Begin() {
    space_ = ReferenceSpace(XR_REFERENCE_SPACE_TYPE_VIEW);
    RunToFocus();
  }

  XrSwapchain Filled(const Color& color, const Color& quarter, int64_t format = VK_FORMAT_R8G8B8A8_SRGB) {
    XrSwapchainCreateInfo info = ColorInfo();
    info.format = format;
    const XrSwapchain swapchain = AddSwapchain(info);
    Show(swapchain, {color.linear, quarter.linear});
    return swapchain;
  }

  XrCompositionLayerQuad Quad(XrSwapchain swapchain, const XrVector3f& at, const XrExtent2Df& size) const {
    return {XR_TYPE_COMPOSITION_LAYER_QUAD,
            nullptr,
            0,
            space_,
            XR_EYE_VISIBILITY_BOTH,
            {swapchain, {{0, 0}, {64, 48}}, 0},
            {{0, 0, 0, 1}, at},
            size};
  }

  Saved Load(const std::string& eye) const {
    Saved saved;
    int channels = 0;
    saved.bytes.reset(stbi_load(folder_.Path(eye + ".png").c_str(), &saved.width, &saved.height, &channels, 3));
    EXPECT_NE(saved.bytes, nullptr) << eye;
    return saved;
  }

  omni::test::TempFolder folder_;
  XrSpace space_ = XR_NULL_HANDLE;
};

constexpr float kEye_m = 0.032F;
// Of the head that looks along -z, at 45 degrees half the field of view.
float Column(float x, float z, float eye_x) { return 512 + 512 * (x - eye_x) / -z / std::tan(0.785F); }
float Row(float y, float z) { return 512 - 512 * y / -z / std::tan(0.785F); }

TEST_F(Pictures, QuadsCoverWhatTheyHideAndAreSeenFromBothEyes) {
  const Color* const colors[] = {&kOrange, &kGreen, &kBlue};
  std::mt19937 random(7);
  std::uniform_real_distribution<float> place(-0.6F, 0.6F);
  std::uniform_real_distribution<float> side(0.2F, 0.6F);
  std::vector<XrCompositionLayerQuad> quads;
  for (const Color* color : colors)
    quads.push_back(
        Quad(Filled(*color, *color), {place(random), place(random), -1 - side(random)}, {side(random), side(random)}));
  ASSERT_EQ(EndFrame(BeginFrame(), {&quads[0], &quads[1], &quads[2]}), XR_SUCCESS);
  for (const char* eye : {"left", "right"}) {
    const Saved saved = Load(eye);
    ASSERT_EQ(saved.width, 1024);
    ASSERT_EQ(saved.height, 1024);
    const float eye_x = eye[0] == 'l' ? -kEye_m : kEye_m;
    int covered = 0;
    for (int i = 0; i < 4000; ++i) {
      const int x = static_cast<int>(random() % 1024);
      const int y = static_cast<int>(random() % 1024);
      const Color* expected = &kBlack;
      bool edge = false;
      for (size_t j = 0; j < quads.size(); ++j) {
        const XrVector3f& p = quads[j].pose.position;
        const XrExtent2Df& size = quads[j].size;
        const float left = Column(p.x - size.width / 2, p.z, eye_x) - static_cast<float>(x);
        const float right = Column(p.x + size.width / 2, p.z, eye_x) - static_cast<float>(x);
        const float top = Row(p.y + size.height / 2, p.z) - static_cast<float>(y);
        const float bottom = Row(p.y - size.height / 2, p.z) - static_cast<float>(y);
        for (const float line : {left, right, top, bottom}) edge = edge || std::abs(line) < 2;
        if (left < 0 && right > 0 && top < 0 && bottom > 0) expected = colors[j];
      }
      if (edge) continue;
      if (expected != &kBlack) ++covered;
      saved.ExpectColor(x, y, *expected);
    }
    EXPECT_GT(covered, 100);
  }
}

TEST_F(Pictures, ProjectionShowsEachEyeItsOwnPartUpright) {
  const XrSwapchain swapchain = Filled(kGray, kOrange);
  XrCompositionLayerProjectionView views[2];
  for (uint32_t eye = 0; eye < 2; ++eye) {
    views[eye] = Make<XrCompositionLayerProjectionView>(XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW);
    views[eye].pose = kHere;
    views[eye].pose.position.x = eye == 0 ? -kEye_m : kEye_m;
    views[eye].fov = {-0.785F, 0.785F, 0.785F, -0.785F};
    views[eye].subImage = {swapchain, {{0, 0}, {64, 48}}, eye};
  }
  XrCompositionLayerProjection projection{XR_TYPE_COMPOSITION_LAYER_PROJECTION, nullptr, 0, space_, 2, views};
  ASSERT_EQ(EndFrame(BeginFrame(), {&projection}), XR_SUCCESS);
  const Saved left = Load("left");
  left.ExpectColor(2, 2, kOrange);
  left.ExpectColor(500, 500, kOrange);
  left.ExpectColor(524, 500, kGray);
  left.ExpectColor(500, 524, kGray);
  const Saved right = Load("right");
  right.ExpectColor(2, 2, kOrange);
  right.ExpectColor(1021, 1021, kOrange);
}

TEST_F(Pictures, RectanglesVisibilityAndBackFacesAreRespected) {
  const XrSwapchain swapchain = Filled(kGray, kOrange);
  XrCompositionLayerQuad part = Quad(swapchain, {0, 0, -1}, {0.5F, 0.5F});
  part.subImage.imageRect = {{16, 12}, {32, 24}};  // a quarter of it orange
  XrCompositionLayerQuad one = Quad(swapchain, {0.7F, 0, -1}, {0.2F, 0.2F});
  one.eyeVisibility = XR_EYE_VISIBILITY_RIGHT;
  XrCompositionLayerQuad back = Quad(swapchain, {-0.7F, 0, -1}, {0.2F, 0.2F});
  back.pose.orientation = {0, 1, 0, 0};
  ASSERT_EQ(EndFrame(BeginFrame(), {&part, &one, &back}), XR_SUCCESS);
  for (const char* eye : {"left", "right"}) {
    const Saved saved = Load(eye);
    const float eye_x = eye[0] == 'l' ? -kEye_m : kEye_m;
    const auto expect = [&](float x, float y, const Color& color) {
      saved.ExpectColor(static_cast<int>(Column(x, -1, eye_x)), static_cast<int>(Row(y, -1)), color);
    };
    expect(-0.1F, 0.1F, kOrange);
    expect(0.1F, 0.1F, kGray);
    expect(-0.1F, -0.1F, kGray);
    expect(0.75F, -0.05F, eye[0] == 'l' ? kBlack : kGray);
    expect(-0.7F, 0, kBlack);
  }
}

TEST_F(Pictures, LinearFormatsAndAlphaAreBlendedInLinearLight) {
  const XrSwapchain solid = Filled(kOrange, kOrange, VK_FORMAT_B8G8R8A8_UNORM);
  Color half = kGreen;
  half.linear.float32[3] = 0.5F;
  const XrSwapchain glass = Filled(half, half);
  XrCompositionLayerQuad back = Quad(solid, {0, 0, -1}, {1, 1});
  XrCompositionLayerQuad front = Quad(glass, {0, 0, -1}, {0.5F, 0.5F});
  front.layerFlags =
      XR_COMPOSITION_LAYER_BLEND_TEXTURE_SOURCE_ALPHA_BIT | XR_COMPOSITION_LAYER_UNPREMULTIPLIED_ALPHA_BIT;
  ASSERT_EQ(EndFrame(BeginFrame(), {&back, &front}), XR_SUCCESS);
  const Saved saved = Load("left");
  saved.ExpectColor(300, 300, kOrange);
  // Half of each: 0.5, 0.5 + 0.2158605 / 2, 0.
  saved.ExpectColor(512, 512, {{}, {188, 204, 0}});
}

TEST_F(Pictures, FrameIsNamedAndAFolderThatIsNotThereIsAnError) {
  const XrSwapchain swapchain = Filled(kGray, kGray);
  XrCompositionLayerQuad quad = Quad(swapchain, {0, 0, -1}, {1, 1});
  for (int i = 0; i < 10; ++i) ASSERT_EQ(EndFrame(BeginFrame(), {&quad}), XR_SUCCESS);
  std::string line;
  std::getline(std::ifstream(folder_.Path("frame.txt")), line);
  EXPECT_EQ(line, "frame 1 layers 1");
  ASSERT_EQ(EndFrame(BeginFrame(), {&quad, &quad}), XR_SUCCESS);
  std::getline(std::ifstream(folder_.Path("frame.txt")), line);
  EXPECT_EQ(line, "frame 11 layers 2");
  ASSERT_EQ(xrDestroySession(session_), XR_SUCCESS);
  ASSERT_EQ(CreateSession(&binding_, &session_), XR_SUCCESS);
  Begin();
  setenv("OMNI_TEST_RUNTIME_PICTURES", folder_.Path("nowhere").c_str(), 1);
  quad = Quad(Filled(kGray, kGray), {0, 0, -1}, {1, 1});
  EXPECT_EQ(EndFrame(BeginFrame(), {&quad}), XR_ERROR_RUNTIME_FAILURE);
}

}  // namespace
}  // namespace omni::runtime
