// For tests of SceneBuilder, whatever builds for it: files to load, and what comes of them.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <iterator>
#include <optional>
#include <string>
#include <utility>

#include "service/daemon/scenes/scene_builder.h"
#include "service/scene/glb_save.h"
#include "tests/haptics/scenario.h"
#include "tests/support/in_time.h"
#include "tests/support/process/temp_folder.h"

namespace omni::daemon {

inline bool Soon(const std::function<bool()>& holds) { return test::InTime(holds, std::chrono::seconds(60)); }

// Descriptors of this process.
inline std::size_t OpenFiles() {
  namespace fs = std::filesystem;
  return static_cast<std::size_t>(std::distance(fs::directory_iterator("/proc/self/fd"), fs::directory_iterator()));
}

class SceneBuilderTest : public testing::Test {
 protected:
  config::AppEntry Saved(const std::string& name, const haptics::SceneInput& input) {
    config::AppEntry app;
    app.scene = folder_.Path(name + ".glb");
    EXPECT_TRUE(scene::SaveGlb(app.scene, input).ok());
    return app;
  }
  config::AppEntry Rigid(const std::string& name, int rings = 5) {
    return Saved(name, haptics::SceneOf(haptics::Sphere(rings, 0.02)));
  }
  // With `count` soft balls.
  config::AppEntry Soft(const std::string& name, int count = 1) {
    haptics::Material jelly;
    jelly.softness.model = haptics::SoftnessModel::kTet;
    haptics::SceneInput input = haptics::SceneOf(haptics::Sphere(8, 0.01), jelly);
    input.objects[0].name = "ball 0";
    for (int k = 1; k < count; ++k) {
      input.objects.push_back(haptics::Sphere(8, 0.01 + 0.001 * k));
      input.objects.back().name = "ball " + std::to_string(k);
      for (base::Vec3& v : input.objects.back().vertices_base_m) v.x += 0.03 * k;
    }
    return Saved(name, input);
  }
  static BuiltScene Result(SceneBuilder& builder) {
    std::optional<BuiltScene> built;
    EXPECT_TRUE(Soon([&] { return (built = builder.PopResult()).has_value(); }));
    return built ? std::move(*built) : BuiltScene{};
  }
  static SoftOutcome Outcome(SceneBuilder& builder) {
    std::optional<SoftOutcome> soft;
    EXPECT_TRUE(Soon([&] { return (soft = builder.PopSoftOutcome()).has_value(); }));
    return soft ? std::move(*soft) : SoftOutcome{};
  }

  const test::TempFolder folder_;
};

}  // namespace omni::daemon
