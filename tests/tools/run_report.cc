// Evaluation of recordings: fabricated runs with known errors.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "service/tools/common/row_table.h"
#include "service/tools/recordings/report.h"
#include "service/tools/scene/scene.h"
#include "tests/support/process/temp_folder.h"

namespace omni::tools {
namespace test_tools_run_report {

class RunReportTest : public testing::Test {
 protected:
  void SetUp() override {
    files_ = {.loop = folder_.Path("loop.csv"), .truth = folder_.Path("truth.csv"), .app = folder_.Path("app.json")};
  }

  // 1000 ticks; the pen moves along x at 0.1 m/s; estimates are off by error_m along z; force in [300, 600). Known to
  // .5 mm, after tick 800 to 1.5 mm; not tracked in the last 50.
  void Write(double error_m) {
    std::ofstream loop(files_.loop);
    loop << "tick,t_ns,done_ns,late,status,magnet_x_m,magnet_y_m,magnet_z_m,axis_x,axis_y,axis_z,tip_x_m,tip_y_m,"
            "tip_z_m,force_x_N,force_y_N,force_z_N,contact,gate,select,thumb_x,thumb_y,haptic_pulses,sigma_m\n";
    std::ofstream truth(files_.truth);
    truth << "t_ns,present,magnet_x_m,magnet_y_m,magnet_z_m\n";
    for (int i = 0; i < 1000; ++i) {
      const double x = 1e-4 * i;
      loop << i << ',' << i * 1'000'000 + 500'000 << ",0," << (i % 100 == 0 ? 1 : 0) << (i < 950 ? ",2," : ",1,")
           << x + 0.5e-4 << ",0," << 0.05 + error_m << ",0,0,-1," << x << ",0,0.045,0,0,"
           << (i >= 300 && i < 600 ? 1.25 : 0) << ",0,1,0,0,0," << i / 400 << (i < 800 ? ",5e-4\n" : ",1.5e-3\n");
      truth << i * 1'000'000 << ",1," << x << ",0,0.05\n";
    }
    std::ofstream(files_.app)
        << R"({"application": "a", "profile": "/p", "select_edges": 3, "pose_valid_fraction": 0.99,
                                     "locate_ns_median": 250})";
  }

  const test::TempFolder folder_;
  RunFiles files_;
};

TEST_F(RunReportTest, MeasuresAgainstTheInterpolatedTruth) {
  Write(2e-4);
  RunData data;
  const auto report = MakeReport("test", files_, data);
  ASSERT_TRUE(report.ok()) << report.error();
  EXPECT_EQ(report->ticks, 1000U);
  EXPECT_EQ(report->late_ticks, 10U);
  EXPECT_EQ(report->tracking.compared_ticks, 950U);
  EXPECT_NEAR(report->tracked_fraction, 800.0 / 999, 1e-9) << "the last one lies after the truth's end";
  EXPECT_NEAR(report->coarse_fraction, 150.0 / 999, 1e-9);
  EXPECT_NEAR(report->tracking.mean_mm, 0.2, 1e-6);
  EXPECT_NEAR(report->tracking.p95_mm, 0.2, 1e-6);
  EXPECT_EQ(report->contact_ticks, 300U);
  EXPECT_DOUBLE_EQ(report->peak_force_N, 1.25);
  EXPECT_EQ(report->select_edges, 3U);
  EXPECT_EQ(report->haptic_pulses, 2U);
  EXPECT_TRUE(Shortcomings(*report).empty());
}

