#include "service/tracker/solve/pair_start.h"

#include <algorithm>
#include <cmath>

#include "service/base/eigen.h"

namespace omni::tracker {
namespace {

using Step = PairStart::Step;

PairStart::Place ToPlace(const Pose& pose) noexcept {
  return {base::FromEigen(pose.position_base_m), base::FromEigen(pose.axis_base)};
}

Pose ToPose(const PairStart::Place& place) noexcept {
  return {base::ToEigen(place.position_base_m), base::ToEigen(place.axis_base)};
}

// The next start, or none.
void NextStart(PairStart& pair) noexcept {
  pair.step = Step::kNone;
  if (++pair.start >= pair.starts) return;
  pair.pen = pair.places[static_cast<std::size_t>(pair.start)];
  pair.step = Step::kPen;
  pair.round = 0;
  pair.magnet = {};
}

// False: no pose is near.
bool FitPen(const PairOptions& options, const Model& model, const Measurement& measurement, PairStart& pair) noexcept {
  const Fit fit =
      SolvePose(model, measurement, ToPose(pair.pen),
                {.precision = Precision::kFloat, .iterations_max = options.iterations_max, .damping = kColdDamping});
  pair.pen = ToPlace(fit.pose);
  pair.chi2 = fit.chi2;
  return fit.pose.position_base_m.allFinite() && std::isfinite(fit.chi2);
}

// The scan's evidence of a magnet, the pen eliminated where it is now.
bool Say(const DipoleOptions& of_magnet, const PairOptions& options, const Model& model, const DriftState& drift,
         PairStart& pair) noexcept {
  StrayScan scan;
  if (!MakeStrayScan(model, drift, pair.measurement, ToPose(pair.pen), {}, nullptr, scan)) return false;
  StrayEvidence said;
  AddScan(scan, {}, {}, said);
  StartSearch(of_magnet, said, pair.round == 0 ? 0 : options.turn_steps, pair.magnet);
  return true;
}

// The scan without the magnet's field.
Measurement Without(const ReadingLanes& field_T, const Measurement& measurement) noexcept {
  Measurement without = measurement;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < kSensors; ++i) {
      without.whitened[axis][i] -= measurement.inverse_sigma[axis][i] * field_T[kSensors * axis + i];
    }
  }
  return without;
}

}  // namespace

void BeginPair(const Model& model, const Measurement& measurement, PairStart& pair) noexcept {
  pair.measurement = measurement;
  const ColdCandidates candidates = RankGrid(model, measurement, PairStart::kStarts);
  pair.starts = std::min(candidates.count, PairStart::kStarts);
  for (std::size_t k = 0; k < static_cast<std::size_t>(pair.starts); ++k) {
    pair.places[k] = ToPlace(candidates.poses[k]);
  }
  pair.start = -1;
  NextStart(pair);
}

bool SeekPair(const PairOptions& options, const DipoleOptions& of_magnet, const Model& model, const DriftState& drift,
              PairStart& pair) noexcept {
  switch (pair.step) {
    case Step::kNone:
      break;
    case Step::kPen:
      if (!FitPen(options, model, pair.measurement, pair)) {
        NextStart(pair);
        break;
      }
      pair.step = Step::kSaid;
      break;
    case Step::kSaid:
      if (!Say(of_magnet, options, model, drift, pair)) {
        NextStart(pair);
        break;
      }
      pair.step = Step::kMagnet;
      break;
    case Step::kMagnet:
      SearchDipole(of_magnet, model, pair.magnet);
      if (IsSearching(pair.magnet)) break;
      pair.step = Step::kPenAgain;
      if (pair.magnet.parameters == DipoleNumbers{}) NextStart(pair);  // no magnet explains anything
      break;
    case Step::kPenAgain: {
      const double before = pair.chi2;
      const ReadingLanes field_T = FieldOfDipole(model, pair.magnet);
      const bool fits = FitPen(options, model, Without(field_T, pair.measurement), pair);
      if (fits && pair.chi2 <= options.chi2_max && FindDipole(of_magnet, model, pair.magnet)) {
        pair.step = Step::kNone;
        return true;
      }
      pair.step = Step::kSaid;
      const bool worth = fits && (pair.round == 0 || pair.chi2 < options.worth * before);
      if (++pair.round >= options.rounds || !worth) NextStart(pair);
      break;
    }
  }
  return false;
}

}  // namespace omni::tracker
