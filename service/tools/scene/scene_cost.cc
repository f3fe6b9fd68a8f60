#include "service/tools/scene/scene.h"

#include <filesystem>
#include <fstream>

#include <nlohmann/json.hpp>

#include "service/haptics/live/make_live.h"
#include "service/haptics/scene/scene.h"

namespace omni::tools {
namespace {

// The number after `name` in a file of lines "name: number".
std::uint64_t NumberIn(const char* file, const std::string& name) {
  std::ifstream lines(file);
  for (std::string word; lines >> word;) {
    std::uint64_t number = 0;
    if (word == name && lines >> number) return number;
  }
  return 0;
}

}  // namespace

ProcessUse MeasureThisProcess() {
  ProcessUse use;
  use.read_bytes = NumberIn("/proc/self/io", "rchar:");
  use.rss_bytes = 1024 * NumberIn("/proc/self/status", "VmRSS:");
  std::error_code error;
  for (std::filesystem::directory_iterator at("/proc/self/task", error), end; !error && at != end; at.increment(error))
    ++use.threads;
  return use;
}

base::Result<nlohmann::ordered_json> SceneCost(const std::string& path, const scene::LoadOptions& options,
                                               bool cached) {
  MeasureThisProcess();  // warms up, so that the measurement itself does not count
  const ProcessUse before = MeasureThisProcess();
  const base::Result<LoadedScene> loaded = LoadScene(path, options, cached);
  const ProcessUse after = MeasureThisProcess();
  if (!loaded.ok()) return base::Error{loaded.error()};
  const haptics::LivePlan plan = haptics::PlanLive(loaded->scene);
  const double rss_MB = (static_cast<double>(after.rss_bytes) - static_cast<double>(before.rss_bytes)) * 1e-6;
  return nlohmann::ordered_json{{"bytes_file", loaded->load.file_bytes},
                                {"bytes_read", after.read_bytes - before.read_bytes},
                                {"bytes_counted", loaded->load.bytes_read},
                                {"images_decoded", loaded->load.images_decoded},
                                {"threads", after.threads - before.threads},
                                {"rss_MB", rss_MB},
                                {"load_ms", loaded->load.load_ms},
                                {"build_ms", loaded->load.cached ? 0.0 : loaded->build.build_ms},
                                {"cached", loaded->load.cached},
                                {"skipped", loaded->load.skipped},
                                {"soft_bodies", plan.soft.size()},
                                {"soft_bytes_max", plan.soft.size() * haptics::MostSoftBytes({})},
                                {"sculpted", plan.sculpted.size()},
                                {"sculpted_bytes", haptics::SculptSessionBytes(loaded->scene, plan)},
                                {"triangles", loaded->scene.empty() ? 0 : loaded->scene.header().triangle_count}};
}

}  // namespace omni::tools