// The pen comes down to a gap of 5 mm; the coils push from 10 mm on, with a peak of 3 N for 4 ticks, of 1.5 N for 40.
TEST_F(RunReportTest, MeasuresGapAndForceWhileTheCoilsPush) {
  Write(0);
  std::ofstream truth(files_.truth);
  truth << "t_ns,present,magnet_x_m,magnet_y_m,magnet_z_m,force_x_N,force_y_N,force_z_N,coil_force_x_N,coil_force_y_N,"
           "coil_force_z_N,gap_m\n";
  for (int i = 0; i < 1000; ++i) {
    const double gap_m = 0.025 - 2e-5 * i;
    const double coil_N = gap_m > 0.010 ? 0 : i >= 800 && i < 804 ? 3 : i >= 900 && i < 940 ? 1.5 : 0.5;
    truth << i * 1'000'000 << ",1,0,0,0.05,0,0," << (coil_N > 0 ? coil_N - 0.1 : -2) << ",0,0," << coil_N << ','
          << gap_m << '\n';
  }
  truth.close();
  RunData data;
  const auto report = MakeReport("test", files_, data);
  ASSERT_TRUE(report.ok()) << report.error();
  EXPECT_NEAR(report->use.reached_N, 1.4, 1e-9) << "what the pen feels, five ticks long, while the coils push";
  EXPECT_NEAR(report->use.gap_mean_mm, 7.5, 0.02);
  EXPECT_NEAR(report->use.gap_p95_mm, 9.75, 0.03);
  EXPECT_NEAR(report->use.gap_max_mm, 10, 0.03);
  Write(0);  // a recording without forces
  const auto older = MakeReport("test", files_, data);
  ASSERT_TRUE(older.ok()) << older.error();
  EXPECT_TRUE(nlohmann::json::parse(ToJson(*older).dump()).at("gap_mean_mm").is_null());
}

TEST_F(RunReportTest, ReportsNullErrorsWithoutATrackedPose) {
  Write(0);
  std::ofstream(files_.loop) << "t_ns,late,status,magnet_x_m,magnet_y_m,magnet_z_m,tip_x_m,tip_y_m,tip_z_m,force_x_N,"
                                "force_y_N,force_z_N,select,haptic_pulses\n500000,0,0,0,0,0,0,0,0,0,0,0,0,0\n";
  RunData data;
  const auto report = MakeReport("test", files_, data);
  ASSERT_TRUE(report.ok()) << report.error();
  const auto row = nlohmann::json::parse(ToJson(*report).dump());
  for (const char* key : {"tracking_mean_mm", "tracking_p95_mm", "tracking_max_mm", "tracked_fraction"}) {
    EXPECT_TRUE(row.at(key).is_null()) << key << ": not measured is no zero";
  }
  EXPECT_FALSE(Shortcomings(*report).empty());
}

TEST_F(RunReportTest, ListsEveryShortcoming) {
  Write(6e-3);
  RunData data;
  auto report = MakeReport("test", files_, data);
  ASSERT_TRUE(report.ok());
  EXPECT_EQ(Shortcomings(*report).size(), 1U);  // tracking error
  report->select_edges = 0;
  report->profile = "";
  report->pose_valid_fraction = 0.2;
  report->contact_ticks = 0;
  report->haptic_pulses = 0;
  report->tracking.compared_ticks = 0;
  EXPECT_EQ(Shortcomings(*report).size(), 7U);
}

TEST_F(RunReportTest, ErrorsForBadRecordingsNameFileAndLine) {
  Write(0);
  RunData data;
  std::ofstream(files_.truth) << "t_ns,present\n1,1\n";
  auto report = MakeReport("test", files_, data);
  ASSERT_FALSE(report.ok());
  EXPECT_NE(report.error().find("magnet_x_m"), std::string::npos);
  std::ofstream(files_.truth) << "t_ns,present\n1,abc\n2,1\n";
  report = MakeReport("test", files_, data);
  ASSERT_FALSE(report.ok());
  EXPECT_NE(report.error().find("truth.csv:2"), std::string::npos) << report.error();
  std::filesystem::remove(files_.truth);
  EXPECT_FALSE(MakeReport("test", files_, data).ok());
  Write(0);
  std::ofstream(files_.app) << "{";
  EXPECT_FALSE(MakeReport("test", files_, data).ok());
}

TEST_F(RunReportTest, IgnoresTruncatedLastLine) {
  std::ofstream(files_.truth) << "t_ns,present\n1,1\n2,";
  const auto cut = CsvTable::Read(files_.truth);
  ASSERT_TRUE(cut.ok()) << cut.error();
  std::ofstream(files_.truth) << "a,b,c\n1,1,1\n2,2";
  const auto shorter = CsvTable::Read(files_.truth);
  ASSERT_TRUE(shorter.ok()) << shorter.error();
  EXPECT_EQ(shorter->rows(), 1U);
}

