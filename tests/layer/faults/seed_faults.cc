// seed_faults SEEDS.json SOURCES OUTPUT: a copy of the layer's sources with all seeded faults in it, each inactive
// until the environment variable OMNI_LAYER_FAULT names it. A row {name, file, find, replace} replaces the only
// occurrence of `find` in the file; the word FAULT in `replace` becomes the condition that this fault is active. Exit
// status 1 if a row matches no place, several, or the place of another row: then the source has changed, and its row
// must follow. Nothing but the rows differs between the copy and the source.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

namespace {

namespace fs = std::filesystem;

struct Seed {
  std::string name, find, replace;
};

struct Edit {
  std::size_t at = 0;
  std::size_t bytes = 0;
  std::string text;
  std::string name;
};

std::string TextOf(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error(path.string() + ": cannot be read");
  return {std::istreambuf_iterator<char>(file), {}};
}

void Write(const fs::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  if (!file.flush()) throw std::runtime_error(path.string() + ": cannot be written");
}

std::string WithFault(const Seed& seed) {
  constexpr std::string_view kWord = "FAULT";
  std::string text = seed.replace;
  const std::size_t at = text.find(kWord);
  if (at == std::string::npos) throw std::runtime_error(seed.name + ": its replacement lacks the word FAULT");
  return text.replace(at, kWord.size(), "::omni::layer::FaultIs(\"" + seed.name + "\")");
}

Edit EditFor(const Seed& seed, const std::string& source, const std::string& file) {
  const std::size_t at = source.find(seed.find);
  if (seed.find.empty() || at == std::string::npos) {
    throw std::runtime_error(file + ": the seeded fault \"" + seed.name + "\" no longer matches its file: \"" +
                             seed.find + "\"; change its row in tests/layer/faults/seeds.json with the source");
  }
  if (source.find(seed.find, at + 1) != std::string::npos) {
    throw std::runtime_error(file + ": the seeded fault \"" + seed.name + "\" matches several places: \"" + seed.find +
                             "\"");
  }
  return {.at = at, .bytes = seed.find.size(), .text = WithFault(seed), .name = seed.name};
}

std::string Mutated(const std::string& source, const std::vector<Seed>& seeds, const std::string& file) {
  std::vector<Edit> edits;
  for (const Seed& seed : seeds) edits.push_back(EditFor(seed, source, file));
  std::sort(edits.begin(), edits.end(), [](const Edit& a, const Edit& b) { return a.at < b.at; });
  std::string text;
  std::size_t copied = 0;
  for (const Edit& edit : edits) {
    if (edit.at < copied) {
      throw std::runtime_error(file + ": the seeded fault \"" + edit.name + "\" overlaps another one");
    }
    text.append(source, copied, edit.at - copied);
    text += edit.text;
    copied = edit.at + edit.bytes;
  }
  return text.append(source, copied);
}

int Run(const fs::path& seeds_path, const fs::path& sources, const fs::path& output) {
  std::map<std::string, std::vector<Seed>> seeds;  // by file
  for (const nlohmann::json& row : nlohmann::json::parse(TextOf(seeds_path))) {
    if (row.size() != 4) throw std::runtime_error(seeds_path.string() + ": a row must be {name, file, find, replace}");
    seeds[row.at("file")].push_back({row.at("name"), row.at("find"), row.at("replace")});
  }
  fs::create_directories(output);
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(sources)) {
    if (entry.path().extension() != ".cc") continue;
    const std::string file = fs::relative(entry.path(), sources).generic_string();
    const fs::path copy = output / file;
    fs::create_directories(copy.parent_path());
    Write(copy, Mutated(TextOf(entry.path()), seeds[file], file));
    seeds.erase(file);
  }
  for (const auto& [file, rows] : seeds) {
    if (!rows.empty()) throw std::runtime_error(seeds_path.string() + ": there is no source " + file);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) {
    std::fprintf(stderr, "usage: seed_faults SEEDS.json SOURCES OUTPUT\n");
    return 2;
  }
  try {
    return Run(argv[1], argv[2], argv[3]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "seed_faults: %s\n", error.what());
    return 1;
  }
}
