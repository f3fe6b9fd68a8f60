/*
 * XR_OMNIX1_stylus_interaction: a pen without a housing full of buttons, as an interaction profile.
 *
 * EXPERIMENTAL. The author tag OMNI is not registered with Khronos; paths will change with a registration.
 * Specification: docs/extensions/XR_OMNIX1_stylus_interaction.md.
 *
 * Self-contained, C89 and C++; needs no other header. The extension adds paths only: no function, no structure, no
 * enumerant. Suggest bindings for XR_OMNIX1_STYLUS_INTERACTION_PROFILE with xrSuggestInteractionProfileBindings; paths
 * below are relative to /user/hand/left or /user/hand/right.
 */
#ifndef OMNI_STYLUS_INTERACTION_H_
#define OMNI_STYLUS_INTERACTION_H_ 1

#define XR_OMNIX1_stylus_interaction 1
#define XR_OMNIX1_stylus_interaction_SPEC_VERSION 1
#define XR_OMNIX1_STYLUS_INTERACTION_EXTENSION_NAME "XR_OMNIX1_stylus_interaction"

#define XR_OMNIX1_STYLUS_INTERACTION_PROFILE "/interaction_profiles/omni/stylus_omnix1"

/* Pose, m: origin at the sharpest point, -Z out of the tip along the pen's axis. On every hand's profile. */
#define XR_OMNIX1_STYLUS_TIP_POSE "/input/tip_omnix1/pose"
/* Float, 0..1: force along the contact's normal divided by the service's full-scale force. On every hand's profile. */
#define XR_OMNIX1_STYLUS_TIP_FORCE "/input/tip_omnix1/force"
/* Boolean: pressed against something, by the service's thresholds. */
#define XR_OMNIX1_STYLUS_TIP_CLICK "/input/tip_omnix1/click"
/* Boolean: the button on the barrel, or the gesture that replaces it. */
#define XR_OMNIX1_STYLUS_BARREL_CLICK "/input/barrel_omnix1/click"
/* Boolean: a second button or gesture. */
#define XR_OMNIX1_STYLUS_SECONDARY_CLICK "/input/secondary_omnix1/click"
/* Boolean: the pen is docked. */
#define XR_OMNIX1_STYLUS_DOCKED "/input/dock_omnix1/docked_omnix1"

#endif /* OMNI_STYLUS_INTERACTION_H_ */
