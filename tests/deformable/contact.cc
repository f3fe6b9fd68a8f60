// Contact with a soft body: properties of the force for any numbers.
#include <cmath>
#include <limits>
#include <random>

#include "tests/deformable/scenario.h"
#include "tests/support/alloc_probe.h"
#include "tests/support/soft_step.h"

namespace omni::haptics {
namespace test_deformable_contact {

const double kNan = std::numeric_limits<double>::quiet_NaN();

SoftContact OnBall(const Vec3& direction, double depth_m) {
  const Vec3 n = Normalized(direction);
  return {true, 0.03 * n, n, depth_m, 0};
}

double LongTermForce(const SoftContact& contact) {
  SoftContactState state{};
  return support::StepSoftContact(SoftBall().view(), contact, kTip_m, 1e-3, state).elastic_N;
}

TEST(SoftContactModel, DentAndForceAreInverse) {
  for (const double nu : {0.0, 0.3, 0.49}) {
    const LocalModel model{2e5, 0.004, GainOf(nu, 0.5)};
    for (double dent = 1e-6; dent < 0.02; dent *= 1.3) {
      EXPECT_NEAR(LocalDent(model, LocalForce(model, dent)) / dent, 1, 1e-9);
      const double h = 1e-4 * dent;
      const double slope = (LocalForce(model, dent + h) - LocalForce(model, dent - h)) / (2 * h);
      EXPECT_NEAR(LocalSlope(model, dent) / slope, 1, 2e-3) << dent;
    }
  }
  EXPECT_EQ(LocalForce({2e5, 0.004, {}}, kNan), 0);
  EXPECT_EQ(LocalDent({2e5, 0.004, {}}, kNan), 0);
}

TEST(SoftContactModel, SmallDentsFollowHertz) {
  const LocalModel model{2e5 / (1 - 0.16), 0.005, GainOf(0.4, 0)};
  const double dent = 0.005 * 1e-6;
  EXPECT_NEAR(LocalForce(model, dent) / (4.0 / 3 * model.modulus_Pa * std::sqrt(0.005) * std::pow(dent, 1.5)), 1, 1e-3);
}

// Whatever dent the search starts from.
TEST(SoftContactModel, DentDoesNotDependOnTheGuess) {
  const LocalModel model{2e5, 0.004, GainOf(0.4, 0)};
  for (double dent = 1e-6; dent < 0.02; dent *= 1.7) {
    const double force_N = LocalForce(model, dent);
    for (const double guess : {0.0, 1e-9, 0.3 * dent, 0.999 * dent, 1.3 * dent, 1.0, kNan}) {
      EXPECT_NEAR(LocalAtForce(model, force_N, guess).dent_m / dent, 1, 1e-12) << dent << " " << guess;
    }
  }
}

// Firm, soft and overfirm bodies, with and without a spring: the force of a depth is that which goes so deep.
TEST(SoftContactModel, SingleBallForceInvertsItsDepth) {
  std::mt19937_64 rng(31);
  std::uniform_real_distribution<double> any(0, 1);
  for (int trial = 0; trial < 2000; ++trial) {
    const LocalModel model{std::pow(10, 4 + 3 * any(rng)), 0.002 + 0.01 * any(rng), GainOf(0.49 * any(rng), 0)};
    const double flat = 1 / (model.modulus_Pa * model.radius_m);
    const BallCompliance give =
        MakeBallCompliance(model, flat * (any(rng) - 0.4), any(rng) < 0.5 ? 0 : 3 * flat * any(rng));
    const double depth_m = model.radius_m * std::pow(10, -4 * any(rng));
    const double force_N = ForceAlone(give, depth_m, 0);
    EXPECT_GT(force_N, 0);
    EXPECT_NEAR(GiveAtForce(give, force_N, 0).depth_m / depth_m, 1, 1e-8) << trial;
    EXPECT_NEAR(ForceAlone(give, depth_m, depth_m * any(rng)) / force_N, 1, 1e-8) << trial;
    const double h = 1e-4 * force_N;
    const double slope =
        (GiveAtForce(give, force_N + h, 0).depth_m - GiveAtForce(give, force_N - h, 0).depth_m) / (2 * h);
    if (force_N > 1e-4) {
      EXPECT_NEAR(GiveAtForce(give, force_N, 0).slope_m_N / slope, 1, 2e-3) << trial;
    }
  }
  EXPECT_EQ(ForceAlone(MakeBallCompliance({2e5, 0.005, {}}, 0, 0), kNan, 0), 0);
}

TEST(SoftContacts, ForceGrowsWithDepthAndSlopeIsItsDerivative) {
  for (const Vec3& at : {Vec3{0, 0, 1}, Vec3{1, 0.3, 0.2}, Vec3{-0.4, 0.5, 0.6}}) {
    double last_N = 0;
    for (double depth = 1e-4; depth < 6e-3; depth += 1e-4) {
      SoftContactState state{};
      const SoftForce f = support::StepSoftContact(SoftBall().view(), OnBall(at, depth), kTip_m, 1e-3, state);
      EXPECT_GT(f.elastic_N, last_N);
      last_N = f.elastic_N;
      const double h = 1e-6;
      SoftContactState next = state;
      const SoftForce more = support::StepSoftContact(SoftBall().view(), OnBall(at, depth + h), kTip_m, 0, next);
      SoftContactState same = state;
      const SoftForce still = support::StepSoftContact(SoftBall().view(), OnBall(at, depth), kTip_m, 0, same);
      EXPECT_NEAR((more.normal_N - still.normal_N) / h / f.slope_N_m, 1, 0.02);
    }
  }
}

TEST(SoftContacts, SeriesSpringTakesItsShareOfDepth) {
  SoftContact contact = OnBall({0, 0, 1}, 0.003);
  contact.series_compliance_m_N = 1 / 300.0;
  SoftContactState state{};
  const SoftForce f = support::StepSoftContact(SoftBall().view(), contact, kTip_m, 1e-3, state);
  EXPECT_LT(f.slope_N_m, 300 * (1 + 1e-9));
  // The spring carries all of the force; the rest of the depth, with the same relaxing part, gives the same force.
  SoftContactState without{};
  contact.depth_m -= f.normal_N / 300;
  contact.series_compliance_m_N = 0;
  const SoftForce bare = support::StepSoftContact(SoftBall().view(), contact, kTip_m, 1e-3, without);
  EXPECT_NEAR(bare.normal_N / f.normal_N, 1, 1e-5);
}

TEST(SoftContacts, RelaxesToTheLongTermForce) {
  SoftContactState state{};
  const SoftContact contact = OnBall({0, 0, 1}, 0.002);
  const double first_N = support::StepSoftContact(SoftBall().view(), contact, kTip_m, 1e-3, state).normal_N;
  SoftForce last;
  for (int tick = 0; tick < 100; ++tick)
    last = support::StepSoftContact(SoftBall().view(), contact, kTip_m, 1e-3, state);
  const double share = SoftBall().view().header().relaxing_share;
  EXPECT_NEAR(first_N / last.elastic_N, 1 + share, 0.01);
  EXPECT_NEAR(last.normal_N / last.elastic_N, 1 + share * std::exp(-1.01), 0.01);
  for (int tick = 0; tick < 2000; ++tick)
    last = support::StepSoftContact(SoftBall().view(), contact, kTip_m, 1e-3, state);
  EXPECT_NEAR(last.normal_N / last.elastic_N, 1, 1e-6);
}

// A ball at one side rocks the body; one at the other side holds it. A neighbour has already moved the surface away.
TEST(SoftContacts, ContactsInteractThroughTheBody) {
  const double alone_N = LongTermForce(OnBall({0.7, 0, 0.7}, 0.002));
  const auto with = [&](const Vec3& other) {
    SoftContactState state{};
    const SoftContact contacts[2] = {OnBall({0.7, 0, 0.7}, 0.002), OnBall(other, 0.002)};
    SoftForce forces[2];
    StepSoftContacts(SoftBall().view(), contacts, kTip_m, 1e-3, state, forces);
    return forces[0].elastic_N;
  };
  EXPECT_GT(with({-0.7, 0, 0.7}), 1.1 * alone_N);
  EXPECT_LT(with({0.7, 0.35, 0.7}), 0.97 * alone_N);
}

TEST(SoftContacts, WarmStartMatchesColdSolveForSixteenBalls) {
  std::mt19937_64 rng(8);
  std::normal_distribution<double> normal;
  const SoftBodyView body = SoftBall().view();
  SoftContactState warm{};
  std::array<Vec3, 16> at;
  for (Vec3& v : at) v = base::Normalized({normal(rng), normal(rng), 0.5 + std::abs(normal(rng))});
  for (int tick = 0; tick < 400; ++tick) {
    std::array<SoftContact, 16> contacts;
    for (std::size_t k = 0; k < 16; ++k) {
      at[k] = Normalized(at[k] + 0.002 * Vec3{normal(rng), normal(rng), normal(rng)});
      contacts[k] = OnBall(at[k], 0.0015 + 0.0015 * std::sin(0.02 * tick + static_cast<double>(k)));
    }
    std::array<SoftForce, 16> forces;
    StepSoftContacts(body, contacts, kTip_m, 1e-3, warm, forces);
    SoftContactState cold{};
    std::array<SoftForce, 16> fresh;
    StepSoftContacts(body, contacts, kTip_m, 1e-3, cold, fresh);
    for (std::size_t k = 0; k < 16; ++k) {
      EXPECT_GE(forces[k].elastic_N, 0);
      EXPECT_NEAR(forces[k].elastic_N, fresh[k].elastic_N, 0.004) << tick << " " << k;
    }
  }
}

TEST(SoftContacts, InvalidContactsGiveNoForce) {
  const SoftBodyView body = SoftBall().view();
  SoftContactState state{};
  const SoftContact good = OnBall({0, 0, 1}, 0.002);
  std::vector<SoftContact> bad(8, good);
  bad[0].depth_m = kNan;
  bad[1].point_base_m.y = kNan;
  bad[2].normal.x = kNan;
  bad[3].series_compliance_m_N = kNan;
  bad[4].depth_m = std::numeric_limits<double>::infinity();
  bad[5].depth_m = -0.001;
  bad[6].touching = false;
  bad[7].point_base_m.z = 1e30;
  for (const SoftContact& contact : bad) {
    support::StepSoftContact(body, good, kTip_m, 1e-3, state);
    EXPECT_EQ(support::StepSoftContact(body, contact, kTip_m, 1e-3, state).normal_N, 0);
  }
  for (const double dt : {kNan, -1.0, 1e9}) {
    EXPECT_TRUE(std::isfinite(support::StepSoftContact(body, good, kTip_m, dt, state).normal_N));
  }
  EXPECT_EQ(support::StepSoftContact(body, good, kNan, 1e-3, state).normal_N, 0);
  EXPECT_TRUE(std::isfinite(support::StepSoftContact(body, OnBall({0, 0, 1}, 100), kTip_m, 1e-3, state).normal_N));
}

TEST(SoftContacts, NothingIsAllocatedInATick) {
  const SoftBodyView body = SoftBall().view();
  SoftContactState state{};
  std::array<SoftContact, 16> contacts;
  std::array<SoftForce, 16> forces;
  const loop::AllocProbe probe;
  for (int tick = 0; tick < 200; ++tick) {
    for (std::size_t k = 0; k < 16; ++k) {
      const double angle = 0.4 * static_cast<double>(k) + 0.01 * tick;
      contacts[k] = OnBall({std::cos(angle), std::sin(angle), 0.8}, 0.001 + 0.002 * std::sin(0.1 * tick));
    }
    StepSoftContacts(body, contacts, kTip_m, 1e-3, state, forces);
    SoftDisplacement(body, state, contacts[3].point_base_m);
  }
  EXPECT_EQ(probe.count(), 0U);
}

TEST(SoftContacts, EqualInputsGiveEqualBits) {
  const auto run = [] {
    SoftContactState state{};
    std::vector<double> forces;
    for (int tick = 0; tick < 300; ++tick) {
      const double angle = 0.02 * tick;
      const SoftContact two[2] = {OnBall({std::cos(angle), std::sin(angle), 1}, 0.002), OnBall({-1, 0, 1}, 0.001)};
      SoftForce force[2];
      StepSoftContacts(SoftBall().view(), std::span(two, tick % 3 == 0 ? 1 : 2), kTip_m, 1e-3, state,
                       std::span(force, tick % 3 == 0 ? 1 : 2));
      forces.push_back(force[0].normal_N);
    }
    return forces;
  };
  EXPECT_EQ(run(), run());
}

// Where the ball is, the surface goes in by its depth; the rest of it moves less and without steps.
TEST(SoftSurface, DisplacementFollowsTheBall) {
  const SoftBodyView body = SoftBall().view();
  SoftContactState state{};
  const SoftContact contact = OnBall({0.2, -0.1, 1}, 0.002);
  const SoftForce force = support::StepSoftContact(body, contact, kTip_m, 1e-3, state);
  const Vec3 under = SoftDisplacement(body, state, contact.point_base_m);
  EXPECT_NEAR(-Dot(under, contact.normal) / contact.depth_m, 1, 0.01);
  const Vec3 carried = CarriedDisplacement(body, state, contact.point_base_m);
  EXPECT_NEAR(-Dot(carried, contact.normal), contact.depth_m - force.dent_m, 0.01 * contact.depth_m);
  const InputObject mesh = SoftBallMesh();
  std::vector<Float3> drawn(mesh.vertices_base_m.size());
  ASSERT_TRUE(SurfaceDisplacement(body, state, mesh.vertices_base_m, drawn));
  for (std::size_t v = 0; v < drawn.size(); ++v) {
    const Vec3 u{drawn[v].x, drawn[v].y, drawn[v].z};
    EXPECT_LT(Norm(u), 1.1 * contact.depth_m);
    EXPECT_LT(Norm(u - SoftDisplacement(body, state, mesh.vertices_base_m[v])), 1e-5);
    if (mesh.vertices_base_m[v].z < -0.0295) {  // the clamped base
      EXPECT_LT(Norm(u), 1e-4);
    }
  }
  EXPECT_FALSE(SurfaceDisplacement(body, state, mesh.vertices_base_m, std::span(drawn).first(5)));
}

TEST(SoftSurface, LocateFindsTheNearestPointFromAnyHint) {
  const SoftBodyView body = SoftBall().view();
  std::mt19937_64 rng(9);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 500; ++trial) {
    const Vec3 p = 0.03 * base::Normalized({normal(rng), normal(rng), normal(rng)});
    const SoftPlace cold = LocateOnSoftBody(body, p, kNoSoftTriangle);
    const SoftPlace hinted =
        LocateOnSoftBody(body, p, static_cast<std::uint32_t>(rng() % body.header().triangle_count));
    const auto at = [&](const SoftPlace& place) {
      Vec3 sum;
      for (int k = 0; k < 3; ++k) {
        const Float3 x = body.Node(body.GetTriangle(place.triangle).node[k]).position_base_m;
        sum = sum + place.weights[k] * Vec3{x.x, x.y, x.z};
      }
      return sum;
    };
    EXPECT_LT(Norm(at(cold) - p), 0.002);
    EXPECT_NEAR(Norm(at(cold) - p), Norm(at(hinted) - p), 1e-4);
  }
  EXPECT_EQ(LocateOnSoftBody(body, {kNan, 0, 0}, kNoSoftTriangle).triangle, 0U);
}

}  // namespace test_deformable_contact
}  // namespace omni::haptics
