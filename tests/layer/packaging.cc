// What lies on disk: manifests, exported symbols, profile files.
#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "layer/src/profile.h"
#include "tests/layer/app.h"

namespace omni::test {
namespace {

const std::string kBuild = OMNI_BINARY_DIR;

nlohmann::json Manifest(const std::string& folder) {
  std::ifstream in(kBuild + "/share/openxr/1/api_layers/" + folder + "/XrApiLayer_omni.json");
  EXPECT_TRUE(in) << folder;
  return nlohmann::json::parse(in);
}

TEST(Packaging, ExactlyOneExportedSymbol) {
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

TEST(Packaging, ManifestsAreLintClean) {
  for (const char* folder : {"explicit.d", "implicit.template"}) {
    const nlohmann::json root = Manifest(folder);
    EXPECT_EQ(root["file_format_version"], "1.0.0");
    const nlohmann::json& layer = root["api_layer"];
    EXPECT_EQ(layer["name"], kLayer);
    EXPECT_EQ(layer["api_version"], "1.0");
    EXPECT_EQ(layer["implementation_version"], "1") << "a decimal string, else the loader skips the layer";
    EXPECT_TRUE(std::filesystem::exists(layer["library_path"].get<std::string>()));
    EXPECT_EQ(layer["instance_extensions"][0]["name"], XR_LOGITECH_MX_INK_STYLUS_INTERACTION_EXTENSION_NAME);
    EXPECT_FALSE(layer.contains("enable_environment"));
  }
  EXPECT_FALSE(Manifest("explicit.d")["api_layer"].contains("disable_environment"));
  EXPECT_EQ(Manifest("implicit.template")["api_layer"]["disable_environment"], "DISABLE_XR_APILAYER_OMNI_stylus_1");
  EXPECT_FALSE(std::filesystem::exists(kBuild + "/share/openxr/1/api_layers/implicit.d"));
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
  ASSERT_EQ(profiles.size(), 3u);
  EXPECT_EQ(profiles[0].path, kMxInk);
  EXPECT_EQ(profiles[1].path, kTouch);
  EXPECT_EQ(profiles[2].path, kSimple);
  for (const layer::Profile& profile : profiles) {
    std::set<std::string> paths;
    for (const layer::Component& c : profile.components) EXPECT_TRUE(paths.insert(c.path).second) << c.path;
    EXPECT_GE(profile.poses.size(), 2u);
  }
}

TEST(Packaging, BadProfileIsNamed) {
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

// [input-suggested-bindings] which source a path means for an action type.
TEST(Packaging, PathsResolveByActionType) {
  using layer::Hand;
  const std::vector<layer::Profile> profiles = layer::LoadProfiles();
  const layer::Profile& touch = profiles[1];
  const auto path = [&](XrActionType type, const char* text) {
    const auto binding = layer::Resolve(touch, Hand::kRight, type, text);
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
      layer::Resolve(touch, Hand::kRight, XR_ACTION_TYPE_BOOLEAN_INPUT, "/user/hand/right/input/trigger/touch");
  ASSERT_TRUE(click);
  EXPECT_EQ(click->identifier, "/user/hand/right/input/trigger") << "what priorities collide on";
}

}  // namespace
}  // namespace omni::test
