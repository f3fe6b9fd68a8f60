/*
 * XR_OMNIX1_haptic_scene: a scene that the pen touches, given by the application.
 *
 * EXPERIMENTAL. The author tag is not registered with Khronos; names and values will change with a registration. This
 * header is the reference; docs/extensions/XR_OMNIX1_haptic_scene.md has the rules in full.
 *
 * Units: SI (metres, seconds, newtons). Frames: as documented at each field. The "scene frame" is that of the glTF
 * document: right-handed, y up, metres as in the file; the placement sets its pose and scale. C89, needs
 * <openxr/openxr.h> 1.0.20 or newer and nothing else. Requires XR_OMNIX1_force_feedback: without it,
 * xrCreateInstance returns XR_ERROR_EXTENSION_DEPENDENCY_NOT_ENABLED.
 */
#ifndef OPENXR_OMNI_HAPTIC_SCENE_H_
#define OPENXR_OMNI_HAPTIC_SCENE_H_ 1

#include <openxr/openxr.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Enumerants outside of openxr.h, of its types. */
#ifndef OMNI_XR_ENUMERANT
#ifdef __cplusplus
#define OMNI_XR_ENUMERANT(type, value) (static_cast<type>(value))
#else
#define OMNI_XR_ENUMERANT(type, value) ((type)(value))
#endif
#endif

#define XR_OMNIX1_haptic_scene 1
#define XR_OMNIX1_haptic_scene_SPEC_VERSION 1
#define XR_OMNIX1_HAPTIC_SCENE_EXTENSION_NAME "XR_OMNIX1_haptic_scene"

#define XR_TYPE_HAPTIC_SCENE_CREATE_INFO_OMNIX1 OMNI_XR_ENUMERANT(XrStructureType, 2000002000)
#define XR_TYPE_HAPTIC_SCENE_STATE_OMNIX1 OMNI_XR_ENUMERANT(XrStructureType, 2000002001)
#define XR_TYPE_EVENT_DATA_HAPTIC_SCENE_STATE_CHANGED_OMNIX1 OMNI_XR_ENUMERANT(XrStructureType, 2000002002)
#define XR_TYPE_HAPTIC_SCENE_PLACEMENT_OMNIX1 OMNI_XR_ENUMERANT(XrStructureType, 2000002003)
#define XR_TYPE_HAPTIC_SCENE_NODE_OMNIX1 OMNI_XR_ENUMERANT(XrStructureType, 2000002004)
#define XR_TYPE_HAPTIC_NODES_UPDATE_INFO_OMNIX1 OMNI_XR_ENUMERANT(XrStructureType, 2000002005)
#define XR_TYPE_HAPTIC_MATERIAL_OMNIX1 OMNI_XR_ENUMERANT(XrStructureType, 2000002006)
#define XR_TYPE_HAPTIC_CONTACTS_GET_INFO_OMNIX1 OMNI_XR_ENUMERANT(XrStructureType, 2000002007)
#define XR_TYPE_HAPTIC_CONTACT_OMNIX1 OMNI_XR_ENUMERANT(XrStructureType, 2000002008)
#define XR_TYPE_HAPTIC_NODE_MESH_GET_INFO_OMNIX1 OMNI_XR_ENUMERANT(XrStructureType, 2000002009)
#define XR_TYPE_HAPTIC_NODE_MESH_OMNIX1 OMNI_XR_ENUMERANT(XrStructureType, 2000002010)

/* The scene is still LOADING: it has no nodes, materials, contacts or meshes yet. */
#define XR_ERROR_HAPTIC_SCENE_NOT_READY_OMNIX1 OMNI_XR_ENUMERANT(XrResult, -2000002000)
/* The scene is FAILED: xrGetHapticSceneDiagnosticsOMNIX1 says why. */
#define XR_ERROR_HAPTIC_SCENE_INVALID_OMNIX1 OMNI_XR_ENUMERANT(XrResult, -2000002001)
/* No node of this scene has that id, or the node does not support the operation (move, deform). */
#define XR_ERROR_HAPTIC_NODE_INVALID_OMNIX1 OMNI_XR_ENUMERANT(XrResult, -2000002002)

