// The [inputs] table of an application's file and of inputs.toml: which sources feed which component, and thresholds.
// docs/howto/apps.md.
#pragma once

#include <cstdint>
#include <string>
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

}  // namespace omni::config
