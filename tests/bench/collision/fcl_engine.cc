// FCL: distance between a ball of a micrometre and the mesh, trees of OBB and RSS.
#include <fcl/fcl.h>

#include <chrono>

#include "tests/bench/collision/engine.h"
#include "tests/bench/collision/heap.h"

namespace omni::collision {
namespace {

constexpr double kBall_m = 1e-6;

class FclEngine final : public Engine {
 public:
  const char* name() const override { return "fcl"; }

  BuildCost Build(const Body& body) override {
    std::vector<fcl::Vector3d> vertices;
    std::vector<fcl::Triangle> triangles;
    for (const Vec3& v : body.vertices) vertices.emplace_back(v.x, v.y, v.z);
    for (const auto& t : body.triangles) triangles.emplace_back(t[0], t[1], t[2]);
    const double before = HeapBytes();
    const auto start = std::chrono::steady_clock::now();
    mesh_ = std::make_shared<fcl::BVHModel<fcl::OBBRSSd>>();
    mesh_->beginModel();
    mesh_->addSubModel(vertices, triangles);
    mesh_->endModel();
    const auto end = std::chrono::steady_clock::now();
    const double own_mesh = static_cast<double>(vertices.size()) * sizeof(fcl::Vector3d) +
                            static_cast<double>(triangles.size()) * sizeof(fcl::Triangle);
    return {std::chrono::duration<double, std::milli>(end - start).count(), HeapBytes() - before - own_mesh};
  }

  void Start(const Vec3& /*tip*/) override {}

  double Tick(const Vec3& tip) override {
    const fcl::Sphered ball(kBall_m);
    fcl::Transform3d at = fcl::Transform3d::Identity();
    at.translation() = fcl::Vector3d(tip.x, tip.y, tip.z);
    fcl::DistanceRequestd request;
    fcl::DistanceResultd result;
    fcl::distance(&ball, at, mesh_.get(), fcl::Transform3d::Identity(), request, result);
    return result.min_distance + kBall_m;
  }

 private:
  std::shared_ptr<fcl::BVHModel<fcl::OBBRSSd>> mesh_;
};

}  // namespace

std::unique_ptr<Engine> MakeFcl() { return std::make_unique<FclEngine>(); }

}  // namespace omni::collision
