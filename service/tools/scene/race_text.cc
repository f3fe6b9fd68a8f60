#include "service/tools/scene/race_text.h"

#include <nlohmann/json.hpp>

#include "service/tools/common/json_text.h"

namespace omni::tools {
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
