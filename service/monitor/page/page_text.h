// Text messages to the page, JSON: docs/protocol/page.md. Text of other programs and files is cut and made valid UTF-8.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "service/base/device_geometry.h"
#include "service/base/files/json_document.h"
#include "service/monitor/view/scene_view.h"

namespace omni::monitor {

// Of omnid's status.
inline constexpr base::JsonLimits kStatusLimits{.bytes = 1 << 16, .values = 20'000, .members = 1'000, .depth = 16};

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

// `status`: of omnid; empty: none. `why`: there is no connection, and what to do. `strokes`: of sculpted objects; -1:
// nothing is sculpted.
std::string StatusText(bool connected, const std::string& why, const std::string& status, int strokes);

// Strokes in omnid's answer to SceneAction::kEdits; -1: there are none to count.
int StrokesOf(const std::string& edits);

enum class SceneState : std::uint8_t { kNone, kLoading, kReady, kFailed };
// `view`: null: no shapes. `text`: failed: why; ready: notes.
std::string SceneText(std::uint32_t number, const std::string& name, SceneState state, const std::string& text,
                      bool own, const SceneView* view, std::span<const ViewMaterial> materials);

enum class NoticeLevel : std::uint8_t { kInfo, kWarning, kError };
std::string NoticeText(NoticeLevel level, std::string_view text);
std::string AnswerText(std::uint32_t number, bool done, std::string_view text);

}  // namespace omni::monitor
