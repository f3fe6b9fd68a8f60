// omni try: what the pages of a trial may do beside looking. It is an application of omnid like any other, that has the
// pen while no other application is focused; it hands its scenes to omnid (XR_OMNIX1_haptic_scene's messages), and
// leads the hand of the digital twin by a channel of the twin's own, never through omnid.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "service/client/connection.h"
#include "service/client/dial.h"
#include "service/monitor/page/page_requests.h"
#include "service/monitor/page/page_text.h"
#include "service/monitor/view/scene_view.h"
#include "service/protocol/hand_aim.h"
#include "service/protocol/state_memory.h"

namespace omni::monitor {

// Keeps the hand of omni try from pushing the pen through what it touches. A mouse has no force of its own to run out
// of: its aim would go on where a person feels that the base gives way. The aim stays so far beyond the surface that
// the hand's spring pulls with what the base can make there, and no more; nor so deep into what is soft that the pen
// would come out on its far side.
struct AimLimitOptions {
  double hand_stiffness_N_m = 0;  // > 0
  double force_max_N = 0;         // of the base, anywhere
};

class AimLimit {
 public:
  explicit AimLimit(const AimLimitOptions& options) : options_(options) {}

  // What is touched, and whether the base makes all of it. Called some ten times a second or more; `dt_s` > 0: since
  // the last call.
  void Update(const protocol::ToolSample& tool, const protocol::ContactSnapshot& contacts, double dt_s);

  // The nearest aim that is allowed. The pen's axis stays.
  protocol::HandAim LimitAim(const protocol::HandAim& aim) const;

  // How far the aim may be beyond a surface; infinite while nothing is touched.
  double beyond_m() const;

 private:
  AimLimitOptions options_;
  protocol::ContactSnapshot contacts_;
  double beyond_m_ = 0;   // for what the base can make
  double soft_m_ = 0;     // for what gives way: with it the pen comes to rest at a depth
  double pressed_m_ = 0;  // for how fast it comes
  double away_s_ = 0;     // since anything was touched
  bool cut_ = false;      // the base could not make all since the contact began
};

inline constexpr const char* kTrialName = "omni try";  // of the application: manifests/apps.d

struct TrialOptions {
  std::string socket_path;  // of omnid
  std::string hand_path;    // of the twin's hand
  std::string folder;       // for dropped files; only the user may enter it
  double hull_radius_m = 0;
  bool z_up = false;  // of scenes that are not shipped
  AimLimitOptions aim_limit;
};

class Trial {
 public:
  explicit Trial(const TrialOptions& options);

  // A scene of these files; the last one counts. The pen is taken away: what appears must not appear around it. `name`:
  // for people. `shipped`: as authored; else a file without haptic tags is touched as a whole, scaled and moved into
  // reach.
  void ChooseScene(const std::string& path, const std::string& name, bool shipped);
  // Keeps the bytes as a file of the folder, then as above.
  base::Status LoadDropped(std::string_view name, std::string_view bytes);

  void Poll(std::int64_t now_ns);

  // What the pen touches now: the aim goes no further beyond it than the base can push back.
  void UpdateContacts(const protocol::ToolSample& tool, const protocol::ContactSnapshot& contacts, std::int64_t now_ns);

  // False: the twin has gone; problem() says why.
  bool SendAim(const protocol::HandAim& aim);
  const protocol::HandAim& aim() const { return aim_; }
  // False: there is no such material.
  bool SetMaterial(const MaterialRequest& request);

  // The scene's file with the materials' present numbers. `sculpted`: omnid's copy of the sculpted scene; empty: the
  // file as it was loaded.
  base::Result<std::string> MakeSceneFile(std::string_view sculpted) const;

  const ShownScene& scene() const { return scene_; }
  std::string problem() const;

 private:
  void Load(const LoadedView& loaded);
  void SendScene();
  void Place();
  void HandleUpdates();
  void Lift();
  void Change(SceneState state, const std::string& text);

  const TrialOptions options_;
  client::Connection connection_;
  client::HandLink hand_;
  protocol::HandAim asked_aim_, aim_;  // of the hand; what it may have
  AimLimit aim_limit_;
  std::int64_t felt_ns_ = 0;
  SceneLoads loads_;
  ShownScene scene_;
  std::uint32_t requests_ = 0, sent_number_ = 0, drops_ = 0;
  std::uint64_t welcomes_ = 0;
  std::string dropped_path_;
};

}  // namespace omni::monitor
