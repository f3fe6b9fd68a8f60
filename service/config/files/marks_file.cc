#include "service/config/files/marks_file.h"

#include "service/config/files/built_in_device.h"
#include "service/config/text/text_file.h"
#include "service/config/text/toml_reader.h"

namespace omni::config {
namespace {

constexpr Range kMarkPosition_m{-0.5, 0.5};
constexpr std::size_t kMaxMarkNameBytes = 64;

}  // namespace

base::Result<std::vector<Mark>> ParseMarks(const std::string& text, const std::string& name) {
  const base::Result<toml::table> parsed = ParseToml(text, name);
  if (!parsed.ok()) return base::Error{parsed.error()};
  FileProblem problem(name);
  TableReader root(problem, *parsed, "");
  std::vector<Mark> marks;
  const auto tables = root.Tables("marks", kMinMarks, kMaxMarks);
  for (std::size_t i = 0; i < tables.size(); ++i) {
    TableReader reader(problem, *tables[i], "marks[" + std::to_string(i) + "]");
    Mark mark;
    mark.name = reader.Text("name", kMaxMarkNameBytes);
    mark.position_base_m = reader.Vector("position_base_m", kMarkPosition_m);
    reader.Finish();
    marks.push_back(std::move(mark));
  }
  root.Finish();
  if (!problem.ok()) return base::Error{problem.message()};
  return marks;
}

base::Result<std::vector<Mark>> LoadMarksFile(const std::string& path) {
  const base::Result<std::string> text = ReadTextFile(path);
  if (!text.ok()) return base::Error{text.error()};
  return ParseMarks(*text, path);
}

const std::vector<Mark>& DefaultMarks() {
  static const std::vector<Mark> marks = ParsedBuiltIn(ParseMarks, kBuiltInMarksText, "manifests/device/marks.toml");
  return marks;
}

}  // namespace omni::config
