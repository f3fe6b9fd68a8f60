// Meshes that are meant to cost as much as they can (tests/support/mesh_bombs.h): what building them takes, compared
// with a clean ball of as many triangles, how soon a build ends that is not wanted any more, and how long others wait.
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

namespace omni::bombs {

struct GeometryOptions {
  std::filesystem::path bin;           // folder of omni and omnid
  std::filesystem::path folder;        // to write to
  std::filesystem::path json;          // the rows as JSON; empty: none
  std::vector<std::size_t> triangles;  // of each mesh
  double limit_s = 0;
};

// Prints a table. The result is whether all could be measured.
bool RunGeometry(const GeometryOptions& options);

// By clients of omnid that end at random moments of a build, and by LoadScene in this process; then the waits of
// clients that request a small scene meanwhile. Prints a table. Of the counts of triangles the first.
bool RunCancels(const GeometryOptions& options);

}  // namespace omni::bombs
