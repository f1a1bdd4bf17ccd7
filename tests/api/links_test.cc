#include "api/http/links.h"

#include <gtest/gtest.h>

namespace skyquilt::api {
namespace {

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

}  // namespace
}  // namespace skyquilt::api