XR_DEFINE_HANDLE(XrHapticSceneOMNIX1) /* parent: XrSession */
XR_DEFINE_ATOM(XrHapticNodeIdOMNIX1)  /* valid as long as its scene */

#define XR_NULL_HAPTIC_NODE_ID_OMNIX1 0

#define XR_MAX_HAPTIC_SCENE_BYTES_OMNIX1 (256u << 20) /* of a document in memory */
#define XR_MAX_HAPTIC_NODE_NAME_SIZE_OMNIX1 48        /* terminator included; longer names are cut */
#define XR_MAX_HAPTIC_NODES_MOVED_OMNIX1 16           /* different nodes that xrUpdateHapticNodesOMNIX1 moves */
#define XR_MAX_HAPTIC_MATERIALS_OMNIX1 256            /* that can be read and set */
#define XR_MAX_HAPTIC_MATERIALS_SET_OMNIX1 16         /* different materials that are set */

/* ---- Creation ---------------------------------------------------------------------------------------------------- */

typedef XrFlags64 XrHapticSceneCreateFlagsOMNIX1;
/* A document without any haptic tag can be touched as a whole, with the default material. Without this bit such a
 * document makes a scene that cannot be touched. */
static const XrHapticSceneCreateFlagsOMNIX1 XR_HAPTIC_SCENE_CREATE_TOUCH_UNTAGGED_BIT_OMNIX1 = 0x00000001;
/* Every node may be moved by xrUpdateHapticNodesOMNIX1, as if each had the tag "kinematic". */
static const XrHapticSceneCreateFlagsOMNIX1 XR_HAPTIC_SCENE_CREATE_ALL_KINEMATIC_BIT_OMNIX1 = 0x00000002;

typedef struct XrHapticSceneCreateInfoOMNIX1 {
  XrStructureType type; /* XR_TYPE_HAPTIC_SCENE_CREATE_INFO_OMNIX1 */
  const void* XR_MAY_ALIAS next;
  XrHapticSceneCreateFlagsOMNIX1 createFlags;
  uint32_t bufferByteCount; /* 1 to XR_MAX_HAPTIC_SCENE_BYTES_OMNIX1 */
  const uint8_t* buffer;    /* glTF 2.0: .glb, or JSON with data URIs. Copied before the call returns. */
} XrHapticSceneCreateInfoOMNIX1;

typedef enum XrHapticSceneStatusOMNIX1 {
  XR_HAPTIC_SCENE_STATUS_LOADING_OMNIX1 = 0, /* being built, or waiting for the service */
  XR_HAPTIC_SCENE_STATUS_READY_OMNIX1 = 1,   /* rendered while it is enabled and the session is focused */
  XR_HAPTIC_SCENE_STATUS_FAILED_OMNIX1 = 2,  /* for good: destroy it */
  XR_HAPTIC_SCENE_STATUS_MAX_ENUM_OMNIX1 = 0x7FFFFFFF
} XrHapticSceneStatusOMNIX1;

typedef struct XrHapticSceneStateOMNIX1 {
  XrStructureType type; /* XR_TYPE_HAPTIC_SCENE_STATE_OMNIX1 */
  void* XR_MAY_ALIAS next;
  XrHapticSceneStatusOMNIX1 status;
  XrBool32 isFelt;        /* the pen is rendering this scene now */
  uint32_t nodeCount;     /* 0 unless READY */
  uint32_t materialCount; /* likewise */
  uint32_t triangleCount; /* likewise; after repair */
  XrDuration loadTime;    /* from the service's receipt of the document to READY or FAILED, ns */
} XrHapticSceneStateOMNIX1;

/* Sent whenever `status` changes; the first one after creation reports READY or FAILED. */
typedef struct XrEventDataHapticSceneStateChangedOMNIX1 {
  XrStructureType type; /* XR_TYPE_EVENT_DATA_HAPTIC_SCENE_STATE_CHANGED_OMNIX1 */
  const void* XR_MAY_ALIAS next;
  XrSession session;
  XrHapticSceneOMNIX1 scene;
  XrHapticSceneStatusOMNIX1 status;
  XrTime time; /* when the runtime learned of it */
} XrEventDataHapticSceneStateChangedOMNIX1;

