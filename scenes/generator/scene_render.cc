// scene_render FILE.glb OUT.png --view front|side|top|three-quarter: a picture of one of our scenes; with --contact
// also of a touch: tip, proxy, force.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <map>
#include <stdexcept>
#include <vector>

#define STB_IMAGE_WRITE_IMPLEMENTATION
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wold-style-cast"
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wmissing-field-initializers"
#include <stb/stb_image_write.h>
#pragma GCC diagnostic pop

#include "scenes/generator/contact_picture.h"
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
  std::vector<double> tip_mm, from_mm;
  CLI::Option* contact =
      app.add_option("--contact", tip_mm, "x y z of the tip in the base frame, mm: draws what is felt there")
          ->expected(3);
  app.add_option("--from", from_mm, "x y z the tip comes from (default: 20 mm above)")->expected(3)->needs(contact);
  double elevation_deg = 0;
  const CLI::Option* elevation =
      app.add_option("--elevation", elevation_deg, "of the camera, degrees, in place of the view's")
          ->check(CLI::Range(-90.0, 90.0));
  CLI11_PARSE(app, argc, argv);
  options.view = views.at(view);
  if (elevation->count() > 0) options.view.elevation_deg = elevation_deg;
  std::vector<omni::scenes::DrawnMesh> meshes = omni::scenes::ReadGlb(in);
  if (contact->count() > 0) {
    const omni::scenes::Vec tip(tip_mm[0] * 1e-3, tip_mm[1] * 1e-3, tip_mm[2] * 1e-3);
    const omni::scenes::Vec from = from_mm.empty()
                                       ? tip + omni::scenes::Vec(0, 0, 0.02)
                                       : omni::scenes::Vec(from_mm[0] * 1e-3, from_mm[1] * 1e-3, from_mm[2] * 1e-3);
    constexpr double kArrow_m_per_N = 0.02;
    const omni::scenes::TouchedContact touched = omni::scenes::Touch(in, from, tip);
    std::printf("tip %.2f %.2f %.2f mm, proxy %.2f %.2f %.2f mm, force %.3f %.3f %.3f N\n", tip.x * 1e3, tip.y * 1e3,
                tip.z * 1e3, touched.proxy_m.x * 1e3, touched.proxy_m.y * 1e3, touched.proxy_m.z * 1e3,
                touched.force_N.x, touched.force_N.y, touched.force_N.z);
    for (omni::scenes::DrawnMesh& mesh : omni::scenes::DrawContact(touched, kArrow_m_per_N))
      meshes.push_back(std::move(mesh));
  }
  const std::vector<std::uint8_t> pixels = Render(meshes, options);
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
