// scene_keys_page ROOT: writes the parts generated from the tables of a tag's numbers into ROOT/docs/scenes.md and
// ROOT/scenes/schema/OMNI_haptic_material.schema.json. Run after a key was added or changed.
#include <cstdio>
#include <exception>
#include <fstream>
#include <iterator>
#include <string>

#include "scenes/keys/keys_page.h"
#include "service/base/files/whole_file.h"

namespace {

int Update(const std::string& path, std::string (*updated)(const std::string&)) {
  std::ifstream file(path);
  const std::string before{std::istreambuf_iterator<char>(file), {}};
  const std::string after = updated(before);
  if (after == before) return 0;
  const omni::base::Status written = omni::base::WriteWholeFile(path, after);
  if (!written.ok()) throw std::runtime_error(written.error());
  std::printf("%s: written\n", path.c_str());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: scene_keys_page ROOT, the folder of the sources\n");
    return 2;
  }
  try {
    const std::string root = argv[1];
    return Update(root + "/docs/scenes.md", omni::scenes::UpdatedPage) +
           Update(root + "/scenes/schema/OMNI_haptic_material.schema.json", omni::scenes::UpdatedSchema);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "scene_keys_page: %s\n", error.what());
    return 1;
  }
}
