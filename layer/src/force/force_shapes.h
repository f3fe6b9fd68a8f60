// Constraints of XR_OMNIX1_force_feedback: from the application's structures to the service's message. Pure.
#pragma once

#include <cstdint>
#include <vector>

#include "layer/include/openxr/omni_force_feedback.h"
#include "layer/src/entry/omni_openxr_compat.h"
#include "layer/src/spaces/pose_math.h"
#include "service/protocol/force_feedback.h"

namespace omni::layer {

// One constraint as the application set it: point and direction are expressed in `space`.
struct LocalConstraint {
  XrSpace space = XR_NULL_HANDLE;
  protocol::ForceConstraint shape;
};

// XR_ERROR_VALIDATION_FAILURE: a structure outside of the extension's range. Values over what the service takes are
// clamped.
XrResult ReadConstraints(const XrForceFeedbackConstraintsSetInfoOMNIX1& info, std::vector<LocalConstraint>& out);

// The same in the base frame; X_BS: its space there, with the space's velocity.
protocol::ForceConstraint InBase(const protocol::ForceConstraint& shape, const Motion& X_BS) noexcept;

// A vector of the service's messages, within +-limit; zero where not finite.
std::array<double, 3> Clamped(const glm::dvec3& v, double limit) noexcept;

// True: `now` is nothing new to the service, which extrapolates constraints by their velocity.
bool SameConstraints(const protocol::ForceConstraints& sent, const protocol::ForceConstraints& now) noexcept;

}  // namespace omni::layer