/* ---- Where the scene stands -------------------------------------------------------------------------------------- */

typedef struct XrHapticScenePlacementOMNIX1 {
  XrStructureType type; /* XR_TYPE_HAPTIC_SCENE_PLACEMENT_OMNIX1 */
  const void* XR_MAY_ALIAS next;
  XrSpace baseSpace; /* followed while it moves: located at every xrWaitFrame */
  XrPosef pose;      /* of the scene frame in baseSpace */
  float scale;       /* metres per metre of the document, 1e-4 to 1e4; a different one reloads the scene */
} XrHapticScenePlacementOMNIX1;

/* ---- Nodes ------------------------------------------------------------------------------------------------------- */

typedef XrFlags64 XrHapticNodeFlagsOMNIX1;
static const XrHapticNodeFlagsOMNIX1 XR_HAPTIC_NODE_KINEMATIC_BIT_OMNIX1 = 0x00000001;  /* may be moved */
static const XrHapticNodeFlagsOMNIX1 XR_HAPTIC_NODE_SOFT_BIT_OMNIX1 = 0x00000002;       /* deforms under the pen */
static const XrHapticNodeFlagsOMNIX1 XR_HAPTIC_NODE_SCULPTABLE_BIT_OMNIX1 = 0x00000004; /* is sculpted by the pen */
static const XrHapticNodeFlagsOMNIX1 XR_HAPTIC_NODE_EXTRUDABLE_BIT_OMNIX1 = 0x00000008; /* faces are pulled, pushed */
static const XrHapticNodeFlagsOMNIX1 XR_HAPTIC_NODE_DOUBLE_SIDED_BIT_OMNIX1 = 0x00000010;

/* A node of the document whose mesh can be touched. */
typedef struct XrHapticSceneNodeOMNIX1 {
  XrStructureType type; /* XR_TYPE_HAPTIC_SCENE_NODE_OMNIX1 */
  void* XR_MAY_ALIAS next;
  XrHapticNodeIdOMNIX1 node;
  int32_t gltfNode; /* index into the document's nodes; -1: several nodes joined into one */
  XrHapticNodeFlagsOMNIX1 flags;
  uint32_t materialIndex; /* that most of its triangles have */
  uint32_t triangleCount;
  XrPosef restPose; /* of the node in the scene frame, as the document has it; without its scale */
  char name[XR_MAX_HAPTIC_NODE_NAME_SIZE_OMNIX1]; /* UTF-8, terminated */
} XrHapticSceneNodeOMNIX1;

typedef XrFlags64 XrHapticNodePoseFlagsOMNIX1;
/* Teleported, not moved: nothing in between is touched, and no motion is rendered. */
static const XrHapticNodePoseFlagsOMNIX1 XR_HAPTIC_NODE_POSE_TELEPORT_BIT_OMNIX1 = 0x00000001;

typedef struct XrHapticNodePoseOMNIX1 {
  XrHapticNodeIdOMNIX1 node;
  XrHapticNodePoseFlagsOMNIX1 flags;
  XrPosef pose;               /* of the node; restPose stands for "as in the document" */
  XrVector3f linearVelocity;  /* of the node's origin, m/s */
  XrVector3f angularVelocity; /* rad/s */
} XrHapticNodePoseOMNIX1;

typedef struct XrHapticNodesUpdateInfoOMNIX1 {
  XrStructureType type; /* XR_TYPE_HAPTIC_NODES_UPDATE_INFO_OMNIX1 */
  const void* XR_MAY_ALIAS next;
  XrSpace baseSpace; /* of poses and velocities; XR_NULL_HANDLE: the scene frame, lengths in the document's metres */
  XrTime time;       /* when the nodes are there: usually the frame's predictedDisplayTime */
  uint32_t nodeCount;
  const XrHapticNodePoseOMNIX1* nodes;
} XrHapticNodesUpdateInfoOMNIX1;

/* ---- Materials --------------------------------------------------------------------------------------------------- */

