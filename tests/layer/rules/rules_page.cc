// Generates docs/howto/openxr-rules.md from tests/layer/rules/rules.json; Rules.GeneratedPageMatchesCommittedPage
// compares.
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

namespace {

std::string Code(const nlohmann::json& names) {
  std::string text;
  for (const std::string name : names) text += (text.empty() ? "`" : "<br>`") + name + "`";
  return text;
}

void PrintGroup(const nlohmann::json& group) {
  std::printf("\n## %s\n\n| rule | specification | test | seeded fault |\n|---|---|---|---|\n",
              group.at("title").get<std::string>().c_str());
  for (const nlohmann::json& rule : group.at("rules"))
    std::printf("| **%s**: %s | %s | %s | %s |\n", rule.at("id").get<std::string>().c_str(),
                rule.at("text").get<std::string>().c_str(), rule.at("spec").get<std::string>().c_str(),
                Code(rule.at("tests")).c_str(), Code(rule.at("faults")).c_str());
}

}  // namespace

int main() {
  std::ifstream in(OMNI_SOURCE_DIR "/tests/layer/rules/rules.json");
  if (!in) return std::fprintf(stderr, "no " OMNI_SOURCE_DIR "/tests/layer/rules/rules.json\n"), 1;
  const nlohmann::json root = nlohmann::json::parse(in);
  std::size_t rules = 0;
  for (const nlohmann::json& group : root.at("groups")) rules += group.at("rules").size();
  std::printf(
      "# Rules that the OpenXR layer follows, and the tests that verify them\n"
      "\n"
      "Generated from tests/layer/rules/rules.json by `layer_rules_page`; a test compares the two, and fails if a rule "
      "names "
      "no\n"
      "test or one that does not exist. %zu rules, %zu seeded faults.\n"
      "\n"
      "A *seeded fault* is a place in layer/src where a second build of the layer (tests/layer/faults) can be made to "
      "break\n"
      "a rule. ctest's `layer.faults` runs the tests of its rules with each fault and fails if they all pass. The "
      "column\n"
      "*specification* names the anchor, function, structure or document that the rule comes from.\n",
      rules, root.at("faults").size());
  for (const nlohmann::json& group : root.at("groups")) PrintGroup(group);
  std::printf("\n## Seeded faults\n\n| fault | effect |\n|---|---|\n");
  for (const auto& [name, what] : root.at("faults").items())
    std::printf("| `%s` | %s |\n", name.c_str(), what.get<std::string>().c_str());
  return 0;
}
