// omni layer enable, disable, status: what is written where, and what is refused.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include <nlohmann/json.hpp>

#include "service/tools/doctor/elf_file.h"
#include "service/tools/layer/layer_store.h"
#include "tests/support/process/temp_folder.h"

namespace omni::tools {
namespace test_tools_layer {

namespace fs = std::filesystem;

constexpr const char* kLibrary = "/usr/lib/x86_64-linux-gnu/openxr/1/api_layers/libXrApiLayer_core_validation.so";

std::string ExplicitText(const std::string& library, const std::string& name = kLayerName) {
  return R"({"file_format_version": "1.0.0", "api_layer": {"name": ")" + name + R"(", "library_path": ")" + library +
         R"(", "api_version": "1.0", "implementation_version": "1", "description": "d",
             "instance_extensions": [{"name": "XR_A_b", "extension_version": "1", "entrypoints": []}]}})";
}

class LayerStore : public testing::Test {
 protected:
  LayerStore() {
    there_.root = folder_.Path("root");
    there_.environment = {{"HOME", folder_.Path("home")}};
    there_.share = folder_.Path("build/share");
    explicit_ =
        folder_.Write("build/share/openxr/1/api_layers/explicit.d/XrApiLayer_omni.json", ExplicitText(kLibrary));
  }
  std::string UserFile() const {
    return folder_.Path("home/.local/share/openxr/1/api_layers/implicit.d/XrApiLayer_omni.json");
  }
  std::string SystemFile() const {
    return folder_.Path("root/etc/openxr/1/api_layers/implicit.d/XrApiLayer_omni.json");
  }

  void ExpectRefused(LayerScope scope, std::initializer_list<std::string> words) {
    const auto enabled = EnableLayer(there_, scope);
    ASSERT_FALSE(enabled.ok());
    for (const std::string& word : words)
      EXPECT_NE(enabled.error().find(word), std::string::npos) << word << " not in: " << enabled.error();
  }

  test::TempFolder folder_;
  Surroundings there_;
  std::string explicit_;
};

TEST_F(LayerStore, EnableWritesValidImplicitManifest) {
  const auto enabled = EnableLayer(there_, LayerScope::kUser);
  ASSERT_TRUE(enabled.ok()) << enabled.error();
  EXPECT_EQ(enabled->file, UserFile());
  EXPECT_FALSE(enabled->replaced);
  const LayerManifest manifest = ReadLayerManifest(UserFile(), true);
  EXPECT_EQ(manifest.problem, "");
  EXPECT_EQ(manifest.library, kLibrary);
  EXPECT_EQ(manifest.disable_environment, "DISABLE_XR_APILAYER_OMNI_stylus_1") << "it varies with the version";
  EXPECT_EQ(manifest.enable_environment, "");
  EXPECT_EQ(manifest.extensions, std::vector<std::string>{"XR_A_b"});
  const auto mode = fs::status(UserFile()).permissions();
  EXPECT_EQ(mode, fs::perms(0644)) << "everybody's loader may read it";
  EXPECT_EQ(std::distance(fs::directory_iterator(fs::path(UserFile()).parent_path()), {}), 1) << "no temporary is left";
  EXPECT_EQ(CheckEnabledLayers(there_).verdict, Verdict::kOk);
  EXPECT_EQ(LintDisabledByEnvironment(there_).verdict, Verdict::kOk);
  EXPECT_EQ(LintBadInstallation(there_).verdict, Verdict::kOk);
}

TEST_F(LayerStore, EnableReplacesOwnManifestAndFollowsXdgFolders) {
  ASSERT_TRUE(EnableLayer(there_, LayerScope::kUser).ok());
  const auto again = EnableLayer(there_, LayerScope::kUser);
  ASSERT_TRUE(again.ok()) << again.error();
  EXPECT_TRUE(again->replaced);
  there_.environment["XDG_DATA_HOME"] = folder_.Path("data");
  EXPECT_EQ(*ImplicitFolder(there_, LayerScope::kUser), folder_.Path("data/openxr/1/api_layers/implicit.d"));
  there_.environment["XDG_DATA_HOME"] = "relative";  // to be ignored
  EXPECT_EQ(*ImplicitFolder(there_, LayerScope::kUser) / "XrApiLayer_omni.json", UserFile());
  there_.environment.erase("HOME");
  EXPECT_NE(ImplicitFolder(there_, LayerScope::kUser).error().find("HOME"), std::string::npos);
  EXPECT_EQ(*ImplicitFolder(there_, LayerScope::kSystem) / "XrApiLayer_omni.json", SystemFile());
}

TEST_F(LayerStore, RefusesToEnableForUserAndSystemAtOnce) {
  ASSERT_TRUE(EnableLayer(there_, LayerScope::kSystem).ok());
  EXPECT_TRUE(fs::exists(SystemFile()));
  ExpectRefused(LayerScope::kUser, {SystemFile(), "omni layer disable --system"});
  ASSERT_EQ(DisableLayer(there_, LayerScope::kSystem)->size(), 1u);
  ASSERT_TRUE(EnableLayer(there_, LayerScope::kUser).ok());
  ExpectRefused(LayerScope::kSystem, {UserFile(), "omni layer disable --user"});
}

