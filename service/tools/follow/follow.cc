// omni follow: reports to omnid where a base is that a controller or tracker carries.
#include <cstdio>
#include <memory>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "service/base/clock.h"
#include "service/base/files/whole_file.h"
#include "service/config/files/follow_file.h"
#include "service/config/paths.h"
#include "service/config/text/text_file.h"
#include "service/tools/align/align.h"
#include "service/tools/common/command_line.h"
#include "service/tools/common/output.h"
#include "service/tools/common/service_link.h"
#include "service/tools/common/terminal.h"
#include "service/tools/follow/mount.h"

namespace omni::tools {
namespace {

constexpr const char* kFollow = "omni follow";
constexpr int kSilence_ms = 100;  // a probe that is silent for so long does not see the source

struct FollowArguments {
  std::string path, socket, probe, file;
  bool mount = false, off = false;
  double patience_s = 60;
};

// The probe's lines, with the headset that they are about.
class Source {
 public:
  base::Status Start(const FollowArguments& arguments, const std::string& path) {
    auto probe = AlignProbe::Start(arguments.probe.empty() ? DefaultProbe() : arguments.probe, {"--follow", path});
    if (!probe.ok()) return base::Error{probe.error()};
    probe_ = std::move(*probe);
    return base::Ok{};
  }
  // Nothing: silence. Lines about the headset are kept.
  std::optional<ProbeLine> Next() {
    const std::optional<ProbeLine> line = probe_->NextLine(kSilence_ms);
    if (!line) return std::nullopt;
    if (line->says == ProbeSays::kRuntime) headset_.runtime = line->text;
    if (line->says == ProbeSays::kSystem) headset_.system = line->text;
    if (line->says == ProbeSays::kSpace) {
      headset_.space = line->space;
      named_ = true;
    }
    return line;
  }
  const Headset& headset() const { return headset_; }
  bool named() const { return named_; }  // the headset and its space are known

