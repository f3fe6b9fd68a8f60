// HandScript files: JSON in, ranges checked, every complaint with file and JSON pointer.
#include <cmath>
#include <sstream>
#include <stdexcept>

#include "service/base/files/json_document.h"
#include "service/base/files/whole_file.h"
#include "service/sim/hand/hand.h"

namespace omni::sim {
namespace {

using Json = base::JsonValue;

constexpr std::size_t kWaypointsMax = 10000;
constexpr base::JsonLimits kLimits{.bytes = 8u << 20, .values = 20 * kWaypointsMax};
constexpr double kReachMax_m = 1;
constexpr double kDurationMax_s = 3600;

// Thrown inside this file only; LoadHandScript turns it into an Error.
struct Complaint : std::runtime_error {
  using std::runtime_error::runtime_error;
};

std::string Show(double value) {
  std::ostringstream out;
  out << value;
  return out.str();
}

std::string OutOfRange(const std::string& pointer, double value, double low, double high, const char* unit) {
  return pointer + ": " + Show(value) + " is not within " + Show(low) + " to " + Show(high) + " " + unit;
}

std::string Below(const std::string& pointer, std::string_view key) {
  return pointer + "/" + std::string(key.substr(0, 60));
}

bool Within(double value, double low, double high) { return value >= low && value <= high; }

double Number(const Json& json, const std::string& pointer) {
  if (!json.is_number()) throw Complaint(pointer + ": a number is expected, found " + json.kind_name());
  return json.number();
}

Vec3 Vector(const Json& json, const std::string& pointer) {
  const std::span<const Json> xyz = json.elements();
  if (xyz.size() != 3) throw Complaint(pointer + ": an array of three numbers [x, y, z] is expected");
  return {Number(xyz[0], pointer + "/0"), Number(xyz[1], pointer + "/1"), Number(xyz[2], pointer + "/2")};
}

bool Boolean(const Json& json, const std::string& pointer) {
  if (!json.is_boolean()) throw Complaint(pointer + ": true or false is expected, found " + json.kind_name());
  return json.boolean();
}

HandWaypoint ParseWaypoint(const Json& json, const std::string& pointer) {
  if (!json.is_object()) throw Complaint(pointer + ": an object is expected, found " + json.kind_name());
  HandWaypoint waypoint;
  bool has_tip = false;
  for (const auto& [key, value] : json.members()) {
    const std::string at = Below(pointer, key);
    if (key == "s") {
      waypoint.duration_s = Number(value, at);
    } else if (key == "tip_m") {
      waypoint.tip_base_m = Vector(value, at);
      has_tip = true;
    } else if (key == "axis") {
      const Vec3 axis = Vector(value, at);
      const double length = Norm(axis);
      if (!Within(length, 1e-6, 1e6)) throw Complaint(OutOfRange(at, length, 1e-6, 1e6, "(its length)"));
      waypoint.axis_base = (1 / length) * axis;
    } else if (key == "present") {
      waypoint.present = Boolean(value, at);
    } else {
      throw Complaint(at + ": unknown key; known are s, tip_m, axis, present");
    }
  }
  if (!has_tip) throw Complaint(pointer + ": tip_m [x, y, z] is missing");
  return waypoint;
}

void ParseHand(const Json& json, HandScript& script) {
  if (!json.is_object()) throw Complaint(std::string("/hand: an object is expected, found ") + json.kind_name());
  const std::pair<const char*, double*> fields[] = {{"stiffness_N_m", &script.stiffness_N_m},
                                                    {"damping_Ns_m", &script.damping_Ns_m},
                                                    {"mass_kg", &script.mass_kg},
                                                    {"tremor_m", &script.tremor_m},
                                                    {"tremor_from_Hz", &script.tremor_band.from_Hz},
                                                    {"tremor_to_Hz", &script.tremor_band.to_Hz}};
  for (const auto& [key, value] : json.members()) {
    bool known = false;
    for (const auto& [name, field] : fields) {
      if (key != name) continue;
      *field = Number(value, Below("/hand", key));
      known = true;
    }
    if (!known) {
      throw Complaint(Below("/hand", key) +
                      ": unknown key; known are stiffness_N_m, damping_Ns_m, mass_kg, tremor_m, tremor_from_Hz and "
                      "tremor_to_Hz");
    }
  }
}

HandScript Parse(const Json& json) {
  if (!json.is_object()) throw Complaint(std::string("/: an object is expected, found ") + json.kind_name());
  HandScript script;
  for (const auto& [key, value] : json.members()) {
    const std::string at = Below("", key);
    if (key == "name") {
      if (!value.is_text()) throw Complaint(at + ": a text is expected, found " + value.kind_name());
      script.name = value.text();
    } else if (key == "repeat") {
      script.repeat = Boolean(value, at);
    } else if (key == "hand") {
      ParseHand(value, script);
    } else if (key == "waypoints") {
      if (!value.is_array()) throw Complaint(at + ": an array is expected, found " + value.kind_name());
      if (value.elements().size() > kWaypointsMax) {
        throw Complaint(at + ": " + std::to_string(value.elements().size()) + " waypoints, the limit is " +
                        std::to_string(kWaypointsMax));
      }
      for (const Json& waypoint : value.elements())
        script.waypoints.push_back(ParseWaypoint(waypoint, at + "/" + std::to_string(script.waypoints.size())));
    } else if (key != "comment") {
      throw Complaint(at + ": unknown key; known are name, repeat, hand, waypoints, comment");
    }
  }
  return script;
}

std::string CheckWaypoint(const HandWaypoint& waypoint, const std::string& pointer) {
  if (!Within(waypoint.duration_s, 0, kDurationMax_s)) {
    return OutOfRange(pointer + "/s", waypoint.duration_s, 0, kDurationMax_s, "s");
  }
  const double tip[] = {waypoint.tip_base_m.x, waypoint.tip_base_m.y, waypoint.tip_base_m.z};
  for (std::size_t i = 0; i < 3; ++i) {
    if (!Within(tip[i], -kReachMax_m, kReachMax_m)) {
      return OutOfRange(pointer + "/tip_m/" + std::to_string(i), tip[i], -kReachMax_m, kReachMax_m, "m");
    }
  }
  const double length = Norm(waypoint.axis_base);
  if (!Within(length, 1 - 1e-6, 1 + 1e-6)) return OutOfRange(pointer + "/axis", length, 1, 1, "(its length)");
  return "";
}

}  // namespace

double HandScript::duration_s() const {
  double sum_s = 0;
  for (std::size_t i = 1; i < waypoints.size(); ++i) sum_s += waypoints[i].duration_s;
  return sum_s;
}

// The ranges keep the hand's sub-step of .25 ms stable: k dt^2 <= .016 m and c dt <= .5 m at the least mass.
std::string CheckHandScript(const HandScript& script) {
  if (script.waypoints.empty()) return "/waypoints: at least one waypoint is needed, the start";
  if (script.waypoints.size() > kWaypointsMax) {
    return "/waypoints: " + std::to_string(script.waypoints.size()) + " waypoints, the limit is " +
           std::to_string(kWaypointsMax);
  }
  if (!Within(script.stiffness_N_m, 1, 5000)) {
    return OutOfRange("/hand/stiffness_N_m", script.stiffness_N_m, 1, 5000, "N/m");
  }
  if (!Within(script.damping_Ns_m, 0, 40)) {
    return OutOfRange("/hand/damping_Ns_m", script.damping_Ns_m, 0, 40, "N s/m");
  }
  if (!Within(script.mass_kg, 0.02, 5)) return OutOfRange("/hand/mass_kg", script.mass_kg, 0.02, 5, "kg");
  if (!Within(script.tremor_m, 0, 5e-3)) return OutOfRange("/hand/tremor_m", script.tremor_m, 0, 5e-3, "m");
  const auto& [from_Hz, to_Hz] = script.tremor_band;
  if (!Within(from_Hz, 0.5, 30)) return OutOfRange("/hand/tremor_from_Hz", from_Hz, 0.5, 30, "Hz");
  if (!Within(to_Hz, from_Hz, 30)) return OutOfRange("/hand/tremor_to_Hz", to_Hz, from_Hz, 30, "Hz");
  for (std::size_t i = 0; i < script.waypoints.size(); ++i) {
    std::string complaint = CheckWaypoint(script.waypoints[i], "/waypoints/" + std::to_string(i));
    if (!complaint.empty()) return complaint;
  }
  if (script.repeat && script.waypoints.size() > 1 &&
      !(script.duration_s() + script.waypoints.front().duration_s > 0)) {
    return "/repeat: the waypoints take no time at all; give at least one of them s > 0";
  }
  return "";
}

base::Result<HandScript> LoadHandScript(const std::string& path) {
  const base::Result<std::string> text = base::ReadFile(path, kLimits.bytes);
  if (!text.ok()) return base::Error{text.error()};
  const base::Result<base::JsonDocument> document = base::JsonDocument::Parse(*text, kLimits);
  if (!document.ok()) return base::Error{path + ": not valid JSON: " + document.error()};
  try {
    HandScript script = Parse(document->root());
    const std::string complaint = CheckHandScript(script);
    if (!complaint.empty()) return base::Error{path + ": " + complaint};
    return script;
  } catch (const Complaint& complaint) {
    return base::Error{path + ": " + complaint.what()};
  }
}

}  // namespace omni::sim