TEST_F(LayerStore, DisableRemovesAllOwnManifestsAndNoOthers) {
  EXPECT_TRUE(DisableLayer(there_, LayerScope::kUser)->empty()) << "nothing there is no error";
  ASSERT_TRUE(EnableLayer(there_, LayerScope::kUser).ok());
  const fs::path folder = fs::path(UserFile()).parent_path();
  std::ofstream(folder / "copy.json") << ExplicitText(kLibrary);
  std::ofstream(folder / "other.json") << ExplicitText(kLibrary, "XR_APILAYER_OTHER_one");
  const auto removed = DisableLayer(there_, LayerScope::kUser);
  ASSERT_TRUE(removed.ok()) << removed.error();
  EXPECT_EQ(*removed, (std::vector<fs::path>{folder / "XrApiLayer_omni.json", folder / "copy.json"}));
  EXPECT_TRUE(fs::exists(folder / "other.json"));
}

TEST_F(LayerStore, NoteOfTheManifestsPlaceGoesWithIt) {
  there_.environment["XDG_DATA_HOME"] = folder_.Path("data");
  const fs::path note = folder_.Path("home/.local/share/omni/layer_manifest");
  ASSERT_TRUE(EnableLayer(there_, LayerScope::kUser).ok());
  EXPECT_TRUE(fs::exists(note));
  there_.environment["XDG_DATA_HOME"] = folder_.Path("elsewhere");
  ASSERT_TRUE(DisableLayer(there_, LayerScope::kUser)->empty());
  EXPECT_TRUE(fs::exists(note)) << "of a manifest that is still there";
  there_.environment["XDG_DATA_HOME"] = folder_.Path("data");
  ASSERT_EQ(DisableLayer(there_, LayerScope::kUser)->size(), 1u);
  EXPECT_FALSE(fs::exists(note));
}

TEST_F(LayerStore, RefusalsNameTheFileAndTheRemedy) {
  folder_.Write("home/.local", "a file where a folder should be");
  ExpectRefused(LayerScope::kUser, {folder_.Path("home/.local/share"), "Not a directory", "XDG_DATA_HOME"});
  there_.environment["SUDO_UID"] = "1000";
  ExpectRefused(LayerScope::kUser, {"sudo", "--system"});
  there_.environment.erase("SUDO_UID");
  there_.environment["HOME"] = folder_.Path("home2");
  const std::string file = folder_.Write("home2/.local/share/openxr/1/api_layers/implicit.d/XrApiLayer_omni.json",
                                         ExplicitText(kLibrary, "XR_APILAYER_OTHER_one"));
  ExpectRefused(LayerScope::kUser, {file, "XR_APILAYER_OTHER_one"});
}

TEST_F(LayerStore, WritesNothingWithoutAWorkingLibrary) {
  fs::remove(explicit_);
  ExpectRefused(LayerScope::kUser, {"XR_APILAYER_OMNI_stylus", "XrApiLayer_omni"});
  folder_.Write("build/share/openxr/1/api_layers/explicit.d/XrApiLayer_omni.json",
                ExplicitText(folder_.Path("gone.so")));
  ExpectRefused(LayerScope::kUser, {folder_.Path("gone.so"), "does not exist"});
  EXPECT_FALSE(fs::exists(UserFile()));
  // Installed in a folder of the loader's, the program somewhere else.
  const std::string installed = folder_.Write(
      "root/usr/share/openxr/1/api_layers/explicit.d/XrApiLayer_omni.x86_64-linux-gnu.json", ExplicitText(kLibrary));
  ASSERT_TRUE(FindInstalledLayer(there_).ok()) << FindInstalledLayer(there_).error();
  EXPECT_EQ(FindInstalledLayer(there_)->file, installed);
}

TEST_F(LayerStore, EnableReplacesBrokenManifest) {
  folder_.Write("home/.local/share/openxr/1/api_layers/implicit.d/XrApiLayer_omni.json", "{ half of");
  const auto enabled = EnableLayer(there_, LayerScope::kUser);
  ASSERT_TRUE(enabled.ok()) << enabled.error();
  EXPECT_EQ(ReadLayerManifest(UserFile(), true).problem, "");
}

TEST(ElfFile, SaysWhatALibraryNeedsAndExports) {
  const auto elf = ReadElfFile(kLibrary);
  ASSERT_TRUE(elf.ok()) << elf.error();
  EXPECT_EQ(elf->architecture(), "x86-64");
  EXPECT_EQ(elf->bytes, fs::file_size(kLibrary));
  EXPECT_NE(std::find(elf->needed.begin(), elf->needed.end(), "libc.so.6"), elf->needed.end());
  EXPECT_NE(std::find(elf->exported.begin(), elf->exported.end(), "xrNegotiateLoaderApiLayerInterface"),
            elf->exported.end());
  EXPECT_EQ(elf->newest_glibc.rfind("2.", 0), 0u) << elf->newest_glibc;
}

// Reading terminates and stays in bounds for any bytes.
TEST(ElfFile, SurvivesCorruptedFiles) {
  test::TempFolder folder;
  std::ifstream in(kLibrary, std::ios::binary);
  const std::string good((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  std::uint64_t state = 7;
  const auto next = [&state] { return state = state * 6364136223846793005ULL + 1442695040888963407ULL; };
  for (int i = 0; i < 40; ++i) {
    std::string bad = good;
    // Mostly in the headers, where offsets and counts are.
    for (int k = 0; k < 64; ++k) {
      const std::size_t range = k % 2 == 0 ? 64 : bad.size();
      bad[(next() >> 20) % range] = static_cast<char>(next() >> 33);
    }
    bad.resize((next() >> 20) % bad.size());
    const auto elf = ReadElfFile(folder.Write("bad.so", bad));
    EXPECT_TRUE(elf.ok() || elf.error().find("bad.so") != std::string::npos) << elf.error();
  }
  EXPECT_FALSE(ReadElfFile(folder.Path("none")).ok());
  EXPECT_FALSE(ReadElfFile(folder.Write("text", "hello")).ok());
}

}  // namespace test_tools_layer
}  // namespace omni::tools
