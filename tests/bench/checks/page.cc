// Tables of benchmark documents in a page: replaced, kept and rejected places.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/bench/harness/page.h"

namespace omni::bench {
namespace test_bench_page {

using nlohmann::ordered_json;

ordered_json Document() {
  return {{"name", "solver"},
          {"command", "omni-bench solver --seed 7"},
          {"commit", "abc"},
          {"machine", "a machine"},
          {"rows", {{{"method", "a|b"}, {"us", 1.23456}, {"n", 3}}, {{"method", "c"}, {"us", nullptr}, {"late", 1e6}}}},
          {"tables", {{"ratios", {{{"ratio", 25.5}}}}}}};
}

TEST(BenchPage, InsertsRowsBetweenMarkers) {
  const auto page = FillPage("before\n<!-- results: solver -->\nold\n<!-- end -->\nafter\n", {{"solver", Document()}});
  ASSERT_TRUE(page.ok()) << page.error();
  EXPECT_EQ(*page,
            "before\n<!-- results: solver -->\nMade by `omni-bench solver --seed 7`, commit abc, on a machine:\n\n"
            "| method | us | n | late |\n|---|---|---|---|\n| a\\|b | 1.235 | 3 | - |\n| c | - | - | 1e+06 |\n"
            "<!-- end -->\nafter\n");
}

TEST(BenchPage, FillingIsIdempotent) {
  const BenchDocuments documents{{"solver", Document()}};
  const auto once = FillPage("<!-- results: solver/ratios -->\n<!-- end -->\n", documents);
  ASSERT_TRUE(once.ok()) << once.error();
  EXPECT_NE(once->find("| 25.5 |"), std::string::npos) << *once;
  const auto twice = FillPage(*once, documents);
  ASSERT_TRUE(twice.ok()) << twice.error();
  EXPECT_EQ(*once, *twice);
}

TEST(BenchPage, SectionPlaceSelectsRowsOfThatSection) {
  const BenchDocuments documents{
      {"paper", {{"rows", {{{"section", "heat"}, {"C", 39}}, {{"section", "forces"}, {"N", 2}}}}}}};
  const auto page = FillPage("<!-- results: paper/forces -->\n<!-- end -->\n", documents);
  ASSERT_TRUE(page.ok()) << page.error();
  EXPECT_NE(page->find("| N |\n|---|\n| 2 |\n"), std::string::npos) << *page;
  EXPECT_EQ(page->find("39"), std::string::npos) << *page;
}

TEST(BenchPage, KeyPlaceSelectsRowsThatHaveTheKey) {
  const auto page = FillPage("<!-- results: solver:late -->\n<!-- end -->\n", {{"solver", Document()}});
  ASSERT_TRUE(page.ok()) << page.error();
  EXPECT_NE(page->find("| method | late |\n|---|---|\n| c | 1e+06 |\n"), std::string::npos) << *page;
}

TEST(BenchPage, KeyPlaceSkipsRowsWhereTheKeyIsNull) {
  const auto page = FillPage("<!-- results: solver:us -->\n<!-- end -->\n", {{"solver", Document()}});
  ASSERT_TRUE(page.ok()) << page.error();
  EXPECT_EQ(page->find("| c |"), std::string::npos) << *page;
}

TEST(BenchPage, KeepsPlacesOfAbsentDocuments) {
  const std::string text = "<!-- results: loop -->\nkept\n<!-- end -->\n<!-- results: solver -->\n<!-- end -->\n";
  const auto page = FillPage(text, {{"solver", Document()}});
  ASSERT_TRUE(page.ok()) << page.error();
  EXPECT_EQ(page->rfind("<!-- results: loop -->\nkept\n<!-- end -->\n", 0), 0U) << *page;
}

TEST(BenchPage, RejectsMissingPlacesEndMarkersAndTables) {
  const BenchDocuments documents{{"solver", Document()}};
  const auto nowhere = FillPage("no place\n", documents);
  ASSERT_FALSE(nowhere.ok());
  EXPECT_NE(nowhere.error().find("solver"), std::string::npos);
  const auto endless = FillPage("<!-- results: solver -->\nold\n", documents);
  ASSERT_FALSE(endless.ok());
  EXPECT_NE(endless.error().find("<!-- end -->"), std::string::npos);
  const auto unknown = FillPage("<!-- results: solver/heat -->\n<!-- end -->\n", documents);
  ASSERT_FALSE(unknown.ok());
  EXPECT_NE(unknown.error().find("solver/heat"), std::string::npos);
}

}  // namespace test_bench_page
}  // namespace omni::bench
