#include "api/http/target.h"

#include <gtest/gtest.h>

namespace skyquilt::api {
namespace {

TEST(ParseTarget, DecodesSegmentsAndQuery) {
  const auto target = ParseTarget("/a/b%20c/%C3%A6.jpg?x=1&y=a%2Fb+c&flag&=v");
  ASSERT_TRUE(target);
  EXPECT_EQ(target->segments, (std::vector<std::string>{"a", "b c", "\xC3\xA6.jpg"}));
  ASSERT_EQ(target->query.size(), 4u);
  EXPECT_EQ(target->query[1].second, "a/b c");
  EXPECT_EQ(target->query[2], (std::pair<std::string, std::string>("flag", "")));
}

TEST(ParseTarget, HasNoSegmentsForTheRoot) {
  ASSERT_TRUE(ParseTarget("/"));
  EXPECT_TRUE(ParseTarget("/")->segments.empty());
  EXPECT_TRUE(ParseTarget("/?a=b")->segments.empty());
}

TEST(ParseTarget, KeepsAPlusInAPathAndSemicolonsAsTheyAre) {
  EXPECT_EQ(ParseTarget("/a+b;x=1")->segments.front(), "a+b;x=1");
}

TEST(ParseTarget, TakesBracketsInAQueryAlone) {
  EXPECT_EQ(ParseTarget("/a?crs=[EPSG:4326]")->query[0].second, "[EPSG:4326]");
  EXPECT_FALSE(ParseTarget("/[a]"));
}

class BadTargets : public testing::TestWithParam<const char*> {};

TEST_P(BadTargets, AreRefused) {
  const auto target = ParseTarget(GetParam());
  ASSERT_FALSE(target) << GetParam();
  EXPECT_EQ(target.error().code, ErrorCode::kInvalidArgument);
}

INSTANTIATE_TEST_SUITE_P(ParseTarget, BadTargets,
                         testing::Values("", "a", "*", "http://x/", "/..", "/a/../b", "/.", "/%2e%2e/a",
                                         "/%2E", "/a//b", "/a/", "//", "/..%2f..%2fetc", "/a%2fb", "/a%5Cb",
                                         "/a\\b", "/%00", "/a%0ab", "/%", "/%4", "/%zz", "/a%c0%af", "/%ff",
                                         "/a b", "/\xC3\xA6", "/a?x=%00", "/a?x=%", "/a#b", "/a\"",
                                         "/<script>", "/a?x=<"));

TEST(ParseTarget, RefusesTheEndlessOne) {
  EXPECT_FALSE(ParseTarget("/" + std::string(kMaxTargetBytes, 'a')));
  std::string deep;
  for (int i = 0; i < 100; ++i) deep += "/a";
  EXPECT_FALSE(ParseTarget(deep));
  std::string query = "/?";
  for (int i = 0; i < 1000; ++i) query += "a&";
  EXPECT_FALSE(ParseTarget(query));
}

}  // namespace
}  // namespace skyquilt::api
