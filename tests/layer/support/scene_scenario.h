// An application with a haptic scene, and a service that answers as the test says.
#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <memory>
#include <string>

#include "tests/layer/support/app.h"
#include "tests/layer/support/scene_functions.h"
#include "tests/layer/support/scene_messages.h"

namespace omni::test {

inline const AppOptions kWithScene{.extensions = kSceneExtensions};

inline constexpr const char* kDocument = "a document, as far as this service cares";

class SceneScenario {
 public:
  explicit SceneScenario(bool with_service = true) {
    omni_test_reset();
    if (with_service) service = std::make_unique<FakeService>();
    app = std::make_unique<App>(kWithScene);
    f = std::make_unique<SceneFunctions>(app->instance);
  }

  ~SceneScenario() { omni_test_reset(); }

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

  // Until `done`; the service answers within its period of 10 ms. False: timed out.
  template <class Done>
  bool Until(Done done) {
    return Eventually([&] {
      if (service) service->Fill();
      app->Poll();
      return done();
    });
  }

  void SayTable(std::uint32_t number) { service->Say(SceneTableMessage(number, TwoNodes())); }
  void SayState(std::uint32_t number, protocol::HapticSceneStatus status, std::uint64_t generation,
                const std::string& text, double scale = 1) {
    service->Say(SceneStateMessage(number, status, generation, text, scale));
  }
  // The number by which the service knows the newest scene; waits for it. 0: timed out.
  std::uint32_t Number(std::size_t loads = 1) {
    if (!Until([&] { return service->heard().scene_loads.size() >= loads; })) return 0;
    return service->heard().scene_loads.back().number;
  }
  bool GetReady(const SceneTable& table = TwoNodes()) {
    if (Create() != XR_SUCCESS) return false;
    const std::uint32_t number = Number();
    if (number == 0) return false;
    service->Say(SceneTableMessage(number, table));
    SayState(number, protocol::HapticSceneStatus::kReady, 9, "a warning");
    return Until([&] { return State().status == XR_HAPTIC_SCENE_STATUS_READY_OMNIX1; });
  }

  std::unique_ptr<FakeService> service;
  std::unique_ptr<App> app;
  std::unique_ptr<SceneFunctions> f;
  XrHapticSceneOMNIX1 scene = XR_NULL_HANDLE;
};

}  // namespace omni::test
