// Scenes and soft bodies by processes of their own: the same bits as in this process, cancelled at once, limited, and
// other clients undisturbed whatever becomes of one of them.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>

#include "service/base/sanitized.h"
#include "service/daemon/scenes/child_builder.h"
#include "service/daemon/scenes/scene_builder.h"
#include "service/haptics/live/live_parts.h"
#include "service/scene/cache/cache_store.h"
#include "tests/builder/scene_builder_test.h"
#include "tests/haptics/scenario.h"
#include "tests/scene/compressed.h"
#include "tests/support/mesh_bombs.h"

namespace omni::daemon {
namespace test_builder_child {

namespace fs = std::filesystem;

constexpr std::uint32_t kCoarse = 150;
constexpr std::uint32_t kForever = 4000;

std::shared_ptr<const BuildWay> Children() {
  return std::make_shared<const ChildBuilder>(OMNI_BINARY_DIR "/bin/omni-builder");
}

// Processes of ours that build, by their threads' children [proc(5)]; one that is being started is none yet: stopped by
// a signal there, it would hold up who starts it.
std::set<pid_t> RunningBuilders() {
  std::set<pid_t> all;
  std::error_code gone;
  for (const auto& thread : fs::directory_iterator("/proc/self/task", gone)) {
    std::ifstream children(thread.path() / "children");
    for (pid_t child = 0; children >> child;) {
      std::string state;
      std::ifstream stat("/proc/" + std::to_string(child) + "/stat");
      std::getline(stat, state);
      if (state.find("(omni-builder)") != std::string::npos && state.find(") Z") == std::string::npos)
        all.insert(child);
    }
  }
  return all;
}

class ChildBuilderTest : public SceneBuilderTest {
 protected:
  // The one builder that runs now.
  static pid_t Running() {
    pid_t pid = -1;
    EXPECT_TRUE(Soon([&] {
      const std::set<pid_t> running = RunningBuilders();
      pid = running.empty() ? -1 : *running.begin();
      return running.size() == 1;
    }));
    return pid;
  }
};

bool Same(const haptics::Scene& a, const haptics::Scene& b) {
  return std::equal(a.block().begin(), a.block().end(), b.block().begin(), b.block().end());
}

TEST_F(ChildBuilderTest, BuildsTheSameBitsAndReports) {
  const config::AppEntry app = Rigid("same", 60);
  SceneBuilder here({}), child({.way = Children()});
  for (const char* scene : {app.scene.c_str(), OMNI_SOURCE_DIR "/scenes/extrusion.glb",
                            OMNI_SOURCE_DIR "/scenes/racetrack.glb", OMNI_SOURCE_DIR "/scenes/dragon.glb"}) {
    config::AppEntry of = app;
    of.scene = scene;
    here.Request(1, of);
    child.Request(1, of);
    const BuiltScene a = Result(here), b = Result(child);
    ASSERT_NE(a.scene, nullptr) << a.error;
    ASSERT_NE(b.scene, nullptr) << b.error;
    EXPECT_TRUE(Same(*a.scene, *b.scene)) << scene;
    EXPECT_EQ(a.warnings, b.warnings);
    EXPECT_EQ(a.report.lines, b.report.lines);
    EXPECT_EQ(a.load.objects.size(), b.load.objects.size());
    EXPECT_EQ(a.load.bytes_read, b.load.bytes_read);
    EXPECT_EQ(a.load.fit_scale, b.load.fit_scale);
  }
}

// What they are decoded by may do nothing but build, in the memory that the document was granted.
TEST_F(ChildBuilderTest, CompressedMeshesAreDecodedThere) {
  using namespace scene::test;
  const auto soup = test::meshes::CleanBall(60'000);
  std::string positions;
  for (const base::Vec3& p : soup.vertices_base_m) {
    for (const double c : {p.x, p.z, -p.y}) positions += Bytes(std::vector<float>{static_cast<float>(c)});
  }
  std::vector<unsigned> corners;
  for (const auto& triangle : soup.triangles) corners.insert(corners.end(), triangle.begin(), triangle.end());
  const std::size_t vertices = soup.vertices_base_m.size();
  Model meshopt = MeshoptTetra(true, 4);
  meshopt.json["accessors"][0]["count"] = vertices;
  meshopt.json["accessors"][1]["count"] = corners.size();
  Model edgebreaker = meshopt, sequential = meshopt;
  meshopt.bin.clear();
  Compress(meshopt, 0, MeshoptVertices(positions, 12), vertices, 12, "ATTRIBUTES");
  Compress(meshopt, 1, MeshoptIndices(corners, true), corners.size(), 4, "TRIANGLES");
  const std::vector<DracoAttribute> attributes{
      {"POSITION", draco::GeometryAttribute::POSITION, draco::DT_FLOAT32, 3, positions}};
  UseDraco(edgebreaker, EncodeDraco(soup.triangles, vertices, attributes, true, 14), attributes);
  UseDraco(sequential, EncodeDraco(soup.triangles, vertices, attributes, false), attributes);
  SceneBuilder here({}), child({.way = Children()});
  for (const Model& model : {MeshoptTetra(), DracoTetra(true), DracoTetra(false), meshopt, edgebreaker, sequential}) {
    config::AppEntry app;
    app.scene = folder_.Write("compressed.glb", model.Bytes());
    app.touch = config::Touch::kAll;
    here.Request(1, app);
    child.Request(1, app);
    const BuiltScene a = Result(here), b = Result(child);
    ASSERT_NE(a.scene, nullptr) << a.error;
    ASSERT_NE(b.scene, nullptr) << b.error;
    EXPECT_TRUE(Same(*a.scene, *b.scene));
  }
  Model damaged = DracoTetra(true);
  damaged.json["bufferViews"].back()["byteLength"] = 30;
  config::AppEntry app;
  app.scene = folder_.Write("damaged.glb", damaged.Bytes());
  app.touch = config::Touch::kAll;
  child.Request(1, app);
  EXPECT_NE(Result(child).error.find("KHR_draco_mesh_compression: its data cannot be decoded"), std::string::npos);
}

TEST_F(ChildBuilderTest, TheAxisThatIsUpReachesTheBuilder) {
  config::AppEntry app = Rigid("turned");
  SceneBuilder here({}), child({.way = Children()});
  child.Request(1, app);
  const BuiltScene upright = Result(child);
  app.up = config::Up::kZ;
  here.Request(1, app);
  child.Request(1, app);
  const BuiltScene a = Result(here), b = Result(child);
  ASSERT_TRUE(a.scene != nullptr && b.scene != nullptr && upright.scene != nullptr) << a.error << b.error;
  EXPECT_TRUE(Same(*a.scene, *b.scene));
  EXPECT_FALSE(Same(*upright.scene, *b.scene));
}

TEST_F(ChildBuilderTest, TagsByNameReachTheBuilder) {
  config::AppEntry app;
  app.scene = folder_.Write("plain.glb", scene::test::Tetra().Bytes());
  app.tags = R"({"tetra": {"stiffness": 321}})";
  SceneBuilder builder({.way = Children()});
  builder.Request(1, app);
  const BuiltScene built = Result(builder);
  ASSERT_NE(built.scene, nullptr) << built.error;
  ASSERT_EQ(built.scene->objects().size(), 1U);
  EXPECT_EQ(built.scene->materials()[0].stiffness_N_m, 321);
}

TEST_F(ChildBuilderTest, SoftBodiesAreTheSameAndTheCacheIsOmnids) {
  const config::AppEntry app = Soft("soft");
  const std::string cache = folder_.Path("cache");
  std::vector<std::byte> first;
  for (const bool child : {true, false}) {
    SceneBuilder builder({.cache_folder = child ? cache : "",
                          .soft_tets = kCoarse,
                          .way = child ? Children() : std::make_shared<const BuildHere>()});
    builder.Request(1, app);
    const BuiltScene built = Result(builder);
    ASSERT_NE(built.scene, nullptr) << built.error;
    EXPECT_EQ(Outcome(builder).error, "");
    const auto bytes = built.scene->live()->soft_body(0)->bytes();
    if (first.empty()) first.assign(bytes.begin(), bytes.end());
    EXPECT_TRUE(std::equal(bytes.begin(), bytes.end(), first.begin(), first.end()));
  }
  EXPECT_EQ(scene::CacheStore(cache).Usage().files, 1U);
  SceneBuilder again({.cache_folder = cache, .soft_tets = kCoarse, .way = Children()});
  again.Request(1, app);
  ASSERT_NE(Result(again).scene, nullptr);
  EXPECT_TRUE(Outcome(again).report.cached);
}

// As the service builds it: what it was granted is enough.
TEST_F(ChildBuilderTest, AWholeSoftBodyFitsIntoItsGrant) {
  SceneBuilder builder({.way = Children()});
  config::AppEntry app;
  app.scene = OMNI_SOURCE_DIR "/scenes/dragon.glb";
  builder.Request(1, app);
  ASSERT_NE(Result(builder).scene, nullptr);
  EXPECT_GT(builder.Progress(1).objects, 0U);
  EXPECT_EQ(Outcome(builder).error, "");
}

TEST_F(ChildBuilderTest, ACachedSceneIsNotBuiltAgain) {
  const config::AppEntry app = Rigid("cached", 60);
  for (const bool cached : {false, true}) {
    SceneBuilder builder({.cache_folder = folder_.Path("cache"), .way = Children()});
    builder.Request(1, app);
    const BuiltScene built = Result(builder);
    ASSERT_NE(built.scene, nullptr) << built.error;
    EXPECT_EQ(built.load.cached, cached) << built.load.cache;
  }
}

TEST_F(ChildBuilderTest, ErrorsAreThoseOfTheFile) {
  SceneBuilder here({}), child({.way = Children()});
  config::AppEntry app;
  for (const auto& [name, text] :
       {std::pair("no.gltf", "not a scene"), std::pair("v1.gltf", R"({"asset": {"version": "1.0"}})"),
        std::pair("outside.gltf", R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0,
      "extras": {"haptic": true}}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "accessors": [{"bufferView": 0,
      "componentType": 5126, "count": 3, "type": "VEC3"}], "bufferViews": [{"buffer": 0, "byteLength": 36}],
      "buffers": [{"byteLength": 36, "uri": "../../etc/passwd"}]})")}) {
    app.scene = folder_.Write(name, text);
    here.Request(1, app);
    child.Request(1, app);
    const BuiltScene a = Result(here), b = Result(child);
    EXPECT_EQ(a.scene, nullptr);
    EXPECT_EQ(a.error, b.error);
    EXPECT_NE(a.error, "");
  }
}

TEST_F(ChildBuilderTest, ReadsFilesBesideTheDocument) {
  const std::string document = R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0,
      "extras": {"haptic": true}}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "accessors": [{"bufferView": 0,
      "componentType": 5126, "count": 3, "type": "VEC3"}], "bufferViews": [{"buffer": 0, "byteLength": 36}],
      "buffers": [{"byteLength": 36, "uri": "corners.bin"}]})";
  config::AppEntry app;
  app.scene = folder_.Write("beside.gltf", document);
  SceneBuilder builder({.way = Children()});
  builder.Request(1, app);
  const BuiltScene missing = Result(builder);
  EXPECT_NE(missing.error.find("corners.bin cannot be opened (No such file or directory)"), std::string::npos)
      << missing.error;
  const float corners[] = {0, 0.05F, 0, 0.01F, 0.05F, 0, 0, 0.05F, 0.01F};
  folder_.Write("corners.bin", std::string(reinterpret_cast<const char*>(corners), sizeof corners));
  builder.Request(1, app);
  const BuiltScene built = Result(builder);
  ASSERT_NE(built.scene, nullptr) << built.error;
  EXPECT_EQ(built.scene->header().triangle_count, 1U);
  fs::remove(folder_.Path("corners.bin"));
  fs::create_symlink("/etc/passwd", folder_.Path("corners.bin"));
  builder.Request(1, app);
  EXPECT_NE(Result(builder).error.find("corners.bin cannot be opened"), std::string::npos) << "a link is not followed";
}

