#include "tests/layer/patterns/simulation.h"

#include <cstdio>
#include <utility>

#include "tests/layer/patterns/pattern.h"

namespace omni::test::patterns {
namespace {

constexpr XrVector3f kTip_base_m{0.02f, 0.03f, 0.06f};
constexpr float kGripBehindTip_m = 0.05f;
constexpr float kLocalOverStage_m = 1.6f;
constexpr float kController_m[2][7] = {{-0.2f, 1.3f, -0.4f, 0, 0, 0, 1}, {0.25f, 1.2f, -0.35f, 0, 0, 0, 1}};
// The new origin of LOCAL in the old one: moved, and turned by 90 degrees to the left.
constexpr float kRecentred[7] = {0.3f, -0.1f, -0.2f, 0, 0.70710678f, 0, 0.70710678f};

std::string UserPath(int hand) { return std::string("/user/hand/") + kSides[hand]; }

}  // namespace

Simulation::Simulation(const char* controllers, std::string preferred)
    : controllers_(controllers), preferred_(std::move(preferred)) {
  omni_test_reset();
}

void Simulation::Enter(const World& world) {
  if (world.recentred && !world_.recentred) omni_test_recenter(kRecentred, 0);
  for (const int hand : {kLeftHand, kRightHand}) {
    omni_test_set_device(kSides[hand], world.controller[static_cast<std::size_t>(hand)], controllers_);
    for (const char* pose : {"/input/grip/pose", "/input/aim/pose"})
      omni_test_set_pose((UserPath(hand) + pose).c_str(), kController_m[hand], nullptr);
  }
  omni_test_set_focus(world.focused);
  EnterService(world);
  world_ = world;
}

void Simulation::EnterService(const World& world) {
  if (!world.service) {
    past_ = pen_vibrations();
    service_.reset();
    return;
  }
  if (!service_) {
    service_ = std::make_unique<FakeService>();
    service_->SetTrajectory([](protocol::ToolSample& sample) {
      sample.position_base_m = {kTip_base_m.x, kTip_base_m.y, kTip_base_m.z};
    });
    hand_ = -1;
  }
  if (hand_ != world.hand) {
    protocol::AppSettings settings;
    settings.hand = world.hand == kLeftHand ? protocol::HandSetting::kLeft : protocol::HandSetting::kRight;
    std::snprintf(settings.profile, sizeof(settings.profile), "%s", preferred_.c_str());
    service_->Wish(settings);
    hand_ = world.hand;
  }
  const bool pose = world.pen != PenState::kAway, tracked = pose && world.pen != PenState::kLost;
  service_->SetFlags((pose ? protocol::kToolPoseValid : 0u) | (tracked ? protocol::kToolTracked : 0u));
  service_->Set(protocol::InputIndex::kDocked, world.pen == PenState::kDocked ? 1.0f : 0.0f);
}

Who Simulation::Truth(int hand) const {
  if (!world_.focused) return Who::kNobody;
  const bool put_down = world_.pen == PenState::kDocked || world_.pen == PenState::kLost;
  const bool pen = world_.service && world_.pen != PenState::kAway && !(put_down && HasController(hand));
  if (pen && world_.hand == hand) return Who::kPen;
  return HasController(hand) ? Who::kController : Who::kNobody;
}

XrVector3f Simulation::PlaceBefore(Who who, int hand, XrReferenceSpaceType base, bool tip) const {
  XrVector3f p{kController_m[hand][0], kController_m[hand][1] - kLocalOverStage_m, kController_m[hand][2]};
  // The base's +z points up, its +y away from the user: (x, y, z) is (x, z, -y) in LOCAL, from the base's place on.
  if (who == Who::kPen)
    p = {kTip_base_m.x, kTip_base_m.z - 0.35f + (tip ? 0 : kGripBehindTip_m), -kTip_base_m.y - 0.45f};
  if (base == XR_REFERENCE_SPACE_TYPE_STAGE) p.y += kLocalOverStage_m;
  return p;
}

XrVector3f Simulation::Place(Who who, int hand, XrReferenceSpaceType base, bool tip) const {
  const XrVector3f p = PlaceBefore(who, hand, base, tip);
  if (base == XR_REFERENCE_SPACE_TYPE_STAGE || !world_.recentred) return p;
  const XrVector3f d{p.x - kRecentred[0], p.y - kRecentred[1], p.z - kRecentred[2]};
  return {-d.z, d.y, d.x};  // turned back by 90 degrees about y
}

void Simulation::PressPen(bool pressed) {
  if (!service_) return;
  service_->Set(protocol::InputIndex::kTipForce, pressed ? 0.9f : 0.0f);
  service_->Set(protocol::InputIndex::kSelect, pressed ? 1.0f : 0.0f);
}

// Those that its profile has take effect.
void Simulation::PressController(int hand, bool pressed) const {
  omni_test_set_float((UserPath(hand) + "/input/trigger/value").c_str(), pressed ? 1.0f : 0.0f);
  for (const char* click : {"/input/trigger/click", "/input/select/click"})
    omni_test_set_bool((UserPath(hand) + click).c_str(), pressed);
}

std::size_t Simulation::pen_vibrations() const { return past_ + (service_ ? service_->heard().haptics.size() : 0); }

void Simulation::Fill() const {
  if (service_) service_->Fill();
}

}  // namespace omni::test::patterns
