// Paths are interned, well formed, and belong to their instance.

#include "tests/runtime/cases/fixture.h"

namespace omni::runtime {
namespace test_paths {

class PathTest : public RuntimeTest {
 protected:
  void SetUp() override {
    RuntimeTest::SetUp();
    Start();
  }
};

TEST_F(PathTest, SameStringGivesSamePath) {
  const XrPath left = Path("/user/hand/left");
  EXPECT_EQ(left, Path("/user/hand/left"));
  EXPECT_NE(left, Path("/user/hand/right"));
  EXPECT_NE(left, XR_NULL_PATH);
  EXPECT_EQ(Text(left), "/user/hand/left");
}

TEST_F(PathTest, MalformedPathStringsAreRejected) {
  XrPath path = 7;
  for (const char* const text : {"", "/", "user", "/user/", "//user", "/user//hand", "/User", "/user/händ", "/user/.",
                                 "/user/..", "/...", "/us er", "/user\\hand"}) {
    EXPECT_EQ(xrStringToPath(instance_, text, &path), XR_ERROR_PATH_FORMAT_INVALID) << text;
  }
  const std::string longest = "/" + std::string(XR_MAX_PATH_LENGTH - 2, 'a');
  EXPECT_EQ(xrStringToPath(instance_, longest.c_str(), &path), XR_SUCCESS);
  EXPECT_EQ(xrStringToPath(instance_, (longest + "a").c_str(), &path), XR_ERROR_PATH_FORMAT_INVALID);
  EXPECT_EQ(Text(Path("/a.b/..c/-_0")), "/a.b/..c/-_0");
}

TEST_F(PathTest, UnknownPathsAreInvalid) {
  char text[64];
  uint32_t length = 0;
  for (const XrPath bogus : {XrPath{XR_NULL_PATH}, XrPath{1}, XrPath{0x1234567812345678}, Path("/user/head") + 1000}) {
    EXPECT_EQ(xrPathToString(instance_, bogus, sizeof(text), &length, text), XR_ERROR_PATH_INVALID) << bogus;
  }
}

TEST_F(PathTest, SizesFollowTheTwoCallIdiom) {
  const XrPath path = Path("/user/head");
  uint32_t length = 0;
  ASSERT_EQ(xrPathToString(instance_, path, 0, &length, nullptr), XR_SUCCESS);
  EXPECT_EQ(length, 11U);
  char text[16] = "untouched";
  EXPECT_EQ(xrPathToString(instance_, path, 10, &length, text), XR_ERROR_SIZE_INSUFFICIENT);
  EXPECT_STREQ(text, "untouched");
  EXPECT_EQ(length, 11U);
  EXPECT_EQ(xrPathToString(instance_, path, 11, &length, text), XR_SUCCESS);
  EXPECT_STREQ(text, "/user/head");
}

TEST_F(PathTest, PathsAreInvalidAfterTheirInstance) {
  const XrPath old = Path("/user/head");
  DestroyInstance();
  Start();
  Path("/user/head");
  char text[64];
  uint32_t length = 0;
  EXPECT_EQ(xrPathToString(instance_, old, sizeof(text), &length, text), XR_ERROR_PATH_INVALID);
}

}  // namespace test_paths
}  // namespace omni::runtime
