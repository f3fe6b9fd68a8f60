// The six rules over layers, on generated trees of manifests: a clean tree has no finding, each seeded defect is named
// by its rule; and the loader of this machine agrees with our rules.
#include <gtest/gtest.h>

#include <elf.h>
#include <stdlib.h>

#include <algorithm>
#include <cstring>
#include <random>
#include <set>

#include "service/tools/doctor/diagnosis.h"
#include "service/tools/doctor/openxr_manifests.h"
#include "tests/support/process/scoped_variable.h"
#include "tests/support/process/temp_folder.h"

namespace omni::tools {
namespace test_tools_lint {

using Random = std::mt19937_64;

std::size_t Pick(Random& random, std::size_t count) {
  return std::uniform_int_distribution<std::size_t>(0, count - 1)(random);
}
bool Coin(Random& random) { return Pick(random, 2) == 0; }

// A file that begins as a library of that architecture does.
std::string ElfOf(int bits, std::uint16_t machine) {
  Elf64_Ehdr header{};
  std::memcpy(header.e_ident, ELFMAG, SELFMAG);
  header.e_ident[EI_CLASS] = bits == 64 ? ELFCLASS64 : ELFCLASS32;
  header.e_ident[EI_DATA] = ELFDATA2LSB;
  header.e_machine = machine;
  return {reinterpret_cast<const char*>(&header), sizeof(header)};
}

struct GeneratedLayer {
  std::string name;
  bool implicit = false;
  std::string folder;  // below the tree
  std::string library;
  std::string file;
};

// System folders, home and environment of its own, with sound layers.
class Tree {
 public:
  explicit Tree(Random& random) : random_(random) {
    there.root = folder_.Path("root");
    there.environment = {{"HOME", folder_.Path("home")}};
    folder_.Write("root/usr/lib/x86_64-linux-gnu/libopenxr_loader.so.1", ElfOf(64, EM_X86_64));
    std::string enabled;
    const std::size_t count = 1 + Pick(random_, 5);
    for (std::size_t i = 0; i < count; ++i) {
      const GeneratedLayer& layer = Add("XR_APILAYER_TEST_" + std::to_string(i), Coin(random_));
      if (!layer.implicit && Coin(random_)) Enable(layer.name);
    }
    Listen();
  }

  const GeneratedLayer& Add(const std::string& name, bool implicit, const std::string& folder = {}) {
    static const char* const kFolders[] = {"root/usr/share", "root/usr/local/share", "root/etc", "root/etc/xdg",
                                           "home/.local/share"};
    GeneratedLayer layer{
        name, implicit, folder.empty() ? kFolders[Pick(random_, std::size(kFolders))] : folder, {}, {}};
    layer.library = folder_.Write("lib/lib" + name + ".so", ElfOf(64, EM_X86_64));
    layers.push_back(layer);
    Write(layers.back(), implicit ? R"(, "disable_environment": "DISABLE_)" + name + "\"" : "");
    return layers.back();
  }

  void Write(GeneratedLayer& layer, const std::string& more, const std::string& version = "1") {
    const std::string library = layer.library.empty() ? "" : R"("library_path": ")" + layer.library + "\", ";
    WriteText(layer, R"({"file_format_version": "1.0.0", "api_layer": {"name": ")" + layer.name + "\", " + library +
                         R"("api_version": "1.0", "implementation_version": ")" + version + "\"" + more + "}}");
  }
  void WriteText(GeneratedLayer& layer, const std::string& text) {
    layer.file = folder_.Write(layer.folder + "/openxr/1/api_layers/" +
                                   (layer.implicit ? "implicit.d/" : "explicit.d/") + layer.name + ".json",
                               text);
  }
  void Enable(const std::string& name) {
    std::string& list = there.environment["XR_ENABLE_API_LAYERS"];
    list += (list.empty() ? "" : ":") + name;
  }
  // Makes the loader list the usable layers.
  void Listen() {
    there.loader = {true, {}, {}};
    for (const LayerManifest& manifest : FindLayerManifests(there))
      if (IsUsable(manifest, there)) there.loader.layers.push_back(manifest.name);
  }
  GeneratedLayer& Some(bool implicit) {
    std::vector<std::size_t> fitting;
    for (std::size_t i = 0; i < layers.size(); ++i)
      if (layers[i].implicit == implicit) fitting.push_back(i);
    if (fitting.empty()) {
      Add("XR_APILAYER_TEST_more", implicit);
      return layers.back();
    }
    return layers[fitting[Pick(random_, fitting.size())]];
  }
  test::TempFolder& folder() { return folder_; }

  Surroundings there;
  std::vector<GeneratedLayer> layers;

 private:
  Random& random_;
  test::TempFolder folder_;
};

