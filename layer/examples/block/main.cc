// omni_block: a scene of the application's own, through XR_OMNIX1_haptic_scene
// (docs/extensions/XR_OMNIX1_haptic_scene.md).
//
//   omni_block [--seconds S] [--name NAME]
//
// A block above the base that rises and sinks. It feels like rubber, then like ice, then ribbed, a third of the time
// each. The application says what is there and where; the device computes the forces, a thousand times a second. It
// prints what the pen touches four times a second. Exit status: 0; 1 with a line on stderr; 2 wrong arguments.

#include <openxr/omni_force_feedback.h>
#include <openxr/omni_haptic_scene.h>
#include <openxr/openxr.h>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include "session/session.h"

namespace {

using example::Options;
using example::Session;

bool Ok(XrResult result, const char* call) {
  if (XR_SUCCEEDED(result)) return true;
  std::fprintf(stderr, "omni_block: %s failed with XrResult %d\n", call, static_cast<int>(result));
  return false;
}

// 1. The document: glTF 2.0, here a .glb of one box, made by hand. An application usually has a file that its modelling
// program has written. Metres, y up; the origin is the centre of the base. The tag "haptic" says what can be touched,
// and how it feels (docs/scenes.md).
constexpr float kHalf_m = 0.02f, kBottom_m = 0.042f, kTop_m = 0.052f;  // the hull is a sphere of 37.5 mm
constexpr char kJson[] = R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
  "nodes": [{"name": "block", "mesh": 0, "extras": {"haptic": {"stiffness": 300}}}],
  "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
  "accessors": [{"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3"},
                {"bufferView": 1, "componentType": 5123, "count": 36, "type": "SCALAR"}],
  "bufferViews": [{"buffer": 0, "byteLength": 96}, {"buffer": 0, "byteOffset": 96, "byteLength": 72}],
  "buffers": [{"byteLength": 168}]})";

