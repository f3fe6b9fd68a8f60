// scene_render FILE.glb OUT.png --view front|side|top|three-quarter: a picture of one of our scenes.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <map>
#include <stdexcept>

#define STB_IMAGE_WRITE_IMPLEMENTATION
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wold-style-cast"
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wmissing-field-initializers"
#include <stb/stb_image_write.h>
#pragma GCC diagnostic pop

#include "scenes/generator/picture.h"

namespace {

int Draw(int argc, char** argv) {
  using omni::scenes::View;
  const std::map<std::string, View> views = {{"front", {"front", 12, 8}},
                                             {"side", {"side", -90, 8}},
                                             {"top", {"top", -90, 78}},
                                             {"three-quarter", {"three-quarter", -35, 13}}};
  std::string in, out, view = "three-quarter";
  omni::scenes::PictureOptions options;
  CLI::App app{"Draws a .glb scene of this project into a PNG"};
  app.add_option("FILE", in, "binary glTF")->required();
  app.add_option("OUT", out, "PNG to write")->required();
  app.add_option("--view", view, "from where")->check(CLI::IsMember({"front", "side", "top", "three-quarter"}));
  app.add_option("--width", options.width)->check(CLI::Range(16, 8192));
  app.add_option("--height", options.height)->check(CLI::Range(16, 8192));
  app.add_option("--zoom", options.zoom)->check(CLI::Range(0.1, 20.0));
  double elevation_deg = 0;
  const CLI::Option* elevation =
      app.add_option("--elevation", elevation_deg, "of the camera, degrees, in place of the view's")
          ->check(CLI::Range(-90.0, 90.0));
  CLI11_PARSE(app, argc, argv);
  options.view = views.at(view);
  if (elevation->count() > 0) options.view.elevation_deg = elevation_deg;
  const std::vector<std::uint8_t> pixels = Render(omni::scenes::ReadGlb(in), options);
  stbi_write_png_compression_level = 9;
  if (stbi_write_png(out.c_str(), options.width, options.height, 3, pixels.data(), options.width * 3) == 0) {
    throw std::runtime_error(out + ": cannot be written");
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return Draw(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "scene_render: %s: %s\n", argc > 1 ? argv[1] : "no file", error.what());
  } catch (...) {
    std::fprintf(stderr, "scene_render: failed\n");
  }
  return 1;
}
