// Cost of hostile documents: time until each is refused (or loaded), and memory, for `omni scene explain` and for omnid
// while another application draws. Prints a table; run by scripts/bombs.
//   omni_bench_bombs [--bin FOLDER] [--bytes N] [--limit SECONDS] [--giants N]
//   omni_bench_bombs --geometry | --cancel [--triangles N] [--json FILE] [--bin FOLDER] [--limit SECONDS]
// --giants: instead, so many legal scenes of 3.9 million triangles at once.
// --geometry: instead, meshes that cost as much as they can (default: 32,000, 100,000 and 500,000 triangles); --cancel:
// how soon their builds end (default: 100,000).
// --bin: folder of omni and omnid, possibly of another build (default: that of this program).
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "tests/bench/bombs/geometry.h"
#include "tests/bench/bombs/giants.h"
#include "tests/bench/bombs/measure.h"
#include "tests/bench/harness/work_folder.h"
#include "tests/scene/stream_bombs.h"
#include "tests/support/bombs.h"

namespace omni::bombs {
namespace {

namespace fs = std::filesystem;

struct Options {
  fs::path bin = fs::read_symlink("/proc/self/exe").parent_path();
  std::size_t bytes = 3'000'000;
  double limit_s = 20;
  int giants = 0;
  bool geometry = false, cancel = false;
  std::vector<std::size_t> triangles;
  fs::path json;
};

void Write(const fs::path& path, const std::string& text) {
  fs::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << text;
}

struct NamedText {
  std::string name, text;
};

// A document in a file: none is kept in memory, where it would count as memory of the measured commands.
struct SceneFile {
  std::string name, path;
};

std::vector<SceneFile> WriteScenes(std::size_t bytes, const fs::path& folder) {
  std::vector<SceneFile> scenes;
  const auto add = [&](const std::string& name, const std::string& text) {
    const fs::path file = folder / ("bomb-" + std::to_string(scenes.size()) + ".gltf");
    Write(file, text);
    scenes.push_back({name, file.string()});
  };
  for (const test::Bomb& bomb : test::kSceneBombs) add(bomb.name, bomb.make(bytes));
  for (const test::Bomb& bomb : scene::test::kStreamBombs) add(bomb.name, bomb.make(bytes));
  add("empty texts, 16 times as many", test::kSceneBombs[2].make(16 * bytes));
  add("100,000 honest nodes", test::bombs::HonestNodes());
  return scenes;
}

std::string Read(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// A service with an artist, restarted whenever a bomb ended it.
class Studio {
 public:
  Studio(const Options& options, const fs::path& folder) : omnid_((options.bin / "omnid").string(), folder.string()) {}

  Omnid* Open() {
    if (omnid_.Lives()) return &omnid_;
    artist_.reset();
    if (!omnid_.Start()) return nullptr;
    artist_ = std::make_unique<Artist>(omnid_.socket_path(), "artist");
    const std::uint64_t drawing = 90;
    for (int i = 0; i < 200 && artist_->frames() < drawing; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    return artist_->frames() < drawing ? nullptr : &omnid_;
  }
  Omnid& omnid() { return omnid_; }
  Artist& artist() { return *artist_; }

 private:
  Omnid omnid_;
  std::unique_ptr<Artist> artist_;
};

// Frames that the artist saw during a step.
struct Drawn {
  double seconds = 0;
  std::uint64_t frames = 0;
  double pause_ms = 0;  // the longest between two frames

  void Add(const Drawn& other) {
    seconds += other.seconds;
    frames += other.frames;
    pause_ms = std::max(pause_ms, other.pause_ms);
  }
  double rate_Hz() const { return static_cast<double>(frames) / seconds; }
};

template <class Work>
Drawn WhileDrawing(Artist& artist, Work work) {
  artist.LongestPause_ms();
  const std::uint64_t before = artist.frames();
  const auto start = std::chrono::steady_clock::now();
  work();
  return {std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), artist.frames() - before,
          artist.LongestPause_ms()};
}

std::string Text(const Cost& cost) {
  char text[64];
  std::snprintf(text, sizeof text, "%-8s %6.2f s %5.0f MB", cost.end.c_str(), cost.seconds, cost.memory_MB);
  return text;
}

// Entries for the artist, who draws clay, and for the applications bomb-0, bomb-1, ...
void WriteEntries(const std::vector<SceneFile>& scenes, const fs::path& clay, const fs::path& folder) {
  const auto write = [&](const std::string& application, const std::string& scene) {
    Write(folder / (application + ".toml"),
          "application = \"" + application + "\"\nscene = \"" + scene + "\"\ntouch = \"all\"\n");
  };
  write("artist", clay.string());
  for (std::size_t i = 0; i < scenes.size(); ++i) write("bomb-" + std::to_string(i), scenes[i].path);
}

// One row of the table. Frames drawn meanwhile are added to `all`.
void RunScene(const Options& options, const SceneFile& scene, std::size_t number, Studio& studio, Drawn& all) {
  const std::string omni = (options.bin / "omni").string();
  const Cost command = RunCommand({omni, "scene", "explain", "--touch-all", "--no-cache", scene.path}, options.limit_s);
  Cost entry{.end = "no omnid"}, document{.end = "no omnid"};
  Drawn drawn;
  if (Omnid* omnid = studio.Open()) {
    drawn.Add(WhileDrawing(studio.artist(),
                           [&] { entry = LoadByEntry(*omnid, "bomb-" + std::to_string(number), options.limit_s); }));
  }
  if (Omnid* omnid = studio.Open()) {
    const std::string text = Read(scene.path);
    drawn.Add(
        WhileDrawing(studio.artist(), [&] { document = LoadByDocument(*omnid, "document", text, options.limit_s); }));
  }
  std::printf("%-38s %8zu  %-26s %-26s %-26s %3.0f Hz, %.0f ms\n", scene.name.c_str(),
              static_cast<std::size_t>(fs::file_size(scene.path)), Text(command).c_str(), Text(entry).c_str(),
              Text(document).c_str(), drawn.rate_Hz(), drawn.pause_ms);
  std::fflush(stdout);
  all.Add(drawn);
}

bool RunScenes(const Options& options, const fs::path& folder) {
  const std::vector<SceneFile> scenes = WriteScenes(options.bytes, folder);
  WriteEntries(scenes, options.bin.parent_path() / "share/omni/scenes/extrusion.glb", folder / "config/omni/apps.d");
  Studio studio(options, folder);
  if (studio.Open() == nullptr) return false;
  const Drawn undisturbed =
      WhileDrawing(studio.artist(), [] { std::this_thread::sleep_for(std::chrono::seconds(10)); });
  std::printf("omnid before: %.0f MB\n\n%-38s %8s  %-26s %-26s %-26s %s\n", studio.omnid().PeakMemory_MB(), "document",
              "bytes", "omni scene explain", "omnid, apps.d", "omnid, XR_OMNIX1", "drawn beside it, longest pause");
  Drawn all;
  for (std::size_t i = 0; i < scenes.size(); ++i) RunScene(options, scenes[i], i, studio, all);
  std::printf("\ndrawn: undisturbed %.1f Hz, longest pause %.0f ms; beside all of these %.1f Hz, %.0f ms\n",
              undisturbed.rate_Hz(), undisturbed.pause_ms, all.rate_Hz(), all.pause_ms);
  return true;
}

// Nested settings: each in every user file that omnid reads.
void RunSettings(const Options& options, const fs::path& folder) {
  std::string dotted = "a", arrays = "x = " + std::string(40'000, '[') + std::string(40'000, ']') + "\n";
  while (dotted.size() < 80'000) dotted += ".a";
  std::printf("\n%-40s %s\n", "settings, 80 kB", "omnid");
  for (const NamedText& text :
       {NamedText{"a key of 40,000 parts", dotted + " = 1\n"},
        NamedText{"a table of 40,000 parts", "[" + dotted + "]\n"}, NamedText{"arrays 40,000 deep", arrays}}) {
    for (const char* file :
         {"apps.d/bomb.toml", "inputs.toml", "alignments.toml", "magnets.toml", "calibration.toml"}) {
      const fs::path home = folder / "settings";
      fs::remove_all(home);
      Write(home / "config/omni" / file, text.text);
      Omnid omnid((options.bin / "omnid").string(), home.string());
      const bool answers = omnid.Start();
      std::printf("%-40s %-18s %s\n", text.name.c_str(), file, answers ? "serves" : omnid.end().c_str());
      omnid.Kill();
    }
  }
}

int Run(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    options.geometry = options.geometry || word == "--geometry";
    options.cancel = options.cancel || word == "--cancel";
    if (word == "--geometry" || word == "--cancel" || i + 1 == argc) continue;
    const char* const value = argv[++i];
    if (word == "--bin") options.bin = fs::absolute(value);
    if (word == "--bytes") options.bytes = std::strtoul(value, nullptr, 10);
    if (word == "--giants") options.giants = std::atoi(value);
    if (word == "--limit") options.limit_s = std::strtod(value, nullptr);
    if (word == "--triangles") options.triangles = {std::strtoul(value, nullptr, 10)};
    if (word == "--json") options.json = fs::absolute(value);
  }
  const bench::WorkFolder folder;
  if (options.giants > 0) return RunGiants(options.bin, folder.path(), options.giants, options.limit_s) ? 0 : 1;
  if (options.geometry || options.cancel) {
    GeometryOptions geometry{options.bin, folder.path(), options.json, options.triangles, options.limit_s};
    if (geometry.triangles.empty() && options.geometry) geometry.triangles = {32'000, 100'000, 500'000};
    if (geometry.triangles.empty()) geometry.triangles = {100'000};
    return (options.geometry ? RunGeometry(geometry) : RunCancels(geometry)) ? 0 : 1;
  }
  if (!RunScenes(options, folder.path())) {
    std::fprintf(stderr, "omnid does not start, or nothing is drawn: is %s built?\n", options.bin.c_str());
    return 1;
  }
  RunSettings(options, folder.path());
  return 0;
}

}  // namespace
}  // namespace omni::bombs

int main(int argc, char** argv) { return omni::bombs::Run(argc, argv); }
