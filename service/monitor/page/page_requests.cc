#include "service/monitor/page/page_requests.h"

#include <cmath>
#include <optional>

#include <nlohmann/json.hpp>

#include "service/base/files/json_document.h"
#include "service/protocol/hand_aim.h"

namespace omni::monitor {
namespace {

using nlohmann::json;

constexpr base::JsonLimits kLimits{.bytes = kMaxRequestBytes, .values = 200, .members = 50, .depth = 4};
constexpr double kMaxNumber = 4294967295.0;

struct Problem {
  std::string text;
};

const json& Field(const json& request, const char* name) {
  if (!request.contains(name)) throw Problem{std::string(name) + " is missing"};
  return request.at(name);
}

std::array<double, 3> Vector(const json& request, const char* name) {
  const json& value = Field(request, name);
  if (!value.is_array() || value.size() != 3) throw Problem{std::string(name) + " is not an array of three numbers"};
  std::array<double, 3> vector{};
  for (std::size_t i = 0; i < 3; ++i) {
    if (!value[i].is_number()) throw Problem{std::string(name) + " is not an array of three numbers"};
    vector[i] = value[i].get<double>();
  }
  return vector;
}

std::uint32_t ReadInteger(const json& request, const char* name) {
  const json& value = Field(request, name);
  const double number = value.is_number() ? value.get<double>() : -1;
  if (!(number >= 0 && number <= kMaxNumber && number == std::floor(number))) {
    throw Problem{std::string(name) + " is no whole number in 0..4294967295"};
  }
  return static_cast<std::uint32_t>(number);
}

bool Truth(const json& request, const char* name) {
  const json& value = Field(request, name);
  if (!value.is_boolean()) throw Problem{std::string(name) + " is neither true nor false"};
  return value.get<bool>();
}

AimRequest Aim(const json& request) {
  const AimRequest aim{.tip_base_m = Vector(request, "tip"), .axis_base = Vector(request, "axis")};
  const protocol::HandAim wanted{.tip_base_m = aim.tip_base_m, .axis_base = aim.axis_base};
  protocol::HandAim checked;
  if (!protocol::ReadHandAim(&wanted, sizeof(wanted), checked)) {
    throw Problem{"tip is more than 1 m away, or axis is no unit vector"};
  }
  return aim;
}

SceneRequest Scene(const json& request) {
  const json& name = Field(request, "name");
  if (!name.is_string()) throw Problem{"name is no text"};
  return {name.get<std::string>()};
}

MaterialRequest Material(const json& request) {
  MaterialRequest material{.index = ReadInteger(request, "index")};
  const json& values = Field(request, "values");
  if (!values.is_object()) throw Problem{"values is no object"};
  for (const auto& [key, value] : values.items()) {
    std::optional<std::size_t> row;
    for (std::size_t i = 0; i < base::kLiveFields.size(); ++i) {
      if (base::kLiveFields[i]->key == key) row = i;
    }
    if (!row) throw Problem{"values/" + key + " is no number that can be changed while a scene is in use"};
    const base::MaterialField& field = *base::kLiveFields[*row];
    if (!value.is_number() || !field.Contains(value.get<double>())) {
      throw Problem{"values/" + key + " is out of range"};
    }
    material.given[*row] = true;
    material.values.*field.live = value.get<double>();
  }
  return material;
}

PageRequest Read(const json& request) {
  const json& type = Field(request, "type");
  const std::string name = type.is_string() ? type.get<std::string>() : "";
  if (name == "aim") return Aim(request);
  if (name == "lift") return LiftRequest{};
  if (name == "scene") return Scene(request);
  if (name == "material") return Material(request);
  if (name == "undo") return EditRequest{protocol::SceneAction::kUndo};
  if (name == "redo") return EditRequest{protocol::SceneAction::kRedo};
  if (name == "release") return EditRequest{protocol::SceneAction::kRelease};
  if (name == "save") return SaveRequest{.number = ReadInteger(request, "number")};
  if (name == "stop") return StopRequest{.on = Truth(request, "on")};
  throw Problem{"type is none that this version knows"};
}

}  // namespace

base::Result<PageRequest> ReadPageRequest(std::string_view text) {
  const base::Status checked = base::CheckJson(text, kLimits);
  if (!checked.ok()) return base::Error{"a request of the page is " + checked.error()};
  try {
    const json request = json::parse(text);
    if (!request.is_object()) throw Problem{"it is no object"};
    return Read(request);
  } catch (const Problem& problem) {
    return base::Error{"a request of the page was not done: " + problem.text + "; reload the page"};
  }
}

}  // namespace omni::monitor
