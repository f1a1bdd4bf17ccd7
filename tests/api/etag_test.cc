#include <gtest/gtest.h>

#include "api/http/conditional.h"

namespace skyquilt::api {
namespace {

TEST(StrongEtag, IsQuotedHexadecimalWithItsVariant) {
  EXPECT_EQ(StrongEtag(0x1f), "\"000000000000001f\"");
  EXPECT_EQ(StrongEtag(0x1f, "png"), "\"000000000000001f-png\"");
}

TEST(EtagListMatches, FindsTheTagAnywhereInTheList) {
  EXPECT_TRUE(EtagListMatches("\"a\"", "\"a\""));
  EXPECT_TRUE(EtagListMatches("\"b\", \"a\"", "\"a\""));
  EXPECT_TRUE(EtagListMatches("W/\"a\"", "\"a\""));
  EXPECT_TRUE(EtagListMatches("*", "\"a\""));
  EXPECT_TRUE(EtagListMatches(" \"x\",\"y\" , W/\"a\"", "\"a\""));
}

TEST(EtagListMatches, MatchesNothingElse) {
  for (const char* list :
       {"", "a", "\"b\"", "\"a", "\"ab\"", "\"b\"\"a\"", ",", "W/", "W/a", "\"b\" \"a\""}) {
    EXPECT_FALSE(EtagListMatches(list, "\"a\"")) << list;
  }
}

TEST(IfRangeMatches, TakesStrongTagsOnly) {
  EXPECT_TRUE(IfRangeMatches("\"a\"", "\"a\""));
  EXPECT_FALSE(IfRangeMatches("W/\"a\"", "\"a\""));
  EXPECT_FALSE(IfRangeMatches("Sat, 21 Nov 2026 03:57:55 GMT", "\"a\""));
}

}  // namespace
}  // namespace skyquilt::api
