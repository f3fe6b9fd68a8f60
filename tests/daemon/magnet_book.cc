// The file of learnt magnets: round trip, one entry for a magnet, a damaged file, a disk that refuses.
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>
#include <utility>

#include "service/config/text/text_file.h"
#include "service/daemon/devices/magnet_book.h"
#include "tests/support/process/temp_folder.h"

namespace omni::daemon {
namespace test_daemon_magnet_book {

using omni::test::TempFolder;

constexpr std::int64_t kLearnt_s = 1'800'000'000;
constexpr double kOwn_Am2 = 5.1;

base::ToolState ToolOf(double moment_scale, base::MagnetIdentity magnet = base::MagnetIdentity::kKnown) {
  base::ToolState tool;
  tool.status = base::TrackingStatus::kTracking;
  tool.moment_scale = moment_scale;
  tool.moment_sigma = 0.004;
  tool.magnet = magnet;
  return tool;
}

std::string TextOf(const std::string& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

// What a service that starts now knows of a base.
tracker::MagnetOptions KnownOf(const std::string& path, const std::string& serial, double calibrated_Am2 = kOwn_Am2) {
  tracker::MagnetOptions options;
  MagnetBook(path, config::WriteTextFile).LoadKnownMagnets(serial, calibrated_Am2, options);
  return options;
}

TEST(DaemonMagnetBook, LearntMagnetIsKnownAfterARestart) {
  const TempFolder temp;
  const std::string path = temp.Path("config/magnets.toml");
  {
    MagnetBook book(path, config::WriteTextFile);
    tracker::MagnetOptions options;
    book.LoadKnownMagnets("A1", kOwn_Am2, options);
    EXPECT_EQ(options.known_count, 0);
    for (const auto magnet :
         {base::MagnetIdentity::kUnknown, base::MagnetIdentity::kNew, base::MagnetIdentity::kCalibrated}) {
      EXPECT_FALSE(book.AddSample(ToolOf(0.9, magnet), kLearnt_s));
    }
    EXPECT_TRUE(book.AddSample(ToolOf(0.9), kLearnt_s));
    EXPECT_FALSE(book.AddSample(ToolOf(0.905), kLearnt_s)) << "the same one";
    EXPECT_TRUE(book.AddSample(ToolOf(1.1), kLearnt_s));
  }  // waits for the disk
  const tracker::MagnetOptions options = KnownOf(path, "A1");
  ASSERT_EQ(options.known_count, 2);
  EXPECT_NEAR(options.known[0].moment_scale, 1.1, 1e-9);
  EXPECT_NEAR(options.known[1].moment_scale, 0.9, 1e-9);
  EXPECT_NEAR(options.known[1].sigma, 0.004, 1e-9);
  EXPECT_EQ(KnownOf(path, "B2").known_count, 0) << "another base measures other moments";
  EXPECT_NEAR(KnownOf(path, "A1", 1.1 * kOwn_Am2).known[0].moment_scale, 1, 1e-9) << "calibrated with that pen since";
  EXPECT_EQ(KnownOf(path, "A1", 0).known_count, 0) << "not calibrated";
}

TEST(DaemonMagnetBook, ManyMagnetsKeepTheNewest) {
  const TempFolder temp;
  const std::string path = temp.Path("magnets.toml");
  {
    MagnetBook book(path, config::WriteTextFile);
    tracker::MagnetOptions options;
    for (int base = 0; base < 20; ++base) {
      book.LoadKnownMagnets("base " + std::to_string(base), kOwn_Am2, options);
      for (const double scale : {0.8, 0.9, 1.1, 1.2}) EXPECT_TRUE(book.AddSample(ToolOf(scale), kLearnt_s));
    }
  }
  const auto read = config::LoadMagnetsFile(path);
  ASSERT_TRUE(read.ok()) << read.error();
  EXPECT_EQ(read->size(), config::kMaxMagnets);
  EXPECT_EQ(KnownOf(path, "base 0").known_count, 0);
  EXPECT_EQ(KnownOf(path, "base 19").known_count, 4);
}

TEST(DaemonMagnetBook, DamagedFileIsReportedAndNeverOverwritten) {
  const TempFolder temp;
  config::MagnetEntry entry{.base = "A1", .moment_Am2 = 4.6, .sigma_share = 0.004, .learnt_date = "2026-11-28"};
  const std::string good = config::WriteMagnets({entry});
  const auto broken = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    return text.replace(text.find(from), from.size(), to);
  };
  const std::pair<std::string, std::string> cases[] = {{"\x01\x02 garbage", "TOML syntax"},
                                                       {broken("format = 1", "format = 2"), "format = 2 is not known"},
                                                       {broken("4.59", "nan #"), "magnets[0].moment_Am2"},
                                                       {broken("sigma_share", "sigma"), "sigma_share is missing"}};
  for (const auto& [text, says] : cases) {
    const std::string path = temp.Write("bad.toml", text);
    {
      MagnetBook book(path, config::WriteTextFile);
      ASSERT_TRUE(book.problem()) << text;
      EXPECT_NE(book.problem()->what.find("bad.toml"), std::string::npos);
      EXPECT_NE(book.problem()->what.find(says), std::string::npos) << book.problem()->what;
      EXPECT_NE(book.problem()->fix.find("move it away"), std::string::npos);
      tracker::MagnetOptions options;
      book.LoadKnownMagnets("A1", kOwn_Am2, options);
      EXPECT_EQ(options.known_count, 0);
      EXPECT_FALSE(book.AddSample(ToolOf(0.8), kLearnt_s));
    }
    EXPECT_EQ(TextOf(path), text);
  }
}

TEST(DaemonMagnetBook, DiskThatRefusesIsReportedUntilItDoesNot) {
  bool refuses = true;
  MagnetBook book("/magnets.toml", [&](const std::string& path, const std::string&) {
    return refuses ? base::Status(base::Error{path + ": cannot be written: the disk is full"})
                   : base::Status(base::Ok{});
  });
  tracker::MagnetOptions options;
  book.LoadKnownMagnets("A1", kOwn_Am2, options);
  const auto wait = [&] {
    for (int k = 0; k < 5000 && !book.HandleWritten(); ++k) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  };
  EXPECT_TRUE(book.AddSample(ToolOf(0.8), kLearnt_s));
  wait();
  ASSERT_TRUE(book.problem());
  EXPECT_NE(book.problem()->what.find("the disk is full: a pen that was learnt is known until omnid ends"),
            std::string::npos);
  refuses = false;
  EXPECT_TRUE(book.AddSample(ToolOf(1.2), kLearnt_s));
  wait();
  EXPECT_FALSE(book.problem());
}

}  // namespace test_daemon_magnet_book
}  // namespace omni::daemon
