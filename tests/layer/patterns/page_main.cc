// Prints docs/howto/engines.md; Patterns.PageIsCurrent compares.
#include <cstdio>

#include "tests/layer/patterns/page.h"

int main() {
  std::fputs(omni::test::patterns::Page().c_str(), stdout);
  return 0;
}