template <class T>
void Append(std::string& bytes, const T& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

std::string Document() {
  constexpr float h = kHalf_m, b = kBottom_m, t = kTop_m;
  constexpr float kCorners[] = {-h, b, -h, h, b, -h, h, b, h, -h, b, h, -h, t, -h, h, t, -h, h, t, h, -h, t, h};
  constexpr std::uint16_t kTriangles[] = {0, 1, 2, 0, 2, 3, 4, 6, 5, 4, 7, 6, 0, 4, 5, 0, 5, 1,
                                          1, 5, 6, 1, 6, 2, 2, 6, 7, 2, 7, 3, 3, 7, 4, 3, 4, 0};
  std::string json = kJson, binary, document;
  while (json.size() % 4 != 0) json += ' ';
  Append(binary, kCorners);
  Append(binary, kTriangles);
  constexpr std::uint32_t kVersion = 2, kHeaders_bytes = 12 + 8 + 8;
  document = "glTF";
  Append(document, kVersion);
  Append(document, static_cast<std::uint32_t>(kHeaders_bytes + json.size() + binary.size()));
  Append(document, static_cast<std::uint32_t>(json.size()));
  document += "JSON" + json;
  Append(document, static_cast<std::uint32_t>(binary.size()));
  return document + std::string("BIN\0", 4) + binary;
}

// 2. The functions come from xrGetInstanceProcAddr.
struct Functions {
  PFN_xrCreateHapticSceneOMNIX1 create = nullptr;
  PFN_xrGetHapticSceneStateOMNIX1 get_state = nullptr;
  PFN_xrGetHapticSceneDiagnosticsOMNIX1 get_diagnostics = nullptr;
  PFN_xrEnumerateHapticSceneNodesOMNIX1 enumerate_nodes = nullptr;
  PFN_xrUpdateHapticNodesOMNIX1 update_nodes = nullptr;
  PFN_xrGetHapticMaterialOMNIX1 get_material = nullptr;
  PFN_xrSetHapticMaterialOMNIX1 set_material = nullptr;
  PFN_xrEnumerateHapticContactsOMNIX1 enumerate_contacts = nullptr;
};

template <class Function>
bool Load(XrInstance instance, const char* name, Function& function) {
  PFN_xrVoidFunction found = nullptr;
  if (!Ok(xrGetInstanceProcAddr(instance, name, &found), name)) return false;
  function = reinterpret_cast<Function>(found);
  return true;
}

bool LoadFunctions(XrInstance instance, Functions& xr) {
  return Load(instance, "xrCreateHapticSceneOMNIX1", xr.create) &&
         Load(instance, "xrGetHapticSceneStateOMNIX1", xr.get_state) &&
         Load(instance, "xrGetHapticSceneDiagnosticsOMNIX1", xr.get_diagnostics) &&
         Load(instance, "xrEnumerateHapticSceneNodesOMNIX1", xr.enumerate_nodes) &&
         Load(instance, "xrUpdateHapticNodesOMNIX1", xr.update_nodes) &&
         Load(instance, "xrGetHapticMaterialOMNIX1", xr.get_material) &&
         Load(instance, "xrSetHapticMaterialOMNIX1", xr.set_material) &&
         Load(instance, "xrEnumerateHapticContactsOMNIX1", xr.enumerate_contacts);
}

// What an application knows while it runs.
struct Scene {
  Functions xr;
  XrSpace local = XR_NULL_HANDLE;
  XrHapticSceneOMNIX1 handle = XR_NULL_HANDLE;  // destroyed with its session
  XrHapticSceneNodeOMNIX1 block{};
  int part = -1;
  long frames = 0;
  long touched = 0;
  float largest_N = 0;
};

// 3. The scene. The call copies the document and returns; READY or FAILED comes later. Without a placement the
// document's origin is the centre of the base; xrSetHapticScenePlacementOMNIX1 puts it where the application draws it.
bool CreateScene(XrSession session, Scene& scene) {
  const std::string document = Document();
  const XrHapticSceneCreateInfoOMNIX1 info{XR_TYPE_HAPTIC_SCENE_CREATE_INFO_OMNIX1, nullptr,
                                           XR_HAPTIC_SCENE_CREATE_ALL_KINEMATIC_BIT_OMNIX1,  // the block will move
                                           static_cast<std::uint32_t>(document.size()),
                                           reinterpret_cast<const std::uint8_t*>(document.data())};
  return Ok(scene.xr.create(session, &info, &scene.handle), "xrCreateHapticSceneOMNIX1");
}

// 4. Is it ready? An application can also wait for XrEventDataHapticSceneStateChangedOMNIX1. While there is no omnid
// the scene stays LOADING, and it is loaded again by itself when omnid comes back.
XrHapticSceneStatusOMNIX1 StatusOf(const Scene& scene) {
  XrHapticSceneStateOMNIX1 state{};
  state.type = XR_TYPE_HAPTIC_SCENE_STATE_OMNIX1;
  const bool known = Ok(scene.xr.get_state(scene.handle, &state), "xrGetHapticSceneStateOMNIX1");
  return known ? state.status : XR_HAPTIC_SCENE_STATUS_FAILED_OMNIX1;
}

// Why it is not ready, in words.
std::string Diagnostics(const Scene& scene) {
  std::uint32_t count = 0;
  if (XR_FAILED(scene.xr.get_diagnostics(scene.handle, 0, &count, nullptr))) return {};
  std::vector<char> text(count + 1, '\0');
  if (XR_FAILED(scene.xr.get_diagnostics(scene.handle, count, &count, text.data()))) return {};
  std::string lines = text.data();
  while (!lines.empty() && lines.back() == '\n') lines.pop_back();
  return lines;
}

// 5. What can be touched. Ids and indices stay the same as long as the scene exists.
bool FindBlock(Scene& scene) {
  std::uint32_t count = 0;
  if (!Ok(scene.xr.enumerate_nodes(scene.handle, 0, &count, nullptr), "xrEnumerateHapticSceneNodesOMNIX1"))
    return false;
  XrHapticSceneNodeOMNIX1 empty{};
  empty.type = XR_TYPE_HAPTIC_SCENE_NODE_OMNIX1;
  std::vector<XrHapticSceneNodeOMNIX1> nodes(count, empty);
  if (!Ok(scene.xr.enumerate_nodes(scene.handle, count, &count, nodes.data()), "xrEnumerateHapticSceneNodesOMNIX1"))
    return false;
  for (const XrHapticSceneNodeOMNIX1& node : nodes)
    if ((node.flags & XR_HAPTIC_NODE_KINEMATIC_BIT_OMNIX1) != 0) scene.block = node;
  return scene.block.node != XR_NULL_HAPTIC_NODE_ID_OMNIX1;
}

// 6. How it feels can be changed at any time; the device blends, so that the hand feels no jolt.
struct Part {
  const char* name;
  float stiffness, friction, texture_m;
};
constexpr Part kParts[] = {{"rubber", 150, 1.2f, 0}, {"ice", 400, 0.02f, 0}, {"ribs", 300, 0.3f, 0.0003f}};

void SetMaterial(const Scene& scene, const Part& part) {
  constexpr float kRibs_m = 0.002f;  // from one to the next
  XrHapticMaterialOMNIX1 material{};
  material.type = XR_TYPE_HAPTIC_MATERIAL_OMNIX1;
  const std::uint32_t index = scene.block.materialIndex;
  if (!Ok(scene.xr.get_material(scene.handle, index, &material), "xrGetHapticMaterialOMNIX1")) return;
  material.stiffness = part.stiffness;
  material.staticFriction = part.friction;
  material.dynamicFriction = 0.8f * part.friction;
  material.textureAmplitude = part.texture_m;
  material.textureWavelength = kRibs_m;
  Ok(scene.xr.set_material(scene.handle, index, &material), "xrSetHapticMaterialOMNIX1");
}

// 7. Where it is, every frame, with the velocity: the device continues the motion between the frames. In the scene's
// frame (XR_NULL_HANDLE); restPose is where the document has it.
void Move(const Scene& scene, double time_s, XrTime time) {
  constexpr double kStroke_m = 0.004, kTurn_rad_s = 2 * 3.14159265 * 0.25;
  XrHapticNodePoseOMNIX1 pose{};
  pose.node = scene.block.node;
  pose.pose = scene.block.restPose;
  pose.pose.position.y += static_cast<float>(kStroke_m * std::sin(kTurn_rad_s * time_s));
  pose.linearVelocity.y = static_cast<float>(kStroke_m * kTurn_rad_s * std::cos(kTurn_rad_s * time_s));
  const XrHapticNodesUpdateInfoOMNIX1 info{
      XR_TYPE_HAPTIC_NODES_UPDATE_INFO_OMNIX1, nullptr, XR_NULL_HANDLE, time, 1, &pose};
  Ok(scene.xr.update_nodes(scene.handle, &info), "xrUpdateHapticNodesOMNIX1");
}

// 8. What the pen touches, in any space: for sound, sparks or paint.
void ReadContacts(Scene& scene, XrTime time) {
  constexpr std::uint32_t kMost = 4;
  XrHapticContactOMNIX1 empty{};
  empty.type = XR_TYPE_HAPTIC_CONTACT_OMNIX1;
  std::vector<XrHapticContactOMNIX1> contacts(kMost, empty);
  const XrHapticContactsGetInfoOMNIX1 info{XR_TYPE_HAPTIC_CONTACTS_GET_INFO_OMNIX1, nullptr, scene.local, time};
  std::uint32_t count = 0;
  if (XR_FAILED(scene.xr.enumerate_contacts(scene.handle, &info, kMost, &count, contacts.data())) || count == 0) return;
  const XrHapticContactOMNIX1& contact = contacts[0];
  ++scene.touched;
  scene.largest_N = std::fmax(scene.largest_N, contact.normalForce);
  if (scene.frames % 22 != 0) return;
  std::printf("touched at (%.3f, %.3f, %.3f) m, %.2f N into the surface, %.2f N along it\n", contact.point.x,
              contact.point.y, contact.point.z, contact.normalForce, contact.tangentialForce);
}

void Frame(Scene& scene, double time_s, const Options& options, XrTime time) {
  ++scene.frames;
  const int part = time_s < options.seconds / 3 ? 0 : time_s < 2 * options.seconds / 3 ? 1 : 2;
  if (part != scene.part) {
    scene.part = part;
    std::printf("now: %s\n", kParts[part].name);
    SetMaterial(scene, kParts[part]);
  }
  Move(scene, time_s, time);
  ReadContacts(scene, time);
}

// Frame after frame, from the first in which the scene is ready. Returns what went wrong, or nothing.
std::string Loop(Session& session, const Options& options, Scene& scene) {
  XrTime start = 0, opened = 0;
  bool leaving = false;
  while (!session.over()) {
    session.PollEvents(nullptr, nullptr);
    const XrTime time = session.NextFrame();
    if (time == 0 || leaving) continue;
    if (opened == 0) opened = time;
    const XrHapticSceneStatusOMNIX1 status = StatusOf(scene);
    if (status == XR_HAPTIC_SCENE_STATUS_FAILED_OMNIX1) return "the scene is refused: " + Diagnostics(scene);
    const bool ready = status == XR_HAPTIC_SCENE_STATUS_READY_OMNIX1;
    if (ready && start == 0) {
      if (!FindBlock(scene)) return "the scene has no block that can be moved";
      start = time;
    }
    const double waited_s = start == 0 ? 1e-9 * static_cast<double>(time - opened) : 0;
    if (waited_s >= 2 * options.seconds) return "the scene was not loaded: " + Diagnostics(scene);
    const double time_s = start == 0 ? 0 : 1e-9 * static_cast<double>(time - start);
    if (time_s >= options.seconds) {
      leaving = Ok(xrRequestExitSession(session.handle()), "xrRequestExitSession");  // STOPPING comes as an event
      if (!leaving) break;
    } else if (ready) {
      Frame(scene, time_s, options, time);
    }
  }
  std::printf("frames %ld, touched %ld, largest force %.2f N\n", scene.frames, scene.touched, scene.largest_N);
  return scene.frames > 0 ? std::string() : "the runtime ended the session before the scene was loaded";
}

int Fail(const std::string& problem) {
  if (!problem.empty()) std::fprintf(stderr, "omni_block: %s\n", problem.c_str());
  return 1;
}

int Run(const Options& options) {
  const std::vector<std::string> offered = example::AvailableExtensions();
  std::string problem;
  std::vector<const char*> names = Session::Extensions(offered, &problem);
  if (names.empty()) return Fail(problem);
  const std::vector<const char*> for_session = names;
  if (!example::Contains(offered, XR_OMNIX1_HAPTIC_SCENE_EXTENSION_NAME))
    return Fail("no layer offers XR_OMNIX1_haptic_scene: is XR_APILAYER_OMNI_stylus enabled? (omni doctor)");
  names.push_back(XR_OMNIX1_FORCE_FEEDBACK_EXTENSION_NAME);  // haptic_scene needs it
  names.push_back(XR_OMNIX1_HAPTIC_SCENE_EXTENSION_NAME);
  const example::Instance instance{example::CreateInstance(options.name, names, &problem)};
  Scene scene;
  if (instance.handle == XR_NULL_HANDLE) return Fail(problem);
  if (!LoadFunctions(instance.handle, scene.xr)) return 1;
  Session session(instance.handle, for_session);
  if (session.handle() == XR_NULL_HANDLE) return Fail(session.problem());
  const XrReferenceSpaceCreateInfo local{
      XR_TYPE_REFERENCE_SPACE_CREATE_INFO, nullptr, XR_REFERENCE_SPACE_TYPE_LOCAL, {{0, 0, 0, 1}, {0, 0, 0}}};
  if (!Ok(xrCreateReferenceSpace(session.handle(), &local, &scene.local), "xrCreateReferenceSpace")) return 1;
  if (!CreateScene(session.handle(), scene)) return 1;
  problem = Loop(session, options, scene);
  return problem.empty() ? 0 : Fail(problem);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  options.name = "omni_block";
  options.seconds = 9;  // three parts
  if (const auto ended = example::ParseArguments(argc, argv, options)) return *ended;
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  return Run(options);
}
