// omni monitor and omni try: serves the live page. Reads what omnid publishes, as any client; with a trial, pages also
// lead the simulated hand and choose what is touched.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "service/base/result.h"
#include "service/client/connection.h"
#include "service/monitor/page/page_messages.h"
#include "service/monitor/page/page_requests.h"
#include "service/monitor/page/page_text.h"
#include "service/monitor/trial/trial.h"
#include "service/monitor/view/scene_view.h"
#include "service/monitor/view/surface_copies.h"
#include "service/monitor/web/web_server.h"

namespace omni::monitor {

inline constexpr std::uint64_t kMaxDroppedBytes = 64u << 20;
inline constexpr std::int64_t kFramePeriod_ns = 16'666'667;  // 60 Hz

struct MonitorOptions {
  std::uint16_t port = 0;   // 0: any that is free
  std::string page_folder;  // of the page's files
  std::string socket_path;  // of omnid; empty: the user's
  bool control = false;     // pages may change something; else only the emergency stop
  PageHello hello;          // version, device, and for a trial: scenes, environment
  // Scenes of `hello` by name, for a trial.
  std::map<std::string, std::string> scene_paths;
  // Steps that set a base up, one JSON object each (docs/protocol/page.md), for omnid's status (null: none). Called
  // every two seconds. Empty: none are shown.
  std::function<nlohmann::json(const nlohmann::json& status)> setup_steps;
};

class Monitor : private WebHandler {
 public:
  // `trial`: null without one.
  static base::Result<std::unique_ptr<Monitor>> Start(const MonitorOptions& options, std::unique_ptr<Trial> trial);
  ~Monitor() override;

  // For the person; contains the token.
  std::string address() const;
  // For a browser's command line, which other users can read; contains a code that is good once.
  std::string browser_address() const;

  // Serves until the next frame is due, then sends it.
  void Step();

 private:
  struct Page {
    std::uint64_t next_index = 0;  // publication that it gets next
    std::uint32_t scene_number = 0, scene_revision = 0;
    std::size_t shapes_sent = 0;
    SurfacesSent surfaces;
  };
  struct RequestHandler;
  struct Save {
    PageId page = 0;
    std::uint32_t number = 0;   // of the page
    std::uint32_t command = 0;  // of omnid; 0: none
  };

  Monitor(const MonitorOptions& options, std::unique_ptr<Trial> trial);

  void OnPage(PageId page) override;
  void OnText(PageId page, std::string_view text) override;
  void OnBytes(PageId page, std::string_view bytes) override;
  void OnPageGone(PageId page) override;
  std::string HelloJson() override;

  void PollService(std::int64_t now_ns);
  void HandleStatus(const nlohmann::json& status);
  void FollowOwner(const nlohmann::json& status);
  void FollowSetup(std::int64_t now_ns, const nlohmann::json& status);
  const ShownScene& shown() const { return trial_ == nullptr ? owners_scene_ : trial_->scene(); }
  void HandleSceneAnswer();
  void SendCopy(const Save& save, const base::Result<std::string>& copy);
  void FollowScene();
  void SendFrame();
  void SendScene(PageId id, Page& page);
  LiveFrame NewestFrame() const;
  void AddTicks(std::uint64_t from, LiveFrame& frame) const;
  void Send(PageId page, std::string text);
  void SendAll(const std::string& text);
  void Notice(PageId page, NoticeLevel level, std::string_view text);

  const MonitorOptions options_;
  const std::unique_ptr<Trial> trial_;
  client::Connection connection_;
  std::unique_ptr<WebServer> server_;
  std::string token_, code_;
  std::map<PageId, Page> pages_;
  std::string hello_text_;
  std::string status_text_;
  std::string setup_text_;  // empty: not known yet
  std::int64_t next_status_ns_ = 0, next_setup_ns_ = 0, next_frame_ns_ = 0;
  bool was_connected_ = false;
  std::vector<std::shared_ptr<const std::string>> shapes_;  // messages, of shown()
  std::shared_ptr<const SceneView> shapes_of_;              // that they were made of
  // Without a trial: the scene that omnid's status names.
  ShownScene owners_scene_;
  SceneLoads loads_;
  std::string followed_;  // file and options of the request
  std::uint32_t load_requests_ = 0;
  SurfaceCopies surfaces_;
  bool surfaces_wanted_ = false;
  Save save_;
  std::uint32_t edits_command_ = 0;  // of omnid: the last one that asked for the strokes
  int strokes_ = -1;
};

}  // namespace omni::monitor
