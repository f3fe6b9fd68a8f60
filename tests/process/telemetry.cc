// omni monitor --csv with a real omnid: every tick is one row of the file, over a start of another omnid too.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "service/monitor/page/channels.h"
#include "service/tools/common/command_line.h"
#include "service/tools/common/files.h"
#include "tests/support/process/omni_command.h"
#include "tests/support/process/service_process.h"

namespace omni::test {
namespace test_process_telemetry {

TEST(ProcessTelemetry, EveryTickIsOneRow) {
  const TempFolder folder;
  ServiceProcess service;
  service.Start();
  TestApplication app(service);
  ASSERT_TRUE(app.Run(5000, 5, [&] { return app.connection().connected(); })) << app.connection().last_error();
  const std::string file = folder.Path("ticks.csv");
  const std::vector<std::string> words = {
      "monitor", "--csv", file, "--seconds", "1", "--socket", service.socket_path()};
  const Outcome said = RunOmni(words);
  ASSERT_EQ(said.status, tools::kExitOk) << said.err;
  const auto table = tools::CsvTable::Read(file);
  ASSERT_TRUE(table.ok()) << table.error();
  ASSERT_GT(table->rows(), 10U);
  EXPECT_NE(said.out.find(": " + std::to_string(table->rows()) + " ticks, "), std::string::npos) << said.out;
  for (const monitor::Channel& channel : monitor::Channels())
    EXPECT_TRUE(table->HasColumn(channel.name)) << channel.name;
  const std::vector<double>& t_s = (*table)["time_s"];
  EXPECT_EQ(t_s.front(), 0);
  EXPECT_EQ(std::adjacent_find(t_s.begin(), t_s.end(), std::greater_equal<>()), t_s.end());
  for (const double us : (*table)["tick_us"]) EXPECT_GE(us, 0);  // the time of the test may stand still in a tick

  const Outcome again = RunOmni(words);
  EXPECT_EQ(again.status, tools::kExitFailed);
  EXPECT_NE(again.err.find("already exists"), std::string::npos) << again.err;
  const auto kept = tools::CsvTable::Read(file);
  ASSERT_TRUE(kept.ok());
  EXPECT_EQ(kept->rows(), table->rows());
}

TEST(ProcessTelemetry, NoServiceLeavesNoFile) {
  const TempFolder folder;
  const std::string file = folder.Path("ticks.csv");
  const Outcome said = RunOmni({"monitor", "--csv", file, "--socket", folder.Path("socket/omnid.sock")});
  EXPECT_EQ(said.status, tools::kExitNoService);
  EXPECT_NE(said.err.find("omnid --device twin"), std::string::npos) << said.err;
  EXPECT_FALSE(std::filesystem::exists(file));
}

}  // namespace test_process_telemetry
}  // namespace omni::test
