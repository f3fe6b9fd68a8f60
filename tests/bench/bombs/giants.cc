#include "tests/bench/bombs/giants.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "service/base/clock.h"
#include "service/client/connection.h"
#include "tests/bench/bombs/measure.h"

namespace omni::bombs {
namespace {

namespace fs = std::filesystem;

constexpr int kRings = 1396;  // 2 n (n - 1) triangles: 3.9 million

template <class T>
void Append(std::string& bytes, const std::vector<T>& values) {
  bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
}

// A closed ball of 3.9 million triangles as binary glTF, 50 mm above the centre.
void WriteGiant(const fs::path& path) {
  constexpr int n = kRings;
  std::vector<float> corners;
  std::vector<std::uint32_t> triangles;
  const auto at = [](int ring, int k) {
    if (ring == 0) return 0U;
    return ring == n ? static_cast<std::uint32_t>(1 + (n - 1) * n)
                     : static_cast<std::uint32_t>(1 + (ring - 1) * n + k % n);
  };
  for (int ring = 0; ring <= n; ++ring) {
    for (int k = 0; k < (ring == 0 || ring == n ? 1 : n); ++k) {
      const double u = std::acos(-1.0) * ring / n, v = 2 * std::acos(-1.0) * k / n;
      for (const double c : {std::sin(u) * std::cos(v), 2.5 + std::cos(u), std::sin(u) * std::sin(v)}) {
        corners.push_back(static_cast<float>(0.02 * c));
      }
    }
  }
  for (int ring = 0; ring < n; ++ring) {
    for (int k = 0; k < n; ++k) {
      if (ring + 1 < n) triangles.insert(triangles.end(), {at(ring, k), at(ring + 1, k + 1), at(ring + 1, k)});
      if (ring > 0) triangles.insert(triangles.end(), {at(ring, k), at(ring, k + 1), at(ring + 1, k + 1)});
    }
  }
  std::string bin;
  Append(bin, corners);
  const std::size_t corner_bytes = bin.size();
  Append(bin, triangles);
  char json[1024];
  std::snprintf(
      json, sizeof json,
      R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0,"name":"giant","extras":{"haptic":true}}],)"
      R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],"accessors":[{"bufferView":0,)"
      R"("componentType":5126,"count":%zu,"type":"VEC3"},{"bufferView":1,"componentType":5125,"count":%zu,)"
      R"("type":"SCALAR"}],"bufferViews":[{"buffer":0,"byteLength":%zu},{"buffer":0,"byteOffset":%zu,)"
      R"("byteLength":%zu}],"buffers":[{"byteLength":%zu}]})",
      corners.size() / 3, triangles.size(), corner_bytes, corner_bytes, bin.size() - corner_bytes, bin.size());
  std::string text = json;
  text.resize((text.size() + 3) / 4 * 4, ' ');
  const auto word = [](std::size_t value) {
    const auto number = static_cast<std::uint32_t>(value);
    return std::string(reinterpret_cast<const char*>(&number), sizeof number);
  };
  std::ofstream(path, std::ios::binary) << "glTF" << word(2) << word(12 + 8 + text.size() + 8 + bin.size())
                                        << word(text.size()) << "JSON" << text << word(bin.size())
                                        << std::string("BIN\0", 4) << bin;
}

double ResidentOf_MB(pid_t pid) {
  std::ifstream status("/proc/" + std::to_string(pid) + "/status");
  for (std::string line; std::getline(status, line);) {
    if (line.rfind("VmRSS:", 0) == 0) return std::stod(line.substr(6)) / 1024;
  }
  return 0;
}

struct Sum {
  double service_MB = 0, all_MB = 0;
  int children = 0;
};

// Of omnid and what it has started; shared pages count in each.
Sum MemoryOf(pid_t pid) {
  Sum sum{.service_MB = ResidentOf_MB(pid)};
  sum.all_MB = sum.service_MB;
  std::error_code gone;
  for (const auto& thread : fs::directory_iterator("/proc/" + std::to_string(pid) + "/task", gone)) {
    std::ifstream children(thread.path() / "children");
    for (pid_t child = 0; children >> child;) {
      sum.all_MB += ResidentOf_MB(child);
      ++sum.children;
    }
  }
  return sum;
}

// An application that waits for its scene.
class Owner {
 public:
  Owner(const Omnid& omnid, const std::string& name)
      : connection_({.application = name, .engine = "", .socket_path = omnid.socket_path()}) {}

  // Whether it has connected; begins its session then.
  bool Poll() {
    connection_.Poll(base::MonotonicNow_ns());
    connection_.SignalAlive();
    if (connection_.connected() && !begun_) begun_ = connection_.SendSession(protocol::SessionState::kBegun);
    for (const auto& notice : connection_.PopNotices()) {
      if (notice.level >= 2 && !std::exchange(refused_, true)) std::printf("  %.300s\n", notice.text);
      if (notice.level == 0) waited_ = true;
    }
    return begun_;
  }
  bool refused() const { return refused_; }
  bool waited() const { return waited_; }

 private:
  client::Connection connection_;
  bool begun_ = false, refused_ = false, waited_ = false;
};

}  // namespace

bool RunGiants(const fs::path& bin, const fs::path& folder, int giants, double limit_s) {
  WriteGiant(folder / "giant.glb");
  fs::create_directories(folder / "config/omni/apps.d");
  std::ofstream(folder / "config/omni/apps.d/giant.toml")
      << "application = \"giant*\"\nscene = \"" << (folder / "giant.glb").string() << "\"\n";
  Omnid omnid((bin / "omnid").string(), folder.string());
  if (!omnid.Start()) {
    std::printf("%2d giants: omnid does not start\n", giants);
    return false;
  }
  const double before_MB = MemoryOf(omnid.pid()).all_MB;
  std::vector<std::unique_ptr<Owner>> owners;
  for (int i = 0; i < giants; ++i) owners.push_back(std::make_unique<Owner>(omnid, "giant" + std::to_string(i)));
  Sum most;
  const std::int64_t start_ns = base::MonotonicNow_ns();
  std::int64_t calm_ns = start_ns;
  // Until nothing has been built for a while: some wait until others end.
  while (omnid.Lives() && 1e-9 * static_cast<double>(base::MonotonicNow_ns() - start_ns) < limit_s) {
    for (const auto& owner : owners) owner->Poll();
    const Sum now = MemoryOf(omnid.pid());
    most = {std::max(most.service_MB, now.service_MB), std::max(most.all_MB, now.all_MB),
            std::max(most.children, now.children)};
    if (now.children > 1) calm_ns = base::MonotonicNow_ns();  // the twin is one
    if (base::MonotonicNow_ns() - calm_ns > 5'000'000'000) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  const bool lives = omnid.Lives();
  const auto refused = std::count_if(owners.begin(), owners.end(), [](const auto& owner) { return owner->refused(); });
  const auto waited = std::count_if(owners.begin(), owners.end(), [](const auto& owner) { return owner->waited(); });
  std::printf(
      "%2d giants: omnid %s; at most %.0f MB with what it started (%.0f MB before), omnid alone %.0f MB; %d waited, %d "
      "refused; %.0f s\n",
      giants, lives ? "lives" : ("ended by " + omnid.end()).c_str(), most.all_MB, before_MB, most.service_MB,
      static_cast<int>(waited), static_cast<int>(refused),
      1e-9 * static_cast<double>(base::MonotonicNow_ns() - start_ns));
  std::fflush(stdout);
  owners.clear();
  omnid.Kill();
  return lives;
}

}  // namespace omni::bombs
