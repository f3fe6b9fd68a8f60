// What `omni status` and `omni watch` show, also with missing or unexpected fields of another service version.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <sstream>

#include "service/tools/common/output.h"
#include "service/tools/common/service_link.h"
#include "service/tools/status/status.h"

namespace omni::tools {
namespace test_tools_views {

using nlohmann::json;

void ExpectHas(const std::string& text, std::initializer_list<const char*> parts) {
  for (const char* part : parts) EXPECT_NE(text.find(part), std::string::npos) << part << " not in:\n" << text;
}

TEST(ToolsStatus, ShowsEveryFieldOfTheServiceStatus) {
  const json status = json::parse(R"({
    "service": {"version": "0.1.0", "pid": 42, "uptime_s": 3725.5, "instance": 1},
    "device": {"name": "twin", "simulation": true, "received": 1000, "missed": 3},
    "tick": {"count": 1000, "late": 2, "us_median": 12.34, "us_p99": 20, "us_max": 99.9, "response_us": 612.4, "realtime": false,
             "realtime_reason": "SCHED_FIFO refused"},
    "tracking": {"status": "tracking", "position_m": [0.001, 0.002, 0.0613], "gap_m": 0.0203, "sigma_mm": 0.08},
    "force": {"last_N": [0, 0, 1.25], "contact": true},
    "clients": [{"id": 3, "pid": 77, "application": "game", "session": "focused", "owner": true, "scene": "/s/d.glb"}],
    "scene": {"name": "/s/d.glb", "generation": 4, "triangles": 12000},
    "aligned": false, "problems": ["20-x.toml:3: bad"]})");
  ExpectHas(StatusText(status),
            {"0.1.0", "pid 42", "1:02:05", "twin (a simulation)", "3 missed", "2 late", "12.3 us",
             "612 us after the sample", "refused: SCHED_FIFO refused", "(1.0, 2.0, 61.3) mm",
             "magnet 20.3 mm from the hull", "0.08", "(0.00, 0.00, 1.25) N, in contact", "\"game\" (pid 77)", "focused",
             "controls the force", "12000 triangles", "not aligned", "20-x.toml:3: bad"});
}

TEST(ToolsStatus, SimulationIsTheFirstLine) {
  EXPECT_EQ(StatusText({{"SIMULATION", "no base"}}).rfind("SIMULATION: no base\n", 0), 0U);
  EXPECT_EQ(StatusText(json::object()).find("SIMULATION"), std::string::npos);
}

TEST(ToolsStatus, ShowsRaceOnlyWhenThereIsOne) {
  json status = json::parse(R"({"race": {"laps": 2, "hits": 1, "speed_m_s": 0.0524, "sliding": true,
                                         "lap_s": 3.2, "last_lap_s": 9.841, "best_lap_s": 9.6}})");
  ExpectHas(StatusText(status), {"2 laps, last 9.84 s, best 9.60 s, now 3.20 s; 52 mm/s, sliding; 1 hit\n"});
  status["race"] = {{"laps", 0}, {"hits", 0}, {"speed_m_s", 0.0}};
  ExpectHas(StatusText(status), {"0 laps; 0 mm/s; 0 hits\n"});
  status["race"] = nullptr;
  EXPECT_EQ(StatusText(status).find("race"), std::string::npos);
}

TEST(ToolsStatus, ToleratesMissingAndMistypedFields) {
  for (const char* text :
       {"{}", R"({"service": 3, "device": [], "tick": null, "clients": {}, "problems": "x"})",
        R"({"clients": [1, null, {}], "problems": [1, null], "tracking": {"position_m": ["a", 1, 2]}})",
        R"({"force": {"last_N": [1, 2]}, "service": {"uptime_s": 1e300, "version": [1]}})"}) {
    ExpectHas(StatusText(json::parse(text)), {"omnid", "tick", "alignment"});
  }
}

TEST(ToolsStatus, StripsControlCharactersFromClientNames) {
  const json status = {{"clients", {{{"application", "\033[2Jevil\n"}}}}};
  EXPECT_EQ(StatusText(status).find('\033'), std::string::npos);
}

TEST(ToolsStatus, FillsMissingTrackingAndForceFromNewestSample) {
  protocol::ToolSample sample;
  sample.t_ns = 1'000'000'000;
  sample.flags = protocol::kToolPoseValid | protocol::kToolTracked;
  sample.position_base_m = {0, 0, 0.05};
  sample.force_base_N = {0, 0, 1};
  sample.gap_m = 0.01;
  json status = json::object();
  AddNewestSample(sample, sample.t_ns + 1'000'000, status);
  EXPECT_EQ(status["tracking"]["status"], "tracking");
  EXPECT_EQ(status["tracking"]["position_m"][2], 0.05);
  EXPECT_EQ(status["force"]["last_N"][2], 1.0);
  status = json::object();
  AddNewestSample(sample, sample.t_ns + 200'000'000, status);
  EXPECT_EQ(status["tracking"]["status"], "lost") << "an old sample is not now";
  sample.flags = 0;
  status = {{"force", {{"last_N", {9, 9, 9}}}}};
  AddNewestSample(sample, sample.t_ns, status);
  EXPECT_EQ(status["tracking"]["status"], "absent");
  EXPECT_EQ(status["force"]["last_N"][0], 9) << "what the service says wins";
}

