// An application with a haptic scene, and a service that answers for it as the test says.
#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <string>

#include "tests/layer/app.h"
#include "tests/layer/scene_functions.h"

namespace omni::test {

inline const AppOptions kWithScene{.extensions = kSceneExtensions};

inline constexpr const char* kDocument = "a document, as far as this service cares";

class SceneStory {
 public:
  explicit SceneStory(bool with_service = true) {
    if (with_service) service = std::make_unique<FakeService>();
    app = std::make_unique<App>(kWithScene);
    f = std::make_unique<SceneFunctions>(app->instance);
  }

  XrResult Create(const std::string& document = kDocument) {
    XrHapticSceneCreateInfoOMNIX1 info{XR_TYPE_HAPTIC_SCENE_CREATE_INFO_OMNIX1};
    info.bufferByteCount = static_cast<std::uint32_t>(document.size());
    info.buffer = reinterpret_cast<const std::uint8_t*>(document.data());
    return f->create(app->session, &info, &scene);
  }

  XrHapticSceneStateOMNIX1 State() const {
    XrHapticSceneStateOMNIX1 state{XR_TYPE_HAPTIC_SCENE_STATE_OMNIX1};
    EXPECT_EQ(f->state(scene, &state), XR_SUCCESS);
    return state;
  }

  std::string Diagnostics() const {
    std::uint32_t count = 0;
    EXPECT_EQ(f->diagnostics(scene, 0, &count, nullptr), XR_SUCCESS);
    std::string text(count, '\0');
    EXPECT_EQ(f->diagnostics(scene, count, &count, text.data()), XR_SUCCESS);
    text.resize(std::strlen(text.c_str()));
    return text;
  }

  // Until `done`; the service answers within its period of 10 ms. False: it never was.
  template <class Done>
  bool Until(Done done) {
    return Eventually([&] {
      if (service) service->Fill();
      app->Poll();
      return done();
    });
  }

  // Two nodes: 0 stays where it is, 1 can be moved and is 0.1 m to the right and 0.3 m up in the document.
  void SayTable(std::uint32_t number) {
    protocol::HapticSceneTable table;
    table.number = number;
    table.node_count = 2;
    table.material_count = 1;
    protocol::HapticNodeRow rows[2];
    std::strcpy(rows[0].name, "still");
    rows[0].gltf_node = 4;
    rows[0].flags = protocol::kNodeSoft;
    std::strcpy(rows[1].name, "moved");
    rows[1].gltf_node = 2;
    rows[1].flags = protocol::kNodeKinematic;
    rows[1].rest_position_m = {0.1, 0.3, 0};
    protocol::HapticFeel feel;
    feel.stiffness_N_m = 444;
    table.header.size = sizeof(table) + sizeof(rows) + sizeof(feel);
    std::string message(reinterpret_cast<const char*>(&table), sizeof(table));
    message.append(reinterpret_cast<const char*>(rows), sizeof(rows));
    message.append(reinterpret_cast<const char*>(&feel), sizeof(feel));
    service->Say(message);
  }
  void SayState(std::uint32_t number, protocol::HapticSceneStatus status, std::uint64_t generation,
                const std::string& text, double scale = 1) {
    protocol::HapticSceneState state;
    state.number = number;
    state.status = status;
    state.generation = generation;
    state.scale = scale;
    state.load_ns = 5'000'000;
    state.triangle_count = 12;
    state.material_count = 1;
    state.header.size = static_cast<std::uint32_t>(sizeof(state) + text.size());
    std::string message(reinterpret_cast<const char*>(&state), sizeof(state));
    service->Say(message + text);
  }
  bool GetReady() {
    if (Create() != XR_SUCCESS) return false;
    if (!Until([&] { return !service->heard().scene_loads.empty(); })) return false;
    const std::uint32_t number = service->heard().scene_loads.back().number;
    SayTable(number);
    SayState(number, protocol::HapticSceneStatus::kReady, 9, "a warning");
    return Until([&] { return State().status == XR_HAPTIC_SCENE_STATUS_READY_OMNIX1; });
  }

  std::unique_ptr<FakeService> service;
  std::unique_ptr<App> app;
  std::unique_ptr<SceneFunctions> f;
  XrHapticSceneOMNIX1 scene = XR_NULL_HANDLE;
};

}  // namespace omni::test