TEST_F(ChildBuilderTest, ReadsFilesInFoldersBesideTheDocumentAndNoneThroughLinks) {
  const auto document = [&](const std::string& uri) {
    config::AppEntry app;
    app.scene = folder_.Write("beneath.gltf", R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}],
      "nodes": [{"mesh": 0, "extras": {"haptic": true}}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
      "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
      "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"byteLength": 36, "uri": ")" +
                                                  uri + R"("}]})");
    return app;
  };
  const float corners[] = {0, 0.05F, 0, 0.01F, 0.05F, 0, 0, 0.05F, 0.01F};
  const std::string bytes(reinterpret_cast<const char*>(corners), sizeof corners);
  fs::create_directories(folder_.Path("sub/deep"));
  folder_.Write("sub/deep/corners.bin", bytes);
  SceneBuilder builder({.way = Children()});
  builder.Request(1, document("sub/deep/corners.bin"));
  const BuiltScene built = Result(builder);
  ASSERT_NE(built.scene, nullptr) << built.error;
  EXPECT_EQ(built.scene->header().triangle_count, 1U);
  const test::TempFolder elsewhere;
  elsewhere.Write("corners.bin", bytes);
  fs::create_directory_symlink(elsewhere.Path(), folder_.Path("sub/out"));
  builder.Request(1, document("sub/out/corners.bin"));
  EXPECT_NE(Result(builder).error.find("\"out\" is a link, which is not followed"), std::string::npos);
}

