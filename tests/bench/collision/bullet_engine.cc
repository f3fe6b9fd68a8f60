// Bullet: its quantised tree gives the triangles of a box around the tip, as large as the last distance allows; the
// nearest one is found as for Embree.
#include <BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btTriangleIndexVertexArray.h>

#include <chrono>
#include <cmath>

#include "tests/bench/collision/engine.h"
#include "tests/bench/collision/heap.h"

namespace omni::collision {
namespace {

class Nearest final : public btTriangleCallback {
 public:
  explicit Nearest(const Vec3& p) : p_{static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)} {}
  void processTriangle(btVector3* c, int /*part*/, int /*index*/) override {
    float corner[3][3];
    for (int k = 0; k < 3; ++k) {
      for (int axis = 0; axis < 3; ++axis) corner[k][axis] = static_cast<float>(c[k][axis]);
    }
    best = std::min(best, NearestInFloat(corner[0], corner[1], corner[2], p_));
  }
  float best = 1e30F;

 private:
  float p_[3];
};

class BulletEngine final : public Engine {
 public:
  const char* name() const override { return "bullet"; }

  BuildCost Build(const Body& body) override {
    for (const Vec3& v : body.vertices) {
      for (const double x : {v.x, v.y, v.z}) vertices_.push_back(static_cast<btScalar>(x));
    }
    for (const auto& t : body.triangles) indices_.insert(indices_.end(), t.begin(), t.end());
    const double before = HeapBytes();
    const auto start = std::chrono::steady_clock::now();
    mesh_ = std::make_unique<btTriangleIndexVertexArray>(
        static_cast<int>(body.triangles.size()), indices_.data(), static_cast<int>(3 * sizeof(int)),
        static_cast<int>(body.vertices.size()), vertices_.data(), static_cast<int>(3 * sizeof(btScalar)));
    shape_ = std::make_unique<btBvhTriangleMeshShape>(mesh_.get(), true);
    const auto end = std::chrono::steady_clock::now();
    return {std::chrono::duration<double, std::milli>(end - start).count(), HeapBytes() - before};
  }

  void Start(const Vec3& tip) override {
    radius_ = 0.2;
    last_ = tip;
  }

  double Tick(const Vec3& tip) override {
    const double r = (radius_ + Norm(tip - last_)) * (1 + 1e-5) + 1e-8;
    const auto at = [&](double s) {
      return btVector3(static_cast<btScalar>(tip.x + s), static_cast<btScalar>(tip.y + s),
                       static_cast<btScalar>(tip.z + s));
    };
    Nearest nearest(tip);
    shape_->processAllTriangles(&nearest, at(-r), at(r));
    radius_ = std::sqrt(nearest.best);
    last_ = tip;
    return radius_;
  }

 private:
  std::vector<btScalar> vertices_;
  std::vector<int> indices_;
  std::unique_ptr<btTriangleIndexVertexArray> mesh_;
  std::unique_ptr<btBvhTriangleMeshShape> shape_;
  double radius_ = 0;
  Vec3 last_;
};

}  // namespace

std::unique_ptr<Engine> MakeBullet() { return std::make_unique<BulletEngine>(); }

}  // namespace omni::collision
