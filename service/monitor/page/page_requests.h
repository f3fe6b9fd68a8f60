// What a page may ask for: text messages of docs/protocol/page.md.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>

#include "service/base/material.h"
#include "service/base/result.h"
#include "service/protocol/control.h"

namespace omni::monitor {

inline constexpr std::size_t kMaxRequestBytes = 4096;

struct AimRequest {  // checked as protocol::ReadHandAim does
  std::array<double, 3> tip_base_m{};
  std::array<double, 3> axis_base{0, 0, -1};
};
struct LiftRequest {};
struct SceneRequest {
  std::string name;
};
struct MaterialRequest {
  std::uint32_t index = 0;
  std::array<bool, base::kLiveMaterialFields> given{};  // which of kLiveFields
  base::MaterialParameters values;                      // of those; in range
};
struct EditRequest {
  protocol::SceneAction action = protocol::SceneAction::kUndo;  // kUndo, kRedo, kRelease
};
struct SaveRequest {
  std::uint32_t number = 0;
};
struct StopRequest {
  bool on = true;
};
using PageRequest =
    std::variant<AimRequest, LiftRequest, SceneRequest, MaterialRequest, EditRequest, SaveRequest, StopRequest>;

// The error names the field and its range.
base::Result<PageRequest> ReadPageRequest(std::string_view text);

}  // namespace omni::monitor