 private:
  std::unique_ptr<AlignProbe> probe_;
  Headset headset_;
  bool named_ = false;
};

// Where the base is mounted, from the alignment that is stored, while both rest.
base::Result<config::FollowSettings> MeasureMount(client::Connection& connection, Source& source,
                                                  const FollowArguments& arguments) {
  const std::int64_t deadline_ns = base::MonotonicNow_ns() + static_cast<std::int64_t>(1e9 * arguments.patience_s);
  SourceAtRest rest;
  while (!rest.complete()) {
    if (EndSignals::asked()) return base::Error{"interrupted; nothing was stored"};
    if (base::MonotonicNow_ns() > deadline_ns) {
      return base::Error{arguments.path + " is not tracked; is it switched on, and in view?"};
    }
    connection.Poll(base::MonotonicNow_ns());
    const std::optional<ProbeLine> line = source.Next();
    if (!line) continue;
    if (line->says == ProbeSays::kEnd) return base::Error{"the OpenXR session ended: " + line->text};
    if (line->says == ProbeSays::kMoved || line->says == ProbeSays::kLost) rest = {};
    if (line->says == ProbeSays::kMotion) rest.Add(line->t_ns, line->pose);
  }
  const auto status = RequestStatus(connection);
  if (!status.ok()) return base::Error{status.error()};
  const auto stored = AlignmentOf(*status, source.headset());
  if (!stored.ok()) return base::Error{stored.error()};
  const auto X_LC = rest.Mean();
  if (!X_LC.ok()) return base::Error{arguments.path + ": " + X_LC.error()};
  const alignment::Rigid mount = MountOf(*X_LC, stored->base_space);
  config::FollowSettings settings{
      .follows = arguments.path, .position_source_m = mount.position_m, .orientation_source = mount.orientation};
  if (const auto written = config::WriteTextFile(arguments.file, config::WriteFollow(settings)); !written.ok()) {
    return base::Error{written.error()};
  }
  std::printf("mounted      %.0f mm from the grip of %s; kept in %s\n", 1e3 * base::Norm(mount.position_m),
              settings.follows.c_str(), arguments.file.c_str());
  return settings;
}

// Reports until a signal, or the end of the session or of omnid.
int Report(client::Connection& connection, Source& source, const config::FollowSettings& settings) {
  const alignment::Rigid mount{.orientation = settings.orientation_source, .position_m = settings.position_source_m};
  std::optional<CarriedBase> base;
  bool seen = false, said = false;
  while (!EndSignals::asked()) {
    connection.Poll(base::MonotonicNow_ns());
    const std::optional<ProbeLine> line = source.Next();
    if (EndSignals::asked()) break;  // Ctrl-C ends the probe too
    if (line && line->says == ProbeSays::kEnd) return Fail(kFollow, "the OpenXR session ended: " + line->text);
    if (!connection.connected()) return FailWith(false, kFollow, connection.last_error(), kExitNoService);
    for (const protocol::Notice& notice : connection.PopNotices()) Print(std::string(notice.text) + "\n");
    if (!base && source.named()) base.emplace(source.headset(), mount);
    if (!base) continue;
    const bool motion = line && line->says == ProbeSays::kMotion;
    if (motion) connection.Send(base->MotionAt(*line));
    if (!line || line->says == ProbeSays::kLost) connection.Send(base->In(protocol::BaseState::kLost));
    if (line && !motion && line->says != ProbeSays::kLost) continue;
    if (said && motion == seen) continue;
    seen = motion;
    said = true;
    Print(settings.follows + (seen ? ": the base follows it; Ctrl-C ends\n" : " is not tracked\n"));
    std::fflush(stdout);
  }
  return kExitOk;
}

int Off(client::Connection& connection, const FollowArguments& arguments) {
  if (const auto removed = base::RemoveWholeFile(arguments.file); !removed.ok()) return Fail(kFollow, removed.error());
  const CarriedBase base({}, {});
  if (!connection.Send(base.In(protocol::BaseState::kStands))) {
    return Fail(kFollow, "omnid does not accept requests; restart omnid");
  }
  if (const auto status = RequestStatus(connection); !status.ok()) return Fail(kFollow, status.error());
  for (const protocol::Notice& notice : connection.PopNotices()) return Fail(kFollow, notice.text);
  Print("The base stands where it was aligned. If it was moved: omni align\n");
  return kExitOk;
}

int Follow(const FollowArguments& given) {
  FollowArguments arguments = given;
  if (arguments.file.empty()) arguments.file = config::UserFollowFile();
  if (arguments.file.empty()) return Fail(kFollow, "there is no folder for follow.toml: set HOME or XDG_CONFIG_HOME");
  auto connection = ConnectToService(arguments.socket, protocol::ClientRole::kTool);
  if (!connection.ok()) return FailWith(false, kFollow, connection.error(), kExitNoService);
  if (arguments.off) return Off(**connection, arguments);
  auto kept = config::LoadFollowFile(arguments.file);
  if (!kept.ok() && !arguments.mount) return Fail(kFollow, kept.error());
  const EndSignals signals;
  if (arguments.path.empty() && kept.ok() && *kept) arguments.path = (*kept)->follows;
  const bool mounted = kept.ok() && *kept && (*kept)->follows == arguments.path;
  if (arguments.path.empty() || (!arguments.mount && !mounted)) {
    return Fail(kFollow,
                "where the base is mounted on it is not known; with the base at rest and aligned run: omni follow " +
                    (arguments.path.empty() ? std::string("/user/hand/left") : arguments.path) + " --mount");
  }
  Source source;
  if (const auto started = source.Start(arguments, arguments.path); !started.ok()) {
    return Fail(kFollow, started.error());
  }
  if (!arguments.mount) return Report(**connection, source, **kept);
  const auto settings = MeasureMount(**connection, source, arguments);
  if (!settings.ok()) return Fail(kFollow, settings.error());
  return Report(**connection, source, *settings);
}

}  // namespace

void AddFollow(Command& app) {
  auto arguments = std::make_shared<FollowArguments>();
  Command follow =
      app.AddCommand("follow", "a base that moves: report where the controller or tracker that carries it is");
  follow.Add("path", arguments->path,
             "what carries the base: /user/hand/left, /user/hand/right or the role path of a tracker (default: as "
             "last time)");
  follow.Add("--mount", arguments->mount,
             "first measure where the base is mounted on it; base at rest, where it was aligned");
  follow.Add("--off", arguments->off, "the base stands again, where it was aligned");
  follow.Add("--file", arguments->file, "where the mount is kept (default: follow.toml in the user's folder)");
  follow.Add("--patience", arguments->patience_s, "--mount: give up after this many seconds")
      .Range(5.0, 3600.0)
      .ShowDefault();
  follow.Add("--probe", arguments->probe,
             "the program that reads poses from the OpenXR runtime (default: omni_align_probe)");
  AddSocket(follow, arguments->socket);
  follow.SetAction(arguments, Follow);
}

}  // namespace omni::tools
