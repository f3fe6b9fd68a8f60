// Surfaces to draw: from the snapshot of the tick to the copy of a client, and all of it over the socket.
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "service/base/clock.h"
#include "service/client/connection.h"
#include "service/client/surface_reader.h"
#include "service/config/files/device_file.h"
#include "service/daemon/devices/attached_device.h"
#include "service/daemon/scenes/surface_clients.h"
#include "service/daemon/scenes/surface_thread.h"
#include "service/daemon/service.h"
#include "service/haptics/live/make_live.h"
#include "service/haptics/scene/scene.h"
#include "service/ipc/state_publisher.h"
#include "service/loop/tick_config.h"
#include "tests/deformable/scenario.h"
#include "tests/scene/files.h"
#include "tests/support/process/temp_folder.h"
#include "tests/support/silent_device.h"
#include "tests/support/soft_step.h"
#include "tests/support/touch/sculpt_body.h"

namespace omni::daemon {
namespace test_daemon_surfaces {

using client::SurfaceCopy;
using client::SurfaceRead;
using client::SurfaceReader;
using haptics::Scene;

// A block whose top is one extrudable face.
haptics::SceneInput ExtrudableInput() {
  haptics::SceneInput input = haptics::SceneOf(haptics::Block(6, {0.02, 0.02, 0.01}));
  haptics::Material clay;
  clay.extrude.enabled = true;
  input.materials.push_back(clay);
  haptics::InputObject& block = input.objects[0];
  for (std::size_t t = 0; t < block.triangles.size(); ++t) {
    bool on_top = true;
    for (const std::uint32_t v : block.triangles[t]) on_top = on_top && block.vertices_base_m[v].z == 0.01;
    if (on_top) block.triangle_material[t] = 1;
  }
  return input;
}

// A looker over a scene, with a snapshot that the test writes.
class Drawing {
 public:
  explicit Drawing(Scene built)
      : scene(std::make_shared<const Scene>(std::move(built))),
        looker({.scene = scene,
                .scene_generation = 4,
                .service_instance = 1,
                .snapshot =
                    [this](loop::SurfaceSnapshot& to) {
                      to = snapshot;
                      return there;
                    },
                .memory_generation = &generation}) {
    snapshot.scene_generation = 4;
  }
  SurfaceRead Poll(std::size_t index) {
    ++snapshot.t_ns;
    EXPECT_TRUE(looker.Poll(snapshot.t_ns)) << looker.problem();
    if (looker.memory() == nullptr) return SurfaceRead::kNothing;
    if (reader == nullptr || reader->memory_generation() != looker.memory()->id().memory_generation) {
      reader = SurfaceReader::Map(base::UniqueFd(::dup(looker.memory()->fd())), looker.memory()->bytes()).value();
    }
    return reader->Read(index, copy);
  }

