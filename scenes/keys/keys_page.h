// The parts of docs/scenes.md and scenes/schema/OMNI_haptic_material.schema.json that are generated from the tables of
// a tag's numbers.
#pragma once

#include <string>

namespace omni::scenes {

// The page, its tables of keys with a row for each number of the tables: ranges, units and defaults are theirs, a
// material's meaning too. Rows of words and all other text stay. Throws std::runtime_error: a table is missing.
std::string UpdatedPage(const std::string& page);

// The schema, its numbers those of the tables. Everything else stays. Throws as above.
std::string UpdatedSchema(const std::string& schema);

}  // namespace omni::scenes