using Lint = Finding (*)(const Surroundings&);
constexpr Lint kLints[] = {LintBadInstallation, LintDisabledByEnvironment,
                           LintDuplicates,      LintExplicitLayerArchitectures,
                           LintOrdering,        LintSkippedByLoader};

// Seeds a defect and returns what the finding must name.
struct Defect {
  const char* name;
  Lint rule;
  std::string (*seed)(Tree&, Random&);
};
const Defect kDefects[] = {
    {"not JSON", LintBadInstallation,
     [](Tree& tree, Random& random) {
       GeneratedLayer& layer = tree.Some(Coin(random));
       tree.WriteText(layer, "{");
       return layer.file;
     }},
    {"no library_path", LintBadInstallation,
     [](Tree& tree, Random& random) {
       GeneratedLayer& layer = tree.Some(Coin(random));
       layer.library.clear();
       tree.Write(layer, R"(, "disable_environment": "D")");
       return layer.file;
     }},
    {"library is gone", LintBadInstallation,
     [](Tree& tree, Random& random) {
       const GeneratedLayer& layer = tree.Some(Coin(random));
       std::filesystem::remove(layer.library);
       return layer.library;
     }},
    {"version is no number", LintBadInstallation,
     [](Tree& tree, Random& random) {
       GeneratedLayer& layer = tree.Some(Coin(random));
       tree.Write(layer, R"(, "disable_environment": "D")", Coin(random) ? "1.2" : "");
       return layer.file;
     }},
    {"variable names an absent layer", LintBadInstallation,
     [](Tree& tree, Random&) {
       tree.Enable("XR_APILAYER_TEST_absent");
       return std::string("XR_APILAYER_TEST_absent");
     }},
    {"cannot be switched off", LintDisabledByEnvironment,
     [](Tree& tree, Random&) {
       GeneratedLayer& layer = tree.Some(true);
       tree.Write(layer, "");
       return layer.name;
     }},
    {"waits to be enabled", LintDisabledByEnvironment,
     [](Tree& tree, Random&) {
       GeneratedLayer& layer = tree.Some(true);
       tree.Write(layer, R"(, "disable_environment": "D", "enable_environment": "E")");
       return layer.name;
     }},
    {"is switched off", LintDisabledByEnvironment,
     [](Tree& tree, Random& random) {
       const GeneratedLayer& layer = tree.Some(true);
       tree.there.environment["DISABLE_" + layer.name] = Coin(random) ? "" : "0";
       return "DISABLE_" + layer.name;
     }},
    {"twice", LintDuplicates,
     [](Tree& tree, Random& random) {
       const GeneratedLayer layer = tree.Some(Coin(random));
       return tree.Add(layer.name, layer.implicit, layer.folder == "root/etc" ? "root/usr/share" : "root/etc").file;
     }},
    {"another architecture", LintExplicitLayerArchitectures,
     [](Tree& tree, Random&) {
       const GeneratedLayer& layer = tree.Some(false);
       tree.Enable(layer.name);
       tree.folder().Write("root/usr/lib/i386-linux-gnu/libopenxr_loader.so.1", ElfOf(32, EM_386));
       return layer.name;
     }},
    {"wrong order", LintOrdering,
     [](Tree& tree, Random&) {
       tree.Enable(tree.Add("XR_APILAYER_NOVENDOR_motion_compensation", false).name);
       tree.Enable(tree.Add(kLayerName, false).name);
       return std::string(kLayerName) + " must be above";
     }},
    {"order by chance", LintOrdering,
     [](Tree& tree, Random&) {
       tree.Add("XR_APILAYER_NOVENDOR_motion_compensation", true);
       tree.Add(kLayerName, true);
       return std::string("only by chance");
     }},
    {"skipped", LintSkippedByLoader,
     [](Tree& tree, Random& random) {
       const std::string name = tree.Some(Coin(random)).name;
       auto& listed = tree.there.loader.layers;
       listed.erase(std::remove(listed.begin(), listed.end(), name), listed.end());
       return name;
     }},
    {"loader fails", LintSkippedByLoader,
     [](Tree& tree, Random&) {
       tree.there.loader.error = "XrResult -32";
       return tree.there.loader.error;
     }},
};

