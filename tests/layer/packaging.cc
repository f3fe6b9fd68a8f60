// What lies on disk: manifests, exported symbols, profile files.
#include <dlfcn.h>
#include <gtest/gtest.h>

#include <stdlib.h>
#include <algorithm>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "layer/src/actions/profile.h"
#include "layer/src/entry/loader_interface.h"
#include "layer/src/entry/own_extensions.h"
#include "tests/layer/support/app.h"
#include "tests/support/process/scoped_variable.h"
#include "tests/support/process/temp_folder.h"

namespace omni::test {
namespace test_packaging {

const std::string kBuild = OMNI_BINARY_DIR;

nlohmann::json Manifest(const std::string& folder) {
  std::ifstream in(kBuild + "/share/openxr/1/api_layers/" + folder + "/XrApiLayer_omni.json");
  EXPECT_TRUE(in) << folder;
  return nlohmann::json::parse(in);
}

TEST(Packaging, LibraryExportsOnlyTheNegotiateFunction) {
  const std::string command = "nm -D --defined-only " + kBuild + "/lib/libXrApiLayer_omni.so";
  std::FILE* pipe = popen(command.c_str(), "r");
  ASSERT_TRUE(pipe);
  std::set<std::string> symbols;
  char line[512];
  while (std::fgets(line, sizeof(line), pipe)) {
    std::string text(line);
    while (!text.empty() && text.back() == '\n') text.pop_back();
    symbols.insert(text.substr(text.rfind(' ') + 1));
  }
  ASSERT_EQ(pclose(pipe), 0);
  EXPECT_EQ(symbols, std::set<std::string>{"xrNegotiateLoaderApiLayerInterface"});
}

nlohmann::json ReadJson(const std::filesystem::path& file) {
  std::ifstream in(file);
  EXPECT_TRUE(in) << file;
  return nlohmann::json::parse(in, nullptr, false);
}

// `folder` is the manifest's: a relative path of the library begins there.
void ExpectSound(const nlohmann::json& root, const std::filesystem::path& folder) {
  EXPECT_EQ(root["file_format_version"], "1.0.0");
  const nlohmann::json& layer = root["api_layer"];
  EXPECT_EQ(layer["name"], kLayer);
  EXPECT_EQ(layer["api_version"], "1.0");
  EXPECT_EQ(layer["implementation_version"], "1") << "a decimal string, else the loader skips the layer";
  EXPECT_TRUE(std::filesystem::exists(folder / layer["library_path"].get<std::string>()));
  EXPECT_FALSE(layer.contains("enable_environment"));
  EXPECT_FALSE(layer.contains("disable_environment"));
}

TEST(Packaging, BuildTreeHasOnlyAnExplicitManifest) {
  const nlohmann::json manifest = Manifest("explicit.d");
  ExpectSound(manifest, {});
  EXPECT_TRUE(std::filesystem::path(manifest["api_layer"]["library_path"].get<std::string>()).is_absolute());
  EXPECT_FALSE(std::filesystem::exists(kBuild + "/share/openxr/1/api_layers/implicit.d"));
}

// The library's own function: the loader itself reads only the manifests.
PFN_xrEnumerateInstanceExtensionProperties EnumerateOfTheLibrary() {
  void* library = dlopen((kBuild + "/lib/libXrApiLayer_omni.so").c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!library) return nullptr;
  using Negotiate = XrResult(XRAPI_PTR*)(const XrNegotiateLoaderInfo*, const char*, XrNegotiateApiLayerRequest*);
  const auto negotiate = reinterpret_cast<Negotiate>(dlsym(library, "xrNegotiateLoaderApiLayerInterface"));
  const XrNegotiateLoaderInfo loader{
      XR_LOADER_INTERFACE_STRUCT_LOADER_INFO, kLoaderInfoVersion, sizeof(loader), 1, 1, XR_MAKE_VERSION(1, 0, 0),
      XR_MAKE_VERSION(1, 1023, 4095)};
  XrNegotiateApiLayerRequest request{
      XR_LOADER_INTERFACE_STRUCT_API_LAYER_REQUEST, kApiLayerRequestVersion, sizeof(request), 0, 0, nullptr, nullptr};
  PFN_xrVoidFunction found = nullptr;
  if (!negotiate || negotiate(&loader, kLayer, &request) != XR_SUCCESS ||
      request.getInstanceProcAddr(XR_NULL_HANDLE, "xrEnumerateInstanceExtensionProperties", &found) != XR_SUCCESS)
    return nullptr;
  return reinterpret_cast<PFN_xrEnumerateInstanceExtensionProperties>(found);
}

// layer/extensions.json is the only list: the manifest, the layer's enumeration and the tables of its own functions
// agree.
TEST(Packaging, ManifestEnumerationAndFunctionsAgreeOnExtensions) {
  std::map<std::string, std::uint32_t> listed;
  std::map<std::string, std::set<std::string>> functions;
  const nlohmann::json manifest = Manifest("explicit.d");
  for (const nlohmann::json& extension : manifest["api_layer"]["instance_extensions"]) {
    const std::string name = extension["name"];
    listed[name] = static_cast<std::uint32_t>(std::stoul(extension["extension_version"].get<std::string>()));
    for (const nlohmann::json& function : extension["entrypoints"]) functions[name].insert(function);
  }
  std::map<std::string, std::uint32_t> enumerated;
  std::uint32_t count = 0;
  const auto enumerate = EnumerateOfTheLibrary();
  ASSERT_TRUE(enumerate);
  ASSERT_EQ(enumerate(kLayer, 0, &count, nullptr), XR_SUCCESS);
  std::vector<XrExtensionProperties> properties(count, {XR_TYPE_EXTENSION_PROPERTIES, nullptr, "", 0});
  ASSERT_EQ(enumerate(kLayer, count, &count, properties.data()), XR_SUCCESS);
  for (const XrExtensionProperties& extension : properties)
    enumerated[extension.extensionName] = extension.extensionVersion;
  EXPECT_EQ(listed, enumerated);
  std::map<std::string, std::set<std::string>> own;
  for (const layer::OwnFunction& function : layer::OwnFunctions())
    if (std::string(function.extension) != XR_EXT_CONFORMANCE_AUTOMATION_EXTENSION_NAME)  // of another manifest
      own[function.extension].insert(function.name);
  EXPECT_EQ(functions, own);
}

// The library in lib/<triplet>/openxr/1/api_layers and one manifest per architecture, as Debian does it; the manifest
// names the library relative to itself, so that the prefix may be moved.
TEST(Packaging, InstalledLayerIsFoundByTheLoader) {
  namespace fs = std::filesystem;
  const TempFolder folder;
  const std::string prefix = folder.Path("prefix");
  const std::string command = std::string(OMNI_CMAKE) + " --install " + kBuild + " --component layer --prefix " +
                              prefix + " >" + folder.Path("log") + " 2>&1";
  ASSERT_EQ(std::system(command.c_str()), 0) << command;
  const fs::path manifests = fs::path(prefix) / "share/openxr/1/api_layers/explicit.d";
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(manifests)) files.push_back(entry.path());
  ASSERT_EQ(files.size(), 1u);
  EXPECT_EQ(files[0].filename().string().rfind("XrApiLayer_omni", 0), 0u) << files[0];
  const nlohmann::json manifest = ReadJson(files[0]);
  ExpectSound(manifest, manifests);
  const fs::path library = manifest["api_layer"]["library_path"].get<std::string>();
  EXPECT_TRUE(library.is_relative()) << library;
  EXPECT_EQ((manifests / library).lexically_normal().string().rfind(prefix + "/", 0), 0u) << library;
  EXPECT_EQ(manifest["api_layer"]["instance_extensions"], Manifest("explicit.d")["api_layer"]["instance_extensions"]);
  const ScopedVariable path("XR_API_LAYER_PATH", manifests.string());
  std::uint32_t count = 0;
  ASSERT_EQ(xrEnumerateApiLayerProperties(0, &count, nullptr), XR_SUCCESS);
  ASSERT_EQ(count, 1u);
  const App app({.begin = false, .attach = false});  // the loader opens the library from there
}

TEST(Packaging, LoaderFindsLayerAndExtension) {
  std::uint32_t count = 0;
  ASSERT_EQ(xrEnumerateApiLayerProperties(0, &count, nullptr), XR_SUCCESS);
  std::vector<XrApiLayerProperties> layers(count, {XR_TYPE_API_LAYER_PROPERTIES, nullptr, "", 0, 0, ""});
  ASSERT_EQ(xrEnumerateApiLayerProperties(count, &count, layers.data()), XR_SUCCESS);
  ASSERT_EQ(count, 1u);
  EXPECT_STREQ(layers[0].layerName, kLayer);
  ASSERT_EQ(xrEnumerateInstanceExtensionProperties(kLayer, 0, &count, nullptr), XR_SUCCESS);
  EXPECT_EQ(count, Manifest("explicit.d")["api_layer"]["instance_extensions"].size()) << "the manifest names all";
}

TEST(Packaging, EmbeddedProfilesLoadInOrderOfPriority) {
  const std::vector<layer::Profile> profiles = layer::LoadProfiles();
  ASSERT_GE(profiles.size(), 6u);
  const char* const first[] = {kOmniStylus, kMxInk, kGeneric, kTouch, kIndex};
  for (std::size_t i = 0; i < std::size(first); ++i) EXPECT_EQ(profiles[i].path, first[i]);
  EXPECT_EQ(profiles.back().path, kSimple);
  for (const layer::Profile& profile : profiles) {
    std::set<std::string> paths;
    for (const layer::Component& c : profile.components) EXPECT_TRUE(paths.insert(c.path).second) << c.path;
    EXPECT_GE(profile.poses.size(), 2u);
  }
}

TEST(Packaging, ProfileErrorNamesFileAndField) {
  std::string good;
  for (const layer::EmbeddedFile& file : layer::EmbeddedProfiles())
    if (std::string(file.name) == "oculus_touch.json") good = file.text;
  ASSERT_FALSE(good.empty());
  EXPECT_NO_THROW(layer::ParseProfile("x.json", good));
  const auto message = [](const std::string& text) -> std::string {
    try {
      layer::ParseProfile("x.json", text);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_NE(message("{").find("x.json"), std::string::npos);
  EXPECT_NE(message("[]").find("x.json"), std::string::npos);
  std::string wrong = good;
  wrong.replace(wrong.find("\"source\": \""), 11, "\"source\": \"un");
  EXPECT_NE(message(wrong).find("/components/"), std::string::npos) << message(wrong);
  wrong = good;
  wrong.replace(wrong.find("[1, 0, 0, 0]"), 12, "[2, 0, 0, 0]");
  EXPECT_NE(message(wrong).find("orientation_tool_wxyz"), std::string::npos) << message(wrong);
  wrong = good;
  wrong.replace(wrong.find("\"float\""), 7, "\"int\"");
  EXPECT_NE(message(wrong).find("/type"), std::string::npos) << message(wrong);
}

// [input-suggested-bindings] the source of a path for an action type.
TEST(Packaging, PathsResolveByActionType) {
  using layer::Hand;
  const std::vector<layer::Profile> profiles = layer::LoadProfiles();
  const layer::Profile& touch =
      *std::find_if(profiles.begin(), profiles.end(), [](const layer::Profile& p) { return p.path == kTouch; });
  const auto path = [&](XrActionType type, const char* text) {
    const auto binding = layer::ResolveBinding(touch, Hand::kRight, type, text);
    return binding ? binding->path : std::string();
  };
  EXPECT_EQ(path(XR_ACTION_TYPE_BOOLEAN_INPUT, "/user/hand/right/input/trigger"),
            "/user/hand/right/input/trigger/value");
  EXPECT_EQ(path(XR_ACTION_TYPE_BOOLEAN_INPUT, "/user/hand/right/input/thumbstick"),
            "/user/hand/right/input/thumbstick/click");
  EXPECT_EQ(path(XR_ACTION_TYPE_FLOAT_INPUT, "/user/hand/right/input/a"), "/user/hand/right/input/a/click");
  EXPECT_EQ(path(XR_ACTION_TYPE_VECTOR2F_INPUT, "/user/hand/right/input/thumbstick"),
            "/user/hand/right/input/thumbstick");
  EXPECT_EQ(path(XR_ACTION_TYPE_POSE_INPUT, "/user/hand/right/input/grip"), "/user/hand/right/input/grip/pose");
  EXPECT_EQ(path(XR_ACTION_TYPE_VECTOR2F_INPUT, "/user/hand/right/input/trigger"), "") << "not convertible";
  EXPECT_EQ(path(XR_ACTION_TYPE_BOOLEAN_INPUT, "/user/hand/right/input/x/click"), "") << "the left hand's";
  EXPECT_EQ(path(XR_ACTION_TYPE_BOOLEAN_INPUT, "/user/hand/left/input/trigger/value"), "") << "another hand";
  const auto click =
      layer::ResolveBinding(touch, Hand::kRight, XR_ACTION_TYPE_BOOLEAN_INPUT, "/user/hand/right/input/trigger/touch");
  ASSERT_TRUE(click);
  EXPECT_EQ(click->identifier, "/user/hand/right/input/trigger") << "what priorities collide on";
}

}  // namespace test_packaging
}  // namespace omni::test
