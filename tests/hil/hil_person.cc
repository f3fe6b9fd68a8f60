// hil_person SAID HAND: a person who goes through `omni setup` at the simulated base (omni_hil --hand HAND -- PROGRAM
// that writes its output to SAID -- hil_person SAID HAND): reads what the command says, and moves the pen as it asks.
#include <chrono>
#include <cstdio>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "service/base/clock.h"
#include "service/client/dial.h"
#include "service/config/files/device_file.h"
#include "service/tools/calibrate/calibrate_twin.h"
#include "tests/support/process/child_process.h"

namespace omni::hil {
namespace {

constexpr std::chrono::milliseconds kLook{20};
constexpr double kUnhurried = 1.5;  // the simulated arm is slower than the script of a calibration

// What is said, and what the person then does: a scene is touched; null: the pen is waved and touches the hull.
struct Cue {
  const char* said;
  const char* scene;
};
constexpr Cue kCues[] = {{"Calibrate the base (", nullptr},
                         {"Press the tip onto the clay", "extrusion"},
                         {"Now clay", "extrusion"},
                         {"Now a soft dragon", "dragon"},
                         {"Now a car", "racetrack"}};

// Between two waypoints of a script on a straight line.
class Playing {
 public:
  explicit Playing(sim::HandScript script) : script_(std::move(script)), begin_ns_(base::MonotonicNow_ns()) {}

  protocol::HandAim Now() const {
    double left_s = static_cast<double>(base::MonotonicNow_ns() - begin_ns_) * 1e-9 / kUnhurried;
    for (std::size_t i = 1; i < script_.waypoints.size(); ++i) {
      const sim::HandWaypoint &from = script_.waypoints[i - 1], &to = script_.waypoints[i];
      if (left_s >= to.duration_s) {
        left_s -= to.duration_s;
        continue;
      }
      const double u = left_s / to.duration_s;
      return AimOf((1 - u) * from.tip_base_m + u * to.tip_base_m, to);
    }
    return AimOf(script_.waypoints.back().tip_base_m, script_.waypoints.back());
  }

 private:
  static protocol::HandAim AimOf(const base::Vec3& tip, const sim::HandWaypoint& to) {
    return {.present = to.present ? 1U : 0U,
            .tip_base_m = {tip.x, tip.y, tip.z},
            .axis_base = {to.axis_base.x, to.axis_base.y, to.axis_base.z}};
  }

  sim::HandScript script_;
  std::int64_t begin_ns_;
};

// The first cue in what was said after `begin`, and where its words end.
struct Heard {
  const Cue* cue;
  std::size_t end;
};
std::optional<Heard> Listen(const std::string& said, std::size_t begin) {
  std::optional<Heard> first;
  for (const Cue& cue : kCues) {
    const std::size_t at = said.find(cue.said, begin);
    if (at != std::string::npos && (!first || at < first->end)) first = {&cue, at + std::string(cue.said).size()};
  }
  return first;
}

// Brings the pen over the base, and then leaves it to `omni twin hand`, which waits until it sees one.
class Touching {
 public:
  Touching(const char* scene, std::string hand) : scene_(scene), hand_(std::move(hand)), link_(hand_) {}

  void Step(const std::string& log) {
    if (child_) return;
    if (link_ && link_->Connect()) link_->Send({.tip_base_m = {0, 0, kBring_m}});
    if (base::MonotonicNow_ns() - begin_ns_ < kBring_ns) return;
    link_.reset();
    auto child = test::ChildProcess::Start(
        {std::string(OMNI_BINARY_DIR) + "/bin/omni", "twin", "hand", scene_, "--hand", hand_}, {}, log);
    if (child.ok()) child_.emplace(std::move(*child));
  }

 private:
  static constexpr double kBring_m = 0.09;
  static constexpr std::int64_t kBring_ns = 1'500'000'000;

  const char* scene_;
  std::string hand_;
  std::optional<client::HandLink> link_;
  std::int64_t begin_ns_ = base::MonotonicNow_ns();
  std::optional<test::ChildProcess> child_;  // ended with this object
};

int Main(const std::string& file, const std::string& hand) {
  std::optional<client::HandLink> link;
  std::optional<Playing> playing;
  std::unique_ptr<Touching> touching;
  std::size_t read = 0;
  for (;; std::this_thread::sleep_for(kLook)) {  // until omni_hil ends us
    std::ifstream in(file);
    const std::string said(std::istreambuf_iterator<char>(in), {});
    if (const std::optional<Heard> heard = Listen(said, read)) {
      read = heard->end;
      playing.reset();
      link.reset();
      touching.reset();
      if (heard->cue->scene == nullptr) {
        link.emplace(hand);
        playing.emplace(tools::MakeCalibratingHand(config::DefaultDevice(), {}));
      } else {
        touching = std::make_unique<Touching>(heard->cue->scene, hand);
      }
    }
    if (playing && link->Connect()) link->Send(playing->Now());
    if (touching) touching->Step(file + ".hand");
  }
}

}  // namespace
}  // namespace omni::hil

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: hil_person SAID HAND\n");
    return 2;
  }
  return omni::hil::Main(argv[1], argv[2]);
}
