/*
 * XR_OMNIX1_force_feedback: forces on a hand-held device, from an OpenXR application.
 *
 * EXPERIMENTAL. The author tag OMNI is not registered with Khronos; enumerants lie outside of Khronos' range and will
 * change with a registration. Specification: docs/extensions/XR_OMNIX1_force_feedback.md.
 *
 * Self-contained, C89 and C++; needs openxr.h of OpenXR 1.0.20 or later. Functions come from xrGetInstanceProcAddr.
 * Units are SI: N, m, N/m, N s/m, Hz; times are XrTime and XrDuration (ns). Vectors and poses are expressed in the
 * XrSpace that goes with them.
 */
#ifndef OMNI_FORCE_FEEDBACK_H_
#define OMNI_FORCE_FEEDBACK_H_ 1

#include <openxr/openxr.h>

#ifdef __cplusplus
extern "C" {
#endif

#ifndef OMNI_XR_ENUMERANT
#ifdef __cplusplus
#define OMNI_XR_ENUMERANT(type, value) (static_cast<type>(value))
#else
#define OMNI_XR_ENUMERANT(type, value) ((type)(value))
#endif
#endif

#define XR_OMNIX1_force_feedback 1
#define XR_OMNIX1_force_feedback_SPEC_VERSION 1
#define XR_OMNIX1_FORCE_FEEDBACK_EXTENSION_NAME "XR_OMNIX1_force_feedback"

/* A force that is not renewed ends after this long at the latest: 100 ms. Longer durations count as this one. */
#define XR_MAX_FORCE_DURATION_OMNIX1 100000000
/* Constraints that one XrForceFeedbackOMNIX1 holds at a time. */
#define XR_MAX_FORCE_FEEDBACK_CONSTRAINTS_OMNIX1 8

#define XR_TYPE_SYSTEM_FORCE_FEEDBACK_PROPERTIES_OMNIX1 OMNI_XR_ENUMERANT(XrStructureType, 2000001000)
#define XR_TYPE_FORCE_FEEDBACK_CREATE_INFO_OMNIX1 OMNI_XR_ENUMERANT(XrStructureType, 2000001001)
#define XR_TYPE_FORCE_FEEDBACK_PROPERTIES_GET_INFO_OMNIX1 OMNI_XR_ENUMERANT(XrStructureType, 2000001002)
#define XR_TYPE_FORCE_FEEDBACK_PROPERTIES_OMNIX1 OMNI_XR_ENUMERANT(XrStructureType, 2000001003)
#define XR_TYPE_FORCE_APPLY_INFO_OMNIX1 OMNI_XR_ENUMERANT(XrStructureType, 2000001004)
#define XR_TYPE_FORCE_FEEDBACK_CONSTRAINTS_SET_INFO_OMNIX1 OMNI_XR_ENUMERANT(XrStructureType, 2000001005)
#define XR_TYPE_FORCE_FEEDBACK_STATE_GET_INFO_OMNIX1 OMNI_XR_ENUMERANT(XrStructureType, 2000001006)
#define XR_TYPE_FORCE_FEEDBACK_STATE_OMNIX1 OMNI_XR_ENUMERANT(XrStructureType, 2000001007)
#define XR_TYPE_EVENT_DATA_FORCE_FEEDBACK_STATE_CHANGED_OMNIX1 OMNI_XR_ENUMERANT(XrStructureType, 2000001008)
#define XR_TYPE_FORCE_FEEDBACK_CONSTRAINT_POINT_OMNIX1 OMNI_XR_ENUMERANT(XrStructureType, 2000001010)
#define XR_TYPE_FORCE_FEEDBACK_CONSTRAINT_LINE_OMNIX1 OMNI_XR_ENUMERANT(XrStructureType, 2000001011)
#define XR_TYPE_FORCE_FEEDBACK_CONSTRAINT_PLANE_OMNIX1 OMNI_XR_ENUMERANT(XrStructureType, 2000001012)
#define XR_TYPE_FORCE_FEEDBACK_CONSTRAINT_SPHERE_OMNIX1 OMNI_XR_ENUMERANT(XrStructureType, 2000001013)
#define XR_TYPE_FORCE_FEEDBACK_CONSTRAINT_VISCOUS_OMNIX1 OMNI_XR_ENUMERANT(XrStructureType, 2000001014)

#define XR_OBJECT_TYPE_FORCE_FEEDBACK_OMNIX1 OMNI_XR_ENUMERANT(XrObjectType, 2000001000)

/* The device serves another XrForceFeedbackOMNIX1: of this instance, or of the application that has the focus. */
#define XR_ERROR_FORCE_FEEDBACK_IN_USE_OMNIX1 OMNI_XR_ENUMERANT(XrResult, -2000001000)
/* The space cannot be located now; nothing was changed. */
#define XR_ERROR_FORCE_FEEDBACK_SPACE_NOT_LOCATABLE_OMNIX1 OMNI_XR_ENUMERANT(XrResult, -2000001001)

/* Forces on the device held by one hand of one session. Parent: XrSession. */
XR_DEFINE_HANDLE(XrForceFeedbackOMNIX1)

/* What a device can do. */
typedef XrFlags64 XrForceFeedbackCapabilityFlagsOMNIX1;
typedef XrFlags64 XrForceFeedbackCapabilityFlagBitsOMNIX1;
/* A force in any direction of space, acting at the device point (the tip). */
static const XrForceFeedbackCapabilityFlagBitsOMNIX1 XR_FORCE_FEEDBACK_CAPABILITY_FORCE_3DOF_BIT_OMNIX1 = 0x00000001;
/* Constraints are evaluated at `updateRate`, without the application. */
static const XrForceFeedbackCapabilityFlagBitsOMNIX1 XR_FORCE_FEEDBACK_CAPABILITY_CONSTRAINTS_BIT_OMNIX1 = 0x00000002;
/* xrApplyHapticFeedback and forces act at the same time. */
static const XrForceFeedbackCapabilityFlagBitsOMNIX1 XR_FORCE_FEEDBACK_CAPABILITY_VIBRATION_BIT_OMNIX1 = 0x00000004;

/* The present state. No bit reports that an earlier call failed. */
typedef XrFlags64 XrForceFeedbackStateFlagsOMNIX1;
typedef XrFlags64 XrForceFeedbackStateFlagBitsOMNIX1;
/* The session is not focused: all forces are zero, and forces and constraints set before are gone. */
static const XrForceFeedbackStateFlagBitsOMNIX1 XR_FORCE_FEEDBACK_STATE_FOCUS_LOST_BIT_OMNIX1 = 0x00000001;
/* The device produces less force than requested, in the same direction. */
static const XrForceFeedbackStateFlagBitsOMNIX1 XR_FORCE_FEEDBACK_STATE_SATURATED_BIT_OMNIX1 = 0x00000002;
/* The device is warm and can produce less force than when it is cold. */
static const XrForceFeedbackStateFlagBitsOMNIX1 XR_FORCE_FEEDBACK_STATE_THERMAL_LIMITED_BIT_OMNIX1 = 0x00000004;
/* No force is available where the device is now. */
static const XrForceFeedbackStateFlagBitsOMNIX1 XR_FORCE_FEEDBACK_STATE_OUT_OF_WORKSPACE_BIT_OMNIX1 = 0x00000008;
/* The device reports a fault and has removed all force. */
static const XrForceFeedbackStateFlagBitsOMNIX1 XR_FORCE_FEEDBACK_STATE_EMERGENCY_STOP_BIT_OMNIX1 = 0x00000010;
/* No data from the device for 100 ms: its service ended, or it was unplugged. */
static const XrForceFeedbackStateFlagBitsOMNIX1 XR_FORCE_FEEDBACK_STATE_STALE_BIT_OMNIX1 = 0x00000020;
/* Constraints are rendered less stiff or less damped than requested, to stay stable; or what is touched, a surface or a
   constraint, made the hand swing and is softer for now. */
static const XrForceFeedbackStateFlagBitsOMNIX1 XR_FORCE_FEEDBACK_STATE_STIFFNESS_LIMITED_BIT_OMNIX1 = 0x00000040;
/* Another application has the device. */
static const XrForceFeedbackStateFlagBitsOMNIX1 XR_FORCE_FEEDBACK_STATE_IN_USE_BIT_OMNIX1 = 0x00000080;

/* On which side of a plane or sphere the device is held. */
typedef enum XrForceFeedbackSideOMNIX1 {
  /* On the surface: attracted to it from both sides. */
  XR_FORCE_FEEDBACK_SIDE_ON_OMNIX1 = 0,
  /* Plane: where the normal points to. Sphere: outside of it. Force only while it is beyond. */
  XR_FORCE_FEEDBACK_SIDE_OUTSIDE_OMNIX1 = 1,
  /* Plane: where the normal points away from. Sphere: within it. Force only while it is beyond. */
  XR_FORCE_FEEDBACK_SIDE_INSIDE_OMNIX1 = 2,
  XR_FORCE_FEEDBACK_SIDE_MAX_ENUM_OMNIX1 = 0x7FFFFFFF
} XrForceFeedbackSideOMNIX1;

/* Chain it to XrSystemProperties. All zero if supportsForceFeedback is XR_FALSE: the service is absent or has no
 * device, possibly only temporarily. */
typedef struct XrSystemForceFeedbackPropertiesOMNIX1 {
  XrStructureType type;
  void* XR_MAY_ALIAS next;
  XrBool32 supportsForceFeedback;
  XrForceFeedbackCapabilityFlagsOMNIX1 capabilityFlags;
  float maxForce;              /* N, anywhere and for a short time */
  float maxContinuousForce;    /* N, where it is largest, for any time */
  float maxStiffness;          /* N/m, the most that any constraint gets; noise and delay may reduce it */
  float maxDamping;            /* N s/m, likewise */
  float updateRate;            /* Hz, of constraints */
  uint32_t maxConstraintCount; /* <= XR_MAX_FORCE_FEEDBACK_CONSTRAINTS_OMNIX1 */
} XrSystemForceFeedbackPropertiesOMNIX1;

typedef struct XrForceFeedbackCreateInfoOMNIX1 {
  XrStructureType type;
  const void* XR_MAY_ALIAS next;
  XrPath topLevelUserPath; /* /user/hand/left or /user/hand/right: the hand that holds the device */
} XrForceFeedbackCreateInfoOMNIX1;

typedef struct XrForceFeedbackPropertiesGetInfoOMNIX1 {
  XrStructureType type;
  const void* XR_MAY_ALIAS next;
  XrSpace baseSpace; /* for workspacePose */
  XrTime time;       /* at which the workspace is located; > 0 */
} XrForceFeedbackPropertiesGetInfoOMNIX1;

/* The largest force that the device can produce in every direction at one distance from the workspace's origin. */
typedef struct XrForceFeedbackReachOMNIX1 {
  float distance; /* m, of the device point */
  float force;    /* N, in the direction in which it is least, device pointing at the origin, device cold */
} XrForceFeedbackReachOMNIX1;

/* Workspace: the half of a spherical shell above the base, y >= 0 in the frame of workspacePose (+y up, -z away from
 * the user, origin at the centre of the base). */
typedef struct XrForceFeedbackPropertiesOMNIX1 {
  XrStructureType type;
  void* XR_MAY_ALIAS next;
  XrSpaceLocationFlags workspaceLocationFlags; /* what of workspacePose is valid and tracked */
  XrPosef workspacePose;                       /* in baseSpace */
  float innerRadius;                           /* m: nearest that the device point comes */
  float outerRadius;                           /* m: no force from here on */
  uint32_t reachCapacityInput;                 /* capacity of `reach`; 0: asks for the count */
  uint32_t reachCountOutput;
  XrForceFeedbackReachOMNIX1* reach; /* by rising distance; may be NULL if reachCapacityInput is 0 */
} XrForceFeedbackPropertiesOMNIX1;

/* A force on the device, until it is renewed, stopped, or its time is up. */
typedef struct XrForceApplyInfoOMNIX1 {
  XrStructureType type;
  const void* XR_MAY_ALIAS next;
  XrSpace baseSpace;       /* its orientation at the time of the call counts */
  XrVector3f force;        /* N, on the device, in baseSpace; finite; clamped to what the device can produce */
  XrDuration duration;     /* ns, > 0; from XR_MAX_FORCE_DURATION_OMNIX1 on: that. Then it fades out within 20 ms */
  XrDuration rampDuration; /* ns, >= 0: time from the present force to this one; at most XR_MAX_FORCE_DURATION_OMNIX1 */
} XrForceApplyInfoOMNIX1;

/* Common header of all constraint structures. A constraint is a spring and a damper between the device point and a
 * shape that is fixed in baseSpace; the device evaluates it at its own rate. A constraint only returns energy that the
 * hand has put in. */
typedef struct XR_MAY_ALIAS XrForceFeedbackConstraintBaseHeaderOMNIX1 {
  XrStructureType type;
  const void* XR_MAY_ALIAS next;
  XrSpace baseSpace; /* may move: the layer follows it at xrSyncActions and xrWaitFrame */
  float stiffness;   /* N/m, >= 0; clamped */
  float damping;  /* N s/m, >= 0; clamped. Acts along the directions in which the spring acts, relative to baseSpace */
  float maxForce; /* N, >= 0: of this constraint; clamped */
} XrForceFeedbackConstraintBaseHeaderOMNIX1;

/* Draws the device point to a point:   F = -stiffness (x - position) - damping v */
typedef struct XrForceFeedbackConstraintPointOMNIX1 {
  XrStructureType type;
  const void* XR_MAY_ALIAS next;
  XrSpace baseSpace;
  float stiffness;
  float damping;
  float maxForce;
  XrVector3f position; /* m, in baseSpace */
} XrForceFeedbackConstraintPointOMNIX1;

/* Holds the device point on an endless line, or in a tube around it. */
typedef struct XrForceFeedbackConstraintLineOMNIX1 {
  XrStructureType type;
  const void* XR_MAY_ALIAS next;
  XrSpace baseSpace;
  float stiffness;
  float damping;
  float maxForce;
  XrVector3f position;  /* m: a point of the line, in baseSpace */
  XrVector3f direction; /* not zero, any length */
  float radius;         /* m, >= 0: free up to this distance from the line */
} XrForceFeedbackConstraintLineOMNIX1;

/* Holds the device point on a plane, or on one side of it. */
typedef struct XrForceFeedbackConstraintPlaneOMNIX1 {
  XrStructureType type;
  const void* XR_MAY_ALIAS next;
  XrSpace baseSpace;
  float stiffness;
  float damping;
  float maxForce;
  XrVector3f position; /* m: a point of the plane, in baseSpace */
  XrVector3f normal;   /* not zero, any length */
  XrForceFeedbackSideOMNIX1 side;
} XrForceFeedbackConstraintPlaneOMNIX1;

/* Holds the device point on a sphere, in it, or out of it. The force fades out towards the centre, where it has no
 * direction. */
typedef struct XrForceFeedbackConstraintSphereOMNIX1 {
  XrStructureType type;
  const void* XR_MAY_ALIAS next;
  XrSpace baseSpace;
  float stiffness;
  float damping;
  float maxForce;
  XrVector3f position; /* m: the centre, in baseSpace */
  float radius;        /* m, > 0 */
  XrForceFeedbackSideOMNIX1 side;
} XrForceFeedbackConstraintSphereOMNIX1;

/* Syrup:   F = -damping v, v relative to baseSpace. `stiffness` must be 0. */
typedef struct XrForceFeedbackConstraintViscousOMNIX1 {
  XrStructureType type;
  const void* XR_MAY_ALIAS next;
  XrSpace baseSpace;
  float stiffness;
  float damping;
  float maxForce;
} XrForceFeedbackConstraintViscousOMNIX1;

/* Replaces all constraints set before. All of them are accepted, or none. */
typedef struct XrForceFeedbackConstraintsSetInfoOMNIX1 {
  XrStructureType type;
  const void* XR_MAY_ALIAS next;
  uint32_t constraintCount; /* 0: removes all; at most maxConstraintCount */
  const XrForceFeedbackConstraintBaseHeaderOMNIX1* const* constraints;
} XrForceFeedbackConstraintsSetInfoOMNIX1;

typedef struct XrForceFeedbackStateGetInfoOMNIX1 {
  XrStructureType type;
  const void* XR_MAY_ALIAS next;
  XrSpace baseSpace; /* for appliedForce */
  XrTime time;       /* > 0; past: from 250 ms of history; future: the newest */
} XrForceFeedbackStateGetInfoOMNIX1;

typedef struct XrForceFeedbackStateOMNIX1 {
  XrStructureType type;
  void* XR_MAY_ALIAS next;
  XrBool32 isActive; /* forces of this handle take effect: focused, not in use by others, device present */
  XrForceFeedbackStateFlagsOMNIX1 stateFlags;
  XrTime sampleTime;       /* of what follows; 0: there is none */
  XrBool32 isForceValid;   /* XR_FALSE: baseSpace could not be located, or there is no sample; appliedForce is zero */
  XrVector3f appliedForce; /* N, on the device, in baseSpace: all that is rendered, surfaces and vibration included */
  uint32_t contactCount;   /* surfaces touched */
} XrForceFeedbackStateOMNIX1;

/* isActive or stateFlags changed. SATURATED, THERMAL_LIMITED, OUT_OF_WORKSPACE and STIFFNESS_LIMITED are reported as
 * cleared only after 0.5 s without them. */
typedef struct XrEventDataForceFeedbackStateChangedOMNIX1 {
  XrStructureType type;
  const void* XR_MAY_ALIAS next;
  XrSession session;
  XrForceFeedbackOMNIX1 forceFeedback;
  XrBool32 isActive;
  XrForceFeedbackStateFlagsOMNIX1 stateFlags;
  XrTime time; /* when it was noticed */
} XrEventDataForceFeedbackStateChangedOMNIX1;

/* Errors of all functions: XR_ERROR_FUNCTION_UNSUPPORTED (extension not enabled), XR_ERROR_VALIDATION_FAILURE (NULL,
 * wrong type, NaN or infinity, a value out of the range given above), XR_ERROR_HANDLE_INVALID,
 * XR_ERROR_RUNTIME_FAILURE, XR_ERROR_INSTANCE_LOST, XR_ERROR_SESSION_LOST, XR_ERROR_OUT_OF_MEMORY. A call that fails
 * changes nothing. */

/* XR_ERROR_FEATURE_UNSUPPORTED: there is no such device now. XR_ERROR_PATH_INVALID, XR_ERROR_PATH_UNSUPPORTED: not the
 * hand that holds it. XR_ERROR_FORCE_FEEDBACK_IN_USE_OMNIX1. */
typedef XrResult(XRAPI_PTR* PFN_xrCreateForceFeedbackOMNIX1)(XrSession session,
                                                             const XrForceFeedbackCreateInfoOMNIX1* createInfo,
                                                             XrForceFeedbackOMNIX1* forceFeedback);
/* Its forces and constraints end. */
typedef XrResult(XRAPI_PTR* PFN_xrDestroyForceFeedbackOMNIX1)(XrForceFeedbackOMNIX1 forceFeedback);
/* XR_ERROR_SIZE_INSUFFICIENT, XR_ERROR_TIME_INVALID, XR_ERROR_FEATURE_UNSUPPORTED: the device has gone. */
typedef XrResult(XRAPI_PTR* PFN_xrGetForceFeedbackPropertiesOMNIX1)(
    XrForceFeedbackOMNIX1 forceFeedback, const XrForceFeedbackPropertiesGetInfoOMNIX1* getInfo,
    XrForceFeedbackPropertiesOMNIX1* properties);
/* XR_SESSION_NOT_FOCUSED: nothing is rendered. XR_ERROR_FORCE_FEEDBACK_IN_USE_OMNIX1,
 * XR_ERROR_FORCE_FEEDBACK_SPACE_NOT_LOCATABLE_OMNIX1. */
typedef XrResult(XRAPI_PTR* PFN_xrApplyForceOMNIX1)(XrForceFeedbackOMNIX1 forceFeedback,
                                                    const XrForceApplyInfoOMNIX1* applyInfo);
/* As xrApplyForceOMNIX1, and XR_ERROR_LIMIT_REACHED: too many. */
typedef XrResult(XRAPI_PTR* PFN_xrSetForceFeedbackConstraintsOMNIX1)(
    XrForceFeedbackOMNIX1 forceFeedback, const XrForceFeedbackConstraintsSetInfoOMNIX1* setInfo);
/* Force and constraints end, within 20 ms. XR_SUCCESS also where there was none. */
typedef XrResult(XRAPI_PTR* PFN_xrStopForceFeedbackOMNIX1)(XrForceFeedbackOMNIX1 forceFeedback);
/* XR_ERROR_TIME_INVALID. */
typedef XrResult(XRAPI_PTR* PFN_xrGetForceFeedbackStateOMNIX1)(XrForceFeedbackOMNIX1 forceFeedback,
                                                               const XrForceFeedbackStateGetInfoOMNIX1* getInfo,
                                                               XrForceFeedbackStateOMNIX1* state);

#ifdef __cplusplus
}
#endif

#endif
