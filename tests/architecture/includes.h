// Checks every #include of our code against the table of docs/architecture.md.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

namespace omni::architecture {

// A module is the folder that a CMake target is made of: "service/base", "firmware/wire", "layer".
struct Rule {
  std::string module;
  std::set<std::string> may_include;  // other modules; its own is always allowed
};
const std::vector<Rule>& Rules();

// A third-party header that stays in a few places: path prefixes where it may be included.
struct Confined {
  std::string header_prefix;
  std::vector<std::string> places;
};
const std::vector<Confined>& ConfinedHeaders();

// Path from the root -> text.
using SourceTree = std::map<std::string, std::string>;
// Of the files below `tops` that have one of these extensions.
SourceTree ReadTree(const std::string& root, const std::vector<std::string>& tops = {"layer", "service", "firmware"},
                    const std::set<std::string>& extensions = {".cc", ".h"});

// The module of a path; empty: not under the rules (tests, scenes).
std::string ModuleOf(const std::string& path);

// One line per violation: "path:line: module may not include header".
std::vector<std::string> CheckIncludes(const SourceTree& tree);

// The files of the tree that `path` includes, itself and those that they include among them.
std::set<std::string> ReachableFrom(const SourceTree& tree, const std::string& path);

// A header of the standard library, of C or of the system: not ours and not of a package.
bool IsStandard(const std::string& header);

// The headers that a file includes, in its order.
std::vector<std::string> HeadersOf(const std::string& text);

// Files that include each other in a circle, one line per circle found.
std::vector<std::string> FindCycles(const SourceTree& tree);

}  // namespace omni::architecture
