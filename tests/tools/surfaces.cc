// Output of omni surfaces.
#include <gtest/gtest.h>

#include "service/protocol/surfaces/surface_memory.h"
#include "service/tools/surfaces/surfaces.h"

namespace omni::tools {
namespace test_tools_surfaces {

SurfacesView SomeView() {
  SurfacesView view{.connected = true,
                    .answered = true,
                    .has_memory = true,
                    .scene_generation = 3,
                    .memory_generation = 7,
                    .bytes = 5'400'000,
                    .poll_Hz = 89.97};
  view.rows.push_back({.name = "liver",
                       .flags = protocol::kSurfaceSoft | protocol::kSurfaceMoved,
                       .vertices = 1200,
                       .triangles = 2396,
                       .changes_Hz = 89.5,
                       .largest_displacement_m = 0.00314159,
                       .translation_m = 0.02});
  view.rows.push_back({.name = "clay", .flags = protocol::kSurfaceSculpted, .vertices = 99, .triangles = 194});
  return view;
}

TEST(SurfacesText, OneLinePerObject) {
  const std::string text = SurfacesText(SomeView());
  EXPECT_NE(text.find("scene 3, memory 7 of 5.4 MB, checked 90.0 times per second\n"), std::string::npos) << text;
  EXPECT_NE(text.find("soft, moved"), std::string::npos) << text;
  EXPECT_NE(text.find(" 3.142 "), std::string::npos) << text;
  EXPECT_NE(text.find("20.00\n"), std::string::npos) << text;
  EXPECT_NE(text.find("sculpted "), std::string::npos) << text;
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 4);
}

TEST(SurfacesText, ExplainsWhyNothingIsShown) {
  SurfacesView view;
  view.problem = "omnid at /x does not answer";
  EXPECT_EQ(SurfacesText(view), "no service: omnid at /x does not answer\n");
  view.connected = true;
  EXPECT_NE(SurfacesText(view).find("not answered"), std::string::npos);
  view.answered = true;
  EXPECT_NE(SurfacesText(view).find("nothing to draw"), std::string::npos);
}

TEST(SurfacesText, ColumnsStayAlignedForLongNames) {
  SurfacesView view = SomeView();
  view.rows[0].name = std::string(47, 'x');
  const std::string text = SurfacesText(view);
  std::size_t begin = text.find('\n') + 1, length = 0;
  for (std::size_t end = text.find('\n', begin); end != std::string::npos; end = text.find('\n', begin)) {
    EXPECT_TRUE(length == 0 || end - begin == length);
    length = end - begin;
    begin = end + 1;
  }
}

}  // namespace test_tools_surfaces
}  // namespace omni::tools
