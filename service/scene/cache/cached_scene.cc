#include "service/scene/cache/cached_scene.h"

#include <array>
#include <cstdint>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <utility>

#include "service/haptics/scene/check_scene.h"
#include "service/scene/gltf/json_reading.h"

namespace omni::scene {
namespace {

// Layout: scene block, reports as JSON, length of the JSON (8 bytes). The scene comes first, so that it is taken by
// cutting the rest off.

// A text, number, true or false as JSON.
template <class T>
std::string Said(const T& value) {
  return nlohmann::json(value).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

template <class List, class Element>
std::string SaidList(const List& list, Element element) {
  std::string text = "[";
  for (const auto& one : list) text += (text.size() > 1 ? "," : "") + element(one);
  return text + "]";
}

template <class List>
std::string SaidList(const List& list) {
  return SaidList(list, [](const auto& one) { return Said(one); });
}

std::string ReportsText(const LoadReport& load, const haptics::BuildReport& build) {
  const std::string rows = SaidList(load.rows, [](const ExplainRow& row) {
    return "[" + Said(row.pointer) + "," + Said(row.name) + "," + Said(row.loaded) + "," + Said(row.why) + "," +
           Said(row.bytes) + "]";
  });
  const std::string objects = SaidList(load.objects, [](const ObjectSource& from) {
    return "[" + Said(from.node) + "," + SaidList(from.rest_rotation_wxyz) + "," + SaidList(from.rest_position_m) + "]";
  });
  return R"({"rows":)" + rows + R"(,"objects":)" + objects + R"(,"warnings":)" + SaidList(load.warnings) +
         R"(,"bytes":)" + SaidList(std::array{load.file_bytes, load.bytes_read}) + R"(,"fit_scale":)" +
         Said(load.fit_scale) + R"(,"lines":)" + SaidList(build.lines) + R"(,"counts":)" +
         SaidList(std::array{build.welded_vertices, build.dropped_triangles, build.flipped_objects}) +
         R"(,"build_ms":)" + Said(build.build_ms) + "}";
}

// The elements of a list of `size`. Throws LoadError when it is none.
std::span<const Json> Listed(const Json* list, std::optional<std::size_t> size = {}) {
  if (!list || !list->is_array() || (size && list->elements().size() != *size))
    throw LoadError("", "is not such a list");
  return list->elements();
}

template <class T>
T Counted(const Json& value) {
  const std::optional<std::uint64_t> count = value.whole();
  if (!count || *count > std::numeric_limits<T>::max()) throw LoadError("", "is not a count");
  return static_cast<T>(*count);
}

std::vector<std::string> Texts(const Json* list) {
  std::vector<std::string> texts;
  for (const Json& text : Listed(list)) texts.emplace_back(text.text());
  return texts;
}

double Number(const Json& json, const char* key) {
  const Json* found = FindMember(json, key);
  if (!found || !found->is_number()) throw LoadError("", "is not a number");
  return found->number();
}

template <std::size_t kCount>
std::array<double, kCount> Reals(const Json& list) {
  const std::span<const Json> elements = Listed(&list, kCount);
  std::array<double, kCount> reals{};
  for (std::size_t i = 0; i < kCount; ++i) reals[i] = elements[i].number();
  return reals;
}

// Throws LoadError on anything that is not as above.
void ReadReports(const Json& json, LoadReport& load, haptics::BuildReport& build) {
  for (const Json& row : Listed(FindMember(json, "rows"))) {
    const std::span<const Json> field = Listed(&row, 5);
    load.rows.push_back({std::string(field[0].text()), std::string(field[1].text()), field[2].boolean(),
                         std::string(field[3].text()), Counted<std::uint64_t>(field[4])});
  }
  for (const Json& from : Listed(FindMember(json, "objects"))) {
    const std::span<const Json> field = Listed(&from, 3);
    const std::int32_t node = field[0].number() < 0 ? -1 : Counted<std::int32_t>(field[0]);
    load.objects.push_back({node, Reals<4>(field[1]), Reals<3>(field[2])});
  }
  load.warnings = Texts(FindMember(json, "warnings"));
  const std::span<const Json> bytes = Listed(FindMember(json, "bytes"), 2),
                              counts = Listed(FindMember(json, "counts"), 3);
  load.file_bytes = Counted<std::uint64_t>(bytes[0]);
  load.bytes_read = Counted<std::uint64_t>(bytes[1]);
  load.fit_scale = Number(json, "fit_scale");
  build.lines = Texts(FindMember(json, "lines"));
  build.welded_vertices = Counted<decltype(build.welded_vertices)>(counts[0]);
  build.dropped_triangles = Counted<decltype(build.dropped_triangles)>(counts[1]);
  build.flipped_objects = Counted<decltype(build.flipped_objects)>(counts[2]);
  build.build_ms = Number(json, "build_ms");
  load.cached = true;
  load.cache = "taken from the cache";
}

}  // namespace

std::string PackReports(const LoadReport& load, const haptics::BuildReport& build) {
  std::string text = ReportsText(load, build);
  const std::uint64_t length = text.size();
  return text.append(reinterpret_cast<const char*>(&length), sizeof length);
}

CacheBlock Pack(const haptics::Scene& scene, const LoadReport& load, const haptics::BuildReport& build) {
  const std::string reports = PackReports(load, build);
  CacheBlock block(scene.bytes() + reports.size());
  if (!scene.empty()) std::memcpy(block.data(), scene.block().data(), scene.bytes());
  std::memcpy(block.data() + scene.bytes(), reports.data(), reports.size());
  return block;
}

std::string Unpack(CacheBlock block, CachedScene& cached) {
  std::uint64_t length = 0;
  if (block.size() < sizeof length) return "is empty";
  const std::size_t rest = block.size() - sizeof length;
  std::memcpy(&length, block.data() + rest, sizeof length);
  if (!(length <= rest)) return "has no reports";
  const std::size_t scene_bytes = rest - static_cast<std::size_t>(length);
  const std::string text(reinterpret_cast<const char*>(block.data() + scene_bytes), static_cast<std::size_t>(length));
  try {
    const base::JsonDocument document = ParseJson(text);
    ReadReports(document.root(), cached.load, cached.build);
  } catch (const std::exception&) {
    return "has damaged reports";
  }
  cached.scene = {};
  if (scene_bytes == 0) return {};
  block.resize(scene_bytes);
  cached.scene = haptics::Scene(std::move(block));
  const base::Status checked = haptics::CheckScene(cached.scene);
  return checked.ok() ? std::string() : checked.error();
}

}  // namespace omni::scene
