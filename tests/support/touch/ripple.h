// Judges a texture by the force that coils really deliver: resampled by place, so that neither the stroke's speed nor
// the renderer's own phase counts.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

namespace omni::test {

// Force over place along one stroke, in the order of time.
struct StrokeForce {
  std::vector<double> place_m, force_N;
};

// At `count` places from `first_m` in steps of `step_m`, by linear interpolation at the stroke's first arrival there.
inline std::vector<double> ForceByPlace(const StrokeForce& stroke, double first_m, double step_m, std::size_t count) {
  std::vector<std::pair<double, double>> points;  // ascending in place: what goes back for a moment is left out
  const bool up = stroke.place_m.back() > stroke.place_m.front();
  for (std::size_t i = 0; i < stroke.place_m.size(); ++i) {
    const double at = up ? stroke.place_m[i] : -stroke.place_m[i];
    if (points.empty() || at > points.back().first) points.push_back({at, stroke.force_N[i]});
  }
  if (!up) {
    for (auto& point : points) point.first = -point.first;
    std::reverse(points.begin(), points.end());
  }
  std::vector<double> force_N(count);
  for (std::size_t k = 0; k < count; ++k) {
    const double at = first_m + step_m * static_cast<double>(k);
    auto next = std::lower_bound(points.begin(), points.end(), at, [](auto& p, double x) { return p.first < x; });
    next = std::clamp(next, points.begin() + 1, points.end() - 1);
    const auto last = next - 1;
    const double share = std::clamp((at - last->first) / (next->first - last->first), 0.0, 1.0);
    force_N[k] = (1 - share) * last->second + share * next->second;
  }
  return force_N;
}

inline constexpr int kPerWave = 32;  // places in a wavelength

// Without what varies over more than two wavelengths.
inline std::vector<double> WithoutWander(const std::vector<double>& force_N) {
  const int half = kPerWave, n = static_cast<int>(force_N.size());
  std::vector<double> ripple_N(force_N.size());
  for (int k = 0; k < n; ++k) {
    const int reach = std::min({half, k, n - 1 - k});
    double sum = 0;
    for (int j = k - reach; j <= k + reach; ++j) sum += force_N[static_cast<std::size_t>(j)];
    ripple_N[static_cast<std::size_t>(k)] = force_N[static_cast<std::size_t>(k)] - sum / (2 * reach + 1);
  }
  return {ripple_N.begin() + half, ripple_N.end() - half};
}

inline double Rms(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v * v;
  return values.empty() ? 0 : std::sqrt(sum / static_cast<double>(values.size()));
}

inline double Correlation(const std::vector<double>& a, const std::vector<double>& b) {
  double ab = 0, aa = 0, bb = 0, ma = 0, mb = 0;
  const auto n = static_cast<double>(a.size());
  for (std::size_t k = 0; k < a.size(); ++k) ma += a[k] / n, mb += b[k] / n;
  for (std::size_t k = 0; k < a.size(); ++k) {
    ab += (a[k] - ma) * (b[k] - mb);
    aa += (a[k] - ma) * (a[k] - ma);
    bb += (b[k] - mb) * (b[k] - mb);
  }
  return aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : 0;
}

// Share of the power, from a quarter to four times the nominal spatial frequency, that lies within 15 % of it.
inline double ShareInBand(const std::vector<double>& ripple_N) {
  const auto n = static_cast<double>(ripple_N.size());
  double all = 0, near = 0;
  for (double f = 0.25; f <= 4; f += 0.02) {  // waves per wavelength
    double re = 0, im = 0;
    for (std::size_t k = 0; k < ripple_N.size(); ++k) {
      const double window = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * (static_cast<double>(k) + 0.5) / n);
      const double turn = 2 * std::numbers::pi * f * static_cast<double>(k) / kPerWave;
      re += window * ripple_N[k] * std::cos(turn);
      im += window * ripple_N[k] * std::sin(turn);
    }
    const double power = re * re + im * im;
    all += power;
    if (std::abs(f - 1) <= 0.15) near += power;
  }
  return all > 0 ? near / all : 0;
}

}  // namespace omni::test
