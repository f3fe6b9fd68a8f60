// The field of mains: a tone of 50 or 60 Hz and its third harmonic, the same at all sensors. Learnt from the scans'
// evidence of the ambient field. docs/theory/tracking.md (9.9), (9.10)
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "service/tracker/room/drift.h"

namespace omni::tracker {

struct MainsOptions {
  bool enabled = true;
  std::array<double, 2> candidates_Hz{50, 60};
  // Evidence of a tone is forgotten over the first of these, over up to the second if it is weaker than the third: far
  // from the base noise would dominate.
  double memory_s = 0.5, memory_max_s = 1, strong_chi2 = 120;
  double apart_min_s = 3e-3, apart_max_s = 2e-2;  // spacing of two scans whose difference is evaluated
  double jump_T = 1.5e-5;                         // a larger difference between these: something else happened
  double heard_min_s = 0.1;                       // before a tone is accepted
  // A tone is subtracted above the first and no longer below the second: values of x^T I x, whose mean is 6 without a
  // tone.
  double believed_chi2 = 30, gone_chi2 = 15;
  double listen_s = 0.25, pull = 0.2, pull_max_Hz = 0.5;  // how often, by which share and how far it is tuned
};

inline constexpr std::size_t kToneStates = 6;  // a, b of a cos(phase) + b sin(phase); T, frame B

struct Tone {
  using States = std::array<double, kToneStates>;

  double frequency_Hz = 0, phase_rad = 0;  // of the last scan
  bool believed = false;
  std::array<double, kToneStates * kToneStates> information_1_T2{};
  States gradient_1_T{};
  States mean_T{};
  double chi2 = 0;
  double heard_s = 0;
  std::array<double, 3> held_T{};  // subtracted from the previous scan
};

struct Mains {
  bool started = false;
  bool found = false;  // the tones are the first and third harmonic; before that, the candidates
  std::int64_t t_ns = 0;
  double candidate_Hz = 0, listened_s = 0;  // of what was found; since it was tuned
  Tone::States heard_T{};                   // the first harmonic's mean, when it was tuned
  std::array<Tone, 2> tones;
  // The previous scan: its time, its evidence, and the ambient field that it refers to.
  std::int64_t before_t_ns = 0;
  AmbientEvidence before;
  std::array<double, 3> before_ambient_T{};
};
static_assert(std::is_trivially_copyable_v<Mains>);

// Turns the phases to the scan's time and forgets.
void AdvanceMains(const MainsOptions& options, std::int64_t t_ns, Mains& mains) noexcept;

// After a scan at the phases' time: its evidence of the ambient field, relative to ambient_T and the accepted tones.
// age_s: of its samples, the mean.
void LearnMains(const MainsOptions& options, const AmbientEvidence& evidence, const std::array<double, 3>& ambient_T,
                double age_s, Mains& mains) noexcept;

// At the phases' time.
AmbientChange FieldOfMains(const Mains& mains) noexcept;

}  // namespace omni::tracker