/* How a surface feels. Values outside of a range are clamped to it. */
typedef struct XrHapticMaterialOMNIX1 {
  XrStructureType type; /* XR_TYPE_HAPTIC_MATERIAL_OMNIX1 */
  void* XR_MAY_ALIAS next;
  float stiffness;          /* N/m, 0 to 2000; at most what the device renders stably */
  float damping;            /* N s/m, 0 to 5 */
  float staticFriction;     /* Coulomb, 0 to 2 */
  float dynamicFriction;    /* 0 to staticFriction */
  float viscosity;          /* N s/m inside the volume, 0 to 5 */
  float textureAmplitude;   /* m of height, 0 to 0.002 */
  float textureWavelength;  /* m, 0.0001 to 0.1 */
  float textureGain;        /* 0 to 10 */
  float vibrationAmplitude; /* N while touched, 0 to 2 */
  float vibrationFrequency; /* Hz, 1 to 500 */
  float popThrough;         /* N at which the surface gives way, 0 to 10; 0: never */
} XrHapticMaterialOMNIX1;

/* ---- What the pen touches ---------------------------------------------------------------------------------------- */

typedef struct XrHapticContactsGetInfoOMNIX1 {
  XrStructureType type; /* XR_TYPE_HAPTIC_CONTACTS_GET_INFO_OMNIX1 */
  const void* XR_MAY_ALIAS next;
  XrSpace baseSpace; /* what is returned is expressed in it */
  XrTime time;       /* at which baseSpace is located; the contacts are always the newest */
} XrHapticContactsGetInfoOMNIX1;

typedef struct XrHapticContactOMNIX1 {
  XrStructureType type; /* XR_TYPE_HAPTIC_CONTACT_OMNIX1 */
  void* XR_MAY_ALIAS next;
  XrHapticNodeIdOMNIX1 node;
  uint32_t materialIndex;
  XrVector3f point;        /* on the surface, m */
  XrVector3f normal;       /* unit, towards the side the pen came from */
  XrVector3f force;        /* requested by this contact on the pen, N; before the device's limits */
  float normalForce;       /* N, >= 0 */
  float tangentialForce;   /* N, >= 0 */
  float penetration;       /* m, >= 0: of the tip under the surface */
  XrVector3f slipVelocity; /* of the tip along the surface, relative to it, m/s */
  XrTime time;             /* of the measurement that this follows from */
} XrHapticContactOMNIX1;

/* ---- Surfaces that change ---------------------------------------------------------------------------------------- */

typedef struct XrHapticNodeMeshGetInfoOMNIX1 {
  XrStructureType type; /* XR_TYPE_HAPTIC_NODE_MESH_GET_INFO_OMNIX1 */
  const void* XR_MAY_ALIAS next;
  XrHapticNodeIdOMNIX1 node; /* SOFT, SCULPTABLE or EXTRUDABLE */
} XrHapticNodeMeshGetInfoOMNIX1;

/* Two-call idiom for both arrays at once: a capacity of 0 asks for its count. The mesh is the service's: welded and
 * repaired, so its vertices are not those of the document; draw it by its own indices. */
typedef struct XrHapticNodeMeshOMNIX1 {
  XrStructureType type; /* XR_TYPE_HAPTIC_NODE_MESH_OMNIX1 */
  void* XR_MAY_ALIAS next;
  XrTime time;           /* of the measurement that the shape follows from; 0: at rest since the scene became ready */
  uint64_t vertexChange; /* changes when the vertices change */
  uint64_t indexChange;  /* changes when the indices, and perhaps the counts, change */
  float maxDisplacement; /* m of the document, of a vertex from its rest; 0 for a sculpted node */
  uint32_t vertexCapacityInput;
  uint32_t vertexCountOutput;
  XrVector3f* vertices; /* scene frame, document's metres; without the motion set by xrUpdateHapticNodesOMNIX1 */
  uint32_t indexCapacityInput;
  uint32_t indexCountOutput; /* three per triangle, counter-clockwise from outside */
  uint32_t* indices;
} XrHapticNodeMeshOMNIX1;

