#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include <nlohmann/json.hpp>

#include "service/base/clock.h"
#include "service/base/sealed_memory.h"
#include "service/base/work_watch.h"
#include "service/client/connection.h"
#include "service/scene/load_scene.h"
#include "tests/bench/bombs/geometry.h"
#include "tests/bench/bombs/measure.h"
#include "tests/support/mesh_bombs.h"

namespace omni::bombs {
namespace {

namespace fs = std::filesystem;

constexpr int kCancelsOfEach = 15;            // more than 200 of all together
constexpr std::size_t kSmallTriangles = 400;  // of what another client requests

double MsSince(std::int64_t start_ns) { return 1e-6 * static_cast<double>(base::MonotonicNow_ns() - start_ns); }
void Sleep(double ms) { std::this_thread::sleep_for(std::chrono::duration<double, std::milli>(ms)); }

int BuildersOf(pid_t pid) {
  int builders = 0;
  std::error_code gone;
  for (const auto& thread : fs::directory_iterator("/proc/" + std::to_string(pid) + "/task", gone)) {
    std::ifstream children(thread.path() / "children");
    for (pid_t child = 0; children >> child;) {
      std::string name;
      std::getline(std::ifstream("/proc/" + std::to_string(child) + "/comm"), name);
      builders += name == "omni-builder";
    }
  }
  return builders;
}

// An application with a document of its own.
class Author {
 public:
  Author(const Omnid& omnid, const std::string& name)
      : connection_({.application = name, .engine = "", .socket_path = omnid.socket_path()}) {}

  bool Connect() {
    for (int i = 0; i < 2000 && !connection_.connected(); ++i, Sleep(1)) Poll();
    return connection_.connected();
  }
  void Request(const base::UniqueFd& document, std::size_t bytes) {
    protocol::HapticSceneLoad load;
    load.number = ++number_;
    load.bytes = bytes;
    load.flags = protocol::kSceneTouchUntagged;
    connection_.Send(load, document.get());
  }
  // Whether the document that was requested last is there, or refused.
  bool Poll() {
    connection_.Poll(base::MonotonicNow_ns());
    connection_.SignalAlive();
    for (const client::HapticSceneUpdate& update : connection_.PopHapticSceneUpdates()) {
      if (update.is_table || update.state.number != number_) continue;
      refused_ = refused_ || update.state.status == protocol::HapticSceneStatus::kFailed;
      if (refused_ || update.state.status == protocol::HapticSceneStatus::kReady) ended_ = number_;
    }
    return ended_ == number_;
  }
  bool refused() const { return refused_; }

