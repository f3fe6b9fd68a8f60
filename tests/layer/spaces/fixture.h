// Shared by the tests of spaces: a pen on a known path, and what xrLocateSpace returns for it.
#pragma once

#include <gtest/gtest.h>

#include <functional>

#include "layer/src/spaces/locate.h"
#include "tests/layer/support/app.h"

namespace omni::test {

inline constexpr XrSpaceLocationFlags kSeen = layer::kValid | layer::kTracked;

// The pen in the base at a time in seconds: closed forms, with exact derivatives.
using PenPath = std::function<layer::Motion(double t_s)>;

// A Lissajous figure of 2 cm, turning about a tilted axis.
layer::Motion Lissajous(double t_s);
// A different one for each seed: frequencies up to 2 Hz, 1 to 3 cm, turning with up to 3 rad/s.
PenPath RandomPath(std::uint32_t seed);
// Fills samples for FakeService.
FakeService::Trajectory Along(PenPath path);

struct Seen {
  XrResult result = XR_SUCCESS;
  XrSpaceLocation location{XR_TYPE_SPACE_LOCATION};
  XrSpaceVelocity velocity{XR_TYPE_SPACE_VELOCITY};
  glm::dvec3 p() const { return layer::FromXr(location.pose.position); }
  glm::dquat q() const { return layer::FromXr(location.pose).q; }
  glm::dvec3 v() const { return layer::FromXr(velocity.linearVelocity); }
  glm::dvec3 w() const { return layer::FromXr(velocity.angularVelocity); }
};

Seen Locate(XrSpace space, XrSpace base, std::int64_t monotonic_ns);
inline XrTime ToXrTime(std::int64_t monotonic_ns) { return monotonic_ns + kRuntimeOffset_ns; }

double Angle(const glm::dquat& a, const glm::dquat& b);
layer::Motion MotionOf(const layer::Pose& pose);

// In LOCAL, with the base where it stands before it is aligned: 0.45 m ahead, 0.35 m down, base z up, base y away from
// the user.
layer::Motion InLocal(const layer::Motion& in_base);
layer::Motion WithOffset(const glm::dvec3& offset, const layer::Motion& tool);

class SpacesTest : public testing::Test {
 protected:
  void SetUp() override { omni_test_reset(); }
  // The pen on `path`, the right hand's aim pose (origin at the tip) bound, history filled.
  void Start(App& app, PenPath path = Lissajous);
  // Half of the 300 ms that the service fills up with at once must have gone by, so that all of it is of the new path.
  void ForgetOldPath(const App& app);

  FakeService service;
  XrSpace local = XR_NULL_HANDLE;
  XrSpace pen = XR_NULL_HANDLE;
};

}  // namespace omni::test
