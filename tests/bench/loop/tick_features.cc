#include "tests/bench/loop/tick_features.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>

#include "service/config/paths.h"
#include "service/haptics/scene/scene.h"
#include "service/haptics/state.h"
#include "service/scene/load_scene.h"
#include "tests/bench/harness/idle_timing.h"
#include "tests/support/touch/fresh_scene.h"

namespace omni::bench {
namespace {

using haptics::InputObject;
using haptics::SceneInput;

constexpr int kGroups = 1000;                   // timed, per batch
constexpr int kTouchGroup = 4, kFarGroup = 64;  // steps timed together
constexpr double kFar_m = 0.05;                 // over the body, at least

// A factor from one half to one, in waves over the body.
void AddImages(SceneInput& input) {
  constexpr std::uint32_t kSide = 64;
  haptics::InputImage& image = input.images.emplace_back();
  image.width = image.height = kSide;
  for (std::uint32_t i = 0; i < kSide * kSide; ++i) {
    const std::uint32_t column = i % kSide, row = i / kSide;
    const double turns = static_cast<double>(column + row) / kSide;
    image.texels.push_back(static_cast<std::uint8_t>(191 + 64 * std::sin(2 * std::numbers::pi * turns)));
  }
  input.textures.emplace_back();
  constexpr double kPeriod_m = 0.01;
  InputObject& object = input.objects[0];
  for (const auto& triangle : object.triangles) {
    haptics::CornerUv& uv = object.uv[0].emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      const base::Vec3& v = object.vertices_base_m[triangle[k]];
      uv[2 * k] = static_cast<float>(v.x / kPeriod_m);
      uv[2 * k + 1] = static_cast<float>(v.y / kPeriod_m);
    }
  }
  haptics::Material& m = input.materials[0];
  m.stiffness_texture = m.friction_texture = m.vibrotactile_texture = 0;
}

struct Feature {
  const char* name;
  void (*enable)(SceneInput&);
};

constexpr Feature kFeatures[] = {
    {"friction", [](SceneInput& in) { in.materials[0].static_friction = 0.5, in.materials[0].dynamic_friction = 0.4; }},
    {"damping", [](SceneInput& in) { in.materials[0].damping_Ns_m = 0.5; }},
    {"viscosity", [](SceneInput& in) { in.materials[0].viscosity_Ns_m = 0.5; }},
    {"texture", [](SceneInput& in) { in.materials[0].texture_amplitude_m = 2e-4; }},
    {"images", AddImages},
    {"vibration", [](SceneInput& in) { in.materials[0].vibration_amplitude_N = 0.1; }},
    {"magnet", [](SceneInput& in) { in.materials[0].magnet_max_force_N = 0.2; }},
    {"pop-through", [](SceneInput& in) { in.materials[0].pop_through_N = 5; }},
    {"soft layer", [](SceneInput& in) { in.materials[0].softness.model = haptics::SoftnessModel::kWinkler; }},
    {"soft body", [](SceneInput& in) { in.materials[0].softness.model = haptics::SoftnessModel::kTet; }},
    {"sculptable", [](SceneInput& in) { in.materials[0].sculpt.enabled = true; }},
    {"smooth facets", [](SceneInput& in) { in.materials[0].smooth = true; }},
    {"ball tip", [](SceneInput& in) { in.tip_radius_m = 2e-3; }},
    {"moved by the application", [](SceneInput& in) { in.objects[0].kinematic = true; }},
};

base::Result<haptics::Scene> BuildLive(const SceneInput& input) {
  haptics::BuildReport report;
  base::Result<haptics::Scene> scene = haptics::BuildScene(input, report);
  if (!scene.ok()) return scene;
  scene::CacheStore cache(config::CacheFolder());
  const scene::LiveReport live = scene::LoadLive(*scene, &cache);
  if (!live.lines.empty()) return base::Error{"omni-bench tick: " + live.lines.front()};
  return scene;
}

// The renderer alone, over the same inputs again and again, each time from the start. A kinematic object goes to and
// fro by a micrometre.
class StepPlayer {
 public:
  StepPlayer(const haptics::Scene& original, const std::vector<haptics::Input>& inputs)
      : scene_(original), inputs_(inputs), moves_((original.objects()[0].flags & haptics::kKinematic) != 0) {
    Start();
  }
  bool has(std::size_t steps) const { return next_ + steps <= inputs_.size(); }
  void Start() {
    if (next_ > 0) scene_.Renew();
    next_ = 0;
    state_ = {};
    haptics::EnterScene(scene_.scene(), state_);
  }
  void Step() {
    if (!moves_) return Step(inputs_[next_++]);
    const haptics::ObjectPose pose{.object = 0, .translation_m = {next_ % 2 == 0 ? 1e-6 : 0.0, 0, 0}};
    haptics::Input input = inputs_[next_++];
    input.poses = {&pose, 1};
    Step(input);
  }

