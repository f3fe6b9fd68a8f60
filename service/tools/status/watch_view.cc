#include "service/tools/status/status.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "service/tools/common/output.h"
#include "service/tools/scene/scene.h"

namespace omni::tools {
namespace {

constexpr double kGapShown_m = 0.06;
constexpr double kForceShown_N = 2.0;
constexpr std::int64_t kStale_ns = 100'000'000;
constexpr int kBarMargin = 34;
constexpr std::array<const char*, protocol::kInputCount> kInputNames = {
    "tip force", "select", "secondary", "menu", "squeeze", "stick x", "stick y", "stick click", "docked"};

double Length(const std::array<double, 3>& v) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

const char* PoseWord(const WatchFrame& frame) {
  if (!frame.has_sample || (frame.sample.flags & protocol::kToolPoseValid) == 0) return "absent";
  if (frame.now_ns - frame.sample.t_ns >= kStale_ns) return "stale";
  return (frame.sample.flags & protocol::kToolTracked) != 0 ? "tracked" : "lost";
}

bool InContact(const WatchFrame& frame) { return (frame.sample.flags & protocol::kToolContact) != 0; }

// Direction out of the tip: -Z of the tool, third column of R_BT.
std::array<double, 3> TipDirection(const std::array<double, 4>& q_wxyz) {
  const auto [w, x, y, z] = q_wxyz;
  return {-2 * (x * z + w * y), -2 * (y * z - w * x), -(1 - 2 * (x * x + y * y))};
}

std::string PoseLines(const WatchFrame& frame, int bar) {
  const protocol::ToolSample& s = frame.sample;
  const auto& p = s.position_base_m;
  const auto u = TipDirection(s.orientation_base_wxyz);
  std::string text = Format("pen       %s\n", PoseWord(frame));
  text += Format("tip       x %+7.1f  y %+7.1f  z %+7.1f mm   uncertainty %.2f mm\n", p[0] * 1e3, p[1] * 1e3,
                 p[2] * 1e3, s.position_sigma_m * 1e3);
  text += Format("points to x %+7.3f  y %+7.3f  z %+7.3f\n", u[0], u[1], u[2]);
  text += Format("speed     %7.1f mm/s\n", Length(s.linear_velocity_base_m_s) * 1e3);
  text += Format("gap       %7.1f mm  ", s.gap_m * 1e3) + TextBar(s.gap_m, kGapShown_m, bar) + "\n";
  text += Format("force     %7.2f N   ", Length(s.force_base_N)) + TextBar(Length(s.force_base_N), kForceShown_N, bar) +
          "\n";
  text += Format("          x %+6.2f  y %+6.2f  z %+6.2f N   %s\n", s.force_base_N[0], s.force_base_N[1],
                 s.force_base_N[2], InContact(frame) ? "CONTACT" : "");
  return text;
}

std::string InputLines(const WatchFrame& frame) {
  std::string text;
  for (std::size_t i = 0; i < kInputNames.size(); ++i) {
    const protocol::InputValue& input = frame.inputs.components[i];
    text += Format("%-11s %+5.2f  presses %-6u%s", kInputNames[i], static_cast<double>(input.value), input.press_count,
                   i % 2 == 1 ? "\n" : "   ");
  }
  return text + "\n";
}

std::string ServiceLines(const WatchFrame& frame) {
  std::string text =
      std::isfinite(frame.tick_rate_Hz) ? Format("tick      %.0f Hz", frame.tick_rate_Hz) : "tick      -";
  if (frame.status.is_object()) {
    text += ", " + TextAt(frame.status, "/tick/late") + " late, p99 " + TextAt(frame.status, "/tick/us_p99", 1) + " us";
    const std::string scene = TextAt(frame.status, "/scene/name");
    text += "\nscene     " + (scene.empty() ? std::string("none") : scene);
    const std::string race = RaceText(frame.status);
    if (!race.empty()) text += "\nrace      " + race;
    text += "\ndevice    " + DeviceName(frame.status);
    for (const nlohmann::json& client : ArrayAt(frame.status, "/clients")) {
      if (!TrueAt(client, "/monitor")) {
        text +=
            "\nclient    " + TextAt(client, "/application") + (TrueAt(client, "/owner") ? " (controls the force)" : "");
      }
    }
  }
  return text + "\n";
}

std::string Cut(const std::string& lines, std::size_t columns) {
  std::istringstream all(lines);
  std::string line;
  std::string text;
  while (std::getline(all, line)) text += line.substr(0, columns) + "\n";
  return text;
}

}  // namespace

std::string TextBar(double value, double full, int width) {
  const double share = std::isfinite(value) ? std::clamp(value / full, 0.0, 1.0) : 0.0;
  const int filled = static_cast<int>(std::lround(share * width));
  return std::string(static_cast<std::size_t>(filled), '#') +
         std::string(static_cast<std::size_t>(width - filled), '-');
}

std::string WatchScreen(const WatchFrame& frame, int columns) {
  const int width = std::max(columns, 20);
  std::string text = "omni watch   (Ctrl-C to quit)\n\n";
  if (!frame.connected)
    return Cut(text + "waiting for omnid\n" + frame.problem + "\n", static_cast<std::size_t>(width));
  text +=
      PoseLines(frame, std::clamp(width - kBarMargin, 5, 50)) + "\n" + InputLines(frame) + "\n" + ServiceLines(frame);
  return Cut(text, static_cast<std::size_t>(width));
}

std::string WatchLine(const WatchFrame& frame) {
  if (!frame.connected) return "waiting for omnid: " + frame.problem + "\n";
  const protocol::ToolSample& s = frame.sample;
  const std::string rate = std::isfinite(frame.tick_rate_Hz) ? Format("  tick %.0f Hz", frame.tick_rate_Hz) : "";
  return Format("%s  tip %.1f %.1f %.1f mm  gap %.1f mm  force %.2f N%s%s\n", PoseWord(frame),
                s.position_base_m[0] * 1e3, s.position_base_m[1] * 1e3, s.position_base_m[2] * 1e3, s.gap_m * 1e3,
                Length(s.force_base_N), InContact(frame) ? " contact" : "", rate.c_str());
}

}  // namespace omni::tools
