#include "service/tools/align/align.h"

#include <cmath>
#include <numbers>

#include <nlohmann/json.hpp>

#include "service/alignment/rigid.h"
#include "service/protocol/base_pose.h"
#include "service/tools/common/output.h"

namespace omni::tools {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

// Of B's y, seen from above, from L's -z to the left.
double Yaw_deg(const alignment::Rigid& X_LB) {
  const base::Vec3 away = alignment::TransformPoint({.orientation = X_LB.orientation, .position_m = {}}, {0, 1, 0});
  return kDegrees * std::atan2(-away.x, -away.z);
}

}  // namespace

std::string AlignStepText(const AlignSession& session) {
  const AlignOptions& options = session.options();
  const auto marks = static_cast<int>(options.marks.size());
  switch (session.step()) {
    case AlignStep::kPivot:
      return "press a hard point of the controller into mark " + options.marks.front().name +
             "; keep it there and slowly swing the controller in all directions";
    case AlignStep::kTouch:
      return Format("touch mark %s with the same point and hold still (%d of %d)",
                    options.marks[static_cast<std::size_t>(session.touched())].name.c_str(), session.touched() + 1,
                    marks);
    case AlignStep::kSweep:
      return "hold pen and controller firmly together; move them around the base: left, right, up, down, and turn them "
             "in all directions";
    case AlignStep::kFingertip:
      return Format(
          "hold the pen still over the base, touch its tip with your other index finger and hold still (%d of %d "
          "places)",
          session.touched() + 1, options.fingertips);
    case AlignStep::kRefused:
      return "refused: " + session.problem();
    case AlignStep::kDone:
      break;
  }
  return "done";
}

std::string AlignQualityWord(double expected_error_m) {
  if (expected_error_m <= 1e-3) return "excellent";
  if (expected_error_m <= 2e-3) return "good";
  return expected_error_m <= 4e-3 ? "fair" : "poor";
}

std::string AlignOutcomeText(const AlignOptions& options, const alignment::Outcome& outcome) {
  std::string text =
      Format("expected     %.1f mm, %.2f deg (1 sigma where the pen is used): %s\n", 1e3 * outcome.expected_error_m,
             kDegrees * outcome.rotation_sigma_rad, AlignQualityWord(outcome.expected_error_m).c_str());
  text += Format("residual     %.1f mm rms over %d %s\n", 1e3 * outcome.rms_m, outcome.samples,
                 options.method == AlignMethod::kSweep ? "samples" : "places");
  const base::Vec3& p = outcome.base_space.position_m;
  text += Format("base         (%.3f, %.3f, %.3f) m, yaw %.1f deg in the headset's space\n", p.x, p.y, p.z,
                 Yaw_deg(outcome.base_space));
  if (options.method == AlignMethod::kSweep) {
    text += Format("delay        the controller is %.0f ms behind the pen\n", -1e3 * outcome.time_offset_s);
  }
  if (outcome.wrong_group >= 0) {
    const auto group = static_cast<std::size_t>(outcome.wrong_group);
    const std::string name = options.method == AlignMethod::kTouch && group < options.marks.size()
                                 ? "mark " + options.marks[group].name
                                 : "place " + std::to_string(group + 1);
    text += Format("left out     %s: it is %.0f mm from where the others put it; touch it again for a better result\n",
                   name.c_str(), 1e3 * outcome.wrong_by_m);
  }
  return text;
}

std::string SpaceName(int space) {
  if (space == protocol::kSpaceStage) return "STAGE";
  if (space == protocol::kSpaceLocalFloor) return "LOCAL_FLOOR";
  return space == protocol::kSpaceLocal ? "LOCAL" : "space " + std::to_string(space);
}

namespace {

// "", or by how much it may be off by now.
std::string StartsText(const nlohmann::json& row) {
  const double starts = NumberAt(row, "/starts"), now_mm = NumberAt(row, "/error_now_mm");
  if (!(now_mm > NumberAt(row, "/expected_error_mm"))) return {};
  return Format(", %.1f mm by now, after %.0f %s of the headset", now_mm, starts, starts == 1 ? "start" : "starts");
}

}  // namespace

std::string StoredAlignmentsText(const nlohmann::json& status) {
  std::string text;
  int number = 0;
  for (const nlohmann::json& row : ArrayAt(status, "/alignments/stored")) {
    const double expected_mm = NumberAt(row, "/expected_error_mm");
    text +=
        Format("%d  ", ++number) + TextAt(row, "/runtime") + " / " + TextAt(row, "/system") + " in " +
        SpaceName(static_cast<int>(NumberAt(row, "/space"))) + ": " + TextAt(row, "/method") + " of " +
        TextAt(row, "/date") + ", " +
        (expected_mm > 0
             ? Format("expected error %.1f mm (%s)", expected_mm, AlignQualityWord(1e-3 * expected_mm).c_str())
             : std::string("error not stated")) +
        StartsText(row) +
        (NumberAt(row, "/recentred") > 0 ? ", adjusted for " + TextAt(row, "/recentred") + " recentrings" +
                                               Format(", %.2f m from where it was measured", NumberAt(row, "/moved_m"))
                                         : std::string()) +
        (TrueAt(row, "/doubtful") ? ", DOUBTFUL: the headset's space moved by an unknown amount; align again, or "
                                    "restore it as measured: omni align --restore"
                                  : "") +
        (TrueAt(row, "/base_moved") ? ", DOUBTFUL: the base was turned or carried, as the field about it says; align "
                                      "again, or if it stands where it stood: omni align --restore"
                                    : "") +
        (TrueAt(row, "/drifted") ? ", DOUBTFUL: it may be off by more than 10 mm by now; one touch corrects it: omni "
                                   "align --check --correct"
                                 : "") +
        "\n";
  }
  if (number == 0) text = "no alignment is stored; measure one: omni align\n";
  return text + "without one    placement = " + TextAt(status, "/alignments/placement") + "\n";
}

}  // namespace omni::tools
