#include "service/tracker/room/mains.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "service/base/clock.h"
#include "service/tracker/kernel/cholesky.h"
#include "service/tracker/kernel/matrices.h"

namespace omni::tracker {
namespace {

constexpr double kTurn_rad = 2 * std::numbers::pi;
constexpr double kThird = 3;

void Restart(double frequency_Hz, Tone& tone) noexcept {
  tone = {};
  tone.frequency_Hz = frequency_Hz;
}

void Restart(const MainsOptions& options, Mains& mains) noexcept {
  mains.found = false;
  for (std::size_t k = 0; k < mains.tones.size(); ++k) Restart(options.candidates_Hz[k], mains.tones[k]);
}

// The field and its first two derivatives, if the tone is accepted.
void AddTone(const Tone& tone, double age_s, AmbientChange& change) noexcept {
  if (!tone.believed) return;
  const double rate_rad_s = kTurn_rad * tone.frequency_Hz;
  const double cosine = std::cos(tone.phase_rad - rate_rad_s * age_s);
  const double sine = std::sin(tone.phase_rad - rate_rad_s * age_s);
  const auto mean_T = AsVector(tone.mean_T);
  const Matrix<3, 1> field_T = cosine * mean_T.head<3>() + sine * mean_T.tail<3>();
  AsVector(change.field_T) += field_T;
  AsVector(change.rate_T_s) += rate_rad_s * (cosine * mean_T.tail<3>() - sine * mean_T.head<3>());
  AsVector(change.acceleration_T_s2) -= rate_rad_s * rate_rad_s * field_T;
}

// Difference of two scans' evidence of the ambient field, as information and gradient, with what their offsets
// contained of the tones left out: J = (I + I') / 4,   e = (g - g' + I' (b - b')) / 2
struct Difference {
  std::array<double, 9> information{};
  std::array<double, 3> gradient{};
};
Difference DifferenceOf(const AmbientEvidence& now, const std::array<double, 3>& ambient_T,
                        const AmbientEvidence& before, const std::array<double, 3>& before_T) noexcept {
  Difference difference;
  const auto before_information = AsMatrix<3>(before.information);
  AsMatrix<3>(difference.information) = 0.25 * (AsMatrix<3>(now.information) + before_information);
  AsVector(difference.gradient) = 0.5 * (AsVector(now.gradient) - AsVector(before.gradient) +
                                         before_information * (AsVector(ambient_T) - AsVector(before_T)));
  return difference;
}

bool IsJump(const MainsOptions& options, const Difference& difference) noexcept {
  SmallCholesky<3> factors;
  if (!factors.Factor(difference.information.data(), 3, 0)) return true;
  const auto [x_T, y_T, z_T] = factors.Solve(difference.gradient);
  return !(std::hypot(x_T, y_T, z_T) < options.jump_T);
}

std::array<double, 3> HeldOf(const Tone& tone, double age_s) noexcept {
  AmbientChange held;
  AddTone(tone, age_s, held);
  return held.field_T;
}

// I += H^T J H, g += H^T (e + J (m - m')) with H = [cos - cos', sin - sin'] and m, m' what the offsets contained of
// this tone; x = I^-1 g.
void Learn(const MainsOptions& options, const Difference& difference, double age_s, double apart_s,
           Tone& tone) noexcept {
  const double rate_rad_s = kTurn_rad * tone.frequency_Hz;
  const double phase_rad = tone.phase_rad - rate_rad_s * age_s, before_rad = phase_rad - rate_rad_s * apart_s;
  const Matrix<2, 1> H{std::cos(phase_rad) - std::cos(before_rad), std::sin(phase_rad) - std::sin(before_rad)};
  const std::array<double, 3> held_T = HeldOf(tone, age_s);
  const auto J = AsMatrix<3>(difference.information);
  const Matrix<3, 1> gradient_1_T = AsVector(difference.gradient) + J * (AsVector(held_T) - AsVector(tone.held_T));
  for (int h = 0; h < 2; ++h) {
    AsVector(tone.gradient_1_T).segment<3>(3 * h) += H[h] * gradient_1_T;
    for (int g = 0; g < 2; ++g) {
      AsMatrix<kToneStates>(tone.information_1_T2).block<3, 3>(3 * h, 3 * g) += H[h] * H[g] * J;
    }
  }
  tone.held_T = held_T;
  tone.heard_s += apart_s;
  SmallCholesky<kToneStates> factors;
  if (!factors.Factor(tone.information_1_T2.data(), kToneStates, 0)) return;  // a scan or two do not determine all six
  tone.mean_T = factors.Solve(tone.gradient_1_T);
  tone.chi2 = AsVector(tone.mean_T).dot(AsVector(tone.gradient_1_T));
  tone.believed =
      tone.heard_s >= options.heard_min_s && tone.chi2 > (tone.believed ? options.gone_chi2 : options.believed_chi2);
}

// The stronger candidate is the first harmonic.
void Find(Mains& mains) noexcept {
  const std::size_t best = mains.tones[1].chi2 > mains.tones[0].chi2 ? 1 : 0;
  if (!mains.tones[best].believed) return;
  mains.found = true;
  mains.tones[0] = mains.tones[best];
  mains.candidate_Hz = mains.tones[0].frequency_Hz;
  Restart(kThird * mains.candidate_Hz, mains.tones[1]);
  mains.heard_T = mains.tones[0].mean_T;
  mains.listened_s = 0;
}

// By how much a cos + b sin has turned since the last tuning, mains are faster than assumed.
void Tune(const MainsOptions& options, Mains& mains) noexcept {
  const auto mean_T = AsVector(mains.tones[0].mean_T), heard_T = AsVector(mains.heard_T);
  const double along = heard_T.dot(mean_T);
  const double across = heard_T.tail<3>().dot(mean_T.head<3>()) - heard_T.head<3>().dot(mean_T.tail<3>());
  const double pull_Hz = options.pull * std::atan2(across, along) / (kTurn_rad * mains.listened_s);
  const double tuned_Hz = std::clamp(mains.tones[0].frequency_Hz + pull_Hz, mains.candidate_Hz - options.pull_max_Hz,
                                     mains.candidate_Hz + options.pull_max_Hz);
  mains.tones[0].frequency_Hz = tuned_Hz;
  mains.tones[1].frequency_Hz = kThird * tuned_Hz;
  mains.heard_T = mains.tones[0].mean_T;
  mains.listened_s = 0;
}

double MemoryOf_s(const MainsOptions& options, const Tone& tone) noexcept {
  const double weaker = options.strong_chi2 / std::max(tone.chi2, 1.0);
  return std::clamp(options.memory_s * weaker, options.memory_s, options.memory_max_s);
}

}  // namespace

void AdvanceMains(const MainsOptions& options, std::int64_t t_ns, Mains& mains) noexcept {
  if (!mains.started) {
    Restart(options, mains);
    mains.t_ns = t_ns;
    mains.started = true;
  }
  const double step_s = base::Elapsed_s(t_ns, mains.t_ns);
  mains.t_ns = t_ns;
  if (!(step_s >= 0 && step_s < options.memory_s)) return Restart(options, mains);
  for (Tone& tone : mains.tones) {
    const double keep = std::exp(-step_s / MemoryOf_s(options, tone));
    tone.phase_rad = std::fmod(tone.phase_rad + kTurn_rad * tone.frequency_Hz * step_s, kTurn_rad);
    tone.chi2 *= keep;
    AsVector(tone.information_1_T2) *= keep;
    AsVector(tone.gradient_1_T) *= keep;
  }
  mains.listened_s += step_s;
  if (mains.found && mains.tones[0].chi2 < options.gone_chi2) Restart(options, mains);
}

void LearnMains(const MainsOptions& options, const AmbientEvidence& evidence, const std::array<double, 3>& ambient_T,
                double age_s, Mains& mains) noexcept {
  const bool finite = AsVector(evidence.information).allFinite() && AsVector(evidence.gradient).allFinite();
  if (!mains.started || !finite) return;
  const double apart_s = base::Elapsed_s(mains.t_ns, mains.before_t_ns);
  if (mains.before.valid && apart_s >= 0 && apart_s < options.apart_min_s) return;
  const bool close = mains.before.valid && apart_s >= 0 && apart_s <= options.apart_max_s;
  const Difference difference = DifferenceOf(evidence, ambient_T, mains.before, mains.before_ambient_T);
  mains.before_t_ns = mains.t_ns;
  mains.before = evidence;
  mains.before_ambient_T = ambient_T;
  if (!close || IsJump(options, difference)) {
    for (Tone& tone : mains.tones) tone.held_T = HeldOf(tone, age_s);
    return;
  }
  for (Tone& tone : mains.tones) Learn(options, difference, age_s, apart_s, tone);
  if (!mains.found) {
    Find(mains);
  } else if (mains.listened_s >= options.listen_s) {
    Tune(options, mains);
  }
}

AmbientChange FieldOfMains(const Mains& mains) noexcept {
  AmbientChange change;
  if (!mains.found) return change;
  for (const Tone& tone : mains.tones) AddTone(tone, 0, change);
  return change;
}

}  // namespace omni::tracker
