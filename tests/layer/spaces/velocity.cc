// Accuracy of velocities: a tracker's noise must not become larger than the tracker's own filter leaves it.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>
#include <memory>
#include <random>

#include "tests/layer/spaces/fixture.h"

namespace omni::test {
namespace test_spaces_velocity {

using layer::Motion;
using SpacesVelocity = SpacesTest;

// A path as a tracker reports it: independent noise in each sample, in poses and in velocities.
FakeService::Trajectory Noisy(const PenPath& path) {
  struct Noise {
    std::mt19937 random{21};
    std::normal_distribution<> position_m{0, 40e-6}, angle_rad{0, 1e-3}, velocity_m_s{0, 5e-3}, turn_rad_s{0, 0.05};
    glm::dvec3 Of(std::normal_distribution<>& size) { return {size(random), size(random), size(random)}; }
  };
  const auto noise = std::make_shared<Noise>();
  return Along([path, noise](double t_s) {
    Motion m = path(t_s);
    m.X.p += noise->Of(noise->position_m);
    m.X.q = layer::ExpRotation(noise->Of(noise->angle_rad)) * m.X.q;
    m.v += noise->Of(noise->velocity_m_s);
    m.w += noise->Of(noise->turn_rad_s);
    return m;
  });
}

// Root of the mean square.
class Rms {
 public:
  void Add(const glm::dvec3& error) {
    sum_ += glm::dot(error, error);
    ++count_;
  }
  double value() const { return std::sqrt(sum_ / count_); }

 private:
  double sum_ = 0;
  int count_ = 0;
};

struct VelocityErrors {
  Rms linear, angular;
  void Add(const Seen& seen, std::int64_t t_ns) {
    const Motion truth = InLocal(Lissajous(1e-9 * static_cast<double>(t_ns)));
    linear.Add(seen.v() - truth.v);
    angular.Add(seen.w() - truth.w);
  }
};

TEST_F(SpacesVelocity, PastVelocitiesAreAsAccurateAsCurrentOnes) {
  App app;
  Start(app);
  service.SetTrajectory(Noisy(Lissajous));
  ForgetOldPath(app);
  ForgetOldPath(app);
  VelocityErrors now, past;
  for (int i = 0; i < 200; ++i) {
    service.Fill();
    const std::int64_t t_ns = Now_ns();
    now.Add(Locate(pen, local, t_ns), t_ns);
  }
  const std::int64_t newest_ns = Now_ns();
  service.Fill();
  for (int i = 1; i <= 200; ++i) {
    const std::int64_t t_ns = newest_ns - i * 1'170'000;
    past.Add(Locate(pen, local, t_ns), t_ns);
  }
  std::printf("[ figure   ] rms error of the velocity now %.3f m/s, at past times %.3f m/s\n", now.linear.value(),
              past.linear.value());
  std::printf("[ figure   ] rms error of the angular velocity now %.3f rad/s, at past times %.3f rad/s\n",
              now.angular.value(), past.angular.value());
  EXPECT_LT(past.linear.value(), 1.2 * now.linear.value());
  EXPECT_LT(past.angular.value(), 1.2 * now.angular.value());
}

}  // namespace test_spaces_velocity
}  // namespace omni::test
