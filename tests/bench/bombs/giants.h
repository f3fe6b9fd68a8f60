// Legal scenes of the most triangles, several at once: memory of omnid and of what it has started.
#pragma once

#include <filesystem>

namespace omni::bombs {

// `giants` applications request one each; the result is whether omnid lives. Prints a line. `bin`: folder of omnid.
bool RunGiants(const std::filesystem::path& bin, const std::filesystem::path& folder, int giants, double limit_s);

}  // namespace omni::bombs