TEST_F(ChildBuilderTest, ALongBuildHoldsUpNobody) {
  SceneBuilder builder({.soft_tets = kForever, .way = Children(), .limits = {.builders = 3}});
  builder.Request(1, Soft("slow"));
  ASSERT_EQ(Result(builder).client, 1U);
  const pid_t slow = Running();
  kill(slow, SIGSTOP);
  for (std::uint64_t client = 2; client < 6; ++client) {
    builder.Request(client, Rigid("quick"));
    EXPECT_EQ(Result(builder).client, client);
  }
  EXPECT_EQ(Running(), slow);
  kill(slow, SIGCONT);
}

TEST_F(ChildBuilderTest, CancelEndsTheProcess) {
  const std::size_t files = OpenFiles();
  {
    SceneBuilder builder({.soft_tets = kForever, .way = Children()});
    const std::uint64_t before = builder.Status().kept_bytes;
    builder.Request(1, Soft("slow"));
    ASSERT_NE(Result(builder).scene, nullptr);
    const pid_t pid = Running();
    kill(pid, SIGSTOP);  // nor does it have to agree
    builder.Cancel(1);
    EXPECT_TRUE(Soon([&] { return kill(pid, 0) != 0; }));
    EXPECT_TRUE(Soon([&] { return builder.Status().rows.empty() && builder.Status().kept_bytes == before; }));
    // Another request of the same client does, too.
    builder.Request(1, Soft("slow"));
    ASSERT_NE(Result(builder).scene, nullptr);
    const pid_t second = Running();
    builder.Request(1, Rigid("rigid"));
    EXPECT_EQ(Result(builder).scene->live(), nullptr);
    EXPECT_TRUE(Soon([&] { return kill(second, 0) != 0; }));
  }
  EXPECT_TRUE(Soon([&] { return OpenFiles() == files; }));
}

