// Names of the enumerants of our extensions: as the public headers define them.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>

#include "tests/layer/support/app.h"

namespace omni::test {
namespace test_own_names {

namespace fs = std::filesystem;

// Every enumerant of the headers has its name, and the runtime's enumerants those of the runtime.
TEST(OwnNames, EnumerantNamesMatchTheHeaders) {
  const App app;
  const std::regex defined(R"(#define (XR_\w+)[\s\\]+OMNI_XR_ENUMERANT\((XrResult|XrStructureType), (-?\d+)\))");
  int found = 0;
  for (const auto& entry : fs::directory_iterator(OMNI_SOURCE_DIR "/layer/include/openxr")) {
    std::ifstream in(entry.path());
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    for (std::sregex_iterator it(text.begin(), text.end(), defined), end; it != end; ++it, ++found) {
      const int value = std::stoi((*it)[3]);
      char name[XR_MAX_RESULT_STRING_SIZE] = {};
      const XrResult result = (*it)[2] == "XrResult"
                                  ? xrResultToString(app.instance, static_cast<XrResult>(value), name)
                                  : xrStructureTypeToString(app.instance, static_cast<XrStructureType>(value), name);
      EXPECT_EQ(result, XR_SUCCESS);
      EXPECT_EQ(name, (*it)[1].str());
    }
  }
  EXPECT_GE(found, 30);
  char name[XR_MAX_RESULT_STRING_SIZE] = {};
  ASSERT_EQ(xrResultToString(app.instance, XR_ERROR_HANDLE_INVALID, name), XR_SUCCESS);
  EXPECT_STREQ(name, "XR_ERROR_HANDLE_INVALID");
  ASSERT_EQ(xrStructureTypeToString(app.instance, XR_TYPE_SPACE_LOCATION, name), XR_SUCCESS);
  EXPECT_STREQ(name, "XR_TYPE_SPACE_LOCATION");
}

}  // namespace test_own_names
}  // namespace omni::test
