#include "service/config/inputs/input_table.h"

#include <algorithm>
#include <iterator>
#include <optional>
#include <string_view>
#include <vector>

#include "service/base/files/nearest_word.h"
#include "service/config/text/toml_reader.h"

namespace omni::config {
namespace {

using base::InputComponent;
using base::InputSource;
using base::InputThresholds;

constexpr std::string_view kKeyPrefix = "key:";
constexpr std::size_t kMaxSourceBytes = 64;

struct SourceRow {
  std::string_view name;
  InputSource source;
};
constexpr SourceRow kSources[] = {{"tip_force", InputSource::kTipForce},
                                  {"press", InputSource::kPress},
                                  {"tap", InputSource::kTap},
                                  {"double_tap", InputSource::kDoubleTap},
                                  {"dwell", InputSource::kDwell},
                                  {"hover_dwell", InputSource::kHoverDwell},
                                  {"detent", InputSource::kDetent},
                                  {"flick", InputSource::kFlick},
                                  {"flick_axial", InputSource::kFlickAxial},
                                  {"away", InputSource::kAway},
                                  {"thumbstick_x", InputSource::kThumbstickX},
                                  {"thumbstick_y", InputSource::kThumbstickY}};

constexpr const char* kComponents[] = {"tip_force",    "select",       "secondary",        "menu",  "squeeze",
                                       "thumbstick_x", "thumbstick_y", "thumbstick_click", "docked"};
static_assert(std::size(kComponents) == base::kInputComponentCount);

struct ThresholdRow {
  const char* key;
  double InputThresholds::*field;
  Range range;
};
constexpr ThresholdRow kThresholds[] = {
    {"tip_force_full_N", &InputThresholds::tip_force_full_N, {0.05, 10}},
    {"press_N", &InputThresholds::press_N, {0.02, 5}},
    {"release_N", &InputThresholds::release_N, {0.01, 5}},
    {"tap_force_N", &InputThresholds::tap_force_N, {0.06, 5}},
    {"tap_speed_m_s", &InputThresholds::tap_speed_m_s, {0.01, 1}},
    {"tap_max_s", &InputThresholds::tap_max_s, {0.02, 1}},
    {"tap_travel_m", &InputThresholds::tap_travel_m, {0.0005, 0.02}},
    {"double_tap_s", &InputThresholds::double_tap_s, {0.05, 2}},
    {"double_tap_distance_m", &InputThresholds::double_tap_distance_m, {0.001, 0.1}},
    {"dwell_s", &InputThresholds::dwell_s, {0.1, 10}},
    {"dwell_radius_m", &InputThresholds::dwell_radius_m, {0.0005, 0.02}},
    {"detent_press_N", &InputThresholds::detent_press_N, {0.1, 5}},
    {"detent_release_N", &InputThresholds::detent_release_N, {0.05, 5}},
    {"detent_pulse_N", &InputThresholds::detent_pulse_N, {0, 0.5}},
    {"flick_speed_m_s", &InputThresholds::flick_speed_m_s, {0.1, 5}},
    {"flick_s", &InputThresholds::flick_s, {0.05, 1}},
    {"away_untracked_s", &InputThresholds::away_untracked_s, {0.2, 600}},
    {"away_distance_m", &InputThresholds::away_distance_m, {0.05, 1}},
    {"away_still_s", &InputThresholds::away_still_s, {1, 3600}},
    {"away_still_m", &InputThresholds::away_still_m, {0.0002, 0.01}},
    {"click_s", &InputThresholds::click_s, {0.015, 1}},
};

// Pairs of which the first must stay below the second, or a press would never end.
struct OrderRow {
  const char* below;
  const char* above;
  double InputThresholds::*low;
  double InputThresholds::*high;
};
constexpr OrderRow kOrder[] = {
    {"release_N", "press_N", &InputThresholds::release_N, &InputThresholds::press_N},
    {"detent_release_N", "detent_press_N", &InputThresholds::detent_release_N, &InputThresholds::detent_press_N},
};

bool IsAxis(InputComponent component) {
  return component == InputComponent::kThumbstickX || component == InputComponent::kThumbstickY;
}

std::vector<std::string_view> SourceNames() {
  std::vector<std::string_view> names;
  for (const SourceRow& row : kSources) names.push_back(row.name);
  return names;
}

std::string Known() {
  std::string names;
  for (const SourceRow& row : kSources) names += std::string(row.name) + ", ";
  return names + "or a key as \"key:KEY_B\"";
}

// The source of that name, a key's with its place in `keys`, which grows. Empty, and why in `problem`.
std::optional<InputSource> FindSource(std::string_view name, std::vector<std::uint16_t>& keys, std::string& problem) {
  for (const SourceRow& row : kSources) {
    if (row.name == name) return row.source;
  }
  if (name.substr(0, kKeyPrefix.size()) != kKeyPrefix) {
    problem = "is not a source; known are " + Known() + base::DidYouMean(name, SourceNames());
    return std::nullopt;
  }
  const auto code = KeyCode(name.substr(kKeyPrefix.size()));
  if (!code) {
    problem = "is not a key; write its name in linux/input-event-codes.h (evtest shows it) or its number, 1 to " +
              std::to_string(kHighestKey);
    return std::nullopt;
  }
  const auto at = std::find(keys.begin(), keys.end(), *code);
  if (at == keys.end() && keys.size() == static_cast<std::size_t>(base::kMaxKeys)) {
    problem = "is one key too many; the limit is " + std::to_string(base::kMaxKeys) + " different keys";
    return std::nullopt;
  }
  const auto slot = static_cast<int>(at - keys.begin());
  if (at == keys.end()) keys.push_back(*code);
  return static_cast<InputSource>(static_cast<int>(InputSource::kFirstKey) + slot);
}

void ReadComponent(TableReader& reader, FileProblem& problem, InputComponent component, InputTable& table) {
  const char* key = ComponentText(component);
  const auto names = reader.Texts(key, kMaxSourcesOfComponent, kMaxSourceBytes);
  if (!names) return;
  base::ComponentSources sources;
  for (const std::string& name : *names) {
    const bool minus = IsAxis(component) && name.front() == '-';
    std::string why;
    const auto source = FindSource(minus ? std::string_view(name).substr(1) : name, table.keys, why);
    if (!source) return problem.Report(reader.table().get(key), reader.NameOf(key) + ": \"" + name + "\" " + why);
    (minus ? sources.minus : sources.plus) |= SourceBit(*source);
  }
  table.mapping.at(component) = sources;
}

}  // namespace

const char* ComponentText(InputComponent component) { return kComponents[static_cast<std::size_t>(component)]; }

std::string SourceText(InputSource source, const std::vector<std::uint16_t>& slots) {
  for (const SourceRow& row : kSources) {
    if (row.source == source) return std::string(row.name);
  }
  const auto slot = static_cast<std::size_t>(source) - static_cast<std::size_t>(InputSource::kFirstKey);
  return std::string(kKeyPrefix) + (slot < slots.size() ? KeyNameOf(slots[slot]) : "?");
}

InputTable ReadInputs(TableReader& reader, FileProblem& problem) {
  InputTable table;
  for (int i = 0; i < base::kInputComponentCount; ++i) {
    ReadComponent(reader, problem, static_cast<InputComponent>(i), table);
  }
  InputThresholds& thresholds = table.mapping.thresholds;
  for (const ThresholdRow& row : kThresholds) {
    thresholds.*row.field = reader.Number(row.key, row.range, thresholds.*row.field);
  }
  for (const OrderRow& row : kOrder) {
    if (thresholds.*row.low < thresholds.*row.high) continue;
    const toml::node* node = reader.table().get(row.below);
    problem.Report(node != nullptr ? node : reader.table().get(row.above),
                   reader.NameOf(row.below) + " is not below " + row.above + "; make it smaller");
  }
  reader.ReportUnknownKeys();
  return table;
}

bool ShareKeys(std::vector<std::uint16_t>& slots, InputTable& table) {
  std::vector<std::uint16_t> grown = slots;
  std::vector<int> slot_of;
  for (const std::uint16_t code : table.keys) {
    const auto at = std::find(grown.begin(), grown.end(), code);
    slot_of.push_back(static_cast<int>(at - grown.begin()));
    if (at == grown.end()) grown.push_back(code);
  }
  if (grown.size() > static_cast<std::size_t>(base::kMaxKeys)) return false;
  const auto shared = [&](base::SourceMask mask) {
    base::SourceMask out = mask & (SourceBit(InputSource::kFirstKey) - 1);
    for (std::size_t i = 0; i < slot_of.size(); ++i) {
      if ((mask & base::KeyBit(static_cast<int>(i))) != 0) out |= base::KeyBit(slot_of[i]);
    }
    return out;
  };
  for (base::ComponentSources& sources : table.mapping.components) {
    sources = {.plus = shared(sources.plus), .minus = shared(sources.minus)};
  }
  slots = grown;
  table.keys = grown;
  return true;
}

}  // namespace omni::config
