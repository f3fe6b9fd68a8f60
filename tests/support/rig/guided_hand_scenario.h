// A scenario in virtual time whose hand is controlled by what an application receives: the loop on the twin, and a
// person who sees it late, unevenly, with gaps, and is sometimes prevented from acting.
#pragma once

#include <algorithm>
#include <deque>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "service/config/files/twin_file.h"
#include "service/haptics/live/surface_frame.h"
#include "service/haptics/scene/scene.h"
#include "service/haptics/sculpt/sculpted_scene.h"
#include "service/sim/fields/random.h"
#include "service/tools/hand/hand_task.h"
#include "tests/support/touch/scenario.h"

namespace omni::test {

// Delays of a person's perception and action; all zero: none.
struct Conditions {
  double delay_s = 0;          // until something is perceived, 0.2 at most ...
  double jitter_s = 0;         // ... plus up to this at random
  double dropped = 0;          // share of updates that are lost
  double stall_s = 0;          // longest time that the person cannot act, about every 1.5 s
  double service_stall_s = 0;  // the same for the service: base and pen continue without it

  static Conditions Drawn(std::uint64_t seed) {
    sim::Random random(~seed);
    Conditions drawn;
    drawn.delay_s = random.Uniform(0, 0.2);
    drawn.jitter_s = random.Uniform(0, 0.05);
    drawn.dropped = random.Uniform(0, 0.3);
    drawn.stall_s = random.Uniform(0, 0.3);
    drawn.service_stall_s = seed % 2 == 0 ? 0 : random.Uniform(0, 0.3);
    return drawn;
  }
};

// Occurs at random times, about every 1.5 s.
class Stalls {
 public:
  Stalls(double longest_s, sim::Random& random) : longest_s_(longest_s), random_(random) {}
  bool Stalled(double t_s) {
    if (longest_s_ > 0 && t_s > next_s_) {
      until_s_ = t_s + random_.Uniform(0, longest_s_);
      next_s_ = until_s_ + random_.Uniform(0.5, 2.5);
    }
    return t_s < until_s_;
  }

 private:
  double longest_s_, until_s_ = 0, next_s_ = 0.5;
  sim::Random& random_;
};

class LedScenario {
 public:
  LedScenario(const haptics::Scene& scene, const sim::HandScript& hand, std::uint64_t seed,
              const Conditions& conditions)
      : scene_(scene),
        guide_(std::make_shared<Guide>()),
        random_(seed),
        conditions_(conditions),
        person_stalls_(conditions.stall_s, random_),
        service_stalls_(conditions.service_stall_s, random_),
        config_(loop::MakeTickConfig(config::DefaultDevice())),
        twin_(sim::MakeVirtualTwin(config::DefaultDevice(),
                                   {.seed = seed, .script = hand, .guide = guide_, .truth = config::IdealTwin()},
                                   3600)),
        state_(std::make_unique<loop::LoopState>()),
        output_(std::make_unique<loop::TickOutput>()),
        editor_(scene) {
    loop::FlushDenormals();
    loop::EnterScene(scene, 1, *state_);
    for (const haptics::ChangingObject& object : haptics::ChangingObjects(scene)) {
      if (object.soft) soft_.push_back(haptics::RestOf(scene, object.object));
    }
  }

  // Runs until the task is done. False: not within `patience_s`.
  bool Run(tools::HandTask& task, double patience_s) {
    while (!task.done() && t_s_ < patience_s) {
      Tick();
      if (tick_ % kLook_ticks != 0 || person_stalls_.Stalled(t_s_)) continue;
      tools::Perceived seen = Perceive();
      seen.t_s = t_s_;
      if (const auto aim = task.NextAim(seen)) guide_->newest = *aim;
    }
    return task.done();
  }

  double t_s() const { return t_s_; }
  const loop::TickOutput& output() const { return *output_; }

 private:
  struct Guide final : sim::HandGuide {
    bool Poll(sim::HandAim& aim) noexcept override {
      if (!newest) return false;
      aim = *newest;
      return true;
    }
    std::optional<sim::HandAim> newest;
  };

  void Tick() {
    base::HallScan scan;
    twin_->Read(scan, 0);
    t_s_ = 1e-3 * static_cast<double>(++tick_);
    if (service_stalls_.Stalled(t_s_)) return;
    loop::Tick(config_, scan, Scenario::Open(scan), scene_, *state_, *output_);
    twin_->Write(output_->currents);
    editor_.AfterTick();
    if (tick_ % kShow_ticks == 0) Show();
  }

  // The service's current state.
  void Show() {
    const haptics::Output& haptics = output_->haptics;
    shown_.pen = output_->tool.status == base::TrackingStatus::kTracking;
    shown_.tip_base_m = output_->tool.device_point_base_m;
    shown_.press_N = 0;
    for (int i = 0; i < haptics.contact_count; ++i) {
      shown_.press_N += haptics.contacts[static_cast<std::size_t>(i)].normal_force_N;
    }
    shown_.select_presses =
        output_->inputs.components[static_cast<std::size_t>(base::InputComponent::kSelect)].press_count;
    const haptics::VehicleReport& car = haptics.vehicle;
    shown_.car = {car.on, car.position_base_m, car.heading_rad, car.speed_m_s, car.laps, car.hits};
    ShowSurfaces();
    const double due_s = t_s_ + conditions_.delay_s + random_.Uniform(0, 1) * conditions_.jitter_s;
    if (random_.Uniform() < conditions_.dropped) return;
    coming_.push_back({coming_.empty() ? due_s : std::max(due_s, coming_.back().first), shown_});
  }

  void ShowSurfaces() {
    shown_.soft = !soft_.empty();
    shown_.dent_m = 0;
    std::vector<haptics::DrawnVertex> vertices;
    for (haptics::RestObject& rest : soft_) {
      const haptics::DeformingState deforming{.soft = state_->haptics.soft, .regions = state_->haptics.regions};
      shown_.dent_m = std::max(shown_.dent_m, haptics::DisplacedVertices(scene_, deforming, rest, vertices));
    }
    shown_.strokes = 0;
    shown_.stroke_open = shown_.clay = false;
    for (std::uint32_t n = 0; scene_.live() != nullptr && n < scene_.live()->sculpt_session_count(); ++n) {
      const haptics::sculpt::SculptEditor& editor = scene_.live()->sculpt_session_at(n).editor();
      shown_.clay = true;
      shown_.strokes += static_cast<std::uint32_t>(editor.undo_steps());
      shown_.stroke_open |= editor.in_stroke();
    }
  }

  tools::Perceived Perceive() {
    while (!coming_.empty() && coming_.front().first <= t_s_) {
      perceived_ = coming_.front().second;
      coming_.pop_front();
    }
    return perceived_;
  }

  static constexpr std::uint64_t kLook_ticks = 8, kShow_ticks = 11;

  const haptics::Scene& scene_;
  std::shared_ptr<Guide> guide_;
  sim::Random random_;
  const Conditions conditions_;
  Stalls person_stalls_, service_stalls_;
  const loop::TickConfig config_;
  std::unique_ptr<device::Transport> twin_;
  std::unique_ptr<loop::LoopState> state_;
  std::unique_ptr<loop::TickOutput> output_;
  haptics::sculpt::VirtualEditor editor_;
  std::vector<haptics::RestObject> soft_;
  std::uint64_t tick_ = 0;
  double t_s_ = 0;
  tools::Perceived shown_, perceived_;
  std::deque<std::pair<double, tools::Perceived>> coming_;
};

}  // namespace omni::test
