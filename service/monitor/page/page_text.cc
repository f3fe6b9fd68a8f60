#include "service/monitor/page/page_text.h"

#include <array>
#include <cmath>
#include <span>
#include <utility>

#include <nlohmann/json.hpp>

#include "firmware/wire/names.h"
#include "service/base/files/json_document.h"
#include "service/monitor/page/bit_names.h"
#include "service/monitor/page/channels.h"

namespace omni::monitor {
namespace {

using nlohmann::json;

int BitOf(std::uint32_t mask) { return __builtin_ctz(mask); }

json Bits(std::span<const BitName> names) {
  json rows = json::array();
  for (const BitName& row : names) {
    rows.push_back({{"bit", BitOf(row.mask)}, {"name", *row.text != 0 ? row.text : row.name}});
  }
  return rows;
}

json Vector(const base::Vec3& v) { return {v.x, v.y, v.z}; }

json Base(const base::DeviceGeometry& device) {
  json coils = json::array();
  for (const base::CoilGeometry& coil : device.coils) {
    coils.push_back({{"axis", Vector(coil.axis_base)},
                     {"inner_radius_m", coil.shell_radius_min_m},
                     {"outer_radius_m", coil.shell_radius_max_m},
                     {"length_m", 2 * coil.band_half_width_m}});
  }
  json sensors = json::array();
  for (const base::SensorGeometry& sensor : device.sensors) sensors.push_back(Vector(sensor.position_base_m));
  return {{"hull_radius_m", device.hull_radius_m},
          {"core_radius_m", device.core_radius_m},
          {"coils", std::move(coils)},
          {"sensors", std::move(sensors)},
          {"current_max_A", device.current_max_A},
          {"force_max_N", device.force_max_N},
          {"magnet",
           {{"radius_m", device.magnet.radius_m},
            {"half_height_m", device.magnet.half_height_m},
            {"tip_offset_m", device.magnet.tip_offset_m}}}};
}

json MaterialFields() {
  json fields = json::array();
  for (const base::MaterialField* field : base::kLiveFields) {
    fields.push_back({{"key", field->key},
                      {"label", field->label},
                      {"unit", field->unit == "1" ? std::string_view() : field->unit},
                      {"minimum", field->minimum},
                      {"maximum", field->maximum},
                      {"about", field->about}});
  }
  return fields;
}

std::string Dump(const json& message) { return message.dump(-1, ' ', false, json::error_handler_t::replace); }

}  // namespace

std::string HelloText(const PageHello& hello) {
  json channels = json::array();
  for (const Channel& channel : Channels()) {
    channels.push_back(
        {{"name", channel.name}, {"label", channel.label}, {"unit", channel.unit}, {"group", channel.group}});
  }
  json faults = json::array();
  for (const wire::FaultText& fault : wire::FaultTexts()) {
    faults.push_back(
        {{"bit", BitOf(fault.fault)}, {"name", fault.name}, {"text", fault.meaning}, {"remedy", fault.advice}});
  }
  json scenes = json::array();
  for (const SceneChoice& scene : hello.scenes) {
    scenes.push_back({{"name", scene.name}, {"title", scene.title}, {"about", scene.about}});
  }
  return Dump({{"type", "hello"},
               {"protocol", kPageVersion},
               {"version", hello.version},
               {"control", hello.control},
               {"hand", hello.hand},
               {"channels", std::move(channels)},
               {"flags", Bits(FlagNames())},
               {"faults", Bits(TickFaultNames())},
               {"device_faults", std::move(faults)},
               {"scenes", std::move(scenes)},
               {"material_fields", MaterialFields()},
               {"max_file_bytes", hello.max_file_bytes},
               {"environment", hello.environment},
               {"base", Base(hello.device)}});
}

int StrokesOf(const std::string& edits) {
  const json parsed = base::ParseJsonOrNull(edits);
  const json* objects = base::ValueAt(parsed, "/objects");
  if (objects == nullptr || !objects->is_array()) return -1;
  double strokes = 0;
  for (const json& object : *objects) {
    const double of_object = base::NumberAt(object, "/strokes");
    if (!std::isnan(of_object)) strokes += of_object;
  }
  return strokes >= 0 && strokes <= 1e6 ? static_cast<int>(strokes) : -1;
}

std::string StatusText(bool connected, const std::string& why, const json& status, int strokes) {
  return Dump({{"type", "status"}, {"connected", connected}, {"why", why}, {"status", status}, {"strokes", strokes}});
}

std::string SetupText(const json& steps) { return Dump({{"type", "setup"}, {"steps", steps}}); }

std::string SceneText(const ShownScene& scene, bool own) {
  constexpr const char* kStates[] = {"none", "loading", "ready", "failed"};
  json parts = json::array();
  for (const ViewPart& part : scene.view == nullptr ? std::span<const ViewPart>() : std::span(scene.view->parts)) {
    const bool touched = part.object >= 0 && part.material < scene.materials.size();
    parts.push_back({{"name", part.name},
                     {"object", part.object},
                     {"material", touched ? scene.materials[part.material].name : std::string()}});
  }
  json materials = json::array();
  for (std::size_t i = 0; i < scene.materials.size(); ++i) {
    const ViewMaterial& material = scene.materials[i];
    if (material.name.empty()) continue;  // of nothing that is touched
    json values = json::object();
    for (const base::MaterialField* field : base::kLiveFields) {
      values[std::string(field->key)] = material.values.*field->live;
    }
    materials.push_back({{"index", i}, {"name", material.name}, {"values", std::move(values)}});
  }
  return Dump({{"type", "scene"},
               {"number", scene.number},
               {"name", scene.name},
               {"state", kStates[static_cast<std::size_t>(scene.state)]},
               {"text", scene.text},
               {"own", own},
               {"parts", std::move(parts)},
               {"materials", std::move(materials)}});
}

std::string NoticeText(NoticeLevel level, std::string_view text) {
  constexpr const char* kLevels[] = {"info", "warning", "error"};
  return Dump({{"type", "notice"}, {"level", kLevels[static_cast<std::size_t>(level)]}, {"text", text}});
}

std::string AnswerText(std::uint32_t number, bool done, std::string_view text) {
  return Dump({{"type", "answer"}, {"number", number}, {"done", done}, {"text", text}});
}

}  // namespace omni::monitor
