// Text in fixed fields and in logs.
#include "service/protocol/text.h"

#include <gtest/gtest.h>

#include <string>

namespace omni::protocol {
namespace test_protocol_text {

TEST(Text, SetFieldTruncatesAndTerminates) {
  char field[8];
  SetField(field, "abc");
  EXPECT_STREQ(field, "abc");
  SetField(field, "abcdefghij");
  EXPECT_STREQ(field, "abcdefg");
  SetField(field, "");
  EXPECT_STREQ(field, "");
}

TEST(Text, SetFieldCutsBetweenCharacters) {
  char field[6];
  SetField(field, "abcd\xC3\xA9");  // the e acute would need bytes 5 and 6
  EXPECT_STREQ(field, "abcd");
  SetField(field, "abc\xC3\xA9");
  EXPECT_STREQ(field, "abc\xC3\xA9");
}

TEST(Text, SetFieldStopsAtTheFirstNul) {
  char field[8];
  SetField(field, std::string_view("ab\0cd", 5));
  EXPECT_STREQ(field, "ab");
}

TEST(Text, IsTerminatedDetectsMissingNul) {
  const char open[3] = {'a', 'b', 'c'};
  const char closed[3] = {'a', 'b', 0};
  EXPECT_FALSE(IsTerminated(open));
  EXPECT_TRUE(IsTerminated(closed));
}

TEST(Text, PrintableReplacesControlAndInvalidBytes) {
  EXPECT_EQ(Printable("touch 1.0 (d\xC3\xA9mo) \xE6\xBC\xA2 \xF0\x9F\x96\x8A"),
            "touch 1.0 (d\xC3\xA9mo) \xE6\xBC\xA2 \xF0\x9F\x96\x8A");
  EXPECT_EQ(Printable("a\x1B[31mb\n"), "a?[31mb?");  // terminal escape
  EXPECT_EQ(Printable("a\xC2\x9B"
                      "31m"),
            "a??31m");                               // C1 escape
  EXPECT_EQ(Printable("\xC0\xAF"), "??");            // overlong
  EXPECT_EQ(Printable("\xE0\x80\xAF"), "???");       // overlong
  EXPECT_EQ(Printable("\xED\xA0\x80"), "???");       // surrogate
  EXPECT_EQ(Printable("\xF4\x90\x80\x80"), "????");  // above U+10FFFF
  EXPECT_EQ(Printable("\xF0\x82\x82\xAC"), "????");  // overlong
  EXPECT_EQ(Printable("ab\xC3"), "ab?");             // cut
  EXPECT_EQ(Printable("\x7F\x80\xFF"), "???");
}

}  // namespace test_protocol_text
}  // namespace omni::protocol
