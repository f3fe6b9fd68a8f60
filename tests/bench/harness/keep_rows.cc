#include <cstddef>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "service/tools/common/command_line.h"
#include "service/tools/common/files.h"
#include "service/tools/common/row_table.h"
#include "tests/bench/harness/commands.h"

namespace omni::bench {
namespace {

constexpr std::size_t kNamed = 5;

std::string FirstOf(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size() && i < kNamed; ++i) text += (i == 0 ? "" : "; ") + names[i];
  return text + (names.size() > kNamed ? "; ..." : "");
}

}  // namespace

int KeepRows(const std::string& name, const tools::Rows& rows, const std::string& json_path) {
  const std::string program = "omni-bench " + name;
  if (!json_path.empty()) {
    const std::string problem = tools::WriteText(json_path, tools::RowDocument(name, rows).dump(2) + "\n");
    if (!problem.empty()) return tools::Fail(program, problem);
  }
  const std::vector<std::string> missing = tools::NotMeasured(rows);
  if (missing.empty()) return tools::kExitOk;
  return tools::Fail(
      program, std::to_string(missing.size()) +
                   " figures were not measured (nothing was tracked, or the machine is too busy): " + FirstOf(missing));
}

}  // namespace omni::bench
