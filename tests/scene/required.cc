// What a file requires of its reader: extensions and versions.
#include <gtest/gtest.h>

#include "tests/scene/files.h"

namespace omni::scene::test {
namespace test_scene_required {

Loaded Requiring(const Json& names) {
  Model model = Tetra();
  model.json["extensionsRequired"] = names;
  return LoadBytes(model.Bytes());
}

TEST(SceneRequired, UnknownExtensionsAreRefused) {
  for (const char* name :
       {"VENDOR_crazy_geometry", "CESIUM_RTC", "KHR_accessor_float64", "khr_materials_unlit", "", "KHR_materials"}) {
    const Loaded loaded = Requiring({"KHR_mesh_quantization", name});
    ASSERT_FALSE(loaded.result.ok()) << name;
    const std::string& error = loaded.result.error();
    EXPECT_NE(error.find("/extensionsRequired/1: is \"" + std::string(name) + "\", which cannot be read"),
              std::string::npos)
        << error;
    EXPECT_NE(error.find("export without this extension"), std::string::npos) << error;
  }
  EXPECT_FALSE(Requiring({3}).result.ok());
  EXPECT_FALSE(Requiring("KHR_xmp").result.ok());
}

// A file that is not touched says so too: it is not what its author sees.
TEST(SceneRequired, UnknownExtensionsAreRefusedWithoutATag) {
  Model model = Tetra();
  model.json["extensionsRequired"] = {"VENDOR_crazy_geometry"};
  EXPECT_FALSE(LoadBytes(model.Bytes(), {}).result.ok());
}

TEST(SceneRequired, ExtensionsThatAreReadOrOnlyDrawnLoadSilently) {
  for (const char* name :
       {"KHR_materials_unlit", "KHR_materials_variants", "KHR_texture_transform", "KHR_texture_basisu",
        "EXT_texture_webp", "EXT_texture_avif", "KHR_lights_punctual", "KHR_xmp_json_ld", "KHR_animation_pointer",
        "KHR_mesh_quantization", "EXT_mesh_gpu_instancing", "KHR_node_visibility", "OMNI_haptic_material"}) {
    const Loaded loaded = Requiring({name});
    EXPECT_TRUE(loaded.result.ok()) << name << ": " << loaded.result.error();
    EXPECT_TRUE(loaded.report.warnings.empty()) << loaded.Warnings();
  }
}

TEST(SceneRequired, UnknownOnesForDrawingAreWarnedAboutOnce) {
  const Loaded loaded = Requiring({"EXT_texture_of_tomorrow", "KHR_lights_bright"});
  ASSERT_TRUE(loaded.result.ok()) << loaded.result.error();
  ASSERT_EQ(loaded.report.warnings.size(), 1U) << loaded.Warnings();
  EXPECT_NE(loaded.Warnings().find("/extensionsRequired/0: is \"EXT_texture_of_tomorrow\""), std::string::npos)
      << loaded.Warnings();
}

TEST(SceneRequired, MinVersionAboveTwoIsRefused) {
  const auto load = [](const Json& least) {
    Model model = Tetra();
    model.json["asset"] = {{"version", "2.9"}, {"minVersion", least}};
    return LoadBytes(model.Bytes());
  };
  for (const char* least : {"2.0", "1.0", "1.9"}) EXPECT_TRUE(load(least).result.ok()) << least;
  for (const char* least : {"2.1", "3.0", "10.0", "2.10"}) {
    const Loaded loaded = load(least);
    ASSERT_FALSE(loaded.result.ok()) << least;
    EXPECT_NE(loaded.result.error().find("/asset/minVersion: is \"" + std::string(least) + "\": it needs a reader"),
              std::string::npos)
        << loaded.result.error();
  }
  for (const Json& bad : {Json("two"), Json(""), Json("2"), Json("2."), Json("2.0x"), Json("-1.0"), Json(2.0),
                          Json("99999999999.0"), Json("2.-1")}) {
    const Loaded loaded = load(bad);
    ASSERT_FALSE(loaded.result.ok()) << bad;
    EXPECT_NE(loaded.result.error().find("/asset/minVersion"), std::string::npos) << loaded.result.error();
  }
}

}  // namespace test_scene_required
}  // namespace omni::scene::test
