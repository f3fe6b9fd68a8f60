#include "service/tools/scene/scene.h"

#include <algorithm>
#include <cstdio>
#include <span>

#include <nlohmann/json.hpp>

#include "service/base/material.h"
#include "service/haptics/live/make_live.h"
#include "service/haptics/scene/scene.h"
#include "service/protocol/text.h"
#include "service/scene/tags/haptic_keys.h"
#include "service/tools/common/output.h"

namespace omni::tools {
namespace {

using haptics::Material;
using haptics::Scene;
using haptics::SoftnessModel;
using nlohmann::json;
using protocol::Printable;

std::string NameOf(SoftnessModel model) { return std::string(scene::NameOf(scene::kSoftnessModels, model)); }

std::string Number(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.4g", value);
  return text;
}

std::string Bytes(std::uint64_t bytes) {
  char text[32];
  if (bytes < 10000) {
    std::snprintf(text, sizeof(text), "%llu B", static_cast<unsigned long long>(bytes));
  } else if (bytes < 10'000'000) {
    std::snprintf(text, sizeof(text), "%.1f kB", static_cast<double>(bytes) * 1e-3);
  } else {
    std::snprintf(text, sizeof(text), "%.1f MB", static_cast<double>(bytes) * 1e-6);
  }
  return text;
}

std::string Padded(std::string text, std::size_t width) {
  if (text.size() < width) text.append(width - text.size(), ' ');
  return text;
}

// " N s/m"; empty where there is no unit.
std::string UnitText(const base::MaterialField& field) {
  if (field.unit == "1") return "";
  std::string unit = " " + std::string(field.unit);
  std::replace(unit.begin(), unit.end(), '*', ' ');
  return unit;
}

std::string FieldText(const base::MaterialField& field, const Material& material) {
  return std::string(field.label) + " " + Number(field.Get(material)) + UnitText(field);
}

// ", name 12 unit" for what differs from the default; the four that always matter come first, whatever their value.
std::string MaterialLine(const Material& material) {
  constexpr int kAlways = 4;
  std::string text;
  int count = 0;
  for (const base::MaterialField& field : base::kMaterialFields) {
    if (!base::PartOf(field).empty()) continue;
    if (count++ >= kAlways && field.Get(material) == field.Default()) continue;
    text += (text.empty() ? "" : ", ") + FieldText(field, material);
  }
  if (material.softness.model != SoftnessModel::kNone) {
    text += ", softness " + NameOf(material.softness.model);
    for (const base::MaterialField& field : base::kMaterialFields) {
      if (base::PartOf(field) == "softness") text += ", " + FieldText(field, material);
    }
  }
  if (material.extrude.enabled) {
    text += ", extrude in steps of " + Number(material.extrude.step_m * 1e3) + " mm (" +
            std::to_string(material.extrude.steps_out) + " out, " + std::to_string(material.extrude.steps_in) + " in)";
  }
  if (material.sculpt.enabled) text += ", sculptable within " + Number(material.sculpt.radius_m * 1e3) + " mm";
  return text;
}

std::string LoadRows(const scene::LoadReport& load) {
  std::size_t widths[2] = {8, 5};
  for (const scene::ExplainRow& row : load.rows) {
    widths[0] = std::max(widths[0], row.pointer.size());
    widths[1] = std::max(widths[1], row.name.size());
  }
  std::string text;
  for (const scene::ExplainRow& row : load.rows) {
    text += std::string(row.loaded ? "  on   " : "  off  ") + Padded(Printable(row.pointer), widths[0] + 2) +
            Padded(Printable(row.name), widths[1] + 2) + Padded(row.bytes != 0 ? Bytes(row.bytes) : "", 10) +
            Printable(row.why) + "\n";
  }
  return text;
}

std::string Extent(const haptics::SceneHeader& header) {
  char text[160];
  std::snprintf(text, sizeof(text), "x %.1f..%.1f, y %.1f..%.1f, z %.1f..%.1f mm in the base frame",
                header.lower_base_m.x * 1e3, header.upper_base_m.x * 1e3, header.lower_base_m.y * 1e3,
                header.upper_base_m.y * 1e3, header.lower_base_m.z * 1e3, header.upper_base_m.z * 1e3);
  return text;
}

std::string Summary(const LoadedScene& loaded) {
  std::string text;
  if (!loaded.scene.empty()) {
    const haptics::SceneHeader& header = loaded.scene.header();
    text += "objects    " + std::to_string(header.object_count) + ", " + Plural(header.triangle_count, "triangle") +
            ", " + std::to_string(header.vertex_count) + " vertices, " + Plural(header.node_count, "BVH node") + "\n";
    text += "extent     " + Extent(header) + "\n";
  }
  if (loaded.load.fit_scale != 1) text += "fit        scaled by " + Number(loaded.load.fit_scale) + "\n";
  for (const SceneFeature& feature : FeaturesOf(loaded)) {
    text += Padded(feature.name, 11) + (feature.on ? "on: " : "off: ") + feature.why + "\n";
  }
  text += "images     " + std::to_string(loaded.load.images_decoded) + " decoded\n";
  if (!loaded.load.cache.empty()) text += "cache      " + Printable(loaded.load.cache) + "\n";
  text += "cost       loaded in " + Number(loaded.load.load_ms) + " ms, built in " + Number(loaded.build.build_ms) +
          " ms" + (loaded.load.cached ? " (when it was cached)" : "") + ", " + Bytes(loaded.scene.bytes()) +
          " of memory\n";
  return text;
}

std::span<const Material> MaterialsOf(const Scene& scene) {
  return scene.empty() ? std::span<const Material>() : scene.materials();
}

json VectorJson(const base::Vec3& v) { return json::array({v.x, v.y, v.z}); }

// "static friction" in "N*s/m" -> "static_friction_N_s_m".
std::string KeyOf(const base::MaterialField& field) {
  std::string key(field.label);
  if (field.unit != "1") key += "_" + std::string(field.unit);
  for (char& c : key) {
    if (c == ' ' || c == '/' || c == '*') c = '_';
  }
  return key;
}

json MaterialJson(const Material& material) {
  json values = json::object();
  values["softness"] = {{"model", NameOf(material.softness.model)}};
  values["extrude"] = {{"enabled", material.extrude.enabled}};
  values["sculptable"] = {{"enabled", material.sculpt.enabled}};
  for (const base::MaterialField& field : base::kMaterialFields) {
    const std::string part(base::PartOf(field));
    json& place = part.empty() ? values : values[part];
    if (field.member.whole) {
      place[KeyOf(field)] = static_cast<int>(field.Get(material));
    } else {
      place[KeyOf(field)] = field.Get(material);
    }
  }
  return values;
}

json FeaturesJson(const LoadedScene& loaded) {
  json features = json::object();
  for (const SceneFeature& feature : FeaturesOf(loaded))
    features[feature.name] = {{"on", feature.on}, {"why", feature.why}};
  return features;
}

json RowsJson(const scene::LoadReport& load) {
  json rows = json::array();
  for (const scene::ExplainRow& row : load.rows) {
    rows.push_back(
        {{"pointer", row.pointer}, {"name", row.name}, {"loaded", row.loaded}, {"why", row.why}, {"bytes", row.bytes}});
  }
  return rows;
}

}  // namespace

std::string SceneText(const std::string& path, const LoadedScene& loaded) {
  const scene::LoadReport& load = loaded.load;
  std::string text = path + ": " + Bytes(load.file_bytes) + ", " + Bytes(load.bytes_read) + " read\n";
  text += LoadRows(load) + Summary(loaded);
  std::size_t index = 0;
  for (const Material& material : MaterialsOf(loaded.scene)) {
    text += "material " + Padded(std::to_string(index++), 2) + MaterialLine(material) + "\n";
  }
  for (const std::string& line : loaded.build.lines) text += "note       " + Printable(line) + "\n";
  for (const std::string& line : haptics::PlanLive(loaded.scene).lines) text += "note       " + Printable(line) + "\n";
  for (const std::string& warning : load.warnings) text += "warning    " + Printable(warning) + "\n";
  return text;
}

json SceneJson(const std::string& path, const LoadedScene& loaded) {
  const haptics::SceneHeader nothing{};
  const haptics::SceneHeader& header = loaded.scene.empty() ? nothing : loaded.scene.header();
  json materials = json::array();
  for (const Material& material : MaterialsOf(loaded.scene)) materials.push_back(MaterialJson(material));
  json regions = json::array();
  for (std::size_t r = 0; r < header.region_count; ++r) {
    const haptics::Region& region = loaded.scene.regions()[r];
    regions.push_back({{"material", region.material},
                       {"normal_base", VectorJson(region.normal)},
                       {"centroid_base_m", VectorJson(region.centroid_base_m)}});
  }
  const haptics::LivePlan plan = haptics::PlanLive(loaded.scene);
  std::vector<std::string> notes = loaded.build.lines;
  notes.insert(notes.end(), plan.lines.begin(), plan.lines.end());
  return {{"file", path},
          {"file_bytes", loaded.load.file_bytes},
          {"bytes_read", loaded.load.bytes_read},
          {"fit_scale", loaded.load.fit_scale},
          {"skipped", loaded.load.skipped},
          {"images_decoded", loaded.load.images_decoded},
          {"cached", loaded.load.cached},
          {"cache", loaded.load.cache},
          {"load_ms", loaded.load.load_ms},
          {"features", FeaturesJson(loaded)},
          {"rows", RowsJson(loaded.load)},
          {"objects", header.object_count},
          {"triangles", header.triangle_count},
          {"vertices", header.vertex_count},
          {"bvh_nodes", header.node_count},
          {"lower_base_m", VectorJson(header.lower_base_m)},
          {"upper_base_m", VectorJson(header.upper_base_m)},
          {"joystick", header.has_joystick != 0},
          {"vehicle", header.has_vehicle != 0},
          {"regions", regions},
          {"materials", materials},
          {"build_ms", loaded.build.build_ms},
          {"memory_bytes", loaded.scene.bytes()},
          {"welded_vertices", loaded.build.welded_vertices},
          {"dropped_triangles", loaded.build.dropped_triangles},
          {"flipped_objects", loaded.build.flipped_objects},
          {"soft_bodies", plan.soft},
          {"sculpted", plan.sculpted},
          {"notes", notes},
          {"warnings", loaded.load.warnings}};
}

namespace {

// ", last 9.84 s"; empty: not yet.
std::string Time(const char* word, const nlohmann::json& race, const char* pointer) {
  return NumberAt(race, pointer) > 0 ? std::string(", ") + word + " " + TextAt(race, pointer, 2) + " s" : "";
}

}  // namespace

std::string RaceText(const nlohmann::json& status) {
  if (!status.is_object() || !status.contains("race") || !status["race"].is_object()) return "";
  const nlohmann::json& race = status["race"];
  const std::string laps = TextAt(race, "/laps"), hits = TextAt(race, "/hits");
  std::string text = laps + (laps == "1" ? " lap" : " laps");
  text += Time("last", race, "/last_lap_s") + Time("best", race, "/best_lap_s") + Time("now", race, "/lap_s");
  const nlohmann::json speed{{"mm_s", 1e3 * NumberAt(race, "/speed_m_s")}};
  text += "; " + TextAt(speed, "/mm_s", 0) + " mm/s" + (TrueAt(race, "/sliding") ? ", sliding" : "");
  return text + "; " + hits + (hits == "1" ? " hit" : " hits");
}

}  // namespace omni::tools