 private:
  client::Connection connection_;
  std::uint32_t number_ = 0, ended_ = 0;
  bool refused_ = false;
};

struct Document {
  base::UniqueFd memory;
  std::size_t bytes = 0;
  explicit Document(const std::string& text) : bytes(text.size()) {
    auto copy = base::SealedCopy("mesh", text);
    if (copy.ok()) memory = std::move(*copy);
  }
};

// Until the build of `document` has ended, ms; -1: it was refused, or takes too long.
double BuildTime_ms(const Omnid& omnid, const Document& document, double limit_s) {
  Author author(omnid, "author");
  if (!author.Connect()) return -1;
  const std::int64_t start_ns = base::MonotonicNow_ns();
  author.Request(document.memory, document.bytes);
  while (!author.Poll() && MsSince(start_ns) < 1000 * limit_s) Sleep(1);
  return author.Poll() && !author.refused() ? MsSince(start_ns) : -1;
}

// A client that ends after `after_ms`: until its builder is gone, ms; -1: it had none any more.
double CancelByClient_ms(const Omnid& omnid, const Document& document, double after_ms, double limit_s) {
  auto author = std::make_unique<Author>(omnid, "author");
  if (!author->Connect()) return -1;
  std::int64_t start_ns = base::MonotonicNow_ns();
  author->Request(document.memory, document.bytes);
  while (MsSince(start_ns) < after_ms) {
    author->Poll();
    Sleep(0.2);
  }
  if (BuildersOf(omnid.pid()) == 0) return -1;
  start_ns = base::MonotonicNow_ns();
  author.reset();
  while (BuildersOf(omnid.pid()) > 0 && MsSince(start_ns) < 1000 * limit_s) Sleep(0.1);
  return MsSince(start_ns);
}

// The same in this process. `after_ms` < 0: never, and the result is the time of the whole load.
double CancelInProcess_ms(const fs::path& path, double after_ms) {
  std::atomic<bool> stop = false;
  std::atomic<std::int64_t> ended_ns = 0;
  const std::int64_t start_ns = base::MonotonicNow_ns();
  bool cancelled = false;
  std::thread load([&] {
    const base::WorkWatch watch([&] { return stop.load(std::memory_order_relaxed); });
    scene::LoadReport report;
    haptics::BuildReport build;
    cancelled = !scene::LoadScene(path.string(), {.watch = &watch}, nullptr, report, build).ok();
    ended_ns = base::MonotonicNow_ns();
  });
  std::int64_t stop_ns = start_ns;
  if (after_ms >= 0) {
    Sleep(after_ms);
    stop_ns = base::MonotonicNow_ns();
    stop = true;
  }
  load.join();
  if (after_ms >= 0 && !cancelled) return -1;  // it was faster
  return 1e-6 * static_cast<double>(ended_ns - stop_ns);
}

// Requests for a small scene, one after the other, until the large one has been built: the longest wait, ms, and how
// many there were.
std::pair<double, int> LongestWait_ms(const Omnid& omnid, const Document& large, const Document& small,
                                      double limit_s) {
  Author author(omnid, "author"), other(omnid, "other");
  if (!author.Connect() || !other.Connect()) return {-1, 0};
  const std::int64_t start_ns = base::MonotonicNow_ns();
  author.Request(large.memory, large.bytes);
  double longest_ms = 0;
  int waits = 0;
  while (!author.Poll() && MsSince(start_ns) < 1000 * limit_s) {
    const std::int64_t asked_ns = base::MonotonicNow_ns();
    other.Request(small.memory, small.bytes);
    while (!other.Poll() && MsSince(asked_ns) < 1000 * limit_s) {
      author.Poll();
      Sleep(0.5);
    }
    longest_ms = std::max(longest_ms, MsSince(asked_ns));
    ++waits;
  }
  return {longest_ms, waits};
}

// Prints and keeps the row of all cancels of one kind.
void Report(const char* way, std::vector<double> ms, int missed, nlohmann::json& rows) {
  std::sort(ms.begin(), ms.end());
  const auto at = [&](double share) {
    if (ms.empty()) return 0.0;
    const double rank = std::ceil(share * static_cast<double>(ms.size()));
    return ms[static_cast<std::size_t>(std::max(rank, 1.0)) - 1];
  };
  std::printf("%-26s %4zu cancels (%d more came too late): p50 %.2f ms, p99 %.2f ms, max %.2f ms\n", way, ms.size(),
              missed, at(0.5), at(0.99), at(1));
  rows.push_back({{"kind", "cancel"},
                  {"way", way},
                  {"cancels", ms.size()},
                  {"too_late", missed},
                  {"p50_ms", at(0.5)},
                  {"p99_ms", at(0.99)},
                  {"max_ms", at(1)}});
}

}  // namespace

bool RunCancels(const GeometryOptions& options) {
  std::ofstream(options.folder / "cache") << "a file where the cache's folder would be: each request builds\n";
  Omnid omnid((options.bin / "omnid").string(), options.folder.string());
  if (!omnid.Start()) return false;
  const fs::path path = options.folder / "mesh.glb";
  const Document small(test::MeshFile(test::kCleanMesh.make(kSmallTriangles)));
  test::meshes::Dice dice;
  nlohmann::json rows = nlohmann::json::array();
  std::vector<double> by_client, in_process;
  int late_client = 0, late_process = 0;
  bool all = true;
  std::printf("%-26s %10s %12s %22s %6s\n", "builds", "by omnid", "in process", "longest wait of others", "of");
  for (const test::MeshBomb& bomb : test::kMeshBombs) {
    const std::string text = test::MeshFile(bomb.make(options.triangles.front()));
    std::ofstream(path, std::ios::binary) << text;
    const Document document(text);
    const double build_ms = BuildTime_ms(omnid, document, options.limit_s);
    const double load_ms = CancelInProcess_ms(path, -1);
    const auto [wait_ms, waits] = LongestWait_ms(omnid, document, small, options.limit_s);
    std::printf("%-26s %7.0f ms %9.0f ms %19.1f ms %6d\n", bomb.name, build_ms, load_ms, wait_ms, waits);
    std::fflush(stdout);
    rows.push_back({{"kind", "wait"},
                    {"mesh", bomb.name},
                    {"build_ms", build_ms},
                    {"load_ms", load_ms},
                    {"wait_ms", wait_ms},
                    {"waits", waits}});
    all = all && build_ms >= 0 && wait_ms >= 0 && omnid.Lives();
    for (int i = 0; i < kCancelsOfEach && build_ms >= 0; ++i) {
      const double client_ms = CancelByClient_ms(omnid, document, dice.Roll(0, build_ms), options.limit_s);
      const double process_ms = CancelInProcess_ms(path, dice.Roll(0, load_ms));
      if (client_ms >= 0) by_client.push_back(client_ms);
      if (process_ms >= 0) in_process.push_back(process_ms);
      late_client += client_ms < 0;
      late_process += process_ms < 0;
    }
  }
  Report("client of omnid ends", std::move(by_client), late_client, rows);
  Report("LoadScene in the process", std::move(in_process), late_process, rows);
  if (!options.json.empty()) std::ofstream(options.json) << rows.dump(1) << "\n";
  return all;
}

}  // namespace omni::bombs
