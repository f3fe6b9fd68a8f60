// scene_generator FOLDER: writes extrusion.glb, dragon.glb and racetrack.glb there, the same bytes on every run.
#include <cstdio>
#include <cstring>
#include <fstream>
#include <string>

#include "scenes/generator/models/scene_models.h"

int main(int argc, char** argv) {
  const bool help = argc == 2 && std::strcmp(argv[1], "--help") == 0;
  if (help || argc != 2 || argv[1][0] == '-') {
    std::fprintf(help ? stdout : stderr, "usage: scene_generator FOLDER\n");
    return help ? 0 : 2;
  }
  using omni::scenes::Document;
  constexpr struct {
    const char* name;
    Document (*make)();
  } kScenes[] = {{"extrusion.glb", omni::scenes::ExtrusionScene},
                 {"dragon.glb", omni::scenes::DragonScene},
                 {"racetrack.glb", omni::scenes::RacetrackScene}};
  for (const auto& scene : kScenes) {
    const std::string path = std::string(argv[1]) + "/" + scene.name;
    const std::vector<unsigned char> bytes = omni::scenes::WriteGlb(scene.make());
    std::ofstream file(path, std::ios::binary);
    file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    file.close();
    if (!file) {
      std::fprintf(stderr, "%s: cannot be written; check the folder and the space on its disk\n", path.c_str());
      return 1;
    }
    std::printf("%s: %zu bytes\n", path.c_str(), bytes.size());
  }
  return 0;
}
