// Times the display of changing surfaces of about 100,000 vertices, step by step; run by `omni-bench surfaces`. Prints
// a JSON array of rows: step, vertices, triangles, us_median, us_p99, n.
#include <algorithm>
#include <chrono>
#include <string>

#include <unistd.h>
#include <nlohmann/json.hpp>

#include "service/base/handover.h"
#include "service/client/surface_reader.h"
#include "service/haptics/deformable/build/build_soft_body.h"
#include "service/haptics/deformable/soft_contact.h"
#include "service/haptics/live/surface_frame.h"
#include "service/haptics/scene/scene.h"
#include "service/ipc/surface_publisher.h"
#include "service/loop/surface_snapshot.h"
#include "tests/bench/arguments.h"
#include "tests/bench/printed_rows.h"
#include "tests/support/soft_step.h"
#include "tests/support/touch/sculpt_body.h"

namespace omni::haptics {
namespace {

using nlohmann::ordered_json;

// 6 n^2 + 2 vertices, 12 n^2 triangles.
constexpr int kFine = 130, kFineQuick = 30;

double Clock_us() {
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

struct Timing {
  ordered_json rows = ordered_json::array();
  int repeats = 300;

  template <class Call>
  void Row(const char* step, std::size_t vertices, std::size_t triangles, const Call& call) {
    std::vector<double> us;
    for (int k = 0; k < repeats; ++k) {
      const double begin_us = Clock_us();
      call(k);
      us.push_back(Clock_us() - begin_us);
    }
    std::sort(us.begin(), us.end());
    const auto at = [&us](double share) {
      return us[static_cast<std::size_t>(share * static_cast<double>(us.size() - 1))];
    };
    rows.push_back({{"step", step},
                    {"vertices", vertices},
                    {"triangles", triangles},
                    {"us_median", at(0.5)},
                    {"us_p99", at(0.99)},
                    {"n", us.size()}});
  }
};

// A memory for one object, written and read.
struct Channel {
  Channel(std::size_t vertices, std::size_t triangles, bool triangles_change) {
    const protocol::SurfacePlan plan{.name = "body",
                                     .flags = protocol::kSurfaceSoft,
                                     .vertex_capacity = static_cast<std::uint32_t>(vertices),
                                     .triangle_capacity = static_cast<std::uint32_t>(triangles),
                                     .triangles_change = triangles_change};
    publisher = std::move(ipc::SurfacePublisher::Create({.memory_generation = 1}, {&plan, 1}).value());
    reader = client::SurfaceReader::Map(base::UniqueFd(::dup(publisher->fd())), publisher->bytes()).value();
  }
  std::unique_ptr<ipc::SurfacePublisher> publisher;
  std::shared_ptr<const client::SurfaceReader> reader;
  client::SurfaceCopy copy;
};

void TimeSoft(int n, Timing& timing) {
  const InputObject mesh = CubeGrid(n, [](const Vec3& p) { return 0.03 * Normalized(p); });
  Scene scene = Built(SceneOf(mesh));
  RestObject rest = RestOf(scene, 0);
  std::vector<DrawnTriangle> triangles;
  DrawnTriangles(scene, 0, triangles);
  SoftBodyOptions options;
  options.moduli = {2e5, 0.4, 1};
  options.lattice.max_tets = 500;
  SoftBuildReport report;
  auto live = std::make_shared<LiveParts>();
  live->SetSoftBody(0, std::make_unique<const SoftBody>(
                           std::move(BuildSoftBody(rest.vertices_base_m, triangles, options, report).value())));
  scene.SetLive(live);
  const SoftBodyView view = live->soft_body(0)->view();
  auto state = std::make_unique<loop::LoopState>();
  state->haptics.soft[0].object = 0;
  const SoftContact contact{.touching = true, .point_base_m = {0, 0, 0.03}, .normal = {0, 0, 1}, .depth_m = 0.003};
  for (int tick = 0; tick < 50; ++tick) {
    (void)support::StepSoftContact(view, contact, 0.005, 1e-3, state->haptics.soft[0].body);
  }
  auto latest = std::make_unique<base::Latest<loop::SurfaceSnapshot>>();
  timing.Row("tick: snapshot, one soft body touched", 0, 0, [&](int) {
    latest->WriteWith([&](loop::SurfaceSnapshot& snapshot) { loop::FillSurfaceSnapshot(*state, snapshot); });
  });
  std::vector<DrawnVertex> drawn;
  const std::size_t v = rest.range.count, t = triangles.size();
  timing.Row("soft: displaced vertices", v, t, [&](int) {
    (void)DisplacedVertices(scene, {state->haptics.soft, state->haptics.regions}, rest, drawn);
  });
  Channel channel(v, t, false);
  (void)channel.publisher->Publish(0, {.vertices_base_m = drawn, .triangles = triangles});
  timing.Row("soft: publish", v, t,
             [&](int k) { (void)channel.publisher->Publish(0, {.t_ns = k, .vertices_base_m = drawn}); });
  (void)channel.reader->Read(0, channel.copy);
  timing.Row("soft: a client's read, nothing new", v, t, [&](int) { (void)channel.reader->Read(0, channel.copy); });
  timing.Row("soft: publish and a client's read", v, t, [&](int k) {
    (void)channel.publisher->Publish(0, {.t_ns = k, .vertices_base_m = drawn});
    (void)channel.reader->Read(0, channel.copy);
  });
}

void TimeSculpted(int n, Timing& timing) {
  const auto editor = sculpt::EditorOf(sculpt::BumpyBall(n, 0.03));
  editor->Publish();
  std::vector<DrawnVertex> vertices;
  std::vector<DrawnTriangle> triangles;
  const auto compact = [&](int) {
    CompactSurface(*editor->publisher().Pin(), vertices, triangles);
    editor->publisher().Unpin();
  };
  compact(0);
  timing.Row("sculpted: compact, while pinned", vertices.size(), triangles.size(), compact);
  Channel channel(vertices.size(), triangles.size(), true);
  timing.Row("sculpted: publish", vertices.size(), triangles.size(), [&](int k) {
    (void)channel.publisher->Publish(0, {.t_ns = k, .vertices_base_m = vertices, .triangles = triangles});
  });
  timing.Row("sculpted: publish and a client's read", vertices.size(), triangles.size(), [&](int k) {
    (void)channel.publisher->Publish(0, {.t_ns = k, .vertices_base_m = vertices, .triangles = triangles});
    (void)channel.reader->Read(0, channel.copy);
  });
}

}  // namespace
}  // namespace omni::haptics

int main(int argc, char** argv) {
  bool quick = false;
  // One run is enough; the seed is ignored: `omni-bench` passes it to all.
  std::string seed;
  const auto ended =
      omni::bench::ParseArguments(argc, argv, "omni_bench_surfaces", {{"--quick", &quick}, {"--seed", nullptr, &seed}});
  if (ended) return *ended;
  omni::haptics::Timing timing;
  if (quick) timing.repeats = 20;
  omni::haptics::TimeSoft(quick ? omni::haptics::kFineQuick : omni::haptics::kFine, timing);
  omni::haptics::TimeSculpted(quick ? omni::haptics::kFineQuick : omni::haptics::kFine, timing);
  omni::bench::PrintRows(timing.rows);
  return 0;
}
