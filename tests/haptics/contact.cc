// Contact scenarios of a point tip.
#include <gtest/gtest.h>

#include <limits>

#include "service/haptics/contact/effects.h"
#include "service/haptics/scene/scene.h"
#include "tests/haptics/scenario.h"
#include "tests/support/same_bits.h"

namespace omni::haptics {
namespace test_haptics_contact {

Material Hard(double stiffness_N_m = 400) {
  Material m;
  m.stiffness_N_m = stiffness_N_m;
  m.static_friction = m.dynamic_friction = 0;
  return m;
}

Scene HardBlock(const Material& m = Hard()) { return Built(SceneOf(Block(4, {0.02, 0.02, 0.02}), m)); }

TEST(Contact, PressingGivesHookesLaw) {
  Pen pen(HardBlock());
  pen.Slide({0.001, 0.002, 0.022}, {0.001, 0.002, 0.018}, 100);
  pen.Rest(5);
  EXPECT_NEAR(pen.output.force_base_N.z, 0.8, 1e-9);
  EXPECT_NEAR(pen.output.force_base_N.x, 0, 1e-12);
  ASSERT_EQ(pen.output.contact_count, 1);
  EXPECT_NEAR(pen.output.contacts[0].gap_m, -0.002, 1e-12);
  EXPECT_NEAR(pen.output.contacts[0].point_base_m.z, 0.02, 1e-12);
  EXPECT_NEAR(pen.output.tip_normal_force_N, 0.8, 1e-9);
  EXPECT_TRUE(pen.output.in_contact);
  EXPECT_EQ(pen.output.stiffness_cut, 1);
}

TEST(Contact, DampingResistsButNeverPulls) {
  Material m = Hard();
  m.damping_Ns_m = 0.9;
  Pen pen(HardBlock(m));
  pen.Slide({0, 0, 0.021}, {0, 0, 0.019}, 40);  // 0.05 m/s inwards
  EXPECT_NEAR(pen.output.tip_normal_force_N, 400 * 0.001 + 0.9 * 0.05, 1e-9);
  for (int k = 0; k < 40; ++k) {
    pen.MoveTo({0, 0, 0.019 + 2.5e-5 * 40 * (k + 1)});  // 1 m/s outwards
    EXPECT_GE(pen.output.tip_normal_force_N, 0);
    EXPECT_GE(pen.output.force_base_N.z, 0);
  }
}

TEST(Contact, CoincidentObjectsShareTheStiffnessBound) {
  SceneInput input = SceneOf(Block(2, {0.02, 0.02, 0.02}), Hard(1000));
  input.objects.push_back(Block(2, {0.02, 0.02, 0.02}));  // the same place twice
  Pen pen(Built(input));
  pen.Slide({0, 0, 0.021}, {0, 0, 0.0195}, 50);
  pen.Rest(5);
  EXPECT_EQ(pen.output.contact_count, 2);
  EXPECT_NEAR(pen.output.tip_normal_force_N, 1000 * 0.0005, 1e-9);
}

TEST(Contact, CornerOfTwoObjectsPushesAlongBothNormals) {
  SceneInput input = SceneOf(Block(2, {0.02, 0.02, 0.005}, {0, 0, -0.005}), Hard());
  input.objects.push_back(Block(2, {0.005, 0.02, 0.02}, {0.015, 0, 0.01}));
  Pen pen(Built(input));
  pen.Slide({0.005, 0, 0.005}, {0.011, 0, -0.001}, 100);
  pen.Rest(5);
  EXPECT_EQ(pen.output.contact_count, 2);
  EXPECT_NEAR(pen.output.force_base_N.x, -0.4, 1e-9);
  EXPECT_NEAR(pen.output.force_base_N.z, 0.4, 1e-9);
}

// Two closed parts; and two that have edges in common, where neither is closed: one contact holds the tip off both.
TEST(Contact, OverlappingPartsOfOneObjectActTogether) {
  for (const bool shared : {false, true}) {
    InputObject both = Block(2, {0.02, 0.02, 0.005}, {0, 0, -0.005});
    const InputObject wall = Block(2, {0.005, shared ? 0.02 : 0.019, 0.02}, {0.015, 0, 0.01});
    const auto base = static_cast<std::uint32_t>(both.vertices_base_m.size());
    both.vertices_base_m.insert(both.vertices_base_m.end(), wall.vertices_base_m.begin(), wall.vertices_base_m.end());
    for (const auto& t : wall.triangles) AddTriangle(both, base + t[0], base + t[1], base + t[2]);
    Pen pen(Built(SceneOf(both, Hard())));
    pen.Slide({0.005, 0, 0.001}, {0.005, 0, -0.001}, 50);
    EXPECT_EQ(pen.output.contact_count, 1);
    pen.Slide({0.005, 0, -0.001}, {0.011, 0, -0.001}, 50);
    pen.Rest(5);
    EXPECT_EQ(pen.output.contact_count, shared ? 1 : 2);
    EXPECT_NEAR(pen.output.force_base_N.x, -0.4, shared ? 0.01 : 1e-9);
    EXPECT_NEAR(pen.output.force_base_N.z, 0.4, shared ? 0.01 : 1e-9);
  }
}

// 0.5 mm plate, pressed through by far in one go: the pen is pushed back to where it came from.
TEST(Contact, ThinPlateKeepsTheSideOfEntry) {
  for (const double speed_m_s : {1.0, 5.0, 20.0}) {
    for (const double side : {1.0, -1.0}) {
      Pen pen(Built(SceneOf(Block(8, {0.03, 0.03, 0.00025}), Hard())));
      const Vec3 from{0.0011, 0.0023, side * 0.0137};
      pen.MoveTo(from);
      double z = from.z;
      while (side * z > -0.010) {
        z -= side * speed_m_s * 1e-3;
        pen.MoveTo({from.x, from.y, z});
      }
      pen.Rest(20);
      EXPECT_EQ(pen.output.contact_count, 1) << speed_m_s;
      EXPECT_GT(side * pen.output.force_base_N.z, 0.1) << speed_m_s;
    }
  }
}

TEST(Contact, PenPushedRightThroughAnObjectIsReleased) {
  InputObject shell = Block(4, {0.02, 0.02, 0.003});
  shell.triangles.resize(shell.triangles.size() - 4);  // a hole: open, hence touched from both sides
  shell.triangle_material.resize(shell.triangles.size());
  for (const InputObject& object : {Block(4, {0.02, 0.02, 0.003}), shell}) {
    Pen pen(Built(SceneOf(object, Hard())));
    pen.Slide({0, 0, 0.03}, {0, 0, -0.005}, 300);
    pen.Rest(300);
    EXPECT_GT(pen.output.force_base_N.z, 1) << "8 mm behind the face of entry: held";
    pen.Slide({0, 0, -0.005}, {0, 0, -0.035}, 300);
    pen.Rest(300);
    EXPECT_EQ(pen.output.contact_count, 0);
    EXPECT_EQ(Norm(pen.output.force_base_N), 0);
    pen.Slide({0, 0, -0.035}, {0.03, 0, -0.035}, 50);
    pen.Slide({0.03, 0, -0.035}, {0.03, 0, 0.03}, 100);
    pen.Slide({0.03, 0, 0.03}, {0, 0, 0.03}, 50);
    pen.Slide({0, 0, 0.03}, {0, 0, -0.005}, 200);
    EXPECT_GT(pen.output.force_base_N.z, 1) << "in contact again";
  }
}

TEST(Contact, PenDeepInsideASolidIsNotReleased) {
  Pen pen(Built(SceneOf(Block(4, {0.04, 0.04, 0.04}), Hard(50))));
  pen.Slide({0, 0, 0.05}, {0, 0, 0.018}, 300);
  pen.Rest(500);
  EXPECT_GT(pen.output.force_base_N.z, 0.5);
}

// Pressed in from the top, then around the edge along the side, always 3 mm deep: the force follows to the side, and
// never steps. The rule does not depend on triangle size.
TEST(Contact, DeepContactForceFollowsThePenAroundAnEdge) {
  for (const int n : {1, 6, 30}) {
    Pen pen(Built(SceneOf(Block(n, {0.02, 0.02, 0.02}), Hard())));
    pen.Slide({0.01, 0.001, 0.021}, {0.01, 0.001, 0.017}, 100);
    pen.Slide({0.01, 0.001, 0.017}, {0.017, 0.001, 0.017}, 200);
    EXPECT_NEAR(pen.output.force_base_N.z, 1.2, 1e-6) << "as near as the side: still the face it came through";
    Vec3 last = pen.output.force_base_N;
    for (int k = 0; k < 100; ++k) {
      pen.MoveTo({0.017, 0.001, 0.017 - 1e-4 * k});
      EXPECT_LE(Norm(pen.output.force_base_N - last), 0.3) << n;
      last = pen.output.force_base_N;
    }
    pen.Rest(30);
    EXPECT_NEAR(pen.output.force_base_N.x, 1.2, 1e-6) << n;
    EXPECT_NEAR(pen.output.force_base_N.z, 0, 1e-6) << n;
  }
}

TEST(Contact, OpenSheetIsTwoSidedAndEndsAtItsBorder) {
  InputObject sheet;
  sheet.vertices_base_m = {{-0.02, -0.02, 0}, {0.02, -0.02, 0}, {0.02, 0.02, 0}, {-0.02, 0.02, 0}};
  AddTriangle(sheet, 0, 1, 2);
  AddTriangle(sheet, 0, 2, 3);
  for (const double side : {1.0, -1.0}) {
    Pen pen(Built(SceneOf(sheet, Hard())));
    const Vec3 above{0.001, 0.004, side * 0.002}, below{0.001, 0.004, side * -0.002};
    pen.Slide(above, below, 40);
    pen.Rest(5);
    EXPECT_NEAR(pen.output.force_base_N.z, side * 0.8, 1e-9);
    const Vec3 beyond{0.0215, 0.004, side * -0.002};
    pen.Slide(below, beyond, 100);
    EXPECT_EQ(pen.output.contact_count, 0) << "past the border";
    pen.Slide(beyond, below, 100);
    EXPECT_EQ(pen.output.contact_count, 0) << "came in from the other side, behind the sheet";
    pen.Slide(below, above, 40);
    EXPECT_LT(side * pen.output.force_base_N.z, -0.5) << "now the other side is the outside";
  }
}

TEST(Contact, LeavingASheetOnTheEntrySideDoesNotReenterFromBehind) {
  InputObject sheet;
  sheet.vertices_base_m = {{-0.02, -0.02, 0}, {0.02, -0.02, 0}, {0.02, 0.02, 0}, {-0.02, 0.02, 0}};
  AddTriangle(sheet, 0, 1, 2);
  AddTriangle(sheet, 0, 2, 3);
  Pen pen(Built(SceneOf(sheet, Hard())));
  pen.Slide({0, 0.001, 0.001}, {0, 0.001, -0.0010003}, 30);
  double z = -0.0010003;
  while (z < 0.003) {
    z += 3.1e-7;
    pen.MoveTo({0, 0.001, z});
    ASSERT_EQ(pen.output.contact_count, z > 0 ? 0 : 1) << z;
  }
}

// A floor that rises in a step, with so many triangles that the proxy needs more than a tick to follow. On its way the
// tip is in front of the floor but within the step: it must not be lost.
TEST(Contact, ContactIsKeptWhileTheProxyLagsBehind) {
  constexpr double kReach_m = 0.02;
  const InputObject step = CubeGrid(110, [](const Vec3& p) {
    const Vec3 bottom{kReach_m * p.x, kReach_m * p.y, -kReach_m};
    Vec3 top{0, kReach_m * p.y, 0};
    if (p.x <= 0.8) {
      top.x = kReach_m * (p.x + 1) / 1.8 - kReach_m;
    } else if (p.x <= 0.9) {
      top.z = kReach_m * (p.x - 0.8) / 0.1;
    } else {
      top.x = kReach_m * (p.x - 0.9) / 0.1;
      top.z = kReach_m;
    }
    return bottom + (0.5 * (p.z + 1)) * (top - bottom);
  });
  Pen pen(Built(SceneOf(step, Hard())));
  ASSERT_NE(pen.scene().objects()[0].flags & kClosed, 0U);
  pen.Slide({-0.015, 0.0011, 0.001}, {-0.015, 0.0011, -0.008}, 100);
  pen.MoveTo({0.003, 0.0011, 0.0005});
  EXPECT_EQ(pen.output.contact_count, 1);
  pen.Rest(5);
  ASSERT_EQ(pen.output.contact_count, 1);
  EXPECT_LT(pen.output.force_base_N.x, -0.5) << "the riser pushes back";
}

TEST(Contact, ForceFadesInWhenThePenStartsInside) {
  Pen pen(HardBlock());
  pen.config.ramp_s = 0.15;
  double last_N = 0;
  for (int k = 0; k < 200; ++k) {
    pen.MoveTo({0, 0, 0.017});
    EXPECT_EQ(pen.output.contact_count, 1);
    EXPECT_GE(pen.output.force_base_N.z, last_N - 1e-12);
    EXPECT_LE(pen.output.force_base_N.z - last_N, 1.2 / 150 * 1.0001);
    last_N = pen.output.force_base_N.z;
  }
  EXPECT_NEAR(last_N, 400 * 0.003, 1e-9);
}

TEST(Contact, TrackingLossSceneSwapAndTeleportDoNotStepTheForce) {
  Pen pen(HardBlock());
  pen.config.ramp_s = 0.15;
  Vec3 last;
  const auto check = [&](const char* what) {
    EXPECT_LE(Norm(pen.output.force_base_N - last), 0.85 * 1.000001) << what;
    last = pen.output.force_base_N;
  };
  const auto press = [&] {
    pen.Slide({0, 0, 0.025}, {0, 0, 0.0165}, 300);
    last = pen.output.force_base_N;
    EXPECT_GT(Norm(last), 1.2);
  };
  press();
  pen.Lose(), check("lost");
  EXPECT_EQ(pen.output.contact_count, 0);
  EXPECT_GT(Norm(pen.output.force_base_N), 0.3) << "fades, does not drop";
  pen.input.limit.valid = false;
  pen.Lose(), check("lost, no limit known");
  pen.Lose(), check("lost");
  EXPECT_EQ(Norm(pen.output.force_base_N), 0);
  pen.input.limit.valid = true;
  pen.MoveTo({0, 0, 0.0165}), check("found again inside");
  EXPECT_LT(Norm(pen.output.force_base_N), 0.02);
  pen.Rest(300);
  last = pen.output.force_base_N;
  pen.Swap(Scene());
  pen.MoveTo({0, 0, 0.0165}), check("empty scene");
  EXPECT_GT(Norm(pen.output.force_base_N), 0.3);
  pen.Swap(HardBlock());
  press();
  pen.MoveTo({0.3, 0.1, 0.2}), check("teleport out");
  pen.MoveTo({0, 0, 0.0165}), check("teleport in");
  pen.MoveTo({0, 0, -0.0165}), check("teleport across");
}

// An image over the top of a block: white on the left half, mid-grey on the right.
TEST(Contact, TexturesScaleStiffnessAndFriction) {
  InputObject block = Block(1, {0.02, 0.02, 0.02});
  for (const auto& t : block.triangles) {
    CornerUv uv{};
    for (std::size_t k = 0; k < 3; ++k) {
      uv[2 * k] = static_cast<float>(0.5 + block.vertices_base_m[t[k]].x / 0.04);
      uv[2 * k + 1] = 0.5F;
    }
    block.uv[0].push_back(uv);
  }
  Material m;
  m.stiffness_N_m = 400;
  m.static_friction = m.dynamic_friction = 0.5;
  m.stiffness_texture = m.friction_texture = 0;
  SceneInput input = SceneOf(block, m);
  input.images.push_back({4, 1, {255, 255, 51, 51}});
  input.textures.push_back({});
  Pen pen(Built(input));
  const auto press = [&](double x) {
    pen.MoveTo({x, 0, 0.021});
    pen.Slide({x, 0, 0.021}, {x, 0, 0.019}, 40);
    const double normal_N = pen.Rest(5).tip_normal_force_N;
    pen.Slide({x, 0, 0.019}, {x, 0.006, 0.019}, 60);
    const double share = pen.output.contacts[0].tangential_force_N / pen.output.contacts[0].normal_force_N;
    pen.Slide({x, 0.006, 0.019}, {x, 0.006, 0.021}, 40);
    return std::pair(normal_N, share);
  };
  const auto white = press(-0.012), grey = press(0.012);
  EXPECT_NEAR(white.first, 0.4, 1e-6);
  EXPECT_NEAR(white.second, 0.5, 1e-6);
  EXPECT_NEAR(grey.first, 0.4 * 51 / 255, 1e-6);
  EXPECT_NEAR(grey.second, 0.5 * 51 / 255, 1e-6);
}

TEST(Contact, NonFiniteOrHugeInputIsNotRendered) {
  Pen pen(HardBlock());
  const double bad[] = {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e300};
  for (const double x : bad) {
    pen.Slide({0, 0, 0.021}, {0, 0, 0.018}, 50);
    pen.MoveTo({x, 0, 0.018});
    EXPECT_TRUE(IsWithin(pen.output.force_base_N, 2));
    EXPECT_EQ(pen.output.contact_count, 0);
    pen.MoveTo({0, 0, 0.03});
    pen.input.noise.position_m2 = x;
    pen.Slide({0, 0, 0.021}, {0, 0, 0.018}, 50);
    EXPECT_LT(Norm(pen.output.force_base_N), 1e-9) << "no stiffness is allowed on unknown noise";
    pen.input.noise.position_m2 = 0;
  }
}

TEST(Contact, WinklerForceIsMonotoneAndSofterThanRigid) {
  Softness soft;
  soft.model = SoftnessModel::kWinkler;
  double last = 0;
  for (int step = 0; step < 3000; ++step) {
    const double depth = 1e-5 * step;
    const double force = ElasticForce(soft, 400, depth);
    EXPECT_GE(force, last);
    EXPECT_LE(force - last, 400 * 1e-5 * 1.0001) << "never stiffer than the bound";
    EXPECT_LE(force, 400 * depth * (1 + 1e-12));
    last = force;
  }
  Softness softer = soft;
  softer.young_modulus_Pa /= 2;
  EXPECT_LT(ElasticForce(softer, 400, 0.003), ElasticForce(soft, 400, 0.003));
  // The layer alone (infinitely stiff spring): F = pi R E_c d^2 / h.
  const double confined = 2e4 * 0.55 / (1.45 * 0.1);
  EXPECT_NEAR(ElasticForce(soft, 1e9, 0.002) / (std::numbers::pi * 0.003 * confined * 4e-6 / 0.01), 1, 1e-3);
}

TEST(Contact, WinklerForceRelaxes) {
  Material rubber = Hard();
  rubber.softness.model = SoftnessModel::kWinkler;
  Pen pen(HardBlock(rubber));
  pen.Slide({0, 0, 0.021}, {0, 0, 0.016}, 20);
  const double at_once_N = pen.output.tip_normal_force_N;
  pen.Rest(1000);
  const double later_N = pen.output.tip_normal_force_N;
  EXPECT_GT(at_once_N, 1.1 * later_N);
  EXPECT_NEAR(later_N, ElasticForce(rubber.softness, 400 / 1.3, 0.004), 1e-4 * later_N);
}

TEST(Contact, PopThroughLastsUntilThePenLeavesTheObject) {
  Material skin = Hard();
  skin.pop_through_N = 0.6;
  Pen pen(HardBlock(skin));
  pen.Slide({0, 0, 0.021}, {0, 0, 0.0186}, 100);
  EXPECT_NEAR(pen.output.tip_normal_force_N, 0.56, 1e-9);
  pen.Slide({0, 0, 0.0186}, {0, 0, 0.015}, 100);
  EXPECT_EQ(pen.output.tip_normal_force_N, 0);
  pen.Slide({0, 0, 0.015}, {0, 0.03, 0}, 100);  // out through a side
  EXPECT_EQ(pen.output.tip_normal_force_N, 0);
  pen.Slide({0, 0.03, 0}, {0, 0.019, 0}, 100);
  EXPECT_NEAR(pen.output.tip_normal_force_N, 0.4, 1e-9);
}

TEST(Contact, MagnetPullsFromOutsideOnlyWithinItsRange) {
  Material magnet = Hard();
  magnet.magnet_max_force_N = 0.3;
  magnet.magnet_range_m = 0.003;
  Pen pen(HardBlock(magnet));
  pen.MoveTo({0, 0, 0.0241});
  pen.Slide({0, 0, 0.0241}, {0, 0, 0.0215}, 50);
  pen.Rest(5);
  EXPECT_NEAR(pen.output.force_base_N.z, -0.3, 1e-6);
  EXPECT_EQ(pen.output.contact_count, 0);
  pen.Slide({0, 0, 0.0215}, {0, 0, 0.024}, 50);
  pen.Rest(5);
  EXPECT_EQ(pen.output.force_base_N.z, 0);
}

TEST(Contact, TextureRipplesWhenSlidingAndVibrationActsAtRest) {
  Material rough = Hard();
  rough.texture_amplitude_m = 1e-4;
  rough.texture_wavelength_m = 2e-3;
  Pen pen(HardBlock(rough));
  pen.Slide({-0.01, 0, 0.021}, {-0.01, 0, 0.019}, 50);
  pen.Rest(5);
  const double still_N = pen.output.force_base_N.z;
  double low = 10, high = 0;
  for (int k = 1; k <= 200; ++k) {  // 50 mm/s over 2 mm waves: 25 Hz
    pen.MoveTo({-0.01 + 5e-5 * k, 0, 0.019});
    low = std::min(low, pen.output.force_base_N.z);
    high = std::max(high, pen.output.force_base_N.z);
  }
  EXPECT_NEAR(still_N, 0.4, 1e-9);
  EXPECT_NEAR(high - low, 2 * 0.04, 0.002);

  Material humming = Hard();
  humming.vibration_amplitude_N = 0.1;
  humming.vibration_frequency_Hz = 50;
  Pen hum(HardBlock(humming));
  hum.Slide({0, 0, 0.021}, {0, 0, 0.019}, 50);
  low = 10, high = 0;
  for (int k = 0; k < 40; ++k) {
    hum.Rest(1);
    low = std::min(low, hum.output.force_base_N.z);
    high = std::max(high, hum.output.force_base_N.z);
  }
  EXPECT_NEAR(high - low, 0.2, 0.005);
}

TEST(Contact, FarPenReusesTheMotionBoundWithoutQueries) {
  Pen pen(HardBlock());
  pen.MoveTo({0, 0, 0.12});
  EXPECT_NEAR(pen.state.far_distance_m, 0.1, 1e-5);
  const Vec3 origin = pen.state.far_origin_base_m;
  pen.Slide({0, 0, 0.12}, {0, 0, 0.03}, 500);
  EXPECT_EQ(pen.state.far_origin_base_m, origin) << "still the first bound";
  pen.Slide({0, 0, 0.03}, {0, 0, 0.019}, 50);
  EXPECT_EQ(pen.output.contact_count, 1);
}

TEST(Contact, EqualInputsGiveEqualBits) {
  Material rubber;
  rubber.softness.model = SoftnessModel::kWinkler;
  rubber.texture_amplitude_m = 1e-4;
  const Scene scene = Built(SceneOf(Sphere(12, 0.02), rubber));
  Pen a(scene), b(scene);
  Random random(3);
  for (int k = 0; k < 3000; ++k) {
    const Vec3 tip = random.Uniform(0.7, 1.2) * 0.02 * Normalized(Vec3{1, 0.3, 0.2} + random.InBox(0.2));
    a.MoveTo(tip);
    b.MoveTo(tip);
    ASSERT_TRUE(support::SameBits(a.output.force_base_N, b.output.force_base_N));
  }
  EXPECT_TRUE(support::SameBits(a.state.contacts[0].proxy_m, b.state.contacts[0].proxy_m));
}

}  // namespace test_haptics_contact
}  // namespace omni::haptics
