#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "api/http/responses.h"
#include "core/flight/remarks/because.h"

namespace skyquilt::api {
namespace {

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

}  // namespace
}  // namespace skyquilt::api