TEST(LayerRules, FindOnlySeededDefectsAndNameThem) {
  constexpr std::uint64_t kSeedsPerDefect = 3;
  for (const Defect& defect : kDefects) {
    for (std::uint64_t seed = 1; seed <= kSeedsPerDefect; ++seed) {
      SCOPED_TRACE(std::string(defect.name) + ", seed " + std::to_string(seed));
      Random random(seed);
      Tree tree(random);
      for (const Lint lint : kLints) {
        const Finding finding = lint(tree.there);
        ASSERT_EQ(finding.verdict, Verdict::kOk) << finding.what;
        ASSERT_TRUE(finding.fix.empty()) << finding.fix;
      }
      if (defect.rule != LintSkippedByLoader) {
        const std::string named = defect.seed(tree, random);
        tree.Listen();
        const Finding finding = defect.rule(tree.there);
        ASSERT_NE(finding.verdict, Verdict::kOk);
        ASSERT_NE(finding.what.find(named), std::string::npos) << named << " not in: " << finding.what;
        ASSERT_FALSE(finding.fix.empty());
      } else {
        tree.Some(true);
        tree.Some(false);
        tree.Listen();
        const std::string named = defect.seed(tree, random);
        const Finding finding = defect.rule(tree.there);
        ASSERT_NE(finding.verdict, Verdict::kOk);
        ASSERT_NE(finding.what.find(named), std::string::npos) << named << " not in: " << finding.what;
      }
    }
  }
}

TEST(LayerRules, AcceptWorkingLayerOrder) {
  Random random(1);
  Tree tree(random);
  tree.Enable(tree.Add(kLayerName, false).name);
  tree.Enable(tree.Add("XR_APILAYER_NOVENDOR_motion_compensation", false).name);
  EXPECT_EQ(LintOrdering(tree.there).verdict, Verdict::kOk) << LintOrdering(tree.there).what;
}

// One manifest per architecture, as Debian installs them, is no duplicate.
TEST(LayerRules, AcceptOneManifestPerArchitecture) {
  Random random(2);
  Tree tree(random);
  GeneratedLayer layer = tree.Add("XR_APILAYER_TEST_multi", false, "root/usr/share");
  layer.library = tree.folder().Write("lib/i386.so", ElfOf(32, EM_386));
  layer.folder = "root/usr/local/share";
  tree.Write(layer, "");
  tree.folder().Write("root/usr/lib/i386-linux-gnu/libopenxr_loader.so.1", ElfOf(32, EM_386));
  tree.Enable("XR_APILAYER_TEST_multi");
  tree.Listen();
  EXPECT_EQ(LintDuplicates(tree.there).verdict, Verdict::kOk) << LintDuplicates(tree.there).what;
  for (const GeneratedLayer& other : tree.layers)
    if (other.name != "XR_APILAYER_TEST_multi") return;
  EXPECT_EQ(LintExplicitLayerArchitectures(tree.there).verdict, Verdict::kOk);
}

// Our rules accept exactly the layers that the loader of this machine lists, on valid and on defective trees.
TEST(LayerRules, MatchTheInstalledOpenXrLoader) {
  if (!QueryLoader().asked) GTEST_SKIP() << "no libopenxr_loader.so.1 here";
  for (std::uint64_t seed = 1; seed <= 28; ++seed) {
    Random random(seed);
    Tree tree(random);
    const Defect& defect = kDefects[seed % std::size(kDefects)];
    SCOPED_TRACE(std::string(defect.name) + ", seed " + std::to_string(seed));
    // Debian's loader 1.0.20 accepts any text as version; the manifest rules require a number, and so do we.
    if (std::strcmp(defect.name, "version is no number") == 0) continue;
    if (defect.rule != LintSkippedByLoader) defect.seed(tree, random);
    const std::string root = tree.folder().Path("root");
    const test::ScopedVariable data("XDG_DATA_DIRS", root + "/usr/local/share:" + root + "/usr/share");
    const test::ScopedVariable config("XDG_CONFIG_DIRS", root + "/etc/xdg:" + root + "/etc");
    const test::ScopedVariable home("XDG_DATA_HOME", tree.folder().Path("home/.local/share"));
    std::vector<std::unique_ptr<test::ScopedVariable>> off;
    for (const auto& [name, value] : tree.there.environment)
      if (name.rfind("DISABLE_", 0) == 0) off.push_back(std::make_unique<test::ScopedVariable>(name.c_str(), value));
    std::set<std::string> expected;
    for (const LayerManifest& manifest : FindLayerManifests(tree.there))
      if (IsUsable(manifest, tree.there)) expected.insert(manifest.name);
    const LoaderAnswer loader = QueryLoader();
    ASSERT_EQ(loader.error, "");
    std::set<std::string> listed(loader.layers.begin(), loader.layers.end());
    // Layers below the real /etc are there as well.
    Surroundings real;
    for (const LayerManifest& manifest : FindLayerManifests(real)) {
      if (manifest.file.string().rfind("/etc/", 0) == 0) expected.insert(manifest.name);
    }
    ASSERT_EQ(listed, expected);
  }
}

}  // namespace test_tools_lint
}  // namespace omni::tools