/* ---- Functions --------------------------------------------------------------------------------------------------- */

/* Copies the document and starts to load it; returns at once with status LOADING. One at a time: a second one is
 * XR_ERROR_LIMIT_REACHED. From READY until it is destroyed it replaces the scene that the service's configuration has
 * for this application. */
typedef XrResult(XRAPI_PTR* PFN_xrCreateHapticSceneOMNIX1)(XrSession session,
                                                           const XrHapticSceneCreateInfoOMNIX1* createInfo,
                                                           XrHapticSceneOMNIX1* scene);

/* Destroys the scene; its forces end within 10 ms. */
typedef XrResult(XRAPI_PTR* PFN_xrDestroyHapticSceneOMNIX1)(XrHapticSceneOMNIX1 scene);

typedef XrResult(XRAPI_PTR* PFN_xrGetHapticSceneStateOMNIX1)(XrHapticSceneOMNIX1 scene,
                                                             XrHapticSceneStateOMNIX1* state);

/* Human-readable text (two-call idiom), UTF-8, one message per line. FAILED: why, with the JSON pointer of the cause;
 * READY: warnings; LOADING: what the scene waits for. */
typedef XrResult(XRAPI_PTR* PFN_xrGetHapticSceneDiagnosticsOMNIX1)(XrHapticSceneOMNIX1 scene,
                                                                   uint32_t bufferCapacityInput,
                                                                   uint32_t* bufferCountOutput, char* buffer);

typedef XrResult(XRAPI_PTR* PFN_xrEnumerateHapticSceneNodesOMNIX1)(XrHapticSceneOMNIX1 scene,
                                                                   uint32_t nodeCapacityInput,
                                                                   uint32_t* nodeCountOutput,
                                                                   XrHapticSceneNodeOMNIX1* nodes);

/* Until the first call the document's origin is the centre of the device's base, y up, scale 1. */
typedef XrResult(XRAPI_PTR* PFN_xrSetHapticScenePlacementOMNIX1)(XrHapticSceneOMNIX1 scene,
                                                                 const XrHapticScenePlacementOMNIX1* placement);

/* A disabled scene is not rendered but keeps its nodes, materials and poses. New scenes are enabled. */
typedef XrResult(XRAPI_PTR* PFN_xrSetHapticSceneEnabledOMNIX1)(XrHapticSceneOMNIX1 scene, XrBool32 enabled);

/* Poses of kinematic nodes, usually once a frame. All or none are applied. */
typedef XrResult(XRAPI_PTR* PFN_xrUpdateHapticNodesOMNIX1)(XrHapticSceneOMNIX1 scene,
                                                           const XrHapticNodesUpdateInfoOMNIX1* updateInfo);

/* What is in effect: the document's, or what was set last, within the ranges. */
typedef XrResult(XRAPI_PTR* PFN_xrGetHapticMaterialOMNIX1)(XrHapticSceneOMNIX1 scene, uint32_t materialIndex,
                                                           XrHapticMaterialOMNIX1* material);
typedef XrResult(XRAPI_PTR* PFN_xrSetHapticMaterialOMNIX1)(XrHapticSceneOMNIX1 scene, uint32_t materialIndex,
                                                           const XrHapticMaterialOMNIX1* material);

/* Two-call; none unless the scene is rendered. */
typedef XrResult(XRAPI_PTR* PFN_xrEnumerateHapticContactsOMNIX1)(XrHapticSceneOMNIX1 scene,
                                                                 const XrHapticContactsGetInfoOMNIX1* getInfo,
                                                                 uint32_t contactCapacityInput,
                                                                 uint32_t* contactCountOutput,
                                                                 XrHapticContactOMNIX1* contacts);

typedef XrResult(XRAPI_PTR* PFN_xrGetHapticNodeMeshOMNIX1)(XrHapticSceneOMNIX1 scene,
                                                           const XrHapticNodeMeshGetInfoOMNIX1* getInfo,
                                                           XrHapticNodeMeshOMNIX1* mesh);

#ifdef __cplusplus
}
#endif

#endif /* OPENXR_OMNI_HAPTIC_SCENE_H_ */