  std::shared_ptr<const Scene> scene;
  loop::SurfaceSnapshot snapshot;
  bool there = true;
  std::atomic<std::uint64_t> generation{0};
  SurfacePoller looker;
  std::shared_ptr<const SurfaceReader> reader;
  SurfaceCopy copy;
};

// For readers a surface without a time is not there yet: it gets one even if it never changes.
TEST(SurfacePoller, SurfaceAtRestGetsATimeOnceTheTickRuns) {
  for (const bool sculpted : {false, true}) {
    Scene scene = haptics::Built(ExtrudableInput());
    if (sculpted) {
      haptics::Material clay;
      clay.sculpt.enabled = true;
      scene = haptics::Built(haptics::SceneOf(haptics::Sphere(8, 0.02), clay));
      haptics::MakeLive(scene);
    }
    Drawing drawing(std::move(scene));
    drawing.there = false;
    EXPECT_EQ(drawing.Poll(0), SurfaceRead::kTriangles);
    EXPECT_EQ(drawing.copy.frame.t_ns, 0);
    drawing.there = true;
    EXPECT_EQ(drawing.Poll(0), SurfaceRead::kPose) << sculpted;
    EXPECT_GT(drawing.copy.frame.t_ns, 0);
    EXPECT_EQ(drawing.Poll(0), SurfaceRead::kUnchanged) << "and then rests";
  }
}

TEST(SurfacePoller, PublishesExtrudedFacesWhenTheyMove) {
  Drawing drawing(haptics::Built(ExtrudableInput()));
  EXPECT_EQ(drawing.Poll(0), SurfaceRead::kTriangles);
  EXPECT_EQ(drawing.reader->object_count(), 1U);
  EXPECT_EQ(drawing.reader->object(0).flags, protocol::kSurfaceExtruded);
  EXPECT_EQ(drawing.reader->scene_generation(), 4U);
  EXPECT_EQ(drawing.copy.frame.largest_displacement_m, 0);
  EXPECT_EQ(drawing.copy.vertices_base_m.size(), drawing.scene->vertices().size());
  EXPECT_EQ(drawing.Poll(0), SurfaceRead::kUnchanged) << "nothing moved";
  drawing.snapshot.regions[0].offset_m = 0.003;
  EXPECT_EQ(drawing.Poll(0), SurfaceRead::kVertices);
  EXPECT_NEAR(drawing.copy.frame.largest_displacement_m, 0.003, 1e-12);
  EXPECT_EQ(drawing.Poll(0), SurfaceRead::kUnchanged);
  drawing.snapshot.scene_generation = 5;  // the tick is elsewhere already
  EXPECT_EQ(drawing.Poll(0), SurfaceRead::kVertices);
  EXPECT_EQ(drawing.copy.frame.largest_displacement_m, 0);
  drawing.there = false;
  EXPECT_EQ(drawing.Poll(0), SurfaceRead::kUnchanged);
  EXPECT_EQ(drawing.generation, 1U) << "one memory for all of it";
}

TEST(SurfacePoller, PublishesPosesOfMovedObjects) {
  haptics::SceneInput input = haptics::SceneOf(haptics::SoftBallMesh());
  input.objects[0].kinematic = true;
  Drawing drawing(haptics::Built(input));
  EXPECT_EQ(drawing.Poll(0), SurfaceRead::kPose);
  EXPECT_EQ(drawing.reader->object(0).vertex_capacity, 0U) << "the application has the shape";
  EXPECT_EQ(drawing.Poll(0), SurfaceRead::kUnchanged);
  drawing.snapshot.moved[3] = {.object = 0, .rotation = {.w = 0, .z = 1}, .translation_m = {0.01, 0, 0}};
  EXPECT_EQ(drawing.Poll(0), SurfaceRead::kPose);
  EXPECT_EQ(drawing.copy.frame.translation_m[0], 0.01);
  EXPECT_EQ(drawing.copy.frame.rotation_wxyz[3], 1);
  EXPECT_EQ(drawing.Poll(0), SurfaceRead::kUnchanged);
}

TEST(SurfacePoller, SoftBodyThatBecomesReadyAppearsInANewMemory) {
  Scene scene = haptics::Built(haptics::SceneOf(haptics::SoftBallMesh()));
  const auto live = std::make_shared<haptics::LiveParts>();
  scene.SetLive(live);
  Drawing drawing(std::move(scene));
  EXPECT_EQ(drawing.Poll(0), SurfaceRead::kNothing) << "no memory while there is nothing to draw";
  const haptics::RestObject rest = haptics::RestOf(*drawing.scene, 0);
  std::vector<haptics::DrawnTriangle> triangles;
  haptics::DrawnTriangles(*drawing.scene, 0, triangles);
  haptics::SoftBuildReport report;
  auto body = haptics::BuildSoftBody(rest.vertices_base_m, triangles, haptics::SmallOptions(), report);
  ASSERT_TRUE(body.ok());
  live->SetSoftBody(0, std::make_unique<const haptics::SoftBody>(std::move(*body)));
  EXPECT_EQ(drawing.Poll(0), SurfaceRead::kTriangles);
  EXPECT_EQ(drawing.copy.triangles, triangles);

  drawing.snapshot.soft[0].object = 0;
  const haptics::SoftContact contact{
      .touching = true, .point_base_m = {0, 0, 0.03}, .normal = {0, 0, 1}, .depth_m = 0.003};
  for (int tick = 0; tick < 50; ++tick) {
    (void)support::StepSoftContact(live->soft_body(0)->view(), contact, haptics::kTip_m, 1e-3,
                                   drawing.snapshot.soft[0].body);
  }
  EXPECT_EQ(drawing.Poll(0), SurfaceRead::kVertices);
  EXPECT_GT(drawing.copy.frame.largest_displacement_m, 1e-4);
  drawing.snapshot.soft[0].object = haptics::kNoIndex;
  EXPECT_EQ(drawing.Poll(0), SurfaceRead::kVertices) << "back at rest, once";
  EXPECT_EQ(drawing.copy.frame.largest_displacement_m, 0);
  EXPECT_EQ(drawing.Poll(0), SurfaceRead::kUnchanged);
}

TEST(SurfacePoller, SculptedSurfaceThatOutgrowsItsMemoryGetsANewOne) {
  using namespace haptics::sculpt;
  const haptics::InputObject ball = BumpyBall(8, 0.03);
  Scene scene = haptics::Built(haptics::SceneOf(ball));
  const auto live = std::make_shared<haptics::LiveParts>();
  auto editor = EditorOf(ball, {.detail_m = 3e-4});
  ASSERT_NE(editor, nullptr);
  live->AddSculptSession(0, std::make_unique<SculptSession>(std::move(editor), SculptParameters{}, Brush{}));
  scene.SetLive(live);
  SculptSession& sculpt_session = live->sculpt_session_at(0);
  Drawing drawing(std::move(scene));
  EXPECT_EQ(drawing.Poll(0), SurfaceRead::kTriangles);
  EXPECT_EQ(drawing.copy.triangles.size(), sculpt_session.editor().mesh().triangle_count());
  EXPECT_EQ(drawing.Poll(0), SurfaceRead::kUnchanged);
  haptics::Random random(3);
  Brush brush;
  brush.radius_m = 0.006;
  for (int k = 0; k < 200 && drawing.generation == 1; ++k) {
    ASSERT_TRUE(sculpt_session.editor().Stroke(On(sculpt_session.editor(), random.InBox(0.05)), brush, 0.0005).ok());
    sculpt_session.editor().Publish();
    EXPECT_EQ(drawing.Poll(0), SurfaceRead::kTriangles);
    ASSERT_EQ(drawing.copy.triangles.size(), sculpt_session.editor().mesh().triangle_count());
    ASSERT_EQ(drawing.copy.vertices_base_m.size(), sculpt_session.editor().mesh().vertex_count());
  }
  EXPECT_EQ(drawing.generation, 2U);
  EXPECT_EQ(drawing.reader->memory_generation(), 2U);
  EXPECT_GE(drawing.reader->object(0).triangle_capacity, drawing.copy.triangles.size());
}

// Requests, notifications, and when the thread runs.
class Notified {
 public:
  Notified()
      : clients(
            9, [](loop::SurfaceSnapshot& /*snapshot*/) { return false; },
            [this](ipc::ClientId id, const protocol::Surfaces& surfaces, int fd) {
              EXPECT_EQ(fd >= 0, surfaces.total_bytes > 0);
              if (deaf) return false;
              messages.emplace_back(id, surfaces.memory_generation);
              return true;
            }) {}
  // Periods until `count` messages were sent, for at most 10 s.
  bool Until(std::size_t count) {
    for (int i = 0; i < 2000 && messages.size() < count; ++i) {
      problem += clients.Update(scene, generation);
      if (messages.size() < count) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return messages.size() == count;
  }

  std::shared_ptr<const Scene> scene;
  std::uint64_t generation = 1;
  bool deaf = false;
  std::string problem;
  std::vector<std::pair<ipc::ClientId, std::uint64_t>> messages;
  SurfaceClients clients;
};

TEST(SurfaceClients, NoThreadRunsWithoutARequest) {
  Notified reported;
  reported.scene = std::make_shared<const Scene>(haptics::Built(ExtrudableInput()));
  for (int i = 0; i < 20; ++i) reported.problem += reported.clients.Update(reported.scene, 1);
  EXPECT_FALSE(reported.clients.running());
  EXPECT_TRUE(reported.messages.empty());
}

// The thread of the one before may not have ended: its memory would never be updated.
TEST(SurfaceClients, RequestDuringThreadShutdownGetsANewMemory) {
  Notified reported;
  reported.scene = std::make_shared<const Scene>(haptics::Built(ExtrudableInput()));
  reported.clients.HandleRequest(1, true);
  ASSERT_TRUE(reported.Until(1));
  for (ipc::ClientId id = 2; id < 12; ++id) {
    const std::uint64_t before = reported.messages.back().second;
    reported.clients.Remove(id - 1);
    reported.clients.Update(reported.scene, reported.generation);
    reported.clients.HandleRequest(id, true);
    ASSERT_TRUE(reported.Until(id));
    EXPECT_EQ(reported.messages.back(), std::make_pair(id, before + 1));
  }
}

TEST(SurfaceClients, NotifiesEachClientOncePerMemory) {
  using Messages = std::vector<std::pair<ipc::ClientId, std::uint64_t>>;
  Notified reported;
  reported.clients.HandleRequest(1, true);
  ASSERT_TRUE(reported.Until(1));
  EXPECT_EQ(reported.messages, (Messages{{1, 0}})) << "no scene: nothing to draw";
  EXPECT_FALSE(reported.clients.running());
  reported.scene = std::make_shared<const Scene>(haptics::Built(ExtrudableInput()));
  reported.generation = 2;
  ASSERT_TRUE(reported.Until(2));
  EXPECT_EQ(reported.messages.back(), std::make_pair(ipc::ClientId{1}, std::uint64_t{1}));
  EXPECT_TRUE(reported.clients.running());
  reported.clients.HandleRequest(2, true);
  ASSERT_TRUE(reported.Until(3));
  EXPECT_EQ(reported.messages.back(), std::make_pair(ipc::ClientId{2}, std::uint64_t{1}));
  reported.generation = 3;  // another scene
  reported.deaf = true;     // whose message cannot be sent at first
  for (int i = 0; i < 100; ++i) {
    reported.clients.Update(reported.scene, reported.generation);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  reported.deaf = false;
  ASSERT_TRUE(reported.Until(5));
  EXPECT_EQ(reported.messages[4].second, reported.messages[3].second);
  EXPECT_GT(reported.messages[4].second, 1U);
  reported.clients.HandleRequest(1, false);
  reported.clients.Remove(2);
  for (int i = 0; i < 2000 && reported.clients.running(); ++i) {
    reported.clients.Update(reported.scene, reported.generation);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_FALSE(reported.clients.running());
  EXPECT_EQ(reported.messages.size(), 5U);
  EXPECT_EQ(reported.problem, "");
}

struct NowhereSink : loop::TickSink {
  void Publish(const loop::TickOutput& /*output*/, const base::HallScan& /*scan*/,
               const loop::TickTimes& /*times*/) noexcept override {}
};

// A tetrahedron whose faces can be extruded, and one that is rigid.
config::AppTable SurfaceApps(const test::TempFolder& folder) {
  scene::test::Model rigid = scene::test::Tetra();
  scene::test::Model clay = scene::test::Tetra();
  clay.json["materials"][0]["extras"]["haptic"] = {{"extrude", true}};
  config::AppTable table;
  table.entries.push_back(
      {.application_glob = "clay*", .scene = folder.Write("clay.glb", clay.Bytes()), .touch = config::Touch::kAll});
  table.entries.push_back(
      {.application_glob = "rigid*", .scene = folder.Write("rigid.glb", rigid.Bytes()), .touch = config::Touch::kAll});
  return table;
}

// Service, server, loop, an application with a scene and a monitor that draws: everything but the device is real.
class SurfacesOverTheSocket : public testing::Test {
 protected:
  SurfacesOverTheSocket()
      : source_(device_),
        service_({.version = "test", .instance = 5, .apps = SurfaceApps(temp_), .hull_radius_m = 0.0375}) {
    publisher_ = std::move(ipc::StatePublisher::Create(5).value());
    server_ = std::move(
        ipc::Server::Open(
            {.socket_path = temp_.Path("omnid.sock"), .service_instance = 5, .state_fd = publisher_->fd()}, service_)
            .value());
    service_.SetServer(server_.get());
    server_->Start();
    loop_ = std::make_unique<loop::TickThread>(loop::MakeTickConfig(config::DefaultDevice()),
                                               loop::TickThread::Options{.realtime = false}, source_, sink_);
    loop_->Start();
    service_.device().Attach(*loop_, device_);
  }
  ~SurfacesOverTheSocket() override {
    service_.device().Detach("the test is over");
    server_->Stop();
  }
  std::unique_ptr<client::Connection> Connect(const std::string& application, protocol::ClientRole role) {
    return std::make_unique<client::Connection>(client::ConnectionInfo{
        .role = role, .application = application, .engine = "", .socket_path = temp_.Path("omnid.sock")});
  }
  // Polls all until it holds, for at most 20 s.
  template <class Condition>
  static bool Until(std::initializer_list<client::Connection*> connections, const Condition& holds) {
    for (int i = 0; i < 10'000; ++i) {
      for (client::Connection* connection : connections) {
        connection->Poll(base::MonotonicNow_ns());
        connection->SignalAlive();
      }
      if (holds()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return false;
  }

  test::TempFolder temp_;
  support::SilentDevice device_;
  TransportTickSource source_;
  NowhereSink sink_;
  Service service_;
  std::unique_ptr<ipc::StatePublisher> publisher_;
  std::unique_ptr<ipc::Server> server_;
  std::unique_ptr<loop::TickThread> loop_;
};

TEST_F(SurfacesOverTheSocket, ClientRequestsReceivesAndCancelsSurfaces) {
  const auto monitor = Connect("drawing", protocol::ClientRole::kMonitor);
  monitor->RequestSurfaces(true);  // before there is a connection: sent once there is one
  ASSERT_TRUE(Until({monitor.get()}, [&] { return monitor->surfaces_answered(); })) << monitor->last_error();
  EXPECT_EQ(monitor->surfaces(), nullptr) << "no scene, nothing to draw";

  const auto clay = Connect("clay 1", protocol::ClientRole::kApplication);
  clay->SendSession(protocol::SessionState::kFocused);
  ASSERT_TRUE(Until({monitor.get(), clay.get()}, [&] { return monitor->surfaces() != nullptr; }));
  const auto first = monitor->surfaces();
  EXPECT_EQ(first->service_instance(), 5U);
  EXPECT_EQ(first->object_count(), 1U);
  EXPECT_EQ(first->object(0).flags, protocol::kSurfaceExtruded);
  SurfaceCopy copy;
  ASSERT_TRUE(Until({monitor.get(), clay.get()}, [&] { return first->Read(0, copy) == SurfaceRead::kTriangles; }));
  EXPECT_EQ(copy.triangles.size(), 4U);
  protocol::SurfacePulse early, later;
  ASSERT_TRUE(first->ReadPulse(early));
  ASSERT_TRUE(Until({monitor.get(), clay.get()},
                    [&] { return first->ReadPulse(later) && later.poll_count >= early.poll_count + 10; }));

  // A repeated request gets the same memory.
  monitor->RequestSurfaces(true);
  ASSERT_TRUE(Until({monitor.get(), clay.get()}, [&] { return monitor->surfaces() != nullptr; }));
  EXPECT_EQ(monitor->surfaces()->memory_generation(), first->memory_generation());

  // A scene that changes nothing.
  const auto rigid = Connect("rigid 1", protocol::ClientRole::kApplication);
  rigid->SendSession(protocol::SessionState::kFocused);
  ASSERT_TRUE(Until({monitor.get(), clay.get(), rigid.get()}, [&] { return monitor->surfaces() == nullptr; }));
  EXPECT_TRUE(monitor->surfaces_answered());

  // Back, in a new memory; what was mapped before can still be read.
  rigid->SendSession(protocol::SessionState::kNone);
  ASSERT_TRUE(Until({monitor.get(), clay.get(), rigid.get()}, [&] { return monitor->surfaces() != nullptr; }));
  EXPECT_GT(monitor->surfaces()->memory_generation(), first->memory_generation());
  EXPECT_NE(first->Read(0, copy), SurfaceRead::kNothing);

  // No request: the writer ends.
  const auto last = monitor->surfaces();
  monitor->RequestSurfaces(false);
  EXPECT_EQ(monitor->surfaces(), nullptr);
  std::uint64_t last_count = 0;
  int still = 0;
  ASSERT_TRUE(Until({monitor.get(), clay.get()}, [&] {
    protocol::SurfacePulse pulse;
    (void)last->ReadPulse(pulse);
    still = pulse.poll_count == last_count ? still + 1 : 0;
    last_count = pulse.poll_count;
    return still > 100;
  }));
  EXPECT_TRUE(monitor->connected() && clay->connected()) << monitor->last_error();
}

}  // namespace test_daemon_surfaces
}  // namespace omni::daemon
