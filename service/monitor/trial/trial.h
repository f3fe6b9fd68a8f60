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
#include "service/client/hand_link.h"
#include "service/monitor/page/page_requests.h"
#include "service/monitor/page/page_text.h"
#include "service/monitor/trial/aim_limit.h"
#include "service/monitor/view/scene_loads.h"

namespace omni::monitor {

inline constexpr const char* kTrialName = "omni try";  // of the application: manifests/apps.d

struct TrialOptions {
  std::string socket_path;  // of omnid
  std::string hand_path;    // of the twin's hand
  std::string folder;       // for dropped files; only the user may enter it
  double hull_radius_m = 0;
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
  base::Status Drop(std::string_view name, std::string_view bytes);

  void Poll(std::int64_t now_ns);

  // What the pen touches now: the aim goes no further beyond it than the base can push back.
  void Feel(const protocol::ToolSample& tool, const protocol::ContactSnapshot& contacts, std::int64_t now_ns);

  // False: the twin has gone; problem() says why.
  bool Aim(const protocol::HandAim& aim);
  const protocol::HandAim& aim() const { return aim_; }
  // False: there is no such material.
  bool SetMaterial(const MaterialRequest& request);

  // The scene's file with the materials' present numbers. `sculpted`: omnid's copy of the sculpted scene; empty: the
  // file as it was loaded.
  base::Result<std::string> Copy(std::string_view sculpted) const;

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
