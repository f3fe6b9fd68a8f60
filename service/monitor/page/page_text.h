// Text messages to the page, JSON: docs/protocol/page.md. Text of other programs and files is cut and made valid UTF-8.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "service/base/device_geometry.h"
#include "service/monitor/view/scene_view.h"

namespace omni::monitor {

struct SceneChoice {
  std::string name, title, about;
};

// The first message to a page.
struct PageHello {
  std::string version;   // of Omni
  bool control = false;  // pages may change something
  bool hand = false;     // and lead the simulated hand
  std::vector<SceneChoice> scenes;
  std::uint64_t max_file_bytes = 0;
  std::vector<std::string> environment;  // lines for a shell
  base::DeviceGeometry device;
};
std::string HelloText(const PageHello& hello);

// `status`: of omnid; null: none. `why`: there is no connection, and what to do. `strokes`: of sculpted objects; -1:
// nothing is sculpted.
std::string StatusText(bool connected, const std::string& why, const nlohmann::json& status, int strokes);

// `steps`: an array, one object per step that sets a base up.
std::string SetupText(const nlohmann::json& steps);

// Strokes in omnid's answer to SceneAction::kEdits; -1: there are none to count.
int StrokesOf(const std::string& edits);

enum class SceneState : std::uint8_t { kNone, kLoading, kReady, kFailed };

// What there is to touch. `number` counts the scenes, `revision` every change of one that pages are sent.
struct ShownScene {
  std::uint32_t number = 0, revision = 0;
  std::string name;
  SceneState state = SceneState::kNone;
  std::string text;                       // failed: why; ready: notes
  std::uint64_t generation = 0;           // of omnid; 0: it does not touch it
  std::shared_ptr<const SceneView> view;  // null: no shapes
  std::vector<ViewMaterial> materials;    // of `view`, as they are now
};
// `own`: loaded by a page, which may change its materials.
std::string SceneText(const ShownScene& scene, bool own);

enum class NoticeLevel : std::uint8_t { kInfo, kWarning, kError };
std::string NoticeText(NoticeLevel level, std::string_view text);
std::string AnswerText(std::uint32_t number, bool done, std::string_view text);

}  // namespace omni::monitor
