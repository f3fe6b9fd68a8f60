// What loading a scene costs the process, counted by the system: for `omni scene cost` and, in a fresh child of it
// each, `omni-bench scene`.
#pragma once

#include <cstdint>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "service/base/result.h"
#include "service/scene/scene_file.h"

namespace omni::tools {

struct ProcessUse {
  std::uint64_t read_bytes = 0;  // rchar of /proc/self/io: all that read() and pread() returned
  std::uint64_t threads = 0;     // entries of /proc/self/task
  std::uint64_t rss_bytes = 0;   // VmRSS of /proc/self/status
};
ProcessUse MeasureThisProcess();

// Loads `path` and reports the differences: bytes_file, bytes_read (by the system), bytes_counted (by us),
// images_decoded, threads (more than before), rss_MB (more than before), load_ms, build_ms, cached, skipped, triangles;
// and what the service would allocate besides, computed without allocating it: soft_bodies, soft_bytes_max, sculpted,
// sculpted_bytes.
base::Result<nlohmann::ordered_json> SceneCost(const std::string& path, const scene::LoadOptions& options, bool cached);

}  // namespace omni::tools
