// HandScript files: JSON in, ranges checked, every complaint with file and JSON pointer.
#include <sys/stat.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

#include "service/sim/hand.h"

namespace omni::sim {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kWaypointsMax = 10000;
constexpr std::uintmax_t kFileSizeMax = 8U << 20;
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

std::string Below(const std::string& pointer, const std::string& key) { return pointer + "/" + key; }

bool Within(double value, double low, double high) { return value >= low && value <= high; }

double Number(const Json& json, const std::string& pointer) {
  if (!json.is_number()) throw Complaint(pointer + ": a number is expected, found " + json.type_name());
  return json.get<double>();
}

Vec3 Vector(const Json& json, const std::string& pointer) {
  if (!json.is_array() || json.size() != 3) {
    throw Complaint(pointer + ": an array of three numbers [x, y, z] is expected");
  }
  return {Number(json[0], pointer + "/0"), Number(json[1], pointer + "/1"), Number(json[2], pointer + "/2")};
}

bool Boolean(const Json& json, const std::string& pointer) {
  if (!json.is_boolean()) throw Complaint(pointer + ": true or false is expected, found " + json.type_name());
  return json.get<bool>();
}

HandWaypoint ParseWaypoint(const Json& json, const std::string& pointer) {
  if (!json.is_object()) throw Complaint(pointer + ": an object is expected, found " + json.type_name());
  HandWaypoint waypoint;
  bool has_tip = false;
  for (const auto& [key, value] : json.items()) {
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
  if (!json.is_object()) throw Complaint(std::string("/hand: an object is expected, found ") + json.type_name());
  const std::pair<const char*, double*> fields[] = {{"stiffness_N_m", &script.stiffness_N_m},
                                                    {"damping_Ns_m", &script.damping_Ns_m},
                                                    {"mass_kg", &script.mass_kg},
                                                    {"tremor_m", &script.tremor_m}};
  for (const auto& [key, value] : json.items()) {
    bool known = false;
    for (const auto& [name, field] : fields) {
      if (key != name) continue;
      *field = Number(value, "/hand/" + key);
      known = true;
    }
    if (!known) {
      throw Complaint("/hand/" + key + ": unknown key; known are stiffness_N_m, damping_Ns_m, mass_kg, tremor_m");
    }
  }
}

HandScript Parse(const Json& json) {
  if (!json.is_object()) throw Complaint(std::string("/: an object is expected, found ") + json.type_name());
  HandScript script;
  for (const auto& [key, value] : json.items()) {
    const std::string at = "/" + key;
    if (key == "name") {
      if (!value.is_string()) throw Complaint(at + ": a text is expected, found " + value.type_name());
      script.name = value.get<std::string>();
    } else if (key == "repeat") {
      script.repeat = Boolean(value, at);
    } else if (key == "hand") {
      ParseHand(value, script);
    } else if (key == "waypoints") {
      if (!value.is_array()) throw Complaint(at + ": an array is expected, found " + value.type_name());
      if (value.size() > kWaypointsMax) break;  // reported below with its count
      for (std::size_t i = 0; i < value.size(); ++i) {
        script.waypoints.push_back(ParseWaypoint(value[i], at + "/" + std::to_string(i)));
      }
    } else if (key != "comment") {
      throw Complaint(at + ": unknown key; known are name, repeat, hand, waypoints, comment");
    }
  }
  if (json.contains("waypoints") && json["waypoints"].size() > kWaypointsMax) {
    throw Complaint("/waypoints: " + std::to_string(json["waypoints"].size()) + " waypoints, the limit is " +
                    std::to_string(kWaypointsMax));
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
  std::ifstream file(path, std::ios::binary);
  if (!file) return base::Error{path + ": cannot be opened: check the path and its permissions"};
  struct stat status {};
  if (stat(path.c_str(), &status) != 0 || !S_ISREG(status.st_mode)) {
    return base::Error{path + ": is not a regular file: give a hand script in JSON"};
  }
  if (static_cast<std::uintmax_t>(status.st_size) > kFileSizeMax) {
    return base::Error{path + ": " + std::to_string(status.st_size) + " bytes, the limit is " +
                       std::to_string(kFileSizeMax)};
  }
  try {
    HandScript script = Parse(Json::parse(file));
    const std::string complaint = CheckHandScript(script);
    if (!complaint.empty()) return base::Error{path + ": " + complaint};
    return script;
  } catch (const Complaint& complaint) {
    return base::Error{path + ": " + complaint.what()};
  } catch (const Json::exception& error) {
    return base::Error{path + ": not valid JSON: " + error.what()};
  }
}

}  // namespace omni::sim
