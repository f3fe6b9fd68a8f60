#include "tests/layer/spaces/fixture.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <random>

namespace omni::test {

using layer::Motion;

layer::Motion Lissajous(double t) {
  constexpr double kA = 0.02;
  constexpr double kW = 2 * 3.14159265358979 * 2.0;
  Motion m;
  m.X.p = {kA * std::sin(kW * t), kA * std::cos(kW * t), 0.07 + 0.5 * kA * std::sin(2 * kW * t)};
  m.v = {kA * kW * std::cos(kW * t), -kA * kW * std::sin(kW * t), kA * kW * std::cos(2 * kW * t)};
  m.w = {0.6, 0.0, 2.0};
  m.X.q = layer::ExpRotation(std::fmod(t, 100.0) * m.w);
  return m;
}

PenPath RandomPath(std::uint32_t seed) {
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) { return std::uniform_real_distribution<>(low, high)(random); };
  struct Wave {
    double a, w, phase;
  };
  std::array<Wave, 3> waves;
  for (Wave& wave : waves) wave = {uniform(0.01, 0.03), uniform(3, 12), uniform(0, 6)};
  const glm::dvec3 w(uniform(-3, 3), uniform(-3, 3), uniform(-3, 3));
  return [waves, w](double t) {
    Motion m;
    for (int i = 0; i < 3; ++i) {
      const Wave& wave = waves[static_cast<std::size_t>(i)];
      m.X.p[i] = wave.a * std::sin(wave.w * t + wave.phase);
      m.v[i] = wave.a * wave.w * std::cos(wave.w * t + wave.phase);
    }
    m.X.p.z += 0.08;
    m.w = w;
    m.X.q = layer::ExpRotation(std::fmod(t, 100.0) * w);
    return m;
  };
}

FakeService::Trajectory Along(PenPath path) {
  return [path = std::move(path)](protocol::ToolSample& sample) {
    const Motion m = path(1e-9 * static_cast<double>(sample.t_ns));
    sample.position_base_m = {m.X.p.x, m.X.p.y, m.X.p.z};
    sample.orientation_base_wxyz = {m.X.q.w, m.X.q.x, m.X.q.y, m.X.q.z};
    sample.linear_velocity_base_m_s = {m.v.x, m.v.y, m.v.z};
    sample.angular_velocity_base_rad_s = {m.w.x, m.w.y, m.w.z};
  };
}

Seen Locate(XrSpace space, XrSpace base, std::int64_t monotonic_ns) {
  Seen seen;
  seen.location.next = &seen.velocity;
  seen.result = xrLocateSpace(space, base, ToXrTime(monotonic_ns), &seen.location);
  seen.location.next = nullptr;
  return seen;
}

double Angle(const glm::dquat& a, const glm::dquat& b) {
  const glm::dquat d = glm::conjugate(a) * b;
  return 2 * std::asin(std::min(1.0, glm::length(glm::dvec3(d.x, d.y, d.z))));
}

layer::Motion MotionOf(const layer::Pose& pose) {
  Motion still;
  still.X = pose;
  return still;
}

layer::Motion InLocal(const Motion& in_base) {
  return layer::Compose(MotionOf({{0, -0.35, -0.45}, glm::dquat(std::sqrt(0.5), -std::sqrt(0.5), 0, 0)}), in_base);
}

layer::Motion WithOffset(const glm::dvec3& offset, const Motion& tool) {
  return layer::Compose(tool, MotionOf({offset, {1, 0, 0, 0}}));
}

void SpacesTest::Start(App& app, PenPath path) {
  service.SetTrajectory(Along(std::move(path)));
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  local = app.ReferenceSpace(XR_REFERENCE_SPACE_TYPE_LOCAL);
  pen = app.ActionSpace(app.pose, app.right);
  ForgetOldPath(app);
}

void SpacesTest::ForgetOldPath(const App& app) {
  const std::int64_t end = Now_ns() + 150'000'000;
  while (Now_ns() < end) {
    service.Fill();
    ASSERT_EQ(app.Sync(), XR_SUCCESS);
    const timespec pause{0, 5'000'000};
    nanosleep(&pause, nullptr);
  }
}

}  // namespace omni::test