TEST_F(ChildBuilderTest, TheEndIsNotHeldUp) {
  auto builder = std::make_unique<SceneBuilder>(BuilderOptions{.soft_tets = kForever, .way = Children()});
  builder->Request(1, Soft("slow"));
  ASSERT_NE(Result(*builder).scene, nullptr);
  const pid_t pid = Running();
  builder.reset();
  EXPECT_TRUE(Soon([&] { return kill(pid, 0) != 0; }));
}

// Each way to end, said in words; the other client does not notice.
TEST_F(ChildBuilderTest, SaysHowItEnded) {
  struct Case {
    int signal;
    const char* words;
  };
  SceneBuilder builder({.soft_tets = kForever, .way = Children()});
  for (const Case& row : {Case{SIGKILL, "was killed"}, Case{SIGSEGV, "crashed"}, Case{SIGSYS, "may not make"}}) {
    builder.Request(1, Soft("slow"));
    ASSERT_NE(Result(builder).scene, nullptr);
    kill(Running(), row.signal);
    const SoftOutcome outcome = Outcome(builder);
    EXPECT_NE(outcome.error.find(row.words), std::string::npos) << outcome.error;
    builder.Request(2, Rigid("other"));
    EXPECT_NE(Result(builder).scene, nullptr);
  }
}

