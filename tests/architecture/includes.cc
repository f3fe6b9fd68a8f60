#include "tests/architecture/includes.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>

namespace omni::architecture {
namespace {

namespace fs = std::filesystem;

struct Include {
  std::string header;
  int line = 0;
};

// The header of `#include "x"` or `# include <x>`; empty: another line.
std::string HeaderOf(const std::string& line) {
  std::size_t at = line.find_first_not_of(" \t");
  if (at == std::string::npos || line[at] != '#') return {};
  at = line.find_first_not_of(" \t", at + 1);
  if (at == std::string::npos || line.compare(at, 7, "include") != 0) return {};
  const std::size_t open = line.find_first_of("<\"", at + 7);
  if (open == std::string::npos) return {};
  const std::size_t close = line.find(line[open] == '<' ? '>' : '"', open + 1);
  return close == std::string::npos ? std::string() : line.substr(open + 1, close - open - 1);
}

std::vector<Include> IncludesOf(const std::string& text) {
  std::vector<Include> found;
  std::istringstream lines(text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    if (const std::string header = HeaderOf(line); !header.empty()) found.push_back({header, number});
  }
  return found;
}

bool StartsWith(const std::string& text, const std::string& prefix) {
  return text.compare(0, prefix.size(), prefix) == 0;
}

const Rule* FindRule(const std::string& module) {
  const auto& rules = Rules();
  const auto found = std::find_if(rules.begin(), rules.end(), [&](const Rule& rule) { return rule.module == module; });
  return found == rules.end() ? nullptr : &*found;
}

bool IsOurs(const std::string& header) {
  for (const char* top : {"layer/", "service/", "firmware/", "tests/", "scenes/"}) {
    if (StartsWith(header, top)) return true;
  }
  return false;
}

bool Allowed(const std::string& module, const std::string& header) {
  if (!IsOurs(header)) return true;
  const std::string target = ModuleOf(header);
  if (target == module) return true;
  const Rule* rule = FindRule(module);
  return rule != nullptr && rule->may_include.count(target) != 0;
}

std::set<std::string> AnyService() {
  std::set<std::string> all{"firmware/wire"};
  for (const char* name : {"base", "console",     "protocol", "config", "alignment", "magnetics", "tracker",
                           "room", "calibration", "haptics",  "scene",  "actuation", "device",    "sim",
                           "loop", "ipc",         "client",   "daemon", "monitor",   "tools",     "builder"}) {
    all.insert(std::string("service/") + name);
  }
  return all;
}

}  // namespace

const std::vector<Rule>& Rules() {
  static const std::vector<Rule> kRules = {
      {"service/base", {}},
      {"service/protocol", {"service/base"}},
      {"firmware/wire", {}},
      {"service/console", {"service/base"}},
      {"service/config", {"service/base"}},
      {"service/alignment", {"service/base"}},
      {"service/magnetics", {"service/base"}},
      {"service/haptics", {"service/base"}},
      {"service/tracker", {"service/base", "service/magnetics"}},
      {"service/actuation", {"service/base", "service/magnetics"}},
      {"service/room", {"service/base", "service/magnetics", "service/tracker"}},
      {"service/calibration", {"service/base", "service/magnetics", "service/tracker"}},
      {"service/scene", {"service/base", "service/haptics"}},
      {"service/device", {"service/base", "firmware/wire"}},
      {"firmware/core", {"firmware/wire"}},
      {"firmware/drivers", {}},
      {"firmware/board", {"firmware/core", "firmware/drivers", "firmware/wire"}},
      {"service/sim", {"service/base", "service/device", "firmware/wire", "firmware/core"}},
      {"service/loop", {"service/base", "service/tracker", "service/haptics", "service/actuation"}},
      {"service/ipc", {"service/base", "service/protocol"}},
      {"service/client", {"service/base", "service/protocol"}},
      {"service/builder", {"service/base", "service/haptics", "service/protocol", "service/scene"}},
      {"service/twin",
       {"service/base", "service/console", "service/config", "service/protocol", "service/sim", "service/ipc"}},
      {"layer", {"service/base", "service/protocol", "service/client"}},
      {"service/monitor",
       {"service/base", "service/config", "service/protocol", "service/client", "service/haptics", "service/scene",
        "firmware/wire"}},
      {"service/daemon", AnyService()},
      {"service/tools", AnyService()},
      {"layer/examples", {}},
  };
  return kRules;
}

const std::vector<Confined>& ConfinedHeaders() {
  static const std::vector<Confined> kConfined = {
      {"tiny_gltf.h", {"tests/scene/decode_judge.cc", "tests/scenes/pen.cc"}},
      {"stb/", {"service/scene/tags/haptic_texture.cc", "tests/bench/haptics/scene_files.cc"}},
      {"meshoptimizer.h", {"service/scene/gltf/meshopt_view.cc", "tests/scene/compressed.h"}},
      {"draco/", {"service/scene/gltf/draco_mesh.cc", "tests/scene/compressed.h"}},
      {"libusb", {"service/device/usb/libusb_"}},
      {"seccomp.h", {"service/builder/confine.cc"}},
      {"ceres/", {"tests/bench/peers/"}},
      {"openxr/", {"layer/", "service/tools/doctor/openxr_loader.cc"}},
      {"toml++/", {"service/config/"}},
      {"CLI/", {"service/console/command.cc"}},
      {"boost/", {"service/monitor/web/web_server.cc"}},
      {"spdlog/", {"service/daemon/", "service/tools/"}},
      {"Eigen/",
       {"service/base/eigen.h", "service/magnetics/", "service/tracker/", "service/haptics/", "service/actuation/",
        "service/sim/", "service/loop/", "service/room/", "service/calibration/", "service/alignment/"}},
  };
  return kConfined;
}

SourceTree ReadTree(const std::string& root, const std::vector<std::string>& tops,
                    const std::set<std::string>& extensions) {
  SourceTree tree;
  for (const std::string& top : tops) {
    const fs::recursive_directory_iterator end;
    for (fs::recursive_directory_iterator at(fs::path(root) / top); at != end; ++at) {
      const fs::directory_entry& entry = *at;
      if (entry.path().filename() == "node_modules") at.disable_recursion_pending();  // npm's, where someone used it
      if (!entry.is_regular_file() || extensions.count(entry.path().extension().string()) == 0) continue;
      std::ifstream file(entry.path());
      std::ostringstream text;
      text << file.rdbuf();
      tree[fs::relative(entry.path(), root).generic_string()] = text.str();
    }
  }
  return tree;
}

std::string ModuleOf(const std::string& path) {
  if (StartsWith(path, "layer/examples/")) return "layer/examples";
  if (StartsWith(path, "layer/")) return "layer";
  if (!StartsWith(path, "service/") && !StartsWith(path, "firmware/")) return "";
  return path.substr(0, path.find('/', path.find('/') + 1));
}

std::vector<std::string> CheckIncludes(const SourceTree& tree) {
  std::vector<std::string> violations;
  for (const auto& [path, text] : tree) {
    const std::string module = ModuleOf(path);
    if (FindRule(module) == nullptr) violations.push_back(path + ": module " + module + " is not in the table");
    for (const Include& include : IncludesOf(text)) {
      const std::string where = path + ":" + std::to_string(include.line) + ": ";
      if (!Allowed(module, include.header)) violations.push_back(where + module + " may not include " + include.header);
      for (const Confined& confined : ConfinedHeaders()) {
        if (!StartsWith(include.header, confined.header_prefix)) continue;
        const bool inside = std::any_of(confined.places.begin(), confined.places.end(),
                                        [&path = path](const std::string& place) { return StartsWith(path, place); });
        if (!inside) violations.push_back(where + include.header + " is confined to other places");
      }
    }
  }
  return violations;
}

std::set<std::string> ReachableFrom(const SourceTree& tree, const std::string& path) {
  std::set<std::string> reached{path};
  std::vector<std::string> open{path};
  while (!open.empty()) {
    const std::string at = open.back();
    open.pop_back();
    for (const Include& include : IncludesOf(tree.at(at))) {
      if (tree.count(include.header) != 0 && reached.insert(include.header).second) open.push_back(include.header);
    }
  }
  return reached;
}

bool IsStandard(const std::string& header) {
  const std::size_t slash = header.find('/');
  if (slash != std::string::npos) return header.compare(0, slash, "sys") == 0 || header.compare(0, slash, "linux") == 0;
  static const std::set<std::string> kSystem{"fcntl.h", "unistd.h", "signal.h", "poll.h", "immintrin.h"};
  return header.find('.') == std::string::npos || kSystem.count(header) != 0;
}

std::vector<std::string> HeadersOf(const std::string& text) {
  std::vector<std::string> headers;
  for (const Include& include : IncludesOf(text)) headers.push_back(include.header);
  return headers;
}

std::vector<std::string> FindCycles(const SourceTree& tree) {
  enum class Mark { kNew, kOpen, kDone };
  std::map<std::string, Mark> marks;
  std::vector<std::string> cycles;
  const std::function<void(const std::string&)> visit = [&](const std::string& path) {
    marks[path] = Mark::kOpen;
    for (const Include& include : IncludesOf(tree.at(path))) {
      if (tree.count(include.header) == 0) continue;
      const Mark mark = marks[include.header];
      if (mark == Mark::kOpen) cycles.push_back(path + " and " + include.header + " include each other in a circle");
      if (mark == Mark::kNew) visit(include.header);
    }
    marks[path] = Mark::kDone;
  };
  for (const auto& [path, text] : tree) {
    if (marks[path] == Mark::kNew) visit(path);
  }
  return cycles;
}

}  // namespace omni::architecture
