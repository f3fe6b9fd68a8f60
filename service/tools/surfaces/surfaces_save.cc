#include "service/tools/surfaces/surfaces.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <system_error>
#include <thread>

#include "service/base/clock.h"
#include "service/base/vec.h"
#include "service/client/connection.h"
#include "service/scene/glb_save.h"
#include "service/tools/common/command_line.h"
#include "service/tools/common/files.h"
#include "service/tools/common/output.h"
#include "service/tools/common/terminal.h"

namespace omni::tools {
namespace {

using client::SurfaceRead;

constexpr const char* kSaveCommand = "omni surfaces";
constexpr auto kSavePeriod = std::chrono::milliseconds(4);  // more often than the service publishes
constexpr std::int64_t kPublished_ns = 2'500'000'000;       // if nothing was published by then, nothing will be

// Vertex in the object's frame -> base frame.
base::Vec3 PlacedPoint(const protocol::SurfaceFrame& frame, const protocol::SurfacePoint& point) {
  const auto& q = frame.rotation_wxyz;
  const auto& t = frame.translation_m;
  const base::Vec3 p{double{point[0]}, double{point[1]}, double{point[2]}};
  return Rotated({q[0], q[1], q[2], q[3]}, p) + base::Vec3{t[0], t[1], t[2]};
}

// Requests the surfaces as an application would, and reads what is published.
class PublishedReader {
 public:
  explicit PublishedReader(const std::string& socket)
      : connection_({.role = protocol::ClientRole::kMonitor,
                     .application = "omni surfaces",
                     .engine = "",
                     .socket_path = socket}) {
    connection_.RequestSurfaces(true);
  }

  // True: something is new.
  bool Read() {
    connection_.Poll(base::MonotonicNow_ns());
    connection_.SignalAlive();
    was_connected_ = was_connected_ || connection_.connected();
    if (connection_.surfaces() != reader_) Begin();
    bool news = false;
    for (std::size_t i = 0; reader_ != nullptr && i < surfaces_.objects.size(); ++i) {
      const SurfaceRead read = reader_->Read(i, surfaces_.objects[i].copy);
      news = news || (read != SurfaceRead::kNothing && read != SurfaceRead::kUnchanged);
    }
    return news;
  }

  // All objects have been read, and one of them has a surface.
  bool complete() const {
    bool any = false;
    for (const PublishedSurfaces::Object& object : surfaces_.objects) {
      if (object.copy.frame.t_ns == 0) return false;
      any = any || object.copy.frame.triangle_count > 0;
    }
    return any;
  }
  const PublishedSurfaces& surfaces() const { return surfaces_; }
  bool was_connected() const { return was_connected_; }
  bool gone() const { return was_connected_ && !connection_.connected(); }
  bool refused() const { return !connection_.connected() && !connection_.last_error().empty(); }
  const std::string& problem() const { return connection_.last_error(); }

 private:
  void Begin() {
    reader_ = connection_.surfaces();
    surfaces_.objects.clear();
    if (reader_ == nullptr) return;
    for (std::size_t i = 0; i < reader_->object_count(); ++i) {
      surfaces_.objects.push_back({reader_->object(i).name, {}});
    }
  }