TEST_F(ChildBuilderTest, SaysThatMemoryWasNotEnough) {
  if (base::kSanitized) GTEST_SKIP() << "a sanitizer reserves terabytes, so that there is no limit of addresses";
  SceneBuilder builder({.soft_tets = kForever, .way = Children()});
  builder.Request(1, Soft("slow"));
  ASSERT_NE(Result(builder).scene, nullptr);
  const pid_t pid = Running();
  rlimit granted{};
  EXPECT_TRUE(Soon([&] { return prlimit(pid, RLIMIT_AS, nullptr, &granted) == 0 && granted.rlim_cur < 400'000'000; }));
  ASSERT_TRUE(Soon([&] { return builder.Progress(1).done > 0; }));
  std::size_t pages = 0;
  std::ifstream("/proc/" + std::to_string(pid) + "/statm") >> pages;
  const rlimit no_more{pages * 4096 + 200'000, RLIM_INFINITY};
  ASSERT_EQ(prlimit(pid, RLIMIT_AS, &no_more, nullptr), 0);
  const SoftOutcome outcome = Outcome(builder);
  EXPECT_NE(outcome.error.find("does not fit into the"), std::string::npos) << outcome.error;
}

TEST_F(ChildBuilderTest, IsTheFirstToGoAndLeavesTheProcessorToOthers) {
  SceneBuilder builder({.soft_tets = kForever, .way = Children()});
  builder.Request(1, Soft("slow"));
  ASSERT_NE(Result(builder).scene, nullptr);
  const pid_t pid = Running();
  const auto line = [pid](const std::string& file, const std::string& key) {
    std::ifstream stream("/proc/" + std::to_string(pid) + "/" + file);
    for (std::string text; std::getline(stream, text);) {
      if (text.starts_with(key)) return text.substr(key.size());
    }
    return std::string();
  };
  EXPECT_TRUE(Soon([&] { return line("oom_score_adj", "") == "1000"; }));
  if (!base::kSanitized) {  // sanitizers make system calls of their own
    EXPECT_TRUE(Soon([&] { return line("status", "Seccomp:\t") == "2"; }));
  }
  EXPECT_EQ(line("status", "NoNewPrivs:\t"), "1");
  EXPECT_EQ(line("environ", ""), "");
  EXPECT_GE(getpriority(PRIO_PROCESS, static_cast<id_t>(pid)), 5);
}

TEST_F(ChildBuilderTest, AMissingProgramIsSaid) {
  const ChildBuilder none(folder_.Path("omni-builder"));
  ASSERT_FALSE(none.CheckProgram().ok());
  EXPECT_NE(none.CheckProgram().error().find("No such file or directory; scenes are refused"), std::string::npos);
  SceneBuilder refused({.way = Children(), .refused = none.CheckProgram().error()});
  refused.Request(1, Rigid("rigid"));
  EXPECT_NE(Result(refused).error.find("install"), std::string::npos);
  SceneBuilder builder({.way = std::make_shared<const ChildBuilder>(folder_.Path("omni-builder"))});
  builder.Request(1, Rigid("rigid"));
  EXPECT_NE(Result(builder).error.find("cannot be started: No such file"), std::string::npos);
}

// What waits for memory says so, and is built when there is some.
TEST_F(ChildBuilderTest, WaitsForMemoryInWords) {
  SceneBuilder builder({.way = Children(), .limits = {.kept_bytes = 3 * kMB, .builders = 2}});
  const config::AppEntry app = Rigid("ball", 40);  // 19,200 triangles: 1 MB, and 2 MB at most
  builder.Request(1, app);
  BuiltScene first = Result(builder);
  ASSERT_NE(first.scene, nullptr) << first.error;
  builder.Request(2, app);
  BuiltScene second = Result(builder);
  builder.Request(3, app);
  std::optional<BuilderNote> note;
  ASSERT_TRUE(Soon([&] { return (note = builder.PopNote()).has_value(); }));
  EXPECT_EQ(note->client, 3U);
  EXPECT_NE(note->text.find("waits for memory: needs 2 MB"), std::string::npos) << note->text;
  ASSERT_EQ(builder.Status().rows.size(), 1U);
  EXPECT_NE(builder.Status().rows[0].state.find("waits for memory"), std::string::npos);
  EXPECT_FALSE(builder.PopResult());
  first.scene.reset();
  EXPECT_EQ(Result(builder).client, 3U);
}

TEST_F(ChildBuilderTest, RefusesWhatAClientMayNotKeep) {
  SceneBuilder builder({.way = Children(), .limits = {.client_bytes = 1 * kMB}});
  builder.Request(1, Rigid("ball", 40));
  const BuiltScene built = Result(builder);
  EXPECT_EQ(built.scene, nullptr);
  EXPECT_NE(built.error.find("a client may have 1 MB of built scenes"), std::string::npos) << built.error;
}

}  // namespace test_builder_child
}  // namespace omni::daemon
