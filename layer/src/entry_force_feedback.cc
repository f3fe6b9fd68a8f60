// Entry points of XR_OMNIX1_force_feedback.
#include "layer/src/force_feedback.h"
#include "layer/src/guarded.h"
#include "layer/src/own_functions.h"

namespace omni::layer {
namespace {

XRAPI_ATTR XrResult XRAPI_CALL CreateForceFeedbackOMNIX1(XrSession session, const XrForceFeedbackCreateInfoOMNIX1* info,
                                                         XrForceFeedbackOMNIX1* force) {
  return On(session, &Instance::CreateForceFeedback, session, info, force);
}

XRAPI_ATTR XrResult XRAPI_CALL DestroyForceFeedbackOMNIX1(XrForceFeedbackOMNIX1 force) {
  return On(force, &Instance::DestroyForceFeedback, force);
}

XRAPI_ATTR XrResult XRAPI_CALL GetForceFeedbackPropertiesOMNIX1(XrForceFeedbackOMNIX1 force,
                                                                const XrForceFeedbackPropertiesGetInfoOMNIX1* info,
                                                                XrForceFeedbackPropertiesOMNIX1* properties) {
  return On(force, &Instance::ForceProperties, force, info, properties);
}

XRAPI_ATTR XrResult XRAPI_CALL ApplyForceOMNIX1(XrForceFeedbackOMNIX1 force, const XrForceApplyInfoOMNIX1* info) {
  return On(force, &Instance::ApplyForce, force, info);
}

XRAPI_ATTR XrResult XRAPI_CALL SetForceFeedbackConstraintsOMNIX1(XrForceFeedbackOMNIX1 force,
                                                                 const XrForceFeedbackConstraintsSetInfoOMNIX1* info) {
  return On(force, &Instance::SetConstraints, force, info);
}

XRAPI_ATTR XrResult XRAPI_CALL StopForceFeedbackOMNIX1(XrForceFeedbackOMNIX1 force) {
  return On(force, &Instance::StopForce, force);
}

XRAPI_ATTR XrResult XRAPI_CALL GetForceFeedbackStateOMNIX1(XrForceFeedbackOMNIX1 force,
                                                           const XrForceFeedbackStateGetInfoOMNIX1* info,
                                                           XrForceFeedbackStateOMNIX1* state) {
  return On(force, &Instance::ForceState, force, info, state);
}

}  // namespace

const std::vector<OwnFunction>& ForceFeedbackFunctions() {
#define OMNI_FORCE_ROW(name) \
  { "xr" #name, XR_OMNIX1_FORCE_FEEDBACK_EXTENSION_NAME, Erase(&(name)) }
  static const std::vector<OwnFunction> functions{
      OMNI_FORCE_ROW(CreateForceFeedbackOMNIX1),         OMNI_FORCE_ROW(DestroyForceFeedbackOMNIX1),
      OMNI_FORCE_ROW(GetForceFeedbackPropertiesOMNIX1),  OMNI_FORCE_ROW(ApplyForceOMNIX1),
      OMNI_FORCE_ROW(SetForceFeedbackConstraintsOMNIX1), OMNI_FORCE_ROW(StopForceFeedbackOMNIX1),
      OMNI_FORCE_ROW(GetForceFeedbackStateOMNIX1),
  };
#undef OMNI_FORCE_ROW
  return functions;
}

}  // namespace omni::layer
