// Figures as rows: aligned columns for people, flat JSON rows for machines.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "service/base/files/json_document.h"

namespace omni::tools {

// Rows are flat objects; keys in a stated order. A figure that has no meaning in its row is null; one that should have
// been measured and was not is NaN (or infinite), null in JSON too, and makes a benchmark fail. Rows with a key "table"
// do not belong to the main table: they go to side tables of that name.
using Rows = std::vector<nlohmann::ordered_json>;

// What a file of rows may hold.
inline constexpr base::JsonLimits kRowsJson{.bytes = 16 << 20, .values = 500'000, .depth = 32};

// Side tables in the order of their first row; `rows` keeps the others.
std::vector<std::pair<std::string, Rows>> TakeSideTables(Rows& rows);

// Aligned columns, one line per row.
std::string RowTable(const Rows& rows);

// Each figure that should have been measured and was not, as "key of the row's words"; empty: none.
std::vector<std::string> NotMeasured(const Rows& rows);

// {"name", "command", "commit", "machine", "rows"} and, when there are side tables, "tables": {name: rows}. `command`
// is this program's, without --json FILE.
nlohmann::ordered_json RowDocument(const std::string& name, const Rows& rows);

}  // namespace omni::tools
