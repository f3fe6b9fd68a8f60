// scene_render FILE OUT.png --view front|side|top|three-quarter: a picture of any glTF scene. With --contact also of a
// touch: tip, proxy, force. With --rest of a scene after it was touched: FILE is what `omni surfaces --save` or `omni
// scene save` wrote, the --rest scene gives the paint and everything else, and colours show what has moved.
#include <algorithm>
#include <cstdio>
#include <map>
#include <new>
#include <stdexcept>
#include <vector>

#define STB_IMAGE_WRITE_IMPLEMENTATION
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wold-style-cast"
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wmissing-field-initializers"
#include <stb/stb_image_write.h>
#pragma GCC diagnostic pop

#include "scenes/generator/pictures/contact_picture.h"
#include "scenes/generator/pictures/picture.h"
#include "scenes/generator/pictures/race_picture.h"
#include "scenes/generator/pictures/rest_surface.h"
#include "service/config/paths.h"
#include "service/console/command.h"

namespace {

using omni::console::Command;
using omni::console::Option;
using omni::scenes::DrawnMesh;
using omni::scenes::Vec;
using omni::scenes::View;

constexpr double kArrow_m_per_N = 0.02;

struct DrawArguments {
  std::string in, out, view = "three-quarter", rest, race, caption;
  omni::scenes::PictureOptions options;
  std::vector<double> tip_mm, from_mm;                  // --contact, --from
  std::vector<double> pen_mm, axis{0, 0, -1}, force_N;  // --pen, --pen-axis, --force
  std::vector<double> look_at_mm;                       // --look-at
  double elevation_deg = 0, azimuth_deg = 0, displacement_mm = 0, span_mm = 100;
};

const std::map<std::string, View> kViews = {{"front", {"front", 12, 8}},
                                            {"side", {"side", -90, 8}},
                                            {"top", {"top", -90, 78}},
                                            {"three-quarter", {"three-quarter", -35, 13}}};

Vec Metres(const std::vector<double>& mm) { return Vec(mm[0], mm[1], mm[2]) * 1e-3; }
Vec AsVec(const std::vector<double>& v) { return {v[0], v[1], v[2]}; }

// Angles in place of the view's own.
struct CameraAngles {
  Option elevation, azimuth;
};

CameraAngles AddPlace(Command& app, DrawArguments& arguments) {
  app.Add("--view", arguments.view, "direction of the camera").OneOf({"front", "side", "top", "three-quarter"});
  Option elevation = app.Add("--elevation", arguments.elevation_deg, "of the camera, degrees, in place of the view's")
                         .Range(-90.0, 90.0);
  Option azimuth = app.Add("--azimuth", arguments.azimuth_deg, "of the camera, degrees, 0: in front of +x, likewise")
                       .Range(-360.0, 360.0);
  app.Add("--width", arguments.options.width).Range(16, 8192);
  app.Add("--height", arguments.options.height).Range(16, 8192);
  app.Add("--supersampling", arguments.options.supersampling, "samples along each side of a pixel").Range(1, 8);
  app.Add("--zoom", arguments.options.zoom).Range(0.1, 20.0);
  Option look_at =
      app.Add("--look-at", arguments.look_at_mm, "x y z of the picture's middle in the base frame, mm").ExpectValues(3);
  app.Add("--span", arguments.span_mm, "length shown along the shorter side, mm").Range(1.0, 1000.0).Needs(look_at);
  return {elevation, azimuth};
}

void PlaceCamera(const CameraAngles& angles, DrawArguments& arguments) {
  arguments.options.view = kViews.at(arguments.view);
  if (angles.elevation.given()) arguments.options.view.elevation_deg = arguments.elevation_deg;
  if (angles.azimuth.given()) arguments.options.view.azimuth_deg = arguments.azimuth_deg;
  if (!arguments.look_at_mm.empty()) arguments.options.look_at_m = Metres(arguments.look_at_mm);
  arguments.options.span_m = arguments.span_mm * 1e-3;
}

void AddTouch(Command& app, DrawArguments& arguments) {
  Option contact =
      app.Add("--contact", arguments.tip_mm, "x y z of the tip in the base frame, mm: draws the contact there")
          .ExpectValues(3);
  app.Add("--from", arguments.from_mm, "x y z the tip comes from (default: 20 mm above)")
      .ExpectValues(3)
      .Needs(contact);
  Option rest = app.Add("--rest", arguments.rest, "the scene before it was sculpted or dented: its paint");
  app.Add("--show-displacement", arguments.displacement_mm, "colours displacements from --rest, up to this many mm")
      .Range(0.01, 100.0)
      .Needs(rest);
  Option pen = app.Add("--pen", arguments.pen_mm, "x y z of the tip, mm: draws a pen there").ExpectValues(3);
  app.Add("--pen-axis", arguments.axis, "x y z, out of its tip").ExpectValues(3).Needs(pen);
  app.Add("--force", arguments.force_N, "x y z, N: an arrow at its tip, 20 mm/N").ExpectValues(3).Needs(pen);
  app.Add("--race", arguments.race, "recording of omnid: the car's path, laps and hits, best from the top");
  app.Add("--caption", arguments.caption, "a line below the picture");
}

void AddContact(const DrawArguments& arguments, std::vector<DrawnMesh>& meshes) {
  const Vec tip = Metres(arguments.tip_mm);
  const Vec from = arguments.from_mm.empty() ? tip + Vec(0, 0, 0.02) : Metres(arguments.from_mm);
  const omni::scenes::TouchedContact touched = omni::scenes::Touch(arguments.in, from, tip);
  std::printf("tip %.2f %.2f %.2f mm, proxy %.2f %.2f %.2f mm, force %.3f %.3f %.3f N\n", tip.x * 1e3, tip.y * 1e3,
              tip.z * 1e3, touched.proxy_m.x * 1e3, touched.proxy_m.y * 1e3, touched.proxy_m.z * 1e3, touched.force_N.x,
              touched.force_N.y, touched.force_N.z);
  for (DrawnMesh& mesh : omni::scenes::DrawContact(touched, kArrow_m_per_N)) meshes.push_back(std::move(mesh));
}

// Their caption too, unless there is one.
void AddRace(DrawArguments& arguments, std::vector<DrawnMesh>& meshes) {
  double top_m = 0;
  for (const DrawnMesh& drawn : meshes) {
    for (const Vec& p : drawn.mesh.positions) top_m = std::max(top_m, p.z);
  }
  std::erase_if(meshes, [](const DrawnMesh& drawn) { return drawn.name == "car"; });
  const std::vector<omni::scenes::RacePoint> race = omni::scenes::ReadRace(arguments.race);
  for (DrawnMesh& mesh : omni::scenes::DrawRace(race, top_m)) meshes.push_back(std::move(mesh));
  if (arguments.caption.empty()) arguments.caption = omni::scenes::RaceCaption(race);
}

std::string SceneFile(const std::string& name) {
  const omni::base::Result<std::string> path = omni::config::FindScene(name, omni::config::ScenesFolder());
  if (!path.ok()) throw std::runtime_error(path.error());
  return *path;
}

std::vector<DrawnMesh> MeshesOf(DrawArguments& arguments) {
  arguments.in = SceneFile(arguments.in);
  std::vector<DrawnMesh> meshes = omni::scenes::ReadMeshes(arguments.in);
  if (!arguments.rest.empty()) {
    meshes = omni::scenes::PaintLike(omni::scenes::ReadMeshes(SceneFile(arguments.rest)), std::move(meshes),
                                     arguments.displacement_mm * 1e-3);
  }
  if (!arguments.tip_mm.empty()) AddContact(arguments, meshes);
  if (!arguments.pen_mm.empty()) {
    const Vec tip = Metres(arguments.pen_mm);
    meshes.push_back(omni::scenes::DrawPen(tip, AsVec(arguments.axis)));
    if (!arguments.force_N.empty()) {
      for (DrawnMesh& mesh : omni::scenes::DrawForce(tip, AsVec(arguments.force_N), kArrow_m_per_N))
        meshes.push_back(std::move(mesh));
    }
  }
  if (!arguments.race.empty()) AddRace(arguments, meshes);
  return meshes;
}

int Draw(int argc, char** argv) {
  DrawArguments arguments;
  omni::console::Program app("scene_render", "scene_render: draws a glTF scene into a PNG");
  app.Add("FILE", arguments.in, "a .glb or .gltf file, or the name of a shipped scene").Required();
  app.Add("OUT", arguments.out, "picture to write").Required().WritesOnly(".png", "PNG");
  const CameraAngles angles = AddPlace(app, arguments);
  AddTouch(app, arguments);
  if (const auto ended = app.Parse(argc, argv)) return *ended;
  PlaceCamera(angles, arguments);
  const omni::scenes::PictureOptions& options = arguments.options;
  std::vector<std::uint8_t> rgb = Render(MeshesOf(arguments), options);
  const omni::scenes::Pixels pixels{rgb, options.width, options.height};
  if (arguments.displacement_mm > 0) DrawDisplacementScale(arguments.displacement_mm * 1e-3, pixels);
  if (!arguments.caption.empty()) DrawCaption(arguments.caption, pixels);
  stbi_write_png_compression_level = 9;
  if (stbi_write_png(arguments.out.c_str(), options.width, options.height, 3, rgb.data(), options.width * 3) == 0) {
    throw std::runtime_error(arguments.out + ": cannot be written");
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return Draw(argc, argv);
  } catch (const std::bad_alloc&) {
    return omni::console::Fail("scene_render",
                               "out of memory; a smaller --width, --height or --supersampling needs less");
  } catch (const std::exception& error) {
    return omni::console::Fail("scene_render", error.what());
  }
}