  client::Connection connection_;
  std::shared_ptr<const client::SurfaceReader> reader_;
  PublishedSurfaces surfaces_;
  bool was_connected_ = false;
};

int NoServiceToSave(const SurfacesSaveArguments& arguments, const PublishedReader& reader) {
  const std::string path = arguments.socket.empty() ? client::DefaultSocketPath() : arguments.socket;
  const std::string why = reader.problem().empty() ? "omnid does not answer at " + path : reader.problem();
  Fail(kSaveCommand, why + "; to start it: `omnid --device twin`");
  return kExitNoService;
}

int WriteSurfaces(const SurfacesSaveArguments& arguments, const PublishedSurfaces& surfaces) {
  const base::Result<std::string> bytes = scene::GlbBytes(SceneOfSurfaces(surfaces));
  if (!bytes.ok()) return Fail(kSaveCommand, arguments.file + ": " + bytes.error());
  const base::Status written = WriteWholeFile(arguments.file, *bytes, arguments.force);
  if (!written.ok()) return Fail(kSaveCommand, written.error());
  Print(arguments.file + ": " + SavedText(surfaces) + "\n");
  return kExitOk;
}

int SaveNow(const SurfacesSaveArguments& arguments) {
  PublishedReader reader(arguments.socket);
  const std::int64_t end_ns = base::MonotonicNow_ns() + kPublished_ns;
  while (!reader.complete() && !reader.refused() && base::MonotonicNow_ns() < end_ns) {
    reader.Read();
    std::this_thread::sleep_for(kSavePeriod);
  }
  if (!reader.was_connected()) return NoServiceToSave(arguments, reader);
  if (reader.complete()) return WriteSurfaces(arguments, reader.surfaces());
  return Fail(
      kSaveCommand,
      arguments.file +
          ": not written: nothing is published; run an application whose scene is soft, sculptable or extruded");
}

int SaveLargest(const SurfacesSaveArguments& arguments) {
  const EndSignals signals;
  PublishedReader reader(arguments.socket);
  PublishedSurfaces best;
  const std::int64_t begin_ns = base::MonotonicNow_ns();
  const std::function<bool(double)> progress = ProgressOnTerminal("watching");
  while (!EndSignals::asked() && !reader.gone()) {
    const double elapsed_s = static_cast<double>(base::MonotonicNow_ns() - begin_ns) * 1e-9;
    if (elapsed_s >= arguments.seconds) break;
    if (progress) progress(elapsed_s / arguments.seconds);
    const bool news = reader.Read();
    if (!reader.was_connected() && reader.refused()) break;
    const bool larger = reader.surfaces().LargestDisplacement_m() > best.LargestDisplacement_m();
    if (news && larger && reader.complete()) best = reader.surfaces();
    std::this_thread::sleep_for(kSavePeriod);
  }
  if (!reader.was_connected()) return NoServiceToSave(arguments, reader);
  if (!best.objects.empty()) return WriteSurfaces(arguments, best);
  return Fail(
      kSaveCommand,
      arguments.file +
          ": not written: nothing was displaced; touch something soft or extruded, or watch longer with --seconds");
}

}  // namespace

std::size_t PublishedSurfaces::MostDisplaced() const noexcept {
  const auto less = [](const Object& a, const Object& b) {
    return a.copy.frame.largest_displacement_m < b.copy.frame.largest_displacement_m;
  };
  return static_cast<std::size_t>(std::max_element(objects.begin(), objects.end(), less) - objects.begin());
}

double PublishedSurfaces::LargestDisplacement_m() const noexcept {
  return objects.empty() ? 0 : objects[MostDisplaced()].copy.frame.largest_displacement_m;
}

haptics::SceneInput SceneOfSurfaces(const PublishedSurfaces& surfaces) {
  haptics::SceneInput scene;
  scene.name = "surfaces";
  scene.materials.emplace_back();
  for (const PublishedSurfaces::Object& from : surfaces.objects) {
    if (from.copy.triangles.empty()) continue;
    haptics::InputObject object;
    object.name = from.name;
    object.vertices_base_m.reserve(from.copy.vertices_base_m.size());
    for (const auto& v : from.copy.vertices_base_m) object.vertices_base_m.push_back(PlacedPoint(from.copy.frame, v));
    object.triangles = from.copy.triangles;
    object.triangle_material.assign(object.triangles.size(), 0);
    scene.objects.push_back(std::move(object));
  }
  return scene;
}

std::string SavedText(const PublishedSurfaces& surfaces) {
  std::size_t objects = 0, vertices = 0;
  std::int64_t newest_ns = 0;
  for (const PublishedSurfaces::Object& object : surfaces.objects) {
    objects += object.copy.triangles.empty() ? 0 : 1;
    vertices += object.copy.vertices_base_m.size();
    newest_ns = std::max(newest_ns, object.copy.frame.t_ns);
  }
  std::string text = Plural(objects, "object") + ", " + std::to_string(vertices) + " vertices";
  const std::size_t most = surfaces.MostDisplaced();
  if (surfaces.LargestDisplacement_m() > 0) {
    char number[32];
    std::snprintf(number, sizeof(number), "%.3f", surfaces.LargestDisplacement_m() * 1e3);
    text += std::string("; largest displacement ") + number + " mm (" + surfaces.objects[most].name + ")";
    newest_ns = surfaces.objects[most].copy.frame.t_ns;
  }
  return text + " at t_ns " + std::to_string(newest_ns);
}

int SaveSurfaces(const SurfacesSaveArguments& arguments) {
  std::error_code ignored;
  if (!arguments.force && std::filesystem::exists(std::filesystem::symlink_status(arguments.file, ignored))) {
    return Fail(kSaveCommand, arguments.file + ": already exists; choose another name, or replace it with --force");
  }
  return arguments.largest ? SaveLargest(arguments) : SaveNow(arguments);
}

}  // namespace omni::tools
