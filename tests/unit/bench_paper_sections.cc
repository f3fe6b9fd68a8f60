// The published numbers beside ours: what the comparison promises, and that it can fail.
#include <gtest/gtest.h>

#include <cmath>

#include "service/config/device_file.h"
#include "tests/bench/harness/bench_plot.h"
#include "tests/bench/paper/paper.h"
#include "tests/bench/paper/paper_force_models.h"

namespace omni::bench {
namespace {

using nlohmann::ordered_json;

const ordered_json& RowOf(const PaperSection& section, const std::string& quantity) {
  for (const ordered_json& row : section.rows) {
    if (row.at("quantity") == quantity) return row;
  }
  ADD_FAILURE() << quantity;
  return section.rows.front();
}

void ExpectPicture(const std::string& svg) {
  EXPECT_EQ(svg.rfind("<svg", 0), 0U);
  EXPECT_NE(svg.find("</svg>"), std::string::npos);
  EXPECT_EQ(svg.find("nan"), std::string::npos);
}

TEST(Paper, ForcesFitTheTextWithinFifteenPercent) {
  const PaperSection section = PaperForces(config::DefaultDevice());
  const ordered_json& rms = RowOf(section, "rms deviation from the text, %");
  EXPECT_LT(rms.at("twin_fitted").get<double>(), 15);
  EXPECT_LT(rms.at("ours_fitted").get<double>(), 15);
  EXPECT_GT(rms.at("twin_41mm").get<double>(), 40);       // the nominal geometry does not fit
  EXPECT_GT(rms.at("paper_law_41mm").get<double>(), 80);  // nor does the dipole law with the sensors' C
  EXPECT_TRUE(RowOf(section, "snapping, N").at("paper_law_41mm").is_null());
  EXPECT_FALSE(section.notes.empty());
  ExpectPicture(section.figure_svg);
}

TEST(Paper, OurForcesAreTheTwinsAtContact) {
  const base::DeviceGeometry& device = config::DefaultDevice();
  const ForceTable twin = TwinForces(device, 0.041, device.core_kappa),
                   ours = OurForces(device, 0.041, device.core_kappa);
  EXPECT_NEAR(ours.radial_z_N_A / twin.radial_z_N_A, 1, 0.03);
  EXPECT_NEAR(ours.tangential_y_N_A / twin.tangential_y_N_A, 1, 0.04);
  EXPECT_NEAR(ours.snapping_N / twin.snapping_N, 1, 0.05);
  EXPECT_NEAR(twin.radial_z_N_A, 0.240, 0.005);
  EXPECT_NEAR(twin.snapping_N, 0.469, 0.01);
}

TEST(Paper, HeatMeetsTheThreeTemperatures) {
  const PaperSection section = PaperHeat(config::DefaultDevice());
  for (const char* model : {"twin", "twin_fitted", "ours"}) {
    EXPECT_NEAR(RowOf(section, "15 A, 25 s: peak, C").at(model).get<double>(), 39, 1) << model;
    EXPECT_NEAR(RowOf(section, "15 A, 25 s: time of the peak, s").at(model).get<double>(), 65, 5) << model;
    EXPECT_NEAR(RowOf(section, "5 A, 15 min: end, C").at(model).get<double>(), 47, 1) << model;
  }
  ExpectPicture(section.figure_svg);
}

TEST(Paper, DecayIsSlowerThanTheDipoles) {
  const PaperSection section = PaperDecay(config::DefaultDevice());
  ASSERT_EQ(section.rows.size(), 3U);
  EXPECT_NEAR(section.rows[1].at("paper_law_N").get<double>(), 0.835, 0.002);
  EXPECT_GT(section.rows[1].at("twin_radial_N").get<double>(), 0.95);
  EXPECT_NEAR(section.rows[2].at("ours_radial_N").get<double>() / section.rows[2].at("twin_radial_N").get<double>(), 1,
              0.02);
  ExpectPicture(section.figure_svg);
}

TEST(Paper, TrackingRunsOnFewPoses) {
  const PaperSection section = PaperTracking(config::DefaultDevice(), {.seed = 9001, .rigs = 2, .poses = 8});
  for (const ordered_json& row : section.rows) {
    if (row.at("quantity") != "mean_mm") continue;
    EXPECT_GT(row.at("paper_method_on_twin").get<double>(), 1.5);
    EXPECT_LT(row.at("ours").get<double>(), 1);
  }
  ExpectPicture(section.figure_svg);
}

TEST(BenchPlot, DrawsSolversAndTracking) {
  const nlohmann::json solver = {{"name", "solver"},
                                 {"commit", "abc"},
                                 {"machine", "m"},
                                 {"rows",
                                  {{{"method", "omni"},
                                    {"model", "default"},
                                    {"start", "warm"},
                                    {"precision", "float"},
                                    {"us_median", 1.1},
                                    {"rms_mm", 0.18}},
                                   {{"method", "ceres-analytic"},
                                    {"model", "full"},
                                    {"start", "cold"},
                                    {"precision", "double"},
                                    {"us_median", 44},
                                    {"rms_mm", 0.18}},
                                   {{"method", "broken"}, {"us_median", nullptr}},
                                   3}}};
  const auto picture = DrawBench(solver, "s.json");
  ASSERT_TRUE(picture.ok()) << picture.error();
  ExpectPicture(*picture);
  EXPECT_NE(picture->find("ceres-analytic, cold"), std::string::npos);
  EXPECT_EQ(picture->find("broken"), std::string::npos);
  const nlohmann::json tracking = {{"name", "tracking"},
                                   {"rows",
                                    {{{"model", "default"},
                                      {"noise", "UHP"},
                                      {"actuation_A", 4},
                                      {"currents", "hidden"},
                                      {"moving", true},
                                      {"mean_mm", 0.2},
                                      {"p95_mm", 0.5},
                                      {"max_mm", 1.1}}}}};
  const auto bars = DrawBench(tracking, "t.json");
  ASSERT_TRUE(bars.ok()) << bars.error();
  EXPECT_NE(bars->find("default, UHP, +-4 A hidden, moving"), std::string::npos);
}

TEST(BenchPlot, DrawsTheLayerAndAlignment) {
  nlohmann::json motions = nlohmann::json::array({3});
  for (const char* motion : {"extrusion", "free strokes, seed 1", "free strokes, seed 2"}) {
    for (const char* method : {"layer", "hold last"}) {
      for (const double ms : {10, 20, 40}) {
        motions.push_back({{"motion", motion}, {"method", method}, {"horizon_ms", ms}, {"error_mm_p95", 0.05 * ms}});
      }
    }
  }
  const auto lines =
      DrawBench({{"name", "layer"}, {"rows", nlohmann::json::array()}, {"tables", {{"motions", motions}}}}, "l.json");
  ASSERT_TRUE(lines.ok()) << lines.error();
  ExpectPicture(*lines);
  const std::size_t named = lines->find("free strokes, layer");
  EXPECT_NE(named, std::string::npos);
  EXPECT_EQ(lines->find("free strokes, layer", named + 1), std::string::npos) << "once in the legend";
  const nlohmann::json row = {
      {"method", "touch, 6 DoF"}, {"predicted_mm", 2.4}, {"error_mm_median", 2.2}, {"error_mm_p95", 4.1}};
  const auto marks = DrawBench({{"name", "align"}, {"rows", {row, {{"method", "refused"}}}}}, "a.json");
  ASSERT_TRUE(marks.ok()) << marks.error();
  ExpectPicture(*marks);
  EXPECT_NE(marks->find("touch, median"), std::string::npos);
  EXPECT_EQ(marks->find("refused"), std::string::npos);
}

TEST(BenchPlot, RefusesWhatItCannotDraw) {
  EXPECT_FALSE(DrawBench({{"name", "layer"}, {"rows", nlohmann::json::array()}}, "x").ok());
  EXPECT_FALSE(DrawBench({{"name", "align"}, {"rows", nlohmann::json::array()}}, "x").ok());
  EXPECT_FALSE(DrawBench(nlohmann::json::parse("[", nullptr, false), "x").ok());
  EXPECT_FALSE(DrawBench({{"name", "solver"}, {"rows", nlohmann::json::array()}}, "x").ok());
  const auto loop = DrawBench({{"name", "loop"}, {"rows", nlohmann::json::array()}}, "x.json");
  ASSERT_FALSE(loop.ok());
  EXPECT_NE(loop.error().find("loop"), std::string::npos);
}

}  // namespace
}  // namespace omni::bench