TEST_F(RunReportTest, PictureIsSvgWithEscapedTextAndNoNan) {
  Write(1e-4);
  RunData data;
  auto report = MakeReport("a<b&c", files_, data);
  ASSERT_TRUE(report.ok());
  const std::string svg = DrawRun(*report, data, {}, 0.0375);
  EXPECT_EQ(svg.rfind("<svg", 0), 0U);
  EXPECT_NE(svg.find("</svg>"), std::string::npos);
  EXPECT_NE(svg.find("a&lt;b&amp;c"), std::string::npos);
  EXPECT_EQ(svg.find("nan"), std::string::npos);
}

// Of a closed body that bulges everywhere, what is seen faces the viewer; further triangles come first.
TEST(SceneDrawing, OnlyWhatIsSeenIsDrawnTheFurthestFirst) {
  const auto loaded = LoadScene(std::string(OMNI_SOURCE_DIR) + "/scenes/extrusion.glb", {}, false);
  ASSERT_TRUE(loaded.ok()) << loaded.error();
  const SceneView top{.centre_m = {}, .right = {1, 0, 0}, .up = {0, 1, 0}, .half_m = 0.055};
  const std::vector<DrawnTriangle> seen = SeenTriangles(loaded->scene, top, 396);
  EXPECT_GT(seen.size(), 100U);
  EXPECT_LT(seen.size(), loaded->scene.triangles().size());
  double before_m = -1;
  for (const DrawnTriangle& triangle : seen) {
    const auto& c = triangle.corners_m;
    EXPECT_GT(base::Cross(c[1] - c[0], c[2] - c[0]).z, -1e-9) << "it faces away";
    EXPECT_GE(triangle.brightness, 0.4);
    EXPECT_LE(triangle.brightness, 1.0 + 1e-9);
    const double height_m = c[0].z + c[1].z + c[2].z;
    EXPECT_GE(height_m, before_m);
    before_m = height_m;
  }
}

TEST(Statistics, QuantileUsesNearestRankAndIsNanWhenEmpty) {
  EXPECT_TRUE(std::isnan(Quantile({}, 0.5))) << "not measured is no zero";
  EXPECT_TRUE(std::isnan(Mean({})));
  EXPECT_EQ(Quantile({3, 1, 2}, 0.5), 2);
  EXPECT_EQ(Quantile({3, 1, 2}, 1.0), 3);
  EXPECT_EQ(Quantile({3, 1, 2}, 0.0), 1);
  EXPECT_DOUBLE_EQ(Mean({1, 2, 6}), 3);
}

TEST(BenchOutput, UnmeasuredFiguresAreNullAndListed) {
  const Rows rows{{{"scene", "a"}, {"us_median", Quantile({}, 0.5)}, {"us_p99", 1.5}, {"syscalls", nullptr}},
                  {{"table", "ratios"}, {"ratio", 1.5 / 0.0}}};
  EXPECT_EQ(NotMeasured(rows), (std::vector<std::string>{"us_median of a", "ratio of ratios"}));
  EXPECT_TRUE(NotMeasured({{{"scene", "a"}, {"us_median", 1.5}, {"syscalls", nullptr}}}).empty())
      << "null on purpose: the figure has no meaning there";
  const auto read = nlohmann::json::parse(RowDocument("loop", rows).dump());
  EXPECT_TRUE(read.at("rows")[0].at("us_median").is_null());
  EXPECT_TRUE(read.at("tables").at("ratios")[0].at("ratio").is_null());
  for (const char* word : {"nan", "inf"}) EXPECT_EQ(RowTable(rows).find(word), std::string::npos);
}

TEST(BenchOutput, DocumentHasTheDocumentedKeys) {
  const Rows rows{{{"scene", "a"}, {"ticks", 5}, {"us_median", 1.5}, {"syscalls", nullptr}}};
  const auto document = RowDocument("loop", rows);
  EXPECT_EQ(document.at("name"), "loop");
  EXPECT_TRUE(document.at("commit").is_string());
  EXPECT_FALSE(document.at("machine").get<std::string>().empty());
  EXPECT_TRUE(document.at("rows")[0].at("us_median").is_number());
  EXPECT_TRUE(document.at("rows")[0].at("syscalls").is_null());
  EXPECT_NE(RowTable(rows).find("1.500"), std::string::npos);
}

}  // namespace test_tools_run_report
}  // namespace omni::tools
