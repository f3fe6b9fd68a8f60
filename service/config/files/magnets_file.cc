#include "service/config/files/magnets_file.h"

#include <filesystem>

#include "service/config/text/text_file.h"
#include "service/config/text/toml_reader.h"

namespace omni::config {
namespace {

constexpr std::size_t kMaxBaseBytes = 63, kMaxLearntBytes = 31;
constexpr Range kPenMoment_Am2{1e-3, 1e3};

}  // namespace

base::Result<std::vector<MagnetEntry>> ParseMagnets(const std::string& text, const std::string& name) {
  const base::Result<toml::table> parsed = ParseToml(text, name);
  if (!parsed.ok()) return base::Error{parsed.error()};
  FileProblem problem(name);
  TableReader root(problem, *parsed, "");
  const int format = root.Integer("format", {1, 1000});
  if (problem.ok() && format != kMagnetsFormat) {
    problem.Report(parsed->get("format"), "format = " + std::to_string(format) + " is not known, this version reads " +
                                              std::to_string(kMagnetsFormat) +
                                              "; install the Omni version that wrote it, or move the file away");
  }
  if (!problem.ok()) return base::Error{problem.message()};
  std::vector<MagnetEntry> magnets;
  if (parsed->contains("magnets")) {
    const auto tables = root.Tables("magnets", 0, kMaxMagnets);
    for (std::size_t i = 0; i < tables.size(); ++i) {
      TableReader reader(problem, *tables[i], "magnets[" + std::to_string(i) + "]");
      MagnetEntry& entry = magnets.emplace_back();
      entry.base = reader.Text("base", kMaxBaseBytes);
      entry.moment_Am2 = reader.Number("moment_Am2", kPenMoment_Am2);
      entry.sigma_share = reader.Number("sigma_share", {0, 1});
      entry.learnt_date = reader.Text("learnt_date", kMaxLearntBytes);
      reader.ReportUnknownKeys();
    }
  }
  root.ReportUnknownKeys();
  if (!problem.ok()) return base::Error{problem.message()};
  return magnets;
}

base::Result<std::vector<MagnetEntry>> LoadMagnetsFile(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error) && !error) return std::vector<MagnetEntry>{};
  const base::Result<std::string> text = ReadTextFile(path);
  if (!text.ok()) return base::Error{text.error()};
  return ParseMagnets(*text, path);
}

std::string WriteMagnets(const std::vector<MagnetEntry>& magnets) {
  std::string text = "# Magnets of pens beside the calibrated ones, learnt by omnid.\n";
  text += "format = " + std::to_string(kMagnetsFormat) + "\n";
  for (const MagnetEntry& entry : magnets) {
    text += "\n[[magnets]]\nbase = " + TomlText(entry.base) + "\nmoment_Am2 = " + TomlFloat(entry.moment_Am2) + "\n";
    text += "sigma_share = " + TomlFloat(entry.sigma_share) + "\nlearnt_date = " + TomlText(entry.learnt_date) + "\n";
  }
  return text;
}

}  // namespace omni::config
