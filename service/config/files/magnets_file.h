// magnets.toml: the magnets of pens that omnid has learnt, by base. Written by omnid only. Errors name file, line, key,
// value and remedy.
#pragma once

#include <string>
#include <vector>

#include "service/base/result.h"

namespace omni::config {

inline constexpr int kMagnetsFormat = 1;
inline constexpr std::size_t kMaxMagnets = 64;  // of all bases; the oldest goes when full

struct MagnetEntry {
  std::string base;         // its serial number
  double moment_Am2 = 0;    // as that base measures it
  double sigma_share = 0;   // its standard deviation, relative
  std::string learnt_date;  // ISO 8601, UTC
};

// A missing file reads as an empty one.
base::Result<std::vector<MagnetEntry>> LoadMagnetsFile(const std::string& path);
// `name` stands for the file in messages.
base::Result<std::vector<MagnetEntry>> ParseMagnets(const std::string& text, const std::string& name);

std::string WriteMagnets(const std::vector<MagnetEntry>& magnets);

}  // namespace omni::config
