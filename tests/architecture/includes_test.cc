#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "tests/architecture/includes.h"

namespace omni::architecture {
namespace {

std::string Joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

const SourceTree& OurTree() {
  static const SourceTree kTree = ReadTree(OMNI_SOURCE_DIR);
  return kTree;
}

TEST(Includes, EveryIncludeOfEveryTargetIsAllowed) {
  ASSERT_GT(OurTree().size(), 80U);
  EXPECT_EQ(Joined(CheckIncludes(OurTree())), "");
}

TEST(Includes, NoCycles) { EXPECT_EQ(Joined(FindCycles(OurTree())), ""); }

// The layer runs in third-party processes and anyone may build its clients: protocol, client and what the layer uses
// from base need only the standard library and the system.
TEST(Includes, ClientsNeedTheStandardLibraryOnly) {
  for (const auto& [path, text] : OurTree()) {
    const std::string module = ModuleOf(path);
    if (module != "service/protocol" && module != "service/client" && module != "layer") continue;
    for (const std::string& reached : ReachableFrom(OurTree(), path)) {
      if (ModuleOf(reached) == "layer") continue;  // it uses OpenXR, GLM and a reader of JSON itself
      for (const std::string& header : HeadersOf(OurTree().at(reached)))
        EXPECT_TRUE(OurTree().count(header) != 0 || IsStandard(header))
            << path << " gets " << header << " by " << reached;
    }
  }
}

TEST(Includes, FindsTransitiveThirdPartyIncludes) {
  SourceTree tree;
  tree["service/base/eigen.h"] = "#include <Eigen/Core>\n";
  tree["service/base/near.h"] = "#include \"service/base/eigen.h\"\n";
  tree["service/protocol/far.h"] = "#include <vector>\n#include \"service/base/near.h\"\n";
  EXPECT_EQ(ReachableFrom(tree, "service/protocol/far.h").size(), 3U);
  EXPECT_TRUE(IsStandard("vector") && IsStandard("sys/mman.h") && IsStandard("unistd.h"));
  EXPECT_FALSE(IsStandard("Eigen/Core") || IsStandard("tiny_gltf.h"));
}

// A planted violation of each row: every module that the row does not name is refused.
TEST(Includes, DetectsForbiddenIncludeForEachModule) {
  for (const Rule& rule : Rules()) {
    int planted = 0;
    for (const Rule& target : Rules()) {
      if (target.module == rule.module || rule.may_include.count(target.module) != 0) continue;
      SourceTree tree;
      tree[rule.module + "/planted.cc"] = "// ok\n#include \"" + target.module + "/anything.h\"\n";
      const auto violations = CheckIncludes(tree);
      ASSERT_EQ(violations.size(), 1U) << rule.module << " -> " << target.module;
      EXPECT_NE(violations[0].find("planted.cc:2"), std::string::npos);
      ++planted;
    }
    EXPECT_GT(planted, 0) << rule.module << " may include everything: the row says nothing";
  }
}

TEST(Includes, AcceptsAllowedIncludesForEachModule) {
  for (const Rule& rule : Rules()) {
    SourceTree tree;
    std::string text = "#include \"" + rule.module + "/own.h\"\n#include <vector>\n";
    for (const std::string& module : rule.may_include) text += "#include \"" + module + "/x.h\"\n";
    tree[rule.module + "/fine.cc"] = text;
    EXPECT_EQ(Joined(CheckIncludes(tree)), "") << rule.module;
  }
}

TEST(Includes, DetectsConfinedHeadersElsewhere) {
  for (const Confined& confined : ConfinedHeaders()) {
    SourceTree tree;
    tree["service/protocol/planted.h"] = "#include <" + confined.header_prefix + "x.h>\n";
    EXPECT_EQ(CheckIncludes(tree).size(), 1U) << confined.header_prefix;
  }
}

// "One .cc": the wrapped libraries are included by a single file.
TEST(Includes, WrappedLibrariesStandInOneFile) {
  for (const std::string header : {"stb/stb_image.h", "libusb.h"}) {
    int files = 0;
    for (const auto& [path, text] : OurTree()) files += text.find("<" + header + ">") != std::string::npos ? 1 : 0;
    EXPECT_LE(files, 1) << header;
  }
}

// Files that include <header>, tests included: one path per line.
std::string Including(const std::string& header) {
  std::string including;
  for (const auto& [path, text] : ReadTree(OMNI_SOURCE_DIR, {"layer", "service", "firmware", "tests", "scenes"}))
    if (text.find("#include <" + header + ">") != std::string::npos) including += path + "\n";
  return including;
}

// It is an independent reference for our glTF reader, and for the file that the layer gives to applications.
TEST(Includes, OnlyJudgesIncludeTinyGltf) {
  EXPECT_EQ(Including("tiny_gltf.h"), "tests/scene/decode_judge.cc\ntests/scenes/pen.cc\n");
}

// It takes seconds to compile.
TEST(Includes, OnlyConsoleCommandIncludesCli11) { EXPECT_EQ(Including("CLI/CLI.hpp"), "service/console/command.cc\n"); }

// The libraries' parsers recurse, rescan and allocate without bounds, so their input is checked first. The layer's
// profiles are part of its library.
TEST(Includes, LibraryParsersReceiveOnlyCheckedText) {
  for (const auto& [path, text] : OurTree()) {
    if (path == "layer/src/actions/profile_json.cc") continue;
    const auto has = [&text = text](const char* word) { return text.find(word) != std::string::npos; };
    EXPECT_TRUE(!has("json::parse(") || has("ReadJsonFile(") || has("CheckJson(")) << path;
    EXPECT_TRUE(!has("toml::parse(") || has("CheckToml(")) << path;
    EXPECT_FALSE(has("json::sax_parse(") || has("LoadBinaryFromMemory(")) << path;
  }
}

TEST(Includes, RejectsUnknownModulesAndTestHeaders) {
  SourceTree tree;
  tree["service/new_module/a.h"] = "";
  tree["service/base/b.h"] = "#include \"tests/support/x.h\"\n";
  EXPECT_EQ(CheckIncludes(tree).size(), 2U);
}

TEST(Includes, CycleIsFound) {
  SourceTree tree;
  tree["service/base/a.h"] = "#include \"service/base/b.h\"\n";
  tree["service/base/b.h"] = "#include \"service/base/c.h\"\n";
  tree["service/base/c.h"] = "#include \"service/base/a.h\"\n";
  EXPECT_EQ(FindCycles(tree).size(), 1U);
}

// The table in docs/architecture.md is the one that is checked: each module has its row there.
TEST(Includes, ArchitectureDocumentNamesEveryModule) {
  std::ifstream file(std::string(OMNI_SOURCE_DIR) + "/docs/architecture.md");
  std::ostringstream text;
  text << file.rdbuf();
  for (const Rule& rule : Rules()) {
    if (!std::filesystem::exists(std::string(OMNI_SOURCE_DIR) + "/" + rule.module)) continue;
    EXPECT_NE(text.str().find("`" + rule.module + "`"), std::string::npos) << rule.module;
  }
}

// Files stay small: one idea each.
TEST(Files, NoneIsLongerThan500Lines) {
  for (const auto& [path, text] : OurTree()) {
    EXPECT_LE(std::count(text.begin(), text.end(), '\n'), 500) << path;
  }
}

}  // namespace
}  // namespace omni::architecture
