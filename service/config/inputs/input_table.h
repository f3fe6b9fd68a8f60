// The [inputs] table of an application's file and of inputs.toml: which sources feed which component, and thresholds.
// docs/howto/apps.md.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "service/base/input_mapping.h"

namespace omni::config {

class FileProblem;
class TableReader;

inline constexpr std::size_t kMaxSourcesOfComponent = 16;

struct InputTable {
  base::InputMapping mapping = base::DefaultMapping();
  std::vector<std::uint16_t> keys;  // evdev code of key source i; at most base::kMaxKeys
};

// `reader`: of the table itself. Omitted keys keep their defaults. Problems go to `problem`.
InputTable ReadInputs(TableReader& reader, FileProblem& problem);

// Assigns the keys of `table` their slots in `slots`, adding missing ones. False: they do not fit into base::kMaxKeys,
// nothing was changed.
bool ShareKeys(std::vector<std::uint16_t>& slots, InputTable& table);

// "double_tap", "key:KEY_B"; `slots`: what the key sources mean.
std::string SourceText(base::InputSource source, const std::vector<std::uint16_t>& slots);
// "secondary".
const char* ComponentText(base::InputComponent component);

// Keys by the names of the Linux input system (linux/input-event-codes.h): "KEY_B", "BTN_LEFT", or a number, "183".
inline constexpr std::uint16_t kHighestKey = 0x2FF;  // KEY_MAX

// Empty: no such key.
std::optional<std::uint16_t> KeyCode(std::string_view name);

std::string KeyNameOf(std::uint16_t code);

// Interaction profiles that the pen supports: those of the layer (layer/profiles), as "oculus/touch_controller".
std::span<const std::string_view> ProfileNames();

}  // namespace omni::config