 private:
  void Step(const haptics::Input& input) { haptics::Step(config_, scene_.scene(), input, state_, output_); }

  test::FreshScene scene_;
  const std::vector<haptics::Input>& inputs_;
  const bool moves_;
  const haptics::Config config_;
  std::size_t next_ = 0;
  haptics::State state_;
  haptics::Output output_;
};

IdleTiming TimeSteps(const haptics::Scene& scene, const std::vector<haptics::Input>& inputs, int group, int batches) {
  const auto player = std::make_unique<StepPlayer>(scene, inputs);
  return TimeWhenIdle(
      batches, kGroups, group, [&](std::uint64_t) { player->Step(); },
      [&] {
        if (!player->has(static_cast<std::size_t>(group))) player->Start();
      });
}

constexpr std::size_t kMoment = 16;  // ticks: this times the renderer, not the memory access of a long recording

// A moment of the touch, moved high over the body: the same noise and motion, nothing within reach.
std::array<haptics::Input, kMoment> FarAbove(const haptics::Scene& scene, const std::vector<haptics::Input>& touch) {
  std::array<haptics::Input, kMoment> inputs;
  for (std::size_t k = 0; k < kMoment; ++k) inputs[k] = touch[std::min(k, touch.size() - 1)];
  const double lift_m = scene.header().upper_base_m.z + kFar_m - scene.header().lower_base_m.z;
  for (haptics::Input& input : inputs) input.device_point_base_m.z += lift_m;
  return inputs;
}

nlohmann::ordered_json FarRow(const char* name, const haptics::Scene& scene,
                              const std::array<haptics::Input, kMoment>& inputs, int batches) {
  constexpr std::size_t kSettle = 1000;  // ticks until the force has faded in
  const test::FreshScene fresh(scene);
  const haptics::Config config;
  const auto state = std::make_unique<haptics::State>();
  haptics::EnterScene(fresh.scene(), *state);
  haptics::Output output;
  const auto step = [&](std::size_t i) { haptics::Step(config, fresh.scene(), inputs[i % kMoment], *state, output); };
  for (std::size_t i = 0; i < kSettle; ++i) step(i);
  const IdleTiming timing = TimeWhenIdle(batches, kGroups, kFarGroup, step);
  return {{"table", "far tip"},
          {"scene", name},
          {"triangles", scene.header().triangle_count},
          {"ns_median", 1e3 * timing.us_median},
          {"ns_p99", 1e3 * timing.us_p99},
          {"quiet_batches", timing.quiet_batches}};
}

}  // namespace

base::Result<BenchRows> TickFeatureRows(const TouchedBody& body, bool quick) {
  const int batches = quick ? 3 : 30;
  const base::Result<haptics::Scene> plain = BuildLive(body.input);
  if (!plain.ok()) return base::Error{plain.error()};
  const auto away = FarAbove(*plain, body.touch);
  BenchRows rows, far{FarRow("rigid", *plain, away, batches)};
  for (const Feature& feature : kFeatures) {
    SceneInput with = body.input;
    feature.enable(with);
    const base::Result<haptics::Scene> scene = BuildLive(with);
    if (!scene.ok()) return base::Error{scene.error()};
    const IdleTiming off = TimeSteps(*plain, body.touch, kTouchGroup, batches);
    const IdleTiming on = TimeSteps(*scene, body.touch, kTouchGroup, batches);
    rows.push_back({{"table", "features"},
                    {"feature", feature.name},
                    {"off_us_median", off.us_median},
                    {"on_us_median", on.us_median},
                    {"off_us_p99", off.us_p99},
                    {"on_us_p99", on.us_p99},
                    {"quiet_batches", on.quiet_batches}});
    if (scene->live() != nullptr) far.push_back(FarRow(feature.name, *scene, away, batches));
  }
  rows.insert(rows.end(), far.begin(), far.end());
  return rows;
}

}  // namespace omni::bench
