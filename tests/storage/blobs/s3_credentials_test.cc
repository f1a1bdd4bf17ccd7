#include "storage/blobs/s3/s3_credentials.h"

#include <gtest/gtest.h>

#include <fstream>
#include <map>

#include "tests/storage/blobs/scripted_server.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/value_of.h"

namespace skyquilt::storage {
namespace {

using test::HttpText;
using test::ScriptedServer;
using Clock = std::chrono::system_clock;

Variable From(std::map<std::string, std::string> variables) {
  variables.try_emplace("AWS_EC2_METADATA_DISABLED", "true");
  return [variables = std::move(variables)](const char* name) {
    const auto found = variables.find(name);
    return found == variables.end() ? std::string() : found->second;
  };
}

constexpr const char* kRole =
    R"({"AccessKeyId": "R", "SecretAccessKey": "s", "Token": "t", "Expiration": "2044-01-05T10:00:00Z"})";

TEST(CredentialSource, TakesTheEnvironmentFirst) {
  CredentialSource source(From({{"AWS_ACCESS_KEY_ID", "E"}, {"AWS_SECRET_ACCESS_KEY", "s"}}));
  EXPECT_EQ(source.Get(Clock::now())->access_key, "E");
}

TEST(CredentialSource, ReadsTheProfileThatIsNamed) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "credentials")
      << "# mine\n[default]\naws_access_key_id = D\naws_secret_access_key=d\n"
         "\n[ maps ]\r\naws_access_key_id=M\r\naws_secret_access_key = a=b/+ \r\n"
         "aws_session_token=t\n[none]\naws_access_key_id = N\n";
  const std::string file = (folder / "credentials").string();
  const auto with = [&](const std::string& profile) {
    return CredentialSource(From({{"AWS_SHARED_CREDENTIALS_FILE", file}, {"AWS_PROFILE", profile}}))
        .Get(Clock::now());
  };
  EXPECT_EQ(with("")->access_key, "D");
  EXPECT_EQ(with("maps")->secret_key, "a=b/+");
  EXPECT_EQ(with("maps")->session_token, "t");
  EXPECT_EQ(with("none").error().code, ErrorCode::kForbidden);
  EXPECT_EQ(with("other").error().code, ErrorCode::kForbidden);
}

TEST(CredentialSource, AsksTheContainersService) {
  const ScriptedServer service([](int, const std::string&) { return HttpText(200, kRole); });
  CredentialSource source(From({{"AWS_CONTAINER_CREDENTIALS_FULL_URI", service.Endpoint() + "/role"},
                                {"AWS_CONTAINER_AUTHORIZATION_TOKEN", "let me in"}}));
  EXPECT_EQ(source.Get(Clock::now())->session_token, "t");
  EXPECT_EQ(source.Get(Clock::now())->access_key, "R");
  ASSERT_EQ(service.requests().size(), 1U);  // kept until it ends
  EXPECT_NE(service.requests()[0].find("Authorization: let me in"), std::string::npos);
  // Again once five minutes are left, and the old ones while nobody answers.
  EXPECT_TRUE(source.Get(*ParseUtc("2044-01-05T09:56:00Z")));
  EXPECT_EQ(service.requests().size(), 2U);
}

TEST(CredentialSource, TellsNoTokenToStrangers) {
  EXPECT_FALSE(IsContainerService("http://example.org/role"));
  EXPECT_FALSE(IsContainerService("http://127.0.0.1.example.org/role"));
  EXPECT_FALSE(IsContainerService("http://localhost@example.org/role"));
  EXPECT_FALSE(IsContainerService("file:///etc/passwd"));
  EXPECT_TRUE(IsContainerService("http://169.254.170.2/role"));
  EXPECT_TRUE(IsContainerService("http://[::1]:80/role"));
  EXPECT_TRUE(IsContainerService("https://example.org/role"));
  CredentialSource source(From({{"AWS_CONTAINER_CREDENTIALS_FULL_URI", "http://example.org/role"}}));
  EXPECT_EQ(source.Get(Clock::now()).error().code, ErrorCode::kForbidden);
}

TEST(CredentialSource, AsksForTheMachinesRoleWithAToken) {
  const ScriptedServer service([](int n, const std::string&) {
    return n == 0 ? HttpText(200, "session") : n == 1 ? HttpText(200, "a role\n") : HttpText(200, kRole);
  });
  CredentialSource source(From(
      {{"AWS_EC2_METADATA_SERVICE_ENDPOINT", service.Endpoint()}, {"AWS_EC2_METADATA_DISABLED", "false"}}));
  EXPECT_EQ(source.Get(Clock::now())->access_key, "R");
  const auto requests = service.requests();
  ASSERT_EQ(requests.size(), 3U);
  EXPECT_TRUE(requests[0].starts_with("PUT /latest/api/token "));
  EXPECT_TRUE(requests[2].starts_with("GET /latest/meta-data/iam/security-credentials/a%20role "));
  EXPECT_NE(requests[2].find("X-aws-ec2-metadata-token: session"), std::string::npos);
}

TEST(CredentialSource, SaysWhereItLooked) {
  const Error none = test::ErrorOf(CredentialSource(From({})).Get(Clock::now()));
  EXPECT_NE(none.message.find("AWS_ACCESS_KEY_ID"), std::string::npos);
}

TEST(ParseUtc, RefusesTimesThatNoClockHasHere) {
  EXPECT_EQ(Clock::to_time_t(*ParseUtc("2013-05-24T00:00:01Z")), 1'369'353'601);
  for (const char* bad : {"", "4088-01-05T10:00:00Z", "1969-12-31T23:59:59Z", "2013-13-01T00:00:00Z",
                          "2013-05-24T24:00:00Z", "2013-05-24T00:00:00", "2013-05-24"}) {
    EXPECT_FALSE(ParseUtc(bad)) << bad;
  }
}

TEST(CredentialsInAnswer, RefusesWhatIsNone) {
  EXPECT_TRUE(CredentialsInAnswer(kRole));
  for (const char* bad :
       {"", "[]", "{", "{\"AccessKeyId\": 1}", R"({"AccessKeyId": "R", "SecretAccessKey": "s"})",
        R"({"AccessKeyId": "R", "SecretAccessKey": "s", "Expiration": "tomorrow"})"}) {
    EXPECT_FALSE(CredentialsInAnswer(bad)) << bad;
  }
}

}  // namespace
}  // namespace skyquilt::storage