WatchFrame Frame() {
  WatchFrame frame;
  frame.connected = frame.has_sample = true;
  frame.now_ns = 1'000'000'000;
  frame.sample.t_ns = frame.now_ns - 1'000'000;
  frame.sample.flags = protocol::kToolPoseValid | protocol::kToolTracked | protocol::kToolContact;
  frame.sample.position_base_m = {0.0012, -0.0034, 0.0567};
  frame.sample.gap_m = 0.03;
  frame.sample.force_base_N = {0, 0, 1};
  frame.inputs.components[1] = {.value = 1, .press_count = 17};
  frame.tick_rate_Hz = 1000.2;
  frame.status = {{"tick", {{"late", 5}, {"us_p99", 33.3}}},
                  {"device", {{"name", "twin"}, {"simulation", true}}},
                  {"clients", {{{"application", "game"}, {"owner", true}}}}};
  return frame;
}

TEST(ToolsWatch, ShowsPoseBarsContactInputsAndRate) {
  const std::string screen = WatchScreen(Frame(), 80);
  ExpectHas(screen, {"tracked", "+1.2", "-3.4", "+56.7", "30.0 mm", "1.00 N", "CONTACT", "presses 17", "1000 Hz",
                     "5 late", "33.3 us", "twin (a simulation)", "game (controls the force)"});
  // Half of 60 mm and half of 2 N: half full bars of 46 characters.
  ExpectHas(screen, {(std::string(23, '#') + std::string(23, '-')).c_str()});
}

TEST(ToolsWatch, ShowsTipDirectionFromOrientation) {
  WatchFrame frame = Frame();  // identity: -Z of the tool is -z of the base
  ExpectHas(WatchScreen(frame, 80), {"x  -0.000  y  -0.000  z  -1.000"});
  const double half = std::sqrt(0.5);
  frame.sample.orientation_base_wxyz = {half, half, 0, 0};  // +90 degrees about x: -Z goes to +y
  ExpectHas(WatchScreen(frame, 80), {"y  +1.000"});
}

TEST(ToolsWatch, LinesNeverExceedTheTerminal) {
  WatchFrame frame = Frame();
  frame.status["scene"]["name"] = std::string(500, 'x');
  for (const int columns : {1, 20, 33, 80, 250}) {
    std::istringstream lines(WatchScreen(frame, columns));
    for (std::string line; std::getline(lines, line);) {
      EXPECT_LE(line.size(), static_cast<std::size_t>(std::max(columns, 20)));
    }
  }
}

TEST(ToolsWatch, DistinguishesStaleLostAndAbsentPens) {
  WatchFrame frame = Frame();
  frame.now_ns += 150'000'000;
  ExpectHas(WatchLine(frame), {"stale"});
  frame = Frame();
  frame.sample.flags = protocol::kToolPoseValid;
  ExpectHas(WatchLine(frame), {"lost"});
  frame.has_sample = false;
  ExpectHas(WatchLine(frame), {"absent"});
}

TEST(ToolsWatch, WithoutServiceShowsProblemAndRemedy) {
  WatchFrame frame;
  frame.problem = "cannot connect to /x; start omnid";
  ExpectHas(WatchScreen(frame, 80), {"waiting for omnid", "/x; start omnid"});
  ExpectHas(WatchLine(frame), {"waiting for omnid", "/x; start omnid"});
}

TEST(ToolsWatch, OmitsUnknownTickRate) {
  WatchFrame frame = Frame();
  frame.tick_rate_Hz = std::nan("");
  EXPECT_EQ(WatchLine(frame).find("nan"), std::string::npos);
  EXPECT_EQ(WatchScreen(frame, 80).find("nan"), std::string::npos);
}

TEST(ToolsWatch, BarClampsAnyNumber) {
  EXPECT_EQ(TextBar(0.5, 1, 4), "##--");
  EXPECT_EQ(TextBar(-3, 1, 4), "----");
  EXPECT_EQ(TextBar(9, 1, 4), "####");
  EXPECT_EQ(TextBar(std::nan(""), 1, 4), "----");
  EXPECT_EQ(TextBar(std::numeric_limits<double>::infinity(), 1, 4), "----");
}

TEST(ToolsJson, AccessorsTolerateMissingAndMistypedValues) {
  const json document = {{"a", {{"b", 1.256}, {"t", true}, {"s", "x\033y"}, {"big", 1e300}}}, {"list", {1, 2}}};
  EXPECT_EQ(TextAt(document, "/a/b", 2), "1.26");
  EXPECT_EQ(TextAt(document, "/a/t"), "yes");
  EXPECT_EQ(TextAt(document, "/a/s"), "x?y");
  EXPECT_EQ(TextAt(document, "/a"), "-");
  EXPECT_EQ(TextAt(document, "/none/at/all"), "-");
  EXPECT_FALSE(TextAt(document, "/a/big", 1).empty());
  EXPECT_TRUE(std::isnan(NumberAt(document, "/a/s")));
  EXPECT_TRUE(ArrayAt(document, "/a").empty());
  EXPECT_EQ(ArrayAt(document, "/list").size(), 2u);
  EXPECT_FALSE(TrueAt(document, "/a/b"));
}

}  // namespace test_tools_views
}  // namespace omni::tools
