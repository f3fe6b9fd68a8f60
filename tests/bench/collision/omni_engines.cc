// Our rows: the contact update as haptics::Step makes it, the whole Step, the nearest point.
#include "service/haptics/contact/contacts.h"
#include "service/haptics/geometry/query.h"
#include "service/haptics/scene/scene.h"
#include "tests/bench/collision/engine.h"
#include "tests/haptics/scenario.h"
#include "tests/support/surface_queries.h"

namespace omni::collision {

using namespace haptics;

namespace {

class ClosestEngine final : public Engine {
 public:
  ClosestEngine(bool warm, const Scene& scene, const BuildCost& cost)
      : warm_(warm), scene_(scene), surface_(scene, {}), cost_(cost) {}
  const char* name() const override { return warm_ ? "omni-closest" : "study-omni-closest-cold"; }
  BuildCost Build(const Body& /*body*/) override { return cost_; }
  void Start(const Vec3& /*tip*/) override { last_ = kNoIndex; }
  double Tick(const Vec3& tip) override {
    const NearestResult found =
        support::NearestPoint(surface_, scene_.objects()[0], tip, 1e3, warm_ ? last_ : kNoIndex);
    last_ = found.triangle;
    return std::sqrt(found.closest.distance_squared);
  }

 private:
  bool warm_;
  const Scene& scene_;
  Surface surface_;
  BuildCost cost_;
  std::uint32_t last_ = kNoIndex;
};

class StepEngine final : public Engine {
 public:
  StepEngine(const Scene& scene, const BuildCost& cost)
      : scene_(scene), cost_(cost), config_(PlainConfig()), input_(PlainInput()) {}
  const char* name() const override { return "omni-proxy"; }
  BuildCost Build(const Body& /*body*/) override { return cost_; }
  void Start(const Vec3& tip) override {
    EnterScene(scene_, state_);
    Tick(tip);
  }
  double Tick(const Vec3& tip) override {
    input_.device_point_base_m = tip;
    Step(config_, scene_, input_, state_, output_);
    return -1;
  }

 private:
  const Scene& scene_;
  BuildCost cost_;
  Config config_;
  Input input_;
  State state_;
  Output output_;
};

// The part of Step that finds the contact, without forces: sweep or follow and, without a contact, find the distance to
// the surface.
class ContactEngine final : public Engine {
 public:
  ContactEngine(const Scene& scene, const BuildCost& cost) : scene_(scene), cost_(cost) {}
  const char* name() const override { return "study-omni-contact"; }
  BuildCost Build(const Body& /*body*/) override { return cost_; }
  void Start(const Vec3& tip) override {
    EnterScene(scene_, state_);
    Input input;
    input.device_point_base_m = tip;
    StartContacts(ContactScene(scene_, input, state_), state_);
    state_.last_device_point_base_m = tip;
    state_.was_tracked = true;
  }
  double Tick(const Vec3& tip) override {
    if (!(Norm(tip - state_.far_origin_base_m) < state_.far_distance_m)) {
      Input input;
      input.device_point_base_m = tip;
      const ContactScene contact_scene(scene_, input, state_);
      UpdateContacts(contact_scene, 1e-3, state_);
      state_.far_distance_m = 0;
      if (!state_.contacts[0].active) LookAround(contact_scene.surface(), tip);
    }
    state_.last_device_point_base_m = tip;
    return -1;
  }

 private:
  void LookAround(const Surface& surface, const Vec3& tip) {
    const NearestResult found = support::NearestPoint(surface, scene_.objects()[0], tip, 1e3);
    state_.far_origin_base_m = tip;
    state_.far_distance_m = std::max(0.0, std::sqrt(found.closest.distance_squared) - 2e-6);
  }

  const Scene& scene_;
  BuildCost cost_;
  State state_;
};

}  // namespace

std::unique_ptr<Engine> MakeOmni(OmniKind kind, const Scene& scene, const BuildCost& cost) {
  if (kind == OmniKind::kProxy) return std::make_unique<StepEngine>(scene, cost);
  if (kind == OmniKind::kContact) return std::make_unique<ContactEngine>(scene, cost);
  return std::make_unique<ClosestEngine>(kind == OmniKind::kClosest, scene, cost);
}

SceneInput SceneOf(const Body& body) {
  SceneInput input;
  input.name = body.name;
  Material material;
  material.static_friction = material.dynamic_friction = 0;
  material.damping_Ns_m = 0;
  input.materials.push_back(material);
  InputObject object;
  object.name = body.name;
  object.vertices_base_m = body.vertices;
  object.triangles = body.triangles;
  object.triangle_material.assign(body.triangles.size(), 0);
  input.objects.push_back(std::move(object));
  return input;
}

Config PlainConfig() {
  Config config;
  config.force_slew_N_s = 1e9;
  config.ramp_s = 0;
  return config;
}

Input PlainInput() {
  Input input;
  input.tracked = true;
  input.limit = test::UsualLimit();
  return input;
}

}  // namespace omni::collision
