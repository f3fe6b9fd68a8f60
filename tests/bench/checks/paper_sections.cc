// The comparison with the published numbers: its results, and that it can fail.
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "service/config/files/device_file.h"
#include "service/tools/common/row_table.h"
#include "tests/bench/paper/paper.h"
#include "tests/bench/paper/paper_force_models.h"

namespace omni::bench {
namespace test_bench_paper_sections {

using nlohmann::ordered_json;

const ordered_json& RowOf(const PaperSection& section, const std::string& quantity) {
  for (const ordered_json& row : section.rows) {
    if (!row.contains("table") && row.at("quantity") == quantity) return row;
  }
  ADD_FAILURE() << quantity;
  return section.rows.front();
}

// Removes and returns the rows of a side table that scripts/plot draws; the section's own rows remain.
tools::Rows TakeTable(tools::Rows& rows, const std::string& name) {
  for (auto& [table, side] : tools::TakeSideTables(rows)) {
    if (table == name) return side;
  }
  ADD_FAILURE() << name;
  return {};
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
}

TEST(Paper, ForceLinesMatchTheSectionRows) {
  PaperSection section = PaperForces(config::DefaultDevice());
  const double up_N = RowOf(section, "radial, I_z = +14.6 A, N").at("twin_fitted");
  const double down_N = RowOf(section, "radial, I_z = -14.6 A, N").at("twin_fitted");
  const double text_N = RowOf(section, "radial, I_z = +14.6 A, N").at("paper");
  double low_N = 0, high_N = 0;
  int of_text = 0;
  for (const ordered_json& row : TakeTable(section.rows, "force lines")) {
    if (row.at("direction") != "radial") continue;
    if (row.at("of_text") && row.at("current_A") == 14.6) {
      EXPECT_EQ(row.at("force_N"), text_N);
      ++of_text;
    }
    if (row.at("series") != "twin, fitted geometry") continue;
    (row.at("current_A") > 0 ? high_N : low_N) = row.at("force_N");
  }
  EXPECT_EQ(of_text, 1);
  EXPECT_NEAR((high_N - low_N) / 30, (up_N - down_N) / 29.2, 1e-9);
  EXPECT_NEAR(high_N + low_N, up_N + down_N, 1e-9);
}

TEST(Paper, ForceMapMatchesTheTwinAtContact) {
  const base::DeviceGeometry& device = config::DefaultDevice();
  const ForceTable twin = TwinForces(device, 0.041, device.core_kappa),
                   ours = OurForces(device, 0.041, device.core_kappa);
  EXPECT_NEAR(ours.radial_z_N_A / twin.radial_z_N_A, 1, 0.03);
  EXPECT_NEAR(ours.tangential_y_N_A / twin.tangential_y_N_A, 1, 0.04);
  EXPECT_NEAR(ours.snapping_N / twin.snapping_N, 1, 0.05);
  EXPECT_NEAR(twin.radial_z_N_A, 0.240, 0.005);
  EXPECT_NEAR(twin.snapping_N, 0.469, 0.01);
}

TEST(Paper, HeatModelsMatchThePublishedTemperatures) {
  const PaperSection section = PaperHeat(config::DefaultDevice());
  for (const char* model : {"twin", "twin_fitted", "ours"}) {
    EXPECT_NEAR(RowOf(section, "15 A, 25 s: peak, C").at(model).get<double>(), 39, 1) << model;
    EXPECT_NEAR(RowOf(section, "15 A, 25 s: time of the peak, s").at(model).get<double>(), 65, 5) << model;
    EXPECT_NEAR(RowOf(section, "5 A, 15 min: end, C").at(model).get<double>(), 47, 1) << model;
  }
}

TEST(Paper, HeatCurvesMatchTheSectionRows) {
  PaperSection section = PaperHeat(config::DefaultDevice());
  const double peak_C = RowOf(section, "15 A, 25 s: peak, C").at("twin_fitted");
  const double end_C = RowOf(section, "5 A, 15 min: end, C").at("twin_fitted");
  double highest_C = 0, last_C = 0;
  int seconds = 0;
  for (const ordered_json& row : TakeTable(section.rows, "heat curves")) {
    ++seconds;
    if (row.at("run") == "15 A for 25 s") highest_C = std::max(highest_C, row.at("body_C").get<double>());
    if (row.at("run") == "5 A for 15 min") last_C = row.at("body_C");
  }
  EXPECT_EQ(seconds, 181 + 901);
  EXPECT_NEAR(highest_C, peak_C, 0.01);
  EXPECT_NEAR(last_C, end_C, 0.01);
}

TEST(Paper, ForceDecaysSlowerThanTheDipoleLaw) {
  PaperSection section = PaperDecay(config::DefaultDevice());
  const tools::Rows curve = TakeTable(section.rows, "decay curve");
  ASSERT_EQ(curve.size(), 13U);
  EXPECT_EQ(curve.back().at("gap_mm"), 60);
  ASSERT_EQ(section.rows.size(), 3U);
  EXPECT_NEAR(section.rows[1].at("paper_law_N").get<double>(), 0.835, 0.002);
  EXPECT_GT(section.rows[1].at("twin_radial_N").get<double>(), 0.95);
  EXPECT_NEAR(section.rows[2].at("ours_radial_N").get<double>() / section.rows[2].at("twin_radial_N").get<double>(), 1,
              0.02);
  EXPECT_EQ(curve[2].at("twin_radial_N"), section.rows[1].at("twin_radial_N"));  // both at 10 mm
}

TEST(Paper, MagnetSizeTableContainsTheBestSizes) {
  PaperSection section = PaperMagnets(config::DefaultDevice());
  const tools::Rows sizes = TakeTable(section.rows, "magnet sizes");
  ASSERT_EQ(section.rows.size(), 3U);
  ASSERT_EQ(sizes.size(), 441U);
  const std::pair<std::size_t, const char*> models[] = {{0, "paper_law_N"}, {1, "twin_N"}, {2, "ours_N"}};
  for (const auto& [at, key] : models) {
    const ordered_json* best = &sizes.front();
    for (const ordered_json& size : sizes) {
      if (size.at(key) > best->at(key)) best = &size;
    }
    EXPECT_EQ(best->at(key), section.rows[at].at("best_of_all_N")) << key;
    EXPECT_EQ(best->at("radius_mm"), section.rows[at].at("at_radius_mm")) << key;
    EXPECT_EQ(best->at("height_mm"), section.rows[at].at("at_height_mm")) << key;
  }
}

TEST(Paper, TrackingSectionBeatsThePaperMethodOnFewPoses) {
  PaperSection section = PaperTracking(config::DefaultDevice(), {.seed = 9001, .rigs = 2, .poses = 8});
  const tools::Rows bins = TakeTable(section.rows, "tracking distribution");
  ASSERT_EQ(bins.size(), 80U);
  double share_pct = 0;
  for (const ordered_json& bin : bins) share_pct += bin.at("share_pct").get<double>();
  EXPECT_GT(share_pct, 150);  // of two conditions; errors beyond 20 mm are in no bin
  EXPECT_LT(share_pct, 200.001);
  for (const ordered_json& row : section.rows) {
    if (row.at("quantity") != "mean_mm") continue;
    EXPECT_GT(row.at("paper_method_on_twin").get<double>(), 1.5);
    EXPECT_LT(row.at("ours").get<double>(), 1);
  }
}

}  // namespace test_bench_paper_sections
}  // namespace omni::bench
