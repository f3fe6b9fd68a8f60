#include "service/tracker/solve/solver.h"

#include <algorithm>

#include "service/base/eigen.h"

namespace omni::tracker {
namespace {

// The scan as the scoring kernel reads it: single precision, the nuisances' best share already subtracted, since hidden
// currents would otherwise leave it no digits.
template <int kCapacity>
class ScoreInput {
 public:
  explicit ScoreInput(const BasicMeasurement<kCapacity>& measurement) noexcept {
    task_.readings = 3 * measurement.sensors;
    task_.nuisances = measurement.nuisances;
    const auto nuisances = static_cast<std::size_t>(measurement.nuisances);
    const auto sensors = static_cast<std::size_t>(measurement.sensors);
    std::array<double, kNuisancesMax> Cty{};
    for (std::size_t n = 0; n < nuisances; ++n) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        for (std::size_t i = 0; i < sensors; ++i) {
          const double c = measurement.nuisance[3 * n + axis][i];
          nuisance_[n][3 * i + axis] = static_cast<float>(c);
          Cty[n] += c * measurement.whitened[axis][i];
        }
      }
      task_.nuisance[n] = nuisance_[n].data();
    }
    std::array<double, kNuisancesMax> share{};
    for (std::size_t a = 0; a < nuisances; ++a) {
      for (std::size_t b = 0; b < nuisances; ++b) {
        const double s = measurement.nuisance_covariance[a * kNuisancesMax + b];
        task_.nuisance_covariance[a * kNuisancesMax + b] = static_cast<float>(s);
        share[a] += s * Cty[b];
      }
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t i = 0; i < sensors; ++i) {
        double y = measurement.whitened[axis][i];
        for (std::size_t n = 0; n < nuisances; ++n) y -= measurement.nuisance[3 * n + axis][i] * share[n];
        whitened_[3 * i + axis] = static_cast<float>(y);
        inverse_sigma_[3 * i + axis] = static_cast<float>(measurement.inverse_sigma[axis][i]);
      }
    }
    task_.whitened = whitened_.data();
    task_.inverse_sigma = inverse_sigma_.data();
  }
  ScoreInput(const ScoreInput&) = delete;
  ScoreInput& operator=(const ScoreInput&) = delete;

  const ScoreTask& task() const noexcept { return task_; }

 private:
  using Readings = std::array<float, std::size_t{3} * kCapacity>;
  Readings inverse_sigma_, whitened_;
  std::array<Readings, kNuisancesMax> nuisance_;
  ScoreTask task_;
};

struct Candidate {
  float explained = 0;
  int place = 0;
  Eigen::Vector3f moment = Eigen::Vector3f::Zero();
};

// The best so far, in order; insertion keeps them sorted and drops the worst.
class BestFew {
 public:
  explicit BestFew(int wanted) noexcept : wanted_(std::clamp(wanted, 1, kColdCandidatesMax)) {}

  void Insert(const Candidate& candidate) noexcept {
    if (!(candidate.explained > 0 && candidate.moment.squaredNorm() > 0)) return;  // NaN included
    if (count_ == wanted_ && !(candidate.explained > few_[last()].explained)) return;
    if (count_ < wanted_) ++count_;
    std::size_t at = last();
    for (; at > 0 && few_[at - 1].explained < candidate.explained; --at) few_[at] = few_[at - 1];
    few_[at] = candidate;
  }
  int count() const noexcept { return count_; }
  const Candidate& operator[](std::size_t i) const noexcept { return few_[i]; }

 private:
  std::size_t last() const noexcept { return static_cast<std::size_t>(count_) - 1; }
  int wanted_;
  int count_ = 0;
  std::array<Candidate, kColdCandidatesMax> few_;
};

}  // namespace

template <int kCapacity>
ColdCandidates RankGrid(const Model& model, const BasicMeasurement<kCapacity>& measurement, int wanted) noexcept {
  const ScoreInput<kCapacity> input(measurement);
  const Kernel& kernel = ActiveKernel();
  const std::size_t group_size = std::size_t{3} * kGridLanes * static_cast<std::size_t>(input.task().readings);
  BestFew best(wanted);
  for (int first = 0; first < model.grid.places; first += kGridLanes) {
    PlaceScores scores;
    kernel.score(model.grid.field_sensor.data() + group_size * static_cast<std::size_t>(first / kGridLanes),
                 input.task(), scores);
    for (int lane = 0; lane < std::min(kGridLanes, model.grid.places - first); ++lane) {
      best.Insert({scores.explained[lane],
                   first + lane,
                   {scores.moment_Am2[0][lane], scores.moment_Am2[1][lane], scores.moment_Am2[2][lane]}});
    }
  }
  ColdCandidates result;
  result.count = best.count();
  for (std::size_t c = 0; c < static_cast<std::size_t>(best.count()); ++c) {
    const base::Vec3& place = model.grid.place_base_m[static_cast<std::size_t>(best[c].place)];
    result.poses[c] = {base::ToEigen(place), best[c].moment.cast<double>().normalized()};
  }
  return result;
}
template ColdCandidates RankGrid(const Model&, const Measurement&, int) noexcept;
template ColdCandidates RankGrid(const Model&, const ArrayMeasurement&, int) noexcept;

}  // namespace omni::tracker
