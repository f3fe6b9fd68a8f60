// Gestures of a passive pen, found in the tick from force, motion of the tip, contact and time.
// Each is a source of inputs.h; what an application uses it for is not known here.
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "service/base/input_mapping.h"
#include "service/base/vec.h"

namespace omni::loop {

struct GestureInput {
  std::int64_t t_ns = 0;      // of the Hall sample
  bool tracked = false;       // the tip's place is known
  bool live = false;          // and forces may be rendered
  base::Vec3 tip_base_m;      // device point
  base::Vec3 axis_base;       // unit, out of the tip
  double force_N = 0;         // requested normal force on the tip, finite
  double steady_force_N = 0;  // the same, smoothed: what presses
  base::Vec3 normal_base;     // of the deepest contact, unit, out of the object; zero: none
};

inline constexpr std::uint32_t kTipTrail = 32;  // ticks; a full trail forgets its oldest

// Where the tip was.
struct TipTrail {
  std::array<base::Vec3, kTipTrail> tip_base_m{};
  std::array<std::int64_t, kTipTrail> t_ns{};
  std::uint32_t next = 0;
  std::uint32_t count = 0;
};

struct TouchState {
  bool touching = false;
  double force_N = 0;  // lightly smoothed
  double peak_N = 0;
  double travel_m = 0;  // largest, along the surface from where it began
  bool may_be_tap = false;
  std::int64_t t_begin_ns = 0, t_end_ns = 0;
  base::Vec3 begin_base_m, normal_base;
};

struct TapState {
  bool has_first = false;  // a tap that a second one may follow
  std::int64_t t_first_ns = 0;
  base::Vec3 first_base_m;
};

struct DwellState {
  bool on = false;
  bool touching = false;  // which of the two dwells
  base::Vec3 place_base_m;
  std::int64_t t_since_ns = 0;
};

enum class FlickPhase : std::uint8_t { kIdle = 0, kOut = 1, kRest = 2 };

struct FlickState {
  FlickPhase phase = FlickPhase::kIdle;
  std::int64_t t_ns = 0;  // when the phase began
  base::Vec3 direction_base;
  double peak_m_s = 0;
};

struct AwayState {
  bool started = false;
  bool on = false;
  std::int64_t t_near_ns = 0;   // last seen within reach
  std::int64_t t_still_ns = 0;  // lies within away_still_m of `place` since
  base::Vec3 place_base_m;
};

struct GestureState {
  std::int64_t t_ns = 0;
  TipTrail trail;
  TouchState touch;
  TapState tap;
  DwellState dwell;
  FlickState flick;
  AwayState away;
  bool detent = false;
  std::array<std::int64_t, base::kSourceCount> click_end_ns{};  // of sources that are on for click_s
};
static_assert(std::is_trivially_copyable_v<GestureState>);

// Advances all gestures by one tick. Returns the bits of those that are on. Not live: none but kAway. noexcept, no
// allocation; stamps that are repeated or go back change nothing.
base::SourceMask UpdateGestures(const base::InputThresholds& thresholds, const GestureInput& input,
                                GestureState& state) noexcept;

}  // namespace omni::loop
