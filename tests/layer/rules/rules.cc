// The table of rules is complete: each has tests that exist, the faults are those of seeds.json, the page is current.
#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

namespace omni::test {
namespace test_rules {

namespace fs = std::filesystem;

std::string Content(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::string Format(const std::string& command) {
  std::string text;
  std::FILE* pipe = popen(command.c_str(), "r");
  if (!pipe) return text;
  char part[4096];
  for (std::size_t size = 0; (size = std::fread(part, 1, sizeof(part), pipe)) > 0;) text.append(part, size);
  return pclose(pipe) == 0 ? text : "";
}

const nlohmann::json& Table() {
  static const nlohmann::json table = nlohmann::json::parse(Content(OMNI_SOURCE_DIR "/tests/layer/rules/rules.json"));
  return table;
}

template <class Visit>
void ForEachRule(Visit visit) {
  for (const nlohmann::json& group : Table().at("groups"))
    for (const nlohmann::json& rule : group.at("rules")) visit(rule);
}

// "Suite.Name" of every test in this program, or in build/tests/test_NAME.
std::set<std::string> TestsOf(const std::string& program) {
  std::set<std::string> tests;
  std::istringstream lines(Format("'" OMNI_BINARY_DIR "/tests/test_" + program + "' --gtest_list_tests"));
  std::string suite;
  for (std::string line; std::getline(lines, line);) {
    line = line.substr(0, line.find_first_of("#\r"));
    while (!line.empty() && line.back() == ' ') line.pop_back();
    if (line.empty()) continue;
    if (line[0] != ' ')
      suite = line;
    else
      tests.insert(suite + line.substr(line.find_first_not_of(' ')));
  }
  return tests;
}

TEST(Rules, EveryRuleNamesExistingTests) {
  std::map<std::string, std::set<std::string>> programs;
  int rules = 0;
  ForEachRule([&](const nlohmann::json& rule) {
    ++rules;
    const std::string id = rule.at("id");
    EXPECT_FALSE(rule.at("tests").empty()) << id << " has no test";
    EXPECT_FALSE(rule.at("spec").get<std::string>().empty()) << id << " names no place in the specification";
    for (const std::string test : rule.at("tests")) {
      const std::string program = test.substr(0, test.find('.'));
      if (programs.count(program) == 0) programs[program] = TestsOf(program);
      EXPECT_EQ(programs[program].count(test.substr(program.size() + 1)), 1u) << id << ": there is no " << test;
    }
  });
  EXPECT_GT(rules, 150);
}

TEST(Rules, IdsAreUniqueAndEachGroupHasAFault) {
  std::set<std::string> ids;
  for (const nlohmann::json& group : Table().at("groups")) {
    std::size_t faults = 0;
    for (const nlohmann::json& rule : group.at("rules")) {
      EXPECT_TRUE(ids.insert(rule.at("id")).second) << rule.at("id");
      faults += rule.at("faults").size();
    }
    EXPECT_GT(faults, 0u) << group.at("title") << ": nothing shows that its tests can fail";
  }
}

// Every fault of the table is seeded and breaks a rule; no others are seeded. Each row finds its place: seed_faults, at
// the build.
TEST(Rules, FaultTableMatchesSeedsFile) {
  std::map<std::string, int> places;
  for (const nlohmann::json& row : nlohmann::json::parse(Content(OMNI_SOURCE_DIR "/tests/layer/faults/seeds.json")))
    ++places[row.at("name")];
  std::set<std::string> named;
  ForEachRule([&](const nlohmann::json& rule) {
    for (const std::string fault : rule.at("faults")) named.insert(fault);
  });
  for (const auto& [fault, what] : Table().at("faults").items()) {
    EXPECT_GE(places[fault], 1) << fault << " is not in seeds.json";
    EXPECT_EQ(named.count(fault), 1u) << fault << " breaks no rule of the table";
  }
  for (const auto& [fault, count] : places) EXPECT_TRUE(Table().at("faults").contains(fault)) << fault;
}

// The sources that are read are those that ship.
TEST(Faults, LayerSourcesContainNoFaults) {
  for (const auto& entry : fs::recursive_directory_iterator(OMNI_SOURCE_DIR "/layer/src")) {
    if (!entry.is_regular_file()) continue;
    const std::string text = Content(entry.path());
    EXPECT_TRUE(text.find("FAULT(") == std::string::npos && text.find("FaultIs") == std::string::npos) << entry.path();
  }
}

TEST(Rules, GeneratedPageMatchesCommittedPage) {
  const std::string printed = Format("'" OMNI_BINARY_DIR "/bin/layer_rules_page'");
  ASSERT_FALSE(printed.empty());
  EXPECT_TRUE(printed == Content(OMNI_SOURCE_DIR "/docs/howto/openxr-rules.md"))
      << "run " OMNI_BINARY_DIR "/bin/layer_rules_page > docs/howto/openxr-rules.md";
}

// The library that ships has neither the names of the faults nor the code that reads them.
TEST(Faults, ShippedLibraryContainsNoFaults) {
  const std::string library = Content(OMNI_BINARY_DIR "/lib/libXrApiLayer_omni.so");
  ASSERT_NE(library.find("connected to omnid"), std::string::npos) << "the layer's strings can be found";
  EXPECT_EQ(library.find("OMNI_LAYER_FAULT"), std::string::npos);
  for (const auto& [fault, what] : Table().at("faults").items())
    EXPECT_EQ(library.find(fault), std::string::npos) << fault;
  EXPECT_EQ(Format("nm -C '" OMNI_BINARY_DIR "/lib/libXrApiLayer_omni.so'").find("FaultIs"), std::string::npos);
}

}  // namespace test_rules
}  // namespace omni::test
