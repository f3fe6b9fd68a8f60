#include "tests/probe/report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <sstream>

namespace probe {
namespace {

// The path is for pictures: this many points are plenty.
constexpr size_t kMaxSamples = 2000;

std::string Quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    if (static_cast<unsigned char>(c) < 0x20) {
      char escape[8];
      std::snprintf(escape, sizeof(escape), "\\u%04x", static_cast<unsigned>(c));
      out += escape;
    } else {
      out += c;
    }
  }
  return out + "\"";
}

// JSON has no NaN and no infinity.
std::string Number(double value) {
  if (!std::isfinite(value)) return "null";
  char text[32];
  std::snprintf(text, sizeof(text), "%.9g", value);
  return text;
}

std::string Median(std::vector<int64_t> values) {
  if (values.empty()) return "null";
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return std::to_string(*middle);
}

std::string Fraction(long part, long whole) {
  return Number(whole == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(whole));
}

void AppendErrors(std::ostream& out, const Report& report) {
  out << "  \"errors\": [";
  const char* separator = "";
  for (const FailedCall& error : report.errors) {
    out << separator << "\n    {\"call\": " << Quoted(error.call) << ", \"result\": " << Quoted(error.result)
        << ", \"count\": " << error.count << "}";
    separator = ",";
  }
  out << "]";
}

void AppendSamples(std::ostream& out, const Report& report) {
  const size_t step = report.samples.size() / kMaxSamples + 1;
  out << ",\n  \"samples\": [";
  for (size_t i = 0; i < report.samples.size(); i += step) {
    const Sample& s = report.samples[i];
    out << (i == 0 ? "" : ",") << "\n    {\"t_s\": " << Number(s.time_s) << ", \"position_m\": ["
        << Number(s.position_m.x) << ", " << Number(s.position_m.y) << ", " << Number(s.position_m.z) << "]}";
  }
  out << "]";
}

void AppendCounts(std::ostream& out, const Report& r) {
  out << "  \"frames\": " << r.frames << ",\n  \"locates\": " << r.locates
      << ",\n  \"valid_after_first_valid\": " << r.valid_after_first_valid
      << ",\n  \"pose_valid_fraction\": " << Number(r.PoseValidFraction())
      << ",\n  \"tracked_fraction\": " << Fraction(r.tracked_after_first_valid, r.locates_after_first_valid)
      << ",\n  \"pose_active_frames\": " << r.pose_active_frames << ",\n  \"select_edges\": " << r.select_edges
      << ",\n  \"haptics_sent\": " << r.haptics_sent << ",\n  \"max_speed_m_s\": " << Number(r.max_speed_m_s)
      << ",\n  \"thumbstick_max\": " << Number(r.thumbstick_max) << ",\n  \"force_max\": " << Number(r.force_max)
      << ",\n  \"first_valid_s\": " << (r.first_valid_s < 0 ? "null" : Number(r.first_valid_s))
      << ",\n  \"locate_ns_median\": " << Median(r.locate_ns) << ",\n";
}

}  // namespace

void Report::AddError(const std::string& call, const std::string& result) {
  for (FailedCall& error : errors) {
    if (error.call == call && error.result == result) {
      ++error.count;
      return;
    }
  }
  errors.push_back({call, result, 1});
}

void Report::AddProfile(const std::string& path) {
  profile = path;
  if (std::find(profiles_seen.begin(), profiles_seen.end(), path) == profiles_seen.end()) profiles_seen.push_back(path);
}

void Report::AddLocation(double time_s, int64_t elapsed_ns, const XrSpaceLocation& location,
                         const XrSpaceVelocity& velocity) {
  ++locates;
  locate_ns.push_back(elapsed_ns);
  const bool valid = (location.locationFlags & XR_SPACE_LOCATION_POSITION_VALID_BIT) != 0 &&
                     (location.locationFlags & XR_SPACE_LOCATION_ORIENTATION_VALID_BIT) != 0;
  if (valid && first_valid_s < 0) first_valid_s = time_s;
  if (first_valid_s < 0) return;
  ++locates_after_first_valid;
  if (!valid) return;
  ++valid_after_first_valid;
  if ((location.locationFlags & XR_SPACE_LOCATION_POSITION_TRACKED_BIT) != 0) ++tracked_after_first_valid;
  if ((velocity.velocityFlags & XR_SPACE_VELOCITY_LINEAR_VALID_BIT) != 0) {
    const XrVector3f& v = velocity.linearVelocity;
    max_speed_m_s = std::max(max_speed_m_s, std::sqrt(double{v.x} * v.x + double{v.y} * v.y + double{v.z} * v.z));
  }
  samples.push_back({time_s, location.pose.position});
}

double Report::PoseValidFraction() const {
  if (locates_after_first_valid == 0) return 0;
  return static_cast<double>(valid_after_first_valid) / static_cast<double>(locates_after_first_valid);
}

std::string MissingFromPen(const Report& report) {
  std::string missing;
  const auto add = [&missing](const char* what) { missing += (missing.empty() ? "" : "; ") + std::string(what); };
  if (report.profile.empty()) add("no interaction profile became current");
  if (report.first_valid_s < 0) add("the pose was never valid");
  if (report.select_edges == 0) add("select was never pressed");
  return missing;
}

bool WriteJson(const Options& options, const Report& report) {
  std::ostringstream out;
  out << "{\n  \"application\": " << Quoted(options.name) << ",\n  \"hand\": " << Quoted(options.hand)
      << ",\n  \"profile\": " << (report.profile.empty() ? "null" : Quoted(report.profile))
      << ",\n  \"profiles_seen\": [";
  for (size_t i = 0; i < report.profiles_seen.size(); ++i) {
    out << (i == 0 ? "" : ", ") << Quoted(report.profiles_seen[i]);
  }
  out << "],\n";
  AppendCounts(out, report);
  if (!report.planted_error_result.empty()) {
    out << "  \"planted_error_result\": " << Quoted(report.planted_error_result) << ",\n";
  }
  AppendErrors(out, report);
  if (options.samples) AppendSamples(out, report);
  out << "\n}\n";
  const std::string text = out.str();
  std::FILE* const file = std::fopen(options.json.c_str(), "w");
  if (file == nullptr) return false;
  const bool written = std::fwrite(text.data(), 1, text.size(), file) == text.size();
  return std::fclose(file) == 0 && written;
}

}  // namespace probe
