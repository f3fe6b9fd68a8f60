// A control step has 250 us: at the 600 MHz of a Teensy 4.0, 150,000 cycles. Instructions are counted, not cycles; the
// table keeps them, the stack and the image from growing unnoticed.
#include "tests/hil/board/budget.h"

#include <gtest/gtest.h>

#include <cstdio>

#include "tests/hil/board/tools.h"
#include "tests/support/process/temp_folder.h"

namespace omni::hil {
namespace {

constexpr char kPath[] = OMNI_SOURCE_DIR "/firmware/board/mps2_an500/budget.txt";

TEST(Budget, MeasuredCostsStayWithinTheBudgetFile) {
  OMNI_NEEDS_BOARD();
  const auto reference = ReadBudget(kPath);
  ASSERT_TRUE(reference.ok()) << reference.error();
  const auto measured = MeasureBudget();
  ASSERT_TRUE(measured.ok()) << measured.error();
  for (const auto& [name, value] : *measured) {
    ASSERT_EQ(reference->count(name), 1U) << name << " is not in " << kPath;
    const double limit = kBudgetHeadRoom * reference->at(name);
    std::printf("%-24s %8u of %8.0f\n", name.c_str(), value, limit);
    EXPECT_LE(value, limit) << name;
    // An outdated reference would allow anything.
    EXPECT_GE(value, 0.5 * reference->at(name)) << name << " has shrunk: make " << kPath << " again";
  }
  EXPECT_EQ(measured->size(), reference->size());
}

// The board counts the same twice: the result does not depend on this machine.
TEST(Budget, MeasurementIsReproducible) {
  OMNI_NEEDS_BOARD();
  const auto once = MeasureBudget(), again = MeasureBudget();
  ASSERT_TRUE(once.ok()) << once.error();
  ASSERT_TRUE(again.ok()) << again.error();
  EXPECT_EQ(BudgetPage(*once), BudgetPage(*again));
}

TEST(Budget, FileRoundTripsAndErrorsNameTheLine) {
  const test::TempFolder folder;
  const Budget budget{{"a", 1}, {"b", 4000000000U}};
  const auto read = ReadBudget(folder.Write("budget.txt", BudgetPage(budget)));
  ASSERT_TRUE(read.ok()) << read.error();
  EXPECT_EQ(*read, budget);
  const auto broken = ReadBudget(folder.Write("broken.txt", "# head\na 1\nb x\n"));
  ASSERT_FALSE(broken.ok());
  EXPECT_NE(broken.error().find("broken.txt:3"), std::string::npos) << broken.error();
  EXPECT_FALSE(ReadBudget(folder.Path("none.txt")).ok());
}

}  // namespace
}  // namespace omni::hil
