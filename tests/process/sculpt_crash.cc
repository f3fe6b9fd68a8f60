// omnid killed in the middle of strokes, and started again: the application that comes back finds its clay. Also the
// end of sessions, a changed file, two applications, a disk that takes nothing. ProcessSculptLong has a hundred crashes
// and prints them (docs/CONTRIBUTING.md); ctest leaves it out.
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <map>
#include <random>

#include <nlohmann/json.hpp>

#include "service/scene/journal/journal_folder.h"
#include "service/tools/common/command_line.h"
#include "tests/support/process/clay.h"

namespace omni::test {
namespace test_process_sculpt_crash {

namespace fs = std::filesystem;
using nlohmann::json;

std::string BytesOf(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

class Sculptor {
 public:
  explicit Sculptor(int n = 16) : clay_(ClayFile(folder_, n)), service(clay_, kPressAndPull) {}

  void Start() { service.Start({"--log-level", "info"}, log()); }
  std::string log() const { return folder_.Path("log"); }
  std::string journals() const { return service.state_folder() + "/omni/sculpt"; }
  std::string Path(const std::string& name) const { return folder_.Path(name); }
  const std::string& clay() const { return clay_; }

  // A session that has its scene, and not yet the force: nothing is sculpted.
  std::unique_ptr<TestApplication> Begin(const std::string& name = "process_test") {
    auto app = std::make_unique<TestApplication>(service, name);
    EXPECT_TRUE(app->Run(5000, 5, [&] { return app->connection().connected(); }));
    EXPECT_TRUE(app->connection().SendSession(protocol::SessionState::kBegun));
    // That of an application that has just gone may still be there.
    EXPECT_TRUE(app->Run(5000, 5, [&] {
      const std::vector<std::string> clients = ClientsWithScene();
      return clients.size() == 1 && Edits({"--client", clients[0]});
    })) << "its scene is there";
    return app;
  }
  // Their ids, the oldest first.
  std::vector<std::string> ClientsWithScene() {
    std::vector<std::string> ids;
    const json status = Status();
    if (!status.is_object()) return ids;
    for (const json& client : status["clients"]) {
      if (client["monitor"] == false && client["scene"] != "") ids.push_back(client["id"].dump());
    }
    return ids;
  }
  // False: there is nothing to sculpt. Then: strokes, open.
  bool Edits(const std::vector<std::string>& more = {}) {
    std::vector<std::string> words{"edits", "--json"};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome said = OmniScene(service, words);
    if (said.status != tools::kExitOk) return false;
    edits = json::parse(said.out)["objects"][0];
    strokes = edits["strokes"];
    open = edits["stroke_open"];
    return true;
  }
  // The surface that omnid has now, as a file; empty: a stroke came between.
  std::string Surface() {
    const int before = strokes;
    const std::string file = folder_.Path("surface.glb");
    if (open || OmniScene(service, {"save", file, "--force"}).status != 0) return {};
    if (!Edits() || open || strokes != before) return {};
    return BytesOf(file);
  }
  json Status() {
    const Outcome said = RunOmni({"status", "--json", "--socket", service.socket_path()});
    return json::parse(said.out, nullptr, false);
  }

 private:
  const TempFolder folder_;
  const std::string clay_;

 public:
  ServiceProcess service;
  json edits;
  int strokes = 0;
  bool open = false;
};

struct Crash {
  int before = 0;  // strokes, with the one that was open
  bool open = false;
  int restored = 0;
  double ms = 0;  // sculpted until the kill
  bool same = false;
};

// Sculpts on for `ms`, kills omnid, starts it again and looks at the clay.
Crash CrashOnce(Sculptor& sculptor, int ms) {
  Crash crash;
  std::map<int, std::string> published;  // by strokes
  {
    const auto app = sculptor.Begin();
    EXPECT_TRUE(app->connection().SendSession(protocol::SessionState::kFocused));
    const std::int64_t begin_ns = base::MonotonicNow_ns();
    const int first = sculptor.strokes;
    app->Run(20000, 5, [&] {
      if (!sculptor.Edits()) return false;
      if (published.count(sculptor.strokes) == 0) {
        if (std::string surface = sculptor.Surface(); !surface.empty()) published[sculptor.strokes] = surface;
      }
      crash.ms = 1e-6 * static_cast<double>(base::MonotonicNow_ns() - begin_ns);
      return crash.ms > ms && (sculptor.open || sculptor.strokes > first);
    });
    crash.open = sculptor.open;
    crash.before = sculptor.strokes + (sculptor.open ? 1 : 0);
    sculptor.service.Signal(SIGKILL);
    EXPECT_NE(sculptor.service.Wait(), 0);
  }
  sculptor.Start();
  const auto app = sculptor.Begin();
  crash.restored = sculptor.strokes;
  // Back to a number of strokes at which the surface was seen: it is that one.
  int undone = 0;
  while (!published.empty() && published.count(sculptor.strokes) == 0 && sculptor.strokes > published.begin()->first) {
    EXPECT_EQ(OmniScene(sculptor.service, {"undo"}).status, 0);
    EXPECT_TRUE(sculptor.Edits());
    ++undone;
  }
  const std::string surface = sculptor.Surface();
  crash.same = !surface.empty() && (published.empty() || surface == published[sculptor.strokes]);
  for (; undone > 0; --undone) EXPECT_EQ(OmniScene(sculptor.service, {"redo"}).status, 0);
  EXPECT_TRUE(sculptor.Edits());
  EXPECT_EQ(sculptor.strokes, crash.restored) << "redone";
  return crash;
}

// So many crashes, at random times from a fifth of a second to four.
void ExpectStrokesSurvive(int crashes, bool print) {
  Sculptor sculptor;
  sculptor.Start();
  std::mt19937 random(27);
  int lost_most = 0, in_stroke = 0;
  if (print) std::printf("crash  after ms  in a stroke  strokes before  restored  lost  the same surface\n");
  for (int k = 1; k <= crashes; ++k) {
    const Crash crash = CrashOnce(sculptor, std::uniform_int_distribution<int>(200, 4000)(random));
    const int lost = std::max(0, crash.before - crash.restored);
    lost_most = std::max(lost_most, lost);
    in_stroke += crash.open ? 1 : 0;
    if (print) {
      std::printf("%5d  %8.0f  %11s  %14d  %8d  %4d  %s\n", k, crash.ms, crash.open ? "yes" : "no", crash.before,
                  crash.restored, lost, crash.same ? "yes" : "NO");
      std::fflush(stdout);
    }
    EXPECT_LE(lost, 1) << "crash " << k;
    EXPECT_TRUE(crash.same) << "crash " << k;
  }
  EXPECT_GT(sculptor.strokes, 0);
  if (print) std::printf("%d crashes, %d in a stroke: at most %d lost\n", crashes, in_stroke, lost_most);
  EXPECT_EQ(scene::JournalsIn(sculptor.journals()).size(), 1U);
}

TEST(ProcessSculptCrash, StrokesSurviveFiveCrashes) { ExpectStrokesSurvive(5, false); }

TEST(ProcessSculptLong, StrokesSurviveAHundredCrashes) { ExpectStrokesSurvive(100, true); }

// Strokes, and the application is gone.
void SculptSome(Sculptor& sculptor, int strokes = 1) {
  const auto app = sculptor.Begin();
  ASSERT_TRUE(app->connection().SendSession(protocol::SessionState::kFocused));
  ASSERT_TRUE(app->Run(20000, 20, [&] { return sculptor.Edits() && sculptor.strokes >= strokes; }));
  ASSERT_TRUE(app->connection().SendSession(protocol::SessionState::kBegun));
  app->Run(300, 10);
  ASSERT_TRUE(sculptor.Edits());
}

TEST(ProcessSculptCrash, ApplicationComesBackToItsClayUntilItIsDiscarded) {
  Sculptor sculptor;
  sculptor.Start();
  SculptSome(sculptor);
  const int strokes = sculptor.strokes;
  {
    const auto app = sculptor.Begin();  // again, at once: without omnid ending
    EXPECT_EQ(sculptor.strokes, strokes);
    EXPECT_EQ(sculptor.Status()["scene"]["strokes"].size(), 0U) << "it has no force";
    EXPECT_NE(BytesOf(sculptor.log()).find("pad: restored " + std::to_string(strokes) + " stroke"), std::string::npos);
    EXPECT_EQ(sculptor.edits["saved"], false);
    EXPECT_EQ(OmniScene(sculptor.service, {"save", sculptor.Path("saved.glb")}).status, 0);
    EXPECT_TRUE(app->Run(3000, 20, [&] { return sculptor.Edits() && sculptor.edits["saved"] == true; }));
  }
  EXPECT_EQ(sculptor.service.Stop(), 0);
  const std::vector<std::string> paths = scene::JournalsIn(sculptor.journals());
  ASSERT_EQ(paths.size(), 1U);
  const auto content = scene::ReadJournal(paths[0]);
  ASSERT_TRUE(content.ok()) << content.error();
  EXPECT_EQ(content->strokes(), static_cast<std::uint64_t>(strokes));
  EXPECT_TRUE(content->saved);
  EXPECT_TRUE(scene::DiscardJournal(paths[0]).ok());
  sculptor.Start();
  const auto app = sculptor.Begin();
  EXPECT_EQ(sculptor.strokes, 0) << "as the file has it";
}

TEST(ProcessSculptCrash, ChangedFileIsNotSculptedByOldStrokes) {
  Sculptor sculptor;
  sculptor.Start();
  SculptSome(sculptor);
  EXPECT_EQ(sculptor.service.Stop(), 0);
  const TempFolder other;
  fs::copy_file(ClayFile(other, 12), sculptor.clay(), fs::copy_options::overwrite_existing);
  sculptor.Start();
  const auto app = sculptor.Begin();
  EXPECT_EQ(sculptor.strokes, 0);
  const std::string problems = sculptor.Status()["problems"].dump();
  EXPECT_NE(problems.find("the scene's file has changed since"), std::string::npos) << problems;
  const std::vector<std::string> paths = scene::JournalsIn(sculptor.journals());
  ASSERT_EQ(paths.size(), 1U);
  EXPECT_NE(paths[0].find(".changed.journal"), std::string::npos);
  EXPECT_GT(scene::ReadJournal(paths[0])->strokes(), 0U);
}

TEST(ProcessSculptCrash, SecondSessionKeepsItsStrokesApart) {
  Sculptor sculptor;
  sculptor.Start();
  SculptSome(sculptor);
  const auto first = sculptor.Begin();
  const int strokes = sculptor.strokes;
  TestApplication second(sculptor.service);
  ASSERT_TRUE(second.Run(5000, 5, [&] { return second.connection().connected(); }));
  ASSERT_TRUE(second.connection().SendSession(protocol::SessionState::kBegun));
  EXPECT_TRUE(second.Run(5000, 20, [&] {
    return sculptor.Status()["problems"].dump().find("another session sculpts it too") != std::string::npos;
  }));
  std::vector<std::string> clients;
  EXPECT_TRUE(second.Run(5000, 20, [&] { return (clients = sculptor.ClientsWithScene()).size() == 2; }));
  ASSERT_EQ(clients.size(), 2U);
  ASSERT_TRUE(sculptor.Edits({"--client", clients[0]}));
  EXPECT_EQ(sculptor.strokes, strokes);
  ASSERT_TRUE(sculptor.Edits({"--client", clients[1]}));
  EXPECT_EQ(sculptor.strokes, 0);
}

TEST(ProcessSculptCrash, SculptingGoesOnWhereNothingCanBeKept) {
  Sculptor sculptor;
  fs::create_directories(sculptor.service.state_folder() + "/omni");
  std::ofstream(sculptor.journals()) << "a file in its place";
  sculptor.Start();
  SculptSome(sculptor);
  EXPECT_GT(sculptor.strokes, 0);
  const auto app = sculptor.Begin();
  const std::string log = BytesOf(sculptor.log());
  EXPECT_NE(log.find("strokes are not kept: " + sculptor.journals() + ": is not a folder"), std::string::npos) << log;
  EXPECT_EQ(sculptor.service.Stop(), 0);
}

}  // namespace test_process_sculpt_crash
}  // namespace omni::test
