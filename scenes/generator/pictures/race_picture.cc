#include "scenes/generator/pictures/race_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <glm/geometric.hpp>
#include <sstream>
#include <stdexcept>

namespace omni::scenes {
namespace {

constexpr double kLine_m = 0.00045;      // half width
constexpr double kLeastStep_m = 0.0002;  // between points of the line
constexpr double kStar_m = 0.0022;
const Vec kStarColour(0.95, 0.02, 0.01), kWhite(0.95, 0.95, 0.95);

struct LapColour {
  const char* name;
  Vec colour;
};
const std::array<LapColour, 4> kLapColours = {{{"blue", Vec(0.02, 0.25, 0.95)},
                                               {"yellow", Vec(0.98, 0.72, 0.02)},
                                               {"green", Vec(0.05, 0.75, 0.10)},
                                               {"violet", Vec(0.55, 0.05, 0.80)}}};

std::vector<std::string> Split(const std::string& line) {
  std::vector<std::string> fields;
  std::istringstream stream(line);
  for (std::string field; std::getline(stream, field, ',');) fields.push_back(field);
  return fields;
}

// A flat figure that is seen from above, through everything.
DrawnMesh Flat(const Vec& colour) {
  DrawnMesh drawn;
  drawn.overlay = true;
  drawn.roughness = 1;
  drawn.mesh.colours = {colour};
  return drawn;
}

void Finish(DrawnMesh& drawn) {
  const Vec colour = drawn.mesh.colours.front();
  drawn.mesh.colours.assign(drawn.mesh.positions.size(), colour);
  drawn.normals.assign(drawn.mesh.positions.size(), Vec(0, 0, 1));
}

void AddTriangle(const Vec& a, const Vec& b, const Vec& c, DrawnMesh& drawn) {
  const auto first = static_cast<std::uint32_t>(drawn.mesh.positions.size());
  for (const Vec& p : {a, b, c}) drawn.mesh.positions.push_back(p);
  drawn.mesh.triangles.push_back({first, first + 1, first + 2});
}

void AddLine(const Vec& from, const Vec& to, double half_m, DrawnMesh& drawn) {
  const Vec along = glm::normalize(to - from) * half_m, left(-along.y, along.x, 0);
  const Vec a = from - along - left, b = to + along - left, c = to + along + left, d = from - along + left;
  AddTriangle(a, b, c, drawn);
  AddTriangle(a, c, d, drawn);
}

void AddStar(const Vec& centre, DrawnMesh& drawn) {
  constexpr int kPoints = 8;
  constexpr double kTurn = 3.14159265358979323846 / kPoints;
  const auto corner = [&](int i) {
    const double radius_m = i % 2 == 0 ? kStar_m : 0.5 * kStar_m;
    return centre + Vec(std::cos(i * kTurn), std::sin(i * kTurn), 0) * radius_m;
  };
  for (int i = 0; i < 2 * kPoints; ++i) AddTriangle(centre, corner(i), corner(i + 1), drawn);
}

Vec PlaceOf(const RacePoint& point, double height_m) { return {point.x_m, point.y_m, height_m}; }

}  // namespace

std::vector<RacePoint> ReadRace(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  if (!std::getline(file, line)) throw std::runtime_error(path + ": cannot be read; record it with omnid --record");
  const std::vector<std::string> header = Split(line);
  std::array<std::size_t, 8> column{};
  const char* const names[] = {"t_ns",     "car",      "car_x_m",       "car_y_m", "car_heading_rad",
                               "car_hits", "car_laps", "car_last_lap_s"};
  for (std::size_t k = 0; k < column.size(); ++k) {
    const auto found = std::find(header.begin(), header.end(), names[k]);
    if (found == header.end()) throw std::runtime_error(path + ": has no column " + names[k]);
    column[k] = static_cast<std::size_t>(found - header.begin());
  }
  std::vector<RacePoint> race;
  while (std::getline(file, line)) {
    const std::vector<std::string> fields = Split(line);
    if (fields.size() != header.size()) continue;  // cut off by the end of the service
    const auto at = [&](std::size_t k) { return std::strtod(fields[column[k]].c_str(), nullptr); };
    if (at(1) < 0.5) continue;
    race.push_back(
        {at(0) * 1e-9, at(2), at(3), at(4), static_cast<unsigned>(at(5)), static_cast<unsigned>(at(6)), at(7)});
  }
  if (race.empty()) throw std::runtime_error(path + ": no car was driven in it");
  return race;
}

std::vector<DrawnMesh> DrawRace(const std::vector<RacePoint>& race, double height_m) {
  std::vector<DrawnMesh> drawn;
  DrawnMesh rims = Flat(kWhite), stars = Flat(kStarColour), car = Flat(kWhite);
  unsigned lap = race.front().laps, hits = race.front().hits;
  DrawnMesh line = Flat(kLapColours[lap % kLapColours.size()].colour);
  Vec last = PlaceOf(race.front(), height_m);
  for (const RacePoint& point : race) {
    const Vec place = PlaceOf(point, height_m);
    if (point.hits != hits) AddStar(place + Vec(0, 0, 3e-4), stars);
    hits = point.hits;
    if (glm::length(place - last) >= kLeastStep_m) {
      AddLine(last, place, kLine_m, line);
      AddLine(last - Vec(0, 0, 1e-4), place - Vec(0, 0, 1e-4), 1.5 * kLine_m, rims);
      last = place;
    }
    if (point.laps == lap) continue;
    lap = point.laps;
    drawn.push_back(std::move(line));
    line = Flat(kLapColours[lap % kLapColours.size()].colour);
  }
  drawn.push_back(std::move(line));
  const Vec ahead(std::cos(race.back().heading_rad), std::sin(race.back().heading_rad), 0), left(-ahead.y, ahead.x, 0);
  const Vec end = PlaceOf(race.back(), height_m) + Vec(0, 0, 4e-4);
  AddTriangle(end + ahead * 0.004, end - ahead * 0.002 + left * 0.0022, end - ahead * 0.002 - left * 0.0022, car);
  for (DrawnMesh* mesh : {&rims, &stars, &car}) drawn.push_back(std::move(*mesh));
  std::erase_if(drawn, [](const DrawnMesh& mesh) { return mesh.mesh.triangles.empty(); });
  for (DrawnMesh& mesh : drawn) Finish(mesh);
  return drawn;
}

std::string RaceCaption(const std::vector<RacePoint>& race) {
  const unsigned laps = race.back().laps, hits = race.back().hits;
  std::string text = std::to_string(laps) + (laps == 1 ? " lap" : " laps");
  unsigned counted = 0;
  for (const RacePoint& point : race) {
    if (point.laps <= counted) continue;
    char words[48];
    std::snprintf(words, sizeof(words), "%s %.2f s (%s)", counted == 0 ? ":" : ",", point.last_lap_s,
                  kLapColours[counted % kLapColours.size()].name);
    counted = point.laps;
    text += words;
  }
  return text + "; " + std::to_string(hits) + (hits == 1 ? " hit" : " hits") + " (red)";
}

}  // namespace omni::scenes
