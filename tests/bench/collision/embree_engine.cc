// Embree 3: point query over its own tree, one thread, default build quality; triangles decided in float by a callback.
#include <embree3/rtcore.h>

#include <chrono>
#include <cmath>
#include <limits>

#include "tests/bench/collision/engine.h"

namespace omni::collision {
namespace {

class EmbreeEngine final : public Engine {
 public:
  explicit EmbreeEngine(bool warm) : warm_(warm), device_(rtcNewDevice("threads=1,set_affinity=0")) {
    rtcSetDeviceMemoryMonitorFunction(
        device_,
        [](void* self, ssize_t bytes, bool /*post*/) {
          static_cast<EmbreeEngine*>(self)->bytes_ += static_cast<double>(bytes);
          return true;
        },
        this);
  }
  ~EmbreeEngine() override {
    if (scene_ != nullptr) rtcReleaseScene(scene_);
    rtcReleaseDevice(device_);
  }
  const char* name() const override { return warm_ ? "embree-warm" : "embree"; }

  BuildCost Build(const Body& body) override {
    for (const Vec3& v : body.vertices) {
      for (const double x : {v.x, v.y, v.z}) vertices_.push_back(static_cast<float>(x));
    }
    vertices_.push_back(0);  // Embree reads 16 bytes a vertex
    for (const auto& t : body.triangles) indices_.insert(indices_.end(), t.begin(), t.end());
    bytes_ = 0;
    const auto start = std::chrono::steady_clock::now();
    scene_ = rtcNewScene(device_);
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, vertices_.data(), 0,
                               3 * sizeof(float), body.vertices.size());
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, indices_.data(), 0,
                               3 * sizeof(std::uint32_t), body.triangles.size());
    rtcSetGeometryUserData(geometry, this);
    rtcSetGeometryPointQueryFunction(geometry, Visit);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene_);
    const auto end = std::chrono::steady_clock::now();
    return {std::chrono::duration<double, std::milli>(end - start).count(), bytes_};
  }

  void Start(const Vec3& tip) override {
    radius_ = std::numeric_limits<double>::infinity();
    last_ = tip;
  }

  double Tick(const Vec3& tip) override {
    RTCPointQuery query{};
    query.x = point_[0] = static_cast<float>(tip.x);
    query.y = point_[1] = static_cast<float>(tip.y);
    query.z = point_[2] = static_cast<float>(tip.z);
    const double reach = (radius_ + Norm(tip - last_)) * (1 + 1e-5) + 1e-8;
    query.radius = warm_ ? static_cast<float>(reach) : std::numeric_limits<float>::infinity();
    best_ = query.radius * query.radius;
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(scene_, &query, &context, nullptr, this);
    radius_ = std::sqrt(best_);
    last_ = tip;
    return radius_;
  }

 private:
  static bool Visit(RTCPointQueryFunctionArguments* arguments) {
    auto* const self = static_cast<EmbreeEngine*>(arguments->userPtr);
    const std::uint32_t* const t = &self->indices_[3 * static_cast<std::size_t>(arguments->primID)];
    float c[3][3];
    for (int k = 0; k < 3; ++k) {
      for (int axis = 0; axis < 3; ++axis) c[k][axis] = self->vertices_[3 * static_cast<std::size_t>(t[k]) + axis];
    }
    const float d = NearestInFloat(c[0], c[1], c[2], self->point_);
    if (!(d < self->best_)) return false;
    self->best_ = d;
    arguments->query->radius = std::sqrt(d);
    return true;
  }

  bool warm_;
  RTCDevice device_;
  RTCScene scene_ = nullptr;
  std::vector<float> vertices_;
  std::vector<std::uint32_t> indices_;
  double bytes_ = 0;
  double radius_ = 0;
  float best_ = 0;
  float point_[3] = {};
  Vec3 last_;
};

}  // namespace

std::unique_ptr<Engine> MakeEmbree(bool warm) { return std::make_unique<EmbreeEngine>(warm); }

}  // namespace omni::collision
