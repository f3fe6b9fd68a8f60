#include "service/scene/cached_scene.h"

#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>

#include "service/haptics/check_scene.h"
#include "service/scene/json_reading.h"

namespace omni::scene {
namespace {

// Layout: scene block, reports as JSON, length of the JSON (8 bytes). The scene comes first, so that it is taken by
// cutting the rest off.

Json ReportsJson(const LoadReport& load, const haptics::BuildReport& build) {
  Json rows = Json::array();
  for (const ExplainRow& row : load.rows) rows.push_back({row.pointer, row.name, row.loaded, row.why, row.bytes});
  Json objects = Json::array();
  for (const ObjectSource& from : load.objects) {
    objects.push_back({from.node, from.rest_rotation_wxyz, from.rest_position_m});
  }
  return {{"rows", rows},
          {"objects", objects},
          {"warnings", load.warnings},
          {"bytes", {load.file_bytes, load.bytes_read}},
          {"fit_scale", load.fit_scale},
          {"lines", build.lines},
          {"counts", {build.welded_vertices, build.dropped_triangles, build.flipped_objects}},
          {"build_ms", build.build_ms}};
}

// Throws what the JSON library throws on anything that is not as above.
void ReadReports(const Json& json, LoadReport& load, haptics::BuildReport& build) {
  for (const Json& row : json.at("rows")) {
    load.rows.push_back({row.at(0), row.at(1), row.at(2), row.at(3), row.at(4)});
  }
  for (const Json& from : json.at("objects")) load.objects.push_back({from.at(0), from.at(1), from.at(2)});
  load.warnings = json.at("warnings").get<std::vector<std::string>>();
  load.file_bytes = json.at("bytes").at(0);
  load.bytes_read = json.at("bytes").at(1);
  load.fit_scale = json.at("fit_scale");
  build.lines = json.at("lines").get<std::vector<std::string>>();
  build.welded_vertices = json.at("counts").at(0);
  build.dropped_triangles = json.at("counts").at(1);
  build.flipped_objects = json.at("counts").at(2);
  build.build_ms = json.at("build_ms");
  load.cached = true;
  load.cache = "taken from the cache";
}

}  // namespace

std::vector<std::byte> Pack(const haptics::Scene& scene, const LoadReport& load, const haptics::BuildReport& build) {
  const std::string text = ReportsJson(load, build).dump(-1, ' ', false, Json::error_handler_t::replace);
  const std::uint64_t length = text.size();
  std::vector<std::byte> block(scene.bytes() + text.size() + sizeof length);
  std::memcpy(block.data(), scene.block().data(), scene.bytes());
  std::memcpy(block.data() + scene.bytes(), text.data(), text.size());
  std::memcpy(block.data() + scene.bytes() + text.size(), &length, sizeof length);
  return block;
}

std::string Unpack(const std::vector<std::byte>& block, CachedScene& cached) {
  std::uint64_t length = 0;
  if (block.size() < sizeof length) return "is empty";
  const std::size_t rest = block.size() - sizeof length;
  std::memcpy(&length, block.data() + rest, sizeof length);
  if (!(length <= rest)) return "has no reports";
  const std::size_t scene_bytes = rest - static_cast<std::size_t>(length);
  const std::string text(reinterpret_cast<const char*>(block.data() + scene_bytes), static_cast<std::size_t>(length));
  try {
    ReadReports(ParseJson(text), cached.load, cached.build);
  } catch (const std::exception&) {
    return "has damaged reports";
  }
  const auto end = block.begin() + static_cast<std::ptrdiff_t>(scene_bytes);
  cached.scene = haptics::Scene(haptics::SceneBlock(block.begin(), end));
  const base::Status checked = haptics::CheckScene(cached.scene);
  return checked.ok() ? std::string() : checked.error();
}

}  // namespace omni::scene
