// A cold start beside another magnet, a second pen say: pen and magnet together, found in one scan that no pose
// explains. One bounded step a scan. docs/theory/tracking.md (14.4)
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "service/tracker/room/stray_dipole.h"
#include "service/tracker/solve/solver.h"

namespace omni::tracker {

struct PairOptions {
  bool enabled = true;
  int rounds = 6;        // from a start: magnet, then pen, in turn
  int turn_steps = 8;    // of the magnet's search after the first round, which looks everywhere
  double chi2_max = 40;  // of the scan, at some 10 degrees of freedom
  double worth = 0.7;    // a round that leaves more than that of chi2 is the start's last
  int iterations_max = 20;
};

struct PairStart {
  enum class Step : std::uint8_t { kNone, kPen, kSaid, kMagnet, kPenAgain };
  static constexpr int kStarts = kColdCandidates;
  struct Place {
    base::Vec3 position_base_m, axis_base;
  };
  Step step = Step::kNone;
  int starts = 0, start = 0, round = 0;
  std::array<Place, kStarts> places;  // of the pen, to start from
  Place pen;
  double chi2 = 0;
  Measurement measurement;  // of the scan
  StrayDipole magnet;
};
static_assert(std::is_trivially_copyable_v<PairStart>);

// measurement: of a scan with an ambient field that may be anything, no stray field subtracted.
void BeginPair(const Model& model, const Measurement& measurement, PairStart& pair) noexcept;

// Precondition: pair.step is not kNone; then it is, when all starts have led nowhere. True: `pair.magnet` and a pen
// explain the scan; its search has ended.
bool SeekPair(const PairOptions& options, const DipoleOptions& of_magnet, const Model& model, const DriftState& drift,
              PairStart& pair) noexcept;

}  // namespace omni::tracker
