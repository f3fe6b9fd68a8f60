// The example applications as processes of their own, over the test runtime, with the layer and the fake service.
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/wait.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <thread>

#include "tests/layer/support/app.h"
#include "tests/layer/support/scene_messages.h"
#include "tests/support/process/temp_folder.h"

namespace omni::test {
namespace test_examples {

struct ExampleRun {
  int status = -1;
  std::string out;
  std::string err;

  // The number after `word` in the last line: "frames 90, located 80, ...".
  long Count(const std::string& word) const {
    const std::size_t line = out.rfind("frames ");
    const std::size_t at = line == std::string::npos ? line : out.find(word + " ", line);
    return at == std::string::npos ? -1 : std::strtol(out.c_str() + at + word.size(), nullptr, 10);
  }
};

std::string ReadAll(const std::string& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

// Runs a program of the build tree; `meanwhile` is called about every millisecond.
template <class Meanwhile>
ExampleRun RunExample(const std::string& environment, const std::string& command, Meanwhile meanwhile) {
  const TempFolder folder;
  ExampleRun run;
  std::atomic<bool> done{false};
  std::thread program([&] {
    const std::string line = environment + " " + OMNI_BINARY_DIR + "/bin/" + command + " >" + folder.Path("out") +
                             " 2>" + folder.Path("err");
    const int status = std::system(line.c_str());
    run.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    done = true;
  });
  while (!done) {
    meanwhile();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  program.join();
  run.out = ReadAll(folder.Path("out"));
  run.err = ReadAll(folder.Path("err"));
  return run;
}

constexpr const char* kWithLayer = "XR_ENABLE_API_LAYERS=XR_APILAYER_OMNI_stylus";

TEST(Examples, TouchGetsThePenWithTheLayer) {
  FakeService service;
  int passes = 0;
  const ExampleRun run = RunExample(kWithLayer, "omni_touch --seconds 1 --name omni_touch_test", [&] {
    if (++passes % 60 == 0) {
      service.Set(protocol::InputIndex::kTipForce, 0.8f);
      service.Set(protocol::InputIndex::kSelect, 1);
    } else if (passes % 60 == 30) {
      service.Set(protocol::InputIndex::kTipForce, 0);
      service.Set(protocol::InputIndex::kSelect, 0);
    }
    service.Fill();
  });
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(run.err, "");
  EXPECT_GT(run.Count("frames"), 10) << run.out;
  EXPECT_GT(run.Count("located"), run.Count("frames") / 2) << run.out;
  EXPECT_GT(run.Count("presses"), 0) << run.out;
  EXPECT_NE(run.out.find(std::string("profile ") + kMxInk), std::string::npos) << run.out;
  const Heard heard = service.heard();
  EXPECT_EQ(heard.applications, std::vector<std::string>{"omni_touch_test"});
  EXPECT_FALSE(heard.haptics.empty()) << "a press is answered with a pulse";
  ASSERT_TRUE(heard.last_session());
  EXPECT_EQ(*heard.last_session(), protocol::SessionState::kNone) << "it ended its session";
}

// Nothing in it knows of Omni: without the layer it shows the runtime's controller.
TEST(Examples, TouchGetsTheRuntimesControllerWithoutTheLayer) {
  ASSERT_EQ(omni_test_reset(), 0);
  const ExampleRun run = RunExample("XR_ENABLE_API_LAYERS=", "omni_touch --hand left --seconds 0.5", [] {});
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_GT(run.Count("located"), 5) << run.out;
  EXPECT_NE(run.out.find(std::string("profile ") + kTouch), std::string::npos) << run.out;
}

TEST(Examples, MissingRuntimeAndBadOptionsAreReported) {
  const ExampleRun none = RunExample("XR_RUNTIME_JSON=/nowhere.json XR_LOADER_DEBUG=none", "omni_touch", [] {});
  EXPECT_EQ(none.status, 1);
  EXPECT_NE(none.err.find("omni_touch: no OpenXR runtime answers"), std::string::npos) << none.err;
  const ExampleRun wrong = RunExample("", "omni_touch --hand both", [] {});
  EXPECT_EQ(wrong.status, 2);
  EXPECT_EQ(wrong.err.rfind("usage: omni_touch", 0), 0u) << wrong.err;
}

// A runtime without XR_MND_headless: empty frames with Vulkan (lavapipe needs no display).
TEST(Examples, TouchSubmitsEmptyFramesWithoutHeadlessExtension) {
  // Lavapipe itself leaks 128 bytes per device, and its library is gone before LeakSanitizer could say whose they are.
  const std::string environment = std::string(kWithLayer) + " OMNI_TEST_RUNTIME_WITHOUT=XR_MND_headless" +
                                  " ASAN_OPTIONS=${ASAN_OPTIONS:+$ASAN_OPTIONS:}detect_leaks=0";
  const ExampleRun run = RunExample(environment, "omni_touch --hand left --seconds 1", [] {});
  for (const char* why : {"built without Vulkan", "could not make a Vulkan device"})
    if (run.err.find(why) != std::string::npos) GTEST_SKIP() << run.err;
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_GT(run.Count("located"), 10) << run.out;
  EXPECT_NE(run.out.find(std::string("profile ") + kTouch), std::string::npos) << run.out;
}

#ifdef OMNI_FORCE_EXAMPLE
TEST(Examples, ForceNeedsTheLayer) {
  const ExampleRun run = RunExample("XR_ENABLE_API_LAYERS=", "omni_force --seconds 0.3", [] {});
  EXPECT_EQ(run.status, 1);
  EXPECT_NE(run.err.find("omni_force: no layer offers XR_OMNIX1_force_feedback"), std::string::npos) << run.err;
}

TEST(Examples, ForceRunsItsThreeParts) {
  FakeService service;
  service.SetForce(true, protocol::ForceStanding::kYours);
  const ExampleRun run = RunExample(kWithLayer, "omni_force --seconds 1", [&] { service.Fill(); });
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(run.err, "");
  EXPECT_GT(run.Count("frames"), 10) << run.out;
  for (const char* part : {"a breeze", "a table", "honey"})
    EXPECT_NE(run.out.find(part), std::string::npos) << part << " is missing in: " << run.out;
  EXPECT_GT(service.heard().forces.size(), 10u) << "a breeze is renewed every frame";
}
#endif

#ifdef OMNI_BLOCK_EXAMPLE
TEST(Examples, BlockNeedsTheLayer) {
  const ExampleRun run = RunExample("XR_ENABLE_API_LAYERS=", "omni_block --seconds 0.3", [] {});
  EXPECT_EQ(run.status, 1);
  EXPECT_NE(run.err.find("omni_block: no layer offers XR_OMNIX1_haptic_scene"), std::string::npos) << run.err;
}

// One document, which rises and sinks, and feels in three ways.
TEST(Examples, BlockIsSentMovedAndChanged) {
  constexpr double kRise_m = 0.003;
  FakeService service;
  service.AnswerScenes([](const protocol::HapticSceneLoad& load) -> std::vector<std::string> {
    return {SceneTableMessage(load.number, TwoNodes()),
            SceneStateMessage(load.number, protocol::HapticSceneStatus::kReady, 9, "")};
  });
  const ExampleRun run = RunExample(kWithLayer, "omni_block --seconds 1", [&] { service.Fill(); });
  EXPECT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(run.err, "");
  EXPECT_GT(run.Count("frames"), 10) << run.out;
  for (const char* part : {"rubber", "ice", "ribs"})
    EXPECT_NE(run.out.find(part), std::string::npos) << part << " is missing in: " << run.out;
  const Heard heard = service.heard();
  ASSERT_EQ(heard.scene_documents.size(), 1u);
  EXPECT_EQ(heard.scene_documents[0].rfind("glTF", 0), 0u);
  EXPECT_EQ(heard.scene_materials.size(), 3u);
  ASSERT_GT(heard.scene_nodes.size(), 10u);
  double highest_m = 0;
  for (const protocol::HapticNodes& moved : heard.scene_nodes) {
    ASSERT_EQ(moved.count, 1u);
    highest_m = std::max(highest_m, moved.nodes[0].pose.position_m[2]);
  }
  EXPECT_GT(highest_m, kRise_m);
}

TEST(Examples, BlockReportsWhyItsSceneIsRefused) {
  FakeService service;
  service.AnswerScenes([](const protocol::HapticSceneLoad& load) -> std::vector<std::string> {
    return {SceneStateMessage(load.number, protocol::HapticSceneStatus::kFailed, 0, "/meshes/0: is broken")};
  });
  const ExampleRun run = RunExample(kWithLayer, "omni_block --seconds 1", [&] { service.Fill(); });
  EXPECT_EQ(run.status, 1);
  EXPECT_NE(run.err.find("omni_block: the scene is refused: /meshes/0: is broken"), std::string::npos) << run.err;
}
#endif

}  // namespace test_examples
}  // namespace omni::test
