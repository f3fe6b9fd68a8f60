#include "service/scene/tags/relief_image.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include <unsupported/Eigen/FFT>

#include "service/base/free_memory.h"

namespace omni::scene {
namespace {

using Complex = std::complex<float>;

// Of one number per texel.
struct Grid {
  std::uint32_t width = 0, height = 0;
  std::vector<float> values;

  Grid(std::uint32_t w, std::uint32_t h) : width(w), height(h), values(std::size_t{w} * h) {}
  float& At(std::uint32_t x, std::uint32_t y) { return values[std::size_t{y} * width + x]; }
  float At(std::uint32_t x, std::uint32_t y) const { return values[std::size_t{y} * width + x]; }
};

struct Slopes {
  Grid right, down;  // height, in texels of the image, per texel of the grid
};

constexpr float kLeastZ = 0.1F;    // steeper normals, and those that face inwards, count as this
constexpr float kSteepest = 2.0F;  // 63 degrees

// Means over the image's texels that a texel of the grid covers.
Slopes SlopesOf(const NormalPixels& n, const base::WorkWatch& watch) {
  const auto side = [](std::uint32_t length) { return std::bit_floor(std::min(length, haptics::kMaxReliefSide)); };
  Slopes slopes{Grid(side(n.width), side(n.height)), Grid(side(n.width), side(n.height))};
  const auto first = [](std::uint32_t k, std::uint32_t of, std::uint32_t length) {
    return static_cast<std::uint32_t>(std::uint64_t{k} * length / of);
  };
  const Grid& grid = slopes.right;
  const float across = static_cast<float>(n.width) / static_cast<float>(grid.width);
  const float along = static_cast<float>(n.height) / static_cast<float>(grid.height);
  for (std::uint32_t y = 0; y < grid.height; ++y) {
    for (std::uint32_t x = 0; x < grid.width; ++x) {
      float right = 0, down = 0, count = 0;
      for (std::uint32_t j = first(y, grid.height, n.height); j < first(y + 1, grid.height, n.height); ++j) {
        for (std::uint32_t i = first(x, grid.width, n.width); i < first(x + 1, grid.width, n.width); ++i) {
          const std::uint8_t* p = &n.pixels[(std::size_t{j} * n.width + i) * n.channels];
          const auto component = [&](int k) { return static_cast<float>(p[k]) / 127.5F - 1; };
          const float z = std::max(kLeastZ, component(2));
          right += std::clamp(-component(0) / z, -kSteepest, kSteepest);
          down += std::clamp(component(1) / z, -kSteepest, kSteepest);
          ++count;
        }
      }
      slopes.right.At(x, y) = across * right / count;
      slopes.down.At(x, y) = along * down / count;
      watch.Did();
    }
  }
  return slopes;
}

// Fourier transform of each row, then of each column, in place.
void Transform(std::uint32_t width, std::uint32_t height, bool inverse, std::vector<Complex>& values,
               const base::WorkWatch& watch) {
  Eigen::FFT<float> fft;
  std::vector<Complex> line, out;
  const auto along = [&](std::uint32_t length, std::uint32_t lines, std::size_t step, std::size_t to_next) {
    if (length == 1) return;  // it is its own transform
    line.resize(length);
    out.resize(length);
    for (std::uint32_t k = 0; k < lines; ++k) {
      Complex* first = &values[k * to_next];
      for (std::uint32_t i = 0; i < length; ++i) line[i] = first[i * step];
      inverse ? fft.inv(out, line) : fft.fwd(out, line);
      for (std::uint32_t i = 0; i < length; ++i) first[i * step] = out[i];
      watch.Did(length);
    }
  };
  along(width, height, 1, width);
  along(height, width, width, 1);
}

// The height whose slopes are nearest to these, in the mean square, of a surface that repeats: H = -i (w_x P + w_y Q) /
// (w_x^2 + w_y^2) [Frankot & Chellappa 1988]   (T.3). Both slopes are transformed as one complex field, P + i Q.
Grid HeightOf(const Slopes& slopes, const base::WorkWatch& watch) {
  Grid height(slopes.right.width, slopes.right.height);
  const std::uint32_t w = height.width, h = height.height;
  std::vector<Complex> field(height.values.size());
  for (std::size_t k = 0; k < field.size(); ++k) field[k] = {slopes.right.values[k], slopes.down.values[k]};
  Transform(w, h, false, field, watch);
  // Angular frequency of a row or column; the highest has no direction.
  const auto turn = [](std::uint32_t k, std::uint32_t length) {
    if (2 * k == length) return 0.0F;
    const auto cycles = 2 * k < length ? static_cast<float>(k) : static_cast<float>(k) - static_cast<float>(length);
    return 2 * std::numbers::pi_v<float> * cycles / static_cast<float>(length);
  };
  std::vector<Complex> heights(field.size());
  for (std::uint32_t y = 0; y < h; ++y) {
    for (std::uint32_t x = 0; x < w; ++x) {
      const Complex here = field[std::size_t{y} * w + x];
      const Complex mirrored = std::conj(field[std::size_t{(h - y) % h} * w + (w - x) % w]);
      const Complex p = 0.5F * (here + mirrored), q = Complex(0, -0.5F) * (here - mirrored);
      const float wx = turn(x, w), wy = turn(y, h), squared = wx * wx + wy * wy;
      if (squared > 0) heights[std::size_t{y} * w + x] = Complex(0, -1) * (wx * p + wy * q) / squared;
    }
    watch.Did(w);
  }
  Transform(w, h, true, heights, watch);
  for (std::size_t k = 0; k < heights.size(); ++k) height.values[k] = heights[k].real();
  return height;
}

Grid Halved(const Grid& fine) {
  Grid coarse(std::max(fine.width / 2, 1U), std::max(fine.height / 2, 1U));
  const std::uint32_t across = fine.width / coarse.width, along = fine.height / coarse.height;
  for (std::uint32_t y = 0; y < fine.height; ++y) {
    for (std::uint32_t x = 0; x < fine.width; ++x) {
      coarse.At(x / across, y / along) += fine.At(x, y) / static_cast<float>(across * along);
    }
  }
  return coarse;
}

// Bilinear, repeating: as the tick samples it.
float Sample(const Grid& grid, double x, double y) {
  const double x0 = std::floor(x), y0 = std::floor(y);
  const auto at = [](double i, std::uint32_t length) {
    return static_cast<std::uint32_t>(static_cast<std::int64_t>(i) + length) % length;
  };
  const auto fx = static_cast<float>(x - x0), fy = static_cast<float>(y - y0);
  const auto row = [&](double j) {
    const std::uint32_t k = at(j, grid.height);
    return (1 - fx) * grid.At(at(x0, grid.width), k) + fx * grid.At(at(x0 + 1, grid.width), k);
  };
  return (1 - fy) * row(y0) + fy * row(y0 + 1);
}

// A band as texels.
struct Band {
  float step = 0;
  std::vector<std::uint8_t> texels;
};

// Rounds the values to texels, and to what those stand for.
Band BandOf(Grid& grid) {
  float largest = 0;
  for (const float value : grid.values) largest = std::max(largest, std::abs(value));
  Band band{largest / 127, {}};
  band.texels.reserve(grid.values.size());
  for (float& value : grid.values) {
    const long texel = std::lround(band.step > 0 ? value / band.step : 0);
    band.texels.push_back(static_cast<std::uint8_t>(128 + texel));
    value = band.step * static_cast<float>(texel);
  }
  return band;
}

// From the coarsest on: what the coarser ones, as the tick samples and adds them, lack of the heights.
std::vector<Band> BandsOf(std::vector<Grid>& heights, const base::WorkWatch& watch) {
  std::vector<Band> bands(heights.size());
  for (std::size_t k = heights.size(); k-- > 0;) {
    Grid& fine = heights[k];
    for (std::uint32_t y = 0; y < fine.height; ++y) {
      for (std::uint32_t x = 0; x < fine.width; ++x) {
        for (std::size_t coarser = k + 1; coarser < heights.size(); ++coarser) {
          const Grid& from = heights[coarser];
          fine.At(x, y) -=
              Sample(from, (x + 0.5) * from.width / fine.width - 0.5, (y + 0.5) * from.height / fine.height - 0.5);
        }
      }
      watch.Did(fine.width);
    }
    bands[k] = BandOf(fine);
  }
  return bands;
}

}  // namespace

MadeRelief ReliefOf(const NormalPixels& normals, const base::WorkWatch& watch) {
  MadeRelief made;
  Slopes slopes = SlopesOf(normals, watch);
  Grid fine = HeightOf(slopes, watch);
  base::FreeMemory(slopes.right.values);
  base::FreeMemory(slopes.down.values);
  made.relief.image_width = normals.width;
  made.relief.image_height = normals.height;
  made.relief.width = fine.width;
  made.relief.height = fine.height;
  std::vector<Grid> heights;
  while (fine.width > 1 || fine.height > 1) {
    Grid coarse = Halved(fine);
    heights.push_back(std::move(fine));
    fine = std::move(coarse);
  }
  for (const Band& band : BandsOf(heights, watch)) {
    made.relief.steps.push_back(band.step);
    made.bands.texels.insert(made.bands.texels.end(), band.texels.begin(), band.texels.end());
  }
  made.bands.width = static_cast<std::uint32_t>(made.bands.texels.size());
  made.bands.height = 1;
  return made;
}

}  // namespace omni::scene
