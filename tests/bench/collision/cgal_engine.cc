// CGAL: closest point of its box tree in double, warm-started by the last one. Only here, because of its licence.
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Simple_cartesian.h>

#include <chrono>
#include <cmath>

#include "tests/bench/collision/engine.h"
#include "tests/bench/collision/heap.h"

namespace omni::collision {
namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using Triangles = std::vector<Kernel::Triangle_3>;
using Primitive = CGAL::AABB_triangle_primitive<Kernel, Triangles::const_iterator>;
using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;

class CgalEngine final : public Engine {
 public:
  const char* name() const override { return "cgal"; }

  BuildCost Build(const Body& body) override {
    triangles_.reserve(body.triangles.size());
    const auto at = [&](std::uint32_t v) {
      return Kernel::Point_3(body.vertices[v].x, body.vertices[v].y, body.vertices[v].z);
    };
    for (const auto& t : body.triangles) triangles_.emplace_back(at(t[0]), at(t[1]), at(t[2]));
    const double before = HeapBytes();
    const auto start = std::chrono::steady_clock::now();
    tree_ = std::make_unique<Tree>(triangles_.begin(), triangles_.end());
    tree_->do_not_accelerate_distance_queries();
    tree_->build();
    const auto end = std::chrono::steady_clock::now();
    last_ = {at(body.triangles[0][0]), triangles_.cbegin()};
    return {std::chrono::duration<double, std::milli>(end - start).count(), HeapBytes() - before};
  }

  void Start(const Vec3& /*tip*/) override {}

  double Tick(const Vec3& tip) override {
    const Kernel::Point_3 p(tip.x, tip.y, tip.z);
    last_ = tree_->closest_point_and_primitive(p, last_);
    return std::sqrt(CGAL::to_double(CGAL::squared_distance(p, last_.first)));
  }

 private:
  Triangles triangles_;
  std::unique_ptr<Tree> tree_;
  Tree::Point_and_primitive_id last_;
};

}  // namespace

std::unique_ptr<Engine> MakeCgal() { return std::make_unique<CgalEngine>(); }

}  // namespace omni::collision
