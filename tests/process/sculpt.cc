// A pen that presses into clay, holds it and pulls: omnid, the twin and the command line as real processes, from the
// stroke to the file.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "service/tools/common/command_line.h"
#include "tests/support/process/clay.h"

namespace omni::test {
namespace test_process_sculpt {

TEST(ProcessSculpt, StrokeCanBeSavedUndoneAndRedone) {
  const TempFolder folder;
  ServiceProcess service(ClayFile(folder), kPressAndPull);
  service.Start();
  TestApplication app(service);
  ASSERT_TRUE(app.Focus()) << app.connection().last_error();
  nlohmann::json edits;
  const auto look = [&] {
    const Outcome said = OmniScene(service, {"edits", "--json"});
    if (said.status == tools::kExitOk) edits = nlohmann::json::parse(said.out)["objects"][0];
    return said.status == tools::kExitOk;
  };
  ASSERT_TRUE(app.Run(15000, 100, [&] { return look() && edits["strokes"] > 0; })) << edits;
  EXPECT_EQ(edits["name"], "pad");
  EXPECT_NE(OmniScene(service, {"edits"}).out.find("pad: "), std::string::npos);
  // Strokes continue, so each of these may find one in progress and is repeated.
  Outcome said;
  const auto until_done = [&](const std::vector<std::string>& words) {
    return app.Run(15000, 50, [&] { return (said = OmniScene(service, words)).status == tools::kExitOk; });
  };
  const std::string file = folder.Path("saved.glb"), undone = folder.Path("undone.glb");
  ASSERT_TRUE(until_done({"save", file})) << said.err;
  EXPECT_NE(said.out.find("1 object, "), std::string::npos) << said.out;
  EXPECT_GT(std::abs(TopOf(file) - kTop_m), 1e-4) << "it was formed";
  said = OmniScene(service, {"save", file});
  EXPECT_EQ(said.status, tools::kExitFailed);
  EXPECT_NE(said.err.find("saved.glb"), std::string::npos) << said.err;
  ASSERT_TRUE(until_done({"save", file, "--force"})) << said.err;
  // The application continues without the force: nothing touches the pad any more, and everything can be undone.
  ASSERT_TRUE(app.connection().SendSession(protocol::SessionState::kBegun));
  app.Run(300, 10);
  ASSERT_TRUE(look());
  EXPECT_EQ(edits["stroke_open"], false);
  for (int strokes = edits["strokes"]; strokes > 0; --strokes) EXPECT_EQ(OmniScene(service, {"undo"}).status, 0);
  said = OmniScene(service, {"undo"});
  EXPECT_EQ(said.status, tools::kExitFailed);
  EXPECT_EQ(said.err, "omni scene undo: pad: nothing to undo\n");
  ASSERT_EQ(OmniScene(service, {"save", undone}).status, 0);
  EXPECT_NEAR(TopOf(undone), kTop_m, 1e-6) << "as it was";
  EXPECT_EQ(OmniScene(service, {"redo", "--object", "pad"}).status, 0);
  said = OmniScene(service, {"redo", "--object", "vase"});
  EXPECT_NE(said.err.find("no object \"vase\""), std::string::npos) << said.err;
  // The scene ends with the session.
  ASSERT_TRUE(app.connection().SendSession(protocol::SessionState::kNone));
  EXPECT_TRUE(app.Run(3000, 20, [&] {
    return OmniScene(service, {"edits"}).err.find("no application has a scene with a sculptable object") !=
           std::string::npos;
  }));
}

}  // namespace test_process_sculpt
}  // namespace omni::test
