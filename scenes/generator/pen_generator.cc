// pen_generator FILE: writes the pen's render model, layer/models/pen.glb, the same bytes on every run.
#include <cstdio>
#include <cstring>
#include <fstream>

#include "scenes/generator/models/scene_models.h"

int main(int argc, char** argv) {
  const bool help = argc == 2 && std::strcmp(argv[1], "--help") == 0;
  if (help || argc != 2 || argv[1][0] == '-') {
    std::fprintf(help ? stdout : stderr, "usage: pen_generator FILE\n");
    return help ? 0 : 2;
  }
  const std::vector<unsigned char> bytes = omni::scenes::WriteGlb(omni::scenes::PenModel());
  std::ofstream file(argv[1], std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  file.close();
  if (!file) {
    std::fprintf(stderr, "%s: cannot be written; check the folder and the space on its disk\n", argv[1]);
    return 1;
  }
  std::printf("%s: %zu bytes\n", argv[1], bytes.size());
  return 0;
}
