// Fig. 8 and the decay with the gap. The test rig put a second hemisphere and force sensors between base and magnet, so
// the distance of the magnet is not known: it is fitted, with the core's strength, and results for the nominal contact
// at 41 mm are listed too.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>

#include "tests/bench/paper/paper.h"
#include "tests/bench/paper/paper_force_models.h"

namespace omni::bench {
namespace {

constexpr double kWeight_N = 0.370;  // in the text, of magnet and tool
constexpr double kFullCurrent_A = 14.6;

// One number of the text and a model's value for it.
struct TextForce {
  const char* quantity;
  double paper;
  double (*model)(const ForceTable&);
};
constexpr TextForce kTexts[] = {
    {"radial, I_z = +14.6 A, N", 1.95,
     [](const ForceTable& f) { return kFullCurrent_A * f.radial_z_N_A - f.snapping_N - kWeight_N; }},
    {"radial, I_z = -14.6 A, N", -3.04,
     [](const ForceTable& f) { return -kFullCurrent_A * f.radial_z_N_A - f.snapping_N - kWeight_N; }},
    {"snapping, N", 0.17, [](const ForceTable& f) { return f.snapping_N; }},
    {"slope of I_x, N/A", 0.122, [](const ForceTable& f) { return f.tangential_x_N_A; }},
    {"slope of I_y, N/A", 0.142, [](const ForceTable& f) { return f.tangential_y_N_A; }},
    {"peak, I_y = 15 A, N", 2.04, [](const ForceTable& f) { return 15 * f.tangential_y_N_A; }},
    {"constant, I_y = 5 A, N", 0.615, [](const ForceTable& f) { return 5 * f.tangential_y_N_A; }},
};

// Root mean square of the relative deviations from the text, %. `with_snapping` false: the model has none.
double Rms_pct(const ForceTable& forces, bool with_snapping) {
  double square = 0;
  int count = 0;
  for (const TextForce& text : kTexts) {
    if (!with_snapping && text.paper == 0.17) continue;
    const double deviation = text.model(forces) / text.paper - 1;
    square += deviation * deviation;
    ++count;
  }
  return 100 * std::sqrt(square / count);
}

struct Fit {
  double distance_m = 0.045, kappa = 0.8;
  ForceTable forces;
  double rms_pct = 0;
};

// Compass search: try a step each way, halve the steps when none helps [Hooke & Jeeves 1961].
Fit FitGeometry(const std::function<ForceTable(double, double)>& model) {
  Fit best;
  best.forces = model(best.distance_m, best.kappa);
  best.rms_pct = Rms_pct(best.forces, true);
  double step_m = 2e-3, step_kappa = 0.1;
  while (step_m > 2e-5) {
    bool better = false;
    for (const auto& [dm, dk] : {std::pair{1.0, 0.0}, {-1.0, 0.0}, {0.0, 1.0}, {0.0, -1.0}}) {
      Fit next;
      next.distance_m = std::clamp(best.distance_m + dm * step_m, 0.041, 0.060);
      next.kappa = std::clamp(best.kappa + dk * step_kappa, 0.0, 1.0);
      next.forces = model(next.distance_m, next.kappa);
      next.rms_pct = Rms_pct(next.forces, true);
      if (!(next.rms_pct < best.rms_pct)) continue;
      best = next;
      better = true;
    }
    if (!better) step_m /= 2, step_kappa /= 2;
  }
  return best;
}

// The law with its one free number, the "few-point calibration": all forces times `scale`, least squares.
double FitScale(const ForceTable& law) {
  double top = 0, bottom = 0;
  for (const TextForce& text : kTexts) {
    if (text.paper == 0.17) continue;
    const double offset = text.model(ForceTable{}), share = (text.model(law) - offset) / text.paper;
    top += share * (1 - offset / text.paper);
    bottom += share * share;
  }
  return top / bottom;
}

ForceTable Scaled(ForceTable forces, double scale) {
  forces.radial_x_N_A *= scale, forces.radial_y_N_A *= scale, forces.radial_z_N_A *= scale;
  forces.tangential_x_N_A *= scale, forces.tangential_y_N_A *= scale;
  return forces;
}

std::string Text(const char* format, double a, double b) {
  char text[256];
  std::snprintf(text, sizeof(text), format, a, b);
  return text;
}

// Force over current for the figure: the text's points, and one line per model through both ends of the axis.
struct TextPoint {
  const char* direction;
  const char* series;
  double current_A, force_N;
};
constexpr TextPoint kTextPoints[] = {
    {"radial", "numbers in the text", 14.6, 1.95},
    {"radial", "numbers in the text", -14.6, -3.04},
    {"radial", "numbers in the text", 0, -0.54},
    {"radial", "numbers in the text", 3.7, 0},
    {"tangential", "text: I_x 0.122 N/A, I_y 0.142 N/A", -14.6, -14.6 * 0.122},
    {"tangential", "text: I_x 0.122 N/A, I_y 0.142 N/A", 14.6, 14.6 * 0.122},
    {"tangential", "text: I_x 0.122 N/A, I_y 0.142 N/A", -14.6, -14.6 * 0.142},
    {"tangential", "text: I_x 0.122 N/A, I_y 0.142 N/A", 14.6, 14.6 * 0.142},
    {"tangential", "text: 2.04 N at 15 A, 0.615 N at 5 A", 15, 2.04},
    {"tangential", "text: 2.04 N at 15 A, 0.615 N at 5 A", 5, 0.615},
};

void AddForceLines(const ForceTable& law, const ForceTable& nominal, const ForceTable& fitted, BenchRows& rows) {
  const auto add = [&rows](const char* direction, const std::string& series, bool text, double current_A,
                           double force_N) {
    rows.push_back({{"table", "force lines"},
                    {"direction", direction},
                    {"series", series},
                    {"of_text", text},
                    {"current_A", current_A},
                    {"force_N", force_N}});
  };
  for (const TextPoint& point : kTextPoints) add(point.direction, point.series, true, point.current_A, point.force_N);
  const auto add_model = [&add](const std::string& name, const ForceTable& f) {
    for (const double current_A : {-15.0, 15.0}) {
      add("radial", name, false, current_A, current_A * f.radial_z_N_A - f.snapping_N - kWeight_N);
    }
    for (const double current_A : {-15.0, 15.0}) {
      add("tangential", name + ", I_y", false, current_A, current_A * f.tangential_y_N_A);
    }
  };
  add_model("twin, fitted geometry", fitted);
  add_model("twin, contact at 41 mm", nominal);
  add_model("paper's law, 41 mm, C of the sensors", law);
}

}  // namespace

PaperSection PaperForces(const base::DeviceGeometry& device) {
  PaperSection section{.title = "Forces against currents (Fig. 8)"};
  const double contact_m = device.hull_radius_m + device.magnet.half_height_m;
  const ForceTable law = PaperLawForces(device, contact_m);
  const ForceTable nominal = TwinForces(device, contact_m, device.core_kappa);
  const ForceTable ours = OurForces(device, contact_m, device.core_kappa);
  const Fit fitted = FitGeometry([&](double d, double kappa) { return TwinForces(device, d, kappa); });
  const ForceTable ours_fitted = OurForces(device, fitted.distance_m, fitted.kappa);
  const double scale = FitScale(law);
  const ForceTable law_fitted = Scaled(law, scale);
  for (const TextForce& text : kTexts) {
    const bool snapping = text.paper == 0.17;
    const auto law_value = [&](const ForceTable& f) {
      return snapping ? nlohmann::ordered_json() : nlohmann::ordered_json(text.model(f));
    };
    section.rows.push_back({{"quantity", text.quantity},
                            {"paper", text.paper},
                            {"paper_law_41mm", law_value(law)},
                            {"twin_41mm", text.model(nominal)},
                            {"ours_41mm", text.model(ours)},
                            {"paper_law_fitted", law_value(law_fitted)},
                            {"twin_fitted", text.model(fitted.forces)},
                            {"ours_fitted", text.model(ours_fitted)}});
  }
  section.rows.push_back({{"quantity", "rms deviation from the text, %"},
                          {"paper", nullptr},
                          {"paper_law_41mm", Rms_pct(law, false)},
                          {"twin_41mm", Rms_pct(nominal, true)},
                          {"ours_41mm", Rms_pct(ours, true)},
                          {"paper_law_fitted", Rms_pct(law_fitted, false)},
                          {"twin_fitted", fitted.rms_pct},
                          {"ours_fitted", Rms_pct(ours_fitted, true)}});
  section.notes = {
      Text("free parameters, twin and ours: distance %.2f mm (nominal contact 41 mm), core kappa %.3f (0.997)",
           1e3 * fitted.distance_m, fitted.kappa),
      Text("free parameter, paper's law: one factor %.3f on C at %.0f mm (its \"few-point calibration\")", scale,
           1e3 * contact_m),
      "magnet on top of the sphere: I_z acts radially, I_x and I_y tangentially (the text calls all three radial)",
      Text("read the other way, each coil radial on its own axis, the fit gives I_x %.3f and I_y %.3f N/A",
           fitted.forces.radial_x_N_A, fitted.forces.radial_y_N_A),
      Text("levitation: the text has 3.7 A; its own offset and slope give %.2f A, the fitted twin %.2f A",
           0.54 / ((1.95 + 3.04) / 29.2), (fitted.forces.snapping_N + kWeight_N) / fitted.forces.radial_z_N_A),
      "the paper's law has no pull of the core: its rms leaves the snapping out and counts the weight only"};
  AddForceLines(law, nominal, fitted.forces, section.rows);
  return section;
}

PaperSection PaperDecay(const base::DeviceGeometry& device) {
  PaperSection section{.title = "Decay with the gap, 2 N at contact (text: 1/(d0 + g)^4, d0 = 41 mm)"};
  constexpr double kPaperContact_N = 2;
  const double contact_m = device.hull_radius_m + device.magnet.half_height_m;
  const ForceTable twin_0 = TwinForces(device, contact_m, device.core_kappa);
  const ForceTable ours_0 = OurForces(device, contact_m, device.core_kappa);
  for (int gap_mm = 0; gap_mm <= 60; gap_mm += 5) {
    const double d = contact_m + 1e-3 * gap_mm;
    const ForceTable twin = TwinForces(device, d, device.core_kappa), ours = OurForces(device, d, device.core_kappa);
    const double law_N = kPaperContact_N * std::pow(contact_m / d, 4);
    const double twin_N = kPaperContact_N * twin.radial_z_N_A / twin_0.radial_z_N_A;
    const double side_N = kPaperContact_N * twin.tangential_x_N_A / twin_0.tangential_x_N_A;
    const double ours_N = kPaperContact_N * ours.radial_z_N_A / ours_0.radial_z_N_A;
    section.rows.push_back({{"table", "decay curve"},
                            {"gap_mm", gap_mm},
                            {"paper_law_N", law_N},
                            {"twin_radial_N", twin_N},
                            {"twin_tangential_N", side_N},
                            {"ours_radial_N", ours_N}});
    if (gap_mm != 0 && gap_mm != 10 && gap_mm != 30) continue;
    section.rows.push_back({{"gap_mm", gap_mm},
                            {"paper_N", gap_mm == 0    ? 2.0
                                        : gap_mm == 10 ? 0.835
                                                       : 0.2},
                            {"paper_law_N", law_N},
                            {"twin_radial_N", twin_N},
                            {"twin_tangential_N", side_N},
                            {"ours_radial_N", ours_N}});
  }
  section.notes = {
      "no free parameter; the text's 0.835 N and 0.2 N are its formula, not measurements: the twin keeps more "
      "radial force at a distance, since the core and the coils' width flatten the near field"};
  return section;
}

}  // namespace omni::bench
