// A base that is turned or carried: the field about it is another one, and its alignments are doubtful.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include <nlohmann/json.hpp>

#include "service/base/vec.h"
#include "service/daemon/service.h"
#include "tests/daemon/base_pose_scenario.h"

namespace omni::daemon {
namespace test_daemon_base_moved {

using base::Vec3;

constexpr Vec3 kField_T{20e-6, 0, -42e-6};  // at 47 degrees north

// As a base sees it that was turned about the vertical.
Vec3 Turned(double angle_rad) {
  return {std::cos(angle_rad) * kField_T.x, -std::sin(angle_rad) * kField_T.x, kField_T.z};
}

struct Room {
  TempFolder temp;
  std::string path = temp.Path("a.toml");
  BasePoses base_poses{path};
  Listener listener;

  Room() {
    base_poses.HandleRequest(1, Request({kSpaceLocal}), kDate_s);
    Align();
    Feel(kField_T, 2 * BasePoses::kSteady_s);
  }
  void Align() { EXPECT_TRUE(base_poses.Execute(Store(kSpaceLocal), kDate_s).ok); }
  void Feel(const Vec3& field_T, int seconds) {
    for (int i = 0; i < seconds; ++i) base_poses.UpdateField(field_T);
  }
  const config::AlignmentEntry& entry() const { return base_poses.file().entries[0]; }
};

TEST(DaemonBaseMoved, TurnedBaseMakesItsAlignmentDoubtful) {
  constexpr double kDegree = 0.017453292519943295;
  Room room;
  room.Feel(Turned(60 * kDegree), BasePoses::kMoved_s - 1);
  EXPECT_TRUE(room.base_poses.IsAligned(1));
  room.Feel(Turned(60 * kDegree), 1);
  EXPECT_FALSE(room.base_poses.IsAligned(1));
  room.listener.Listen(room.base_poses);
  EXPECT_EQ(room.listener.reported[1].back().doubtful, 1U) << "applications clear TRACKED";
  BasePoses again(room.path);
  again.HandleRequest(1, Request({kSpaceLocal}), kDate_s);
  EXPECT_FALSE(again.IsAligned(1)) << "also after a restart";
  // By eye it is put back to within some degrees: not near enough.
  room.Feel(Turned(6 * kDegree), 60);
  EXPECT_FALSE(room.base_poses.IsAligned(1));
  room.Feel(Turned(2 * kDegree), BasePoses::kMoved_s);
  EXPECT_TRUE(room.base_poses.IsAligned(1));
  room.listener.Listen(room.base_poses);
  EXPECT_EQ(room.listener.reported[1].back().doubtful, 0U);
}

TEST(DaemonBaseMoved, OrdinaryUseChangesNothing) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Room room;
    std::mt19937_64 random(seed);
    std::normal_distribution<double> noise_T(0, 2e-6);
    std::uniform_real_distribution<double> laid_T(-6e-6, 6e-6);
    Vec3 desk_T;
    for (int s = 0; s < 3600; ++s) {
      if (s % 300 == 0) desk_T = {laid_T(random), laid_T(random), laid_T(random)};  // a laptop, a cup, a drawer
      room.base_poses.UpdateField(kField_T + desk_T + Vec3{noise_T(random), noise_T(random), noise_T(random)});
      ASSERT_TRUE(room.base_poses.IsAligned(1)) << "seed " << seed << ", " << s << " s";
    }
  }
}

// One short disturbance is not a base that was turned.
TEST(DaemonBaseMoved, PassingMagnetChangesNothing) {
  Room room;
  for (int i = 0; i < 50; ++i) {
    room.Feel(kField_T + Vec3{30e-6, 0, 0}, BasePoses::kMoved_s - 1);
    room.Feel(kField_T, 1);
  }
  EXPECT_TRUE(room.base_poses.IsAligned(1));
}

// While one aligns, a controller with its magnets is near: the field is kept once it has become steady.
TEST(DaemonBaseMoved, KeepsTheFieldOnceItIsSteady) {
  Room room;
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> near_T(-20e-6, 20e-6);
  room.Align();
  EXPECT_FALSE(room.entry().field_base_T.has_value()) << "of the alignment before";
  for (int i = 0; i < 60; ++i)
    room.base_poses.UpdateField(kField_T + Vec3{near_T(random), near_T(random), near_T(random)});
  EXPECT_FALSE(room.entry().field_base_T.has_value());
  room.Feel(kField_T, BasePoses::kSteady_s + 1);
  ASSERT_TRUE(room.entry().field_base_T.has_value());
  EXPECT_LT(base::Distance(*room.entry().field_base_T, kField_T), 1e-9);
}

TEST(DaemonBaseMoved, AligningOrRestoringTrustsItAgain) {
  for (const bool restore : {false, true}) {
    Room room;
    room.Feel(Turned(1), 10);
    ASSERT_FALSE(room.base_poses.IsAligned(1));
    protocol::BasePoseCommand command = Store(kSpaceLocal);
    if (restore) command.action = protocol::BasePoseAction::kRestore;
    ASSERT_TRUE(room.base_poses.Execute(command, kDate_s).ok);
    EXPECT_TRUE(room.base_poses.IsAligned(1));
    room.Feel(Turned(1), 60);
    EXPECT_TRUE(room.base_poses.IsAligned(1)) << "the field of now belongs to it";
    room.Feel(kField_T, 10);
    EXPECT_FALSE(room.base_poses.IsAligned(1));
  }
}

TEST(DaemonBaseMoved, StatusSaysSo) {
  const TempFolder temp;
  Service service({.version = "test", .instance = 1, .hull_radius_m = 0.0375, .alignment_path = temp.Path("a.toml")});
  service.OnRequest(9, Store(kSpaceLocal), {});
  std::int64_t second_ns = 0;
  const auto feel = [&](const Vec3& field_T, int seconds) {
    for (int i = 0; i < seconds; ++i) {
      ++second_ns;
      service.device().With([&](auto& state) { state.field = {.field_base_T = field_T, .second_ns = second_ns}; });
      service.OnPeriod(second_ns);
      service.OnPeriod(second_ns);  // the same second counts once
    }
  };
  const auto moved = [&service] {
    return nlohmann::json::parse(service.StatusJson())["alignments"]["stored"][0]["base_moved"].get<bool>();
  };
  feel(kField_T, BasePoses::kSteady_s + 1);
  feel(Turned(1), BasePoses::kMoved_s - 1);
  EXPECT_FALSE(moved());
  feel(Turned(1), 1);
  EXPECT_TRUE(moved());
}

}  // namespace test_daemon_base_moved
}  // namespace omni::daemon
