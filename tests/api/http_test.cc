#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "api/http/conditional.h"
#include "api/http/links.h"
#include "api/http/responses.h"
#include "api/http/target.h"
#include "core/flight/remarks/because.h"

namespace skyquilt::api {
namespace {

TEST(StrongEtag, IsQuotedHexadecimalWithItsVariant) {
  EXPECT_EQ(StrongEtag(0x1f), "\"000000000000001f\"");
  EXPECT_EQ(StrongEtag(0x1f, "png"), "\"000000000000001f-png\"");
}

TEST(EtagListMatches, FindsTheTagAnywhereInTheList) {
  for (const char* list : {"\"a\"", "\"b\", \"a\"", "W/\"a\"", "*", " \"x\",\"y\" , W/\"a\""})
    EXPECT_TRUE(EtagListMatches(list, "\"a\"")) << list;
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

struct Case {
  std::string header;
  std::uint64_t body;
  RangeKind kind;
  std::uint64_t first;
  std::uint64_t length;
};

class Ranges : public testing::TestWithParam<Case> {};

TEST_P(Ranges, AreReadAsTheStandardSays) {
  const ByteRange range = ParseRange(GetParam().header, GetParam().body);
  EXPECT_EQ(range.kind, GetParam().kind) << GetParam().header;
  if (range.kind == RangeKind::kPart) {
    EXPECT_EQ(range.first, GetParam().first) << GetParam().header;
    EXPECT_EQ(range.length, GetParam().length) << GetParam().header;
  }
}

constexpr RangeKind kWhole = RangeKind::kWhole;
constexpr RangeKind kPart = RangeKind::kPart;
constexpr RangeKind kBad = RangeKind::kUnsatisfiable;

INSTANTIATE_TEST_SUITE_P(
    ParseRange, Ranges,
    testing::Values(Case{"bytes=0-0", 10, kPart, 0, 1}, Case{"bytes=2-5", 10, kPart, 2, 4},
                    Case{"bytes=2-", 10, kPart, 2, 8}, Case{"bytes=-3", 10, kPart, 7, 3},
                    Case{"bytes=-30", 10, kPart, 0, 10},
                    Case{"bytes=5-99999999999999999999999", 10, kPart, 5, 5},
                    Case{"BYTES=1-1", 10, kPart, 1, 1}, Case{"bytes= 1-1 ", 10, kPart, 1, 1},
                    Case{"bytes=9-9", 10, kPart, 9, 1}, Case{"bytes=10-", 10, kBad, 0, 0},
                    Case{"bytes=99999999999999999999999-", 10, kBad, 0, 0}, Case{"bytes=-0", 10, kBad, 0, 0},
                    Case{"bytes=0-", 0, kBad, 0, 0}, Case{"bytes=-5", 0, kBad, 0, 0},
                    Case{"bytes=5-2", 10, kWhole, 0, 0}, Case{"bytes=0-0,2-3", 10, kWhole, 0, 0},
                    Case{"lines=0-1", 10, kWhole, 0, 0}, Case{"bytes", 10, kWhole, 0, 0},
                    Case{"bytes=", 10, kWhole, 0, 0}, Case{"bytes=-", 10, kWhole, 0, 0},
                    Case{"bytes=a-b", 10, kWhole, 0, 0}, Case{"bytes=+1-2", 10, kWhole, 0, 0},
                    Case{"bytes=1--2", 10, kWhole, 0, 0}, Case{"bytes=--1", 10, kWhole, 0, 0},
                    Case{"", 10, kWhole, 0, 0}));

TEST(Problem, HasAStatusForEveryErrorKind) {
  for (const ErrorCode code : kAllErrorCodes) {
    const int status = StatusOf(code);
    EXPECT_GE(status, 400) << ErrorCodeName(code);
    EXPECT_LT(status, 600) << ErrorCodeName(code);
    EXPECT_STRNE(ReasonOf(status), "Unknown") << status;
  }
}

TEST(Problem, IsADocumentOfTheStandardShape) {
  const Response response =
      Problem({ErrorCode::kNotFound, "No \"such\" <thing>\xff", "secret"}, "/a/b", "id-1");
  EXPECT_EQ(response.status, 404);
  EXPECT_EQ(response.headers.Find("content-type"), "application/problem+json");
  const auto body = nlohmann::json::parse(response.body);
  EXPECT_EQ(body["status"], 404);
  EXPECT_EQ(body["code"], "not_found");
  EXPECT_EQ(body["title"], "Not Found");
  EXPECT_EQ(body["instance"], "/a/b");
  EXPECT_EQ(body["request_id"], "id-1");
  EXPECT_EQ(response.body.find("secret"), std::string::npos);
  EXPECT_FALSE(body.contains("reason"));
}

TEST(Problem, GivesItsReasonAsACode) {
  const auto reason = [](const Error& error) {
    return nlohmann::json::parse(Problem(error, "", "").body).at("reason");
  };
  const nlohmann::json large = reason(
      flight::Because(ErrorCode::kTooLarge, {flight::RemarkCode::kFailFileTooLarge, {{"most_gib", 4}}}));
  EXPECT_EQ(large, nlohmann::json::parse(R"({"code":"fail_file_too_large","values":{"most_gib":4}})"));
  EXPECT_EQ(reason({ErrorCode::kOutOfSpace, "full", ""})["code"], "fail_disk_full");
}

TEST(Problem, TellsWhenToComeBack) {
  EXPECT_EQ(Problem({ErrorCode::kUnavailable, "", ""}, "", "").headers.Find("Retry-After"), "2");
}

TEST(LinkTo, GoesOnWithTheTokenOfTheQuery) {
  Request request;
  request.base_url = "https://maps.example";
  EXPECT_EQ(LinkTo(request, "/tiles/a/{z}/{x}/{y}?rev=1"), "https://maps.example/tiles/a/{z}/{x}/{y}?rev=1");
  request.query.emplace_back("token", "sq_aB-9");
  EXPECT_EQ(LinkTo(request, "/tiles/a.json"), "https://maps.example/tiles/a.json?token=sq_aB-9");
  EXPECT_EQ(LinkTo(request, "/tiles/a/{z}/{x}/{y}?rev=1"),
            "https://maps.example/tiles/a/{z}/{x}/{y}?rev=1&token=sq_aB-9");
}

TEST(LinkTo, WritesNothingElseIntoDocuments) {
  for (const char* text : {"\"><script>", "a b", "a&b", ""}) {
    Request request;
    request.query.emplace_back("token", text);
    EXPECT_EQ(TokenInQuery(request), "") << text;
  }
  Request header;
  header.headers.Add("Authorization", "Bearer sq_secret");
  EXPECT_EQ(LinkTo(header, "/x"), "/x");
}

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
