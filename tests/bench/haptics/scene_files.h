// The glTF files that `omni-bench scene` loads, made by formula: equal seeds give equal bytes.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace omni::bench {

struct BenchFile {
  std::string name;  // of the row
  std::string path;
  bool tagged;
};

// Writes them into `folder`: a textured scene of about 100 MB without any tag; the same with one small tagged mesh,
// then also with a tag that names a texture; one body stored as floats, quantised, interleaved and sparse; a million
// triangles. Sizes are divided by `divisor`. Throws std::runtime_error when a file cannot be written.
std::vector<BenchFile> WriteBenchFiles(const std::string& folder, std::uint64_t seed, std::uint64_t divisor);

}  // namespace omni::bench
