// layer/include/openxr/omni_haptic_scene.h has a float for each live number of a material: its name, its place and the
// range in its comment are those of the table.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <iterator>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "service/base/material.h"

namespace omni {
namespace test_haptic_material_header {

// "static friction" -> "staticFriction"
std::string CamelCase(std::string_view label) {
  std::string name;
  bool upper = false;
  for (const char c : label) {
    if (c == ' ') {
      upper = true;
    } else {
      name += upper ? static_cast<char>(std::toupper(static_cast<unsigned char>(c))) : c;
      upper = false;
    }
  }
  return name;
}

TEST(HapticMaterialHeader, MembersMatchLiveMaterialFieldsAndRanges) {
  std::ifstream file(OMNI_SOURCE_DIR "/layer/include/openxr/omni_haptic_scene.h");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const std::size_t begin = text.find("typedef struct XrHapticMaterialOMNIX1 {");
  const std::size_t end = text.find("} XrHapticMaterialOMNIX1;");
  ASSERT_TRUE(begin != std::string::npos && end != std::string::npos);
  const std::string body = text.substr(begin, end - begin);
  const std::regex member("float (\\w+);\\s*/\\* (.*?) \\*/");
  std::size_t i = 0;
  for (std::sregex_iterator at(body.begin(), body.end(), member), last; at != last; ++at, ++i) {
    ASSERT_LT(i, base::kLiveMaterialFields) << (*at)[1];
    const base::MaterialField& field = *base::kLiveFields[i];
    EXPECT_EQ((*at)[1], CamelCase(field.label));
    std::ostringstream range;
    range << field.minimum << " to ";
    if (field.key != "dynamicFriction") range << field.maximum;
    EXPECT_NE((*at)[2].str().find(range.str()), std::string::npos)
        << (*at)[1] << ": " << (*at)[2] << ", " << range.str();
  }
  EXPECT_EQ(i, base::kLiveMaterialFields);
}

}  // namespace test_haptic_material_header
}  // namespace omni
