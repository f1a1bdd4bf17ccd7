#include "storage/blobs/s3/s3_settings.h"

#include <gtest/gtest.h>

#include <map>

namespace skyquilt::storage {
namespace {

Variable In(std::map<std::string, std::string> variables) {
  return [variables = std::move(variables)](const char* name) {
    const auto found = variables.find(name);
    return found == variables.end() ? std::string() : found->second;
  };
}

TEST(S3Settings, AreAmazonsWhereNothingElseIsSaid) {
  const auto settings = ReadS3Settings("s3://maps/a/b", In({{"AWS_REGION", "eu-west-1"}}));
  ASSERT_TRUE(settings);
  EXPECT_EQ(settings->HostOfRequests(), "maps.s3.eu-west-1.amazonaws.com");
  EXPECT_EQ(settings->scheme, "https");
  EXPECT_EQ(settings->prefix, "a/b/");
  EXPECT_EQ(settings->PathOf("flights/x"), "/a/b/flights/x");
  EXPECT_EQ(settings->PathOf(""), "/");
}

TEST(S3Settings, NameTheBucketInThePathOfAnotherStore) {
  const auto settings = ReadS3Settings(
      "s3://maps", In({{"AWS_ENDPOINT_URL", "http://127.0.0.1:9000/"}, {"AWS_DEFAULT_REGION", "home"}}));
  ASSERT_TRUE(settings);
  EXPECT_EQ(settings->HostOfRequests(), "127.0.0.1:9000");
  EXPECT_EQ(settings->scheme, "http");
  EXPECT_EQ(settings->region, "home");
  EXPECT_EQ(settings->PathOf("flights/x"), "/maps/flights/x");
  EXPECT_EQ(settings->PathOf(""), "/maps");
}

TEST(S3Settings, TakeWhatGdalTakes) {
  const auto settings = ReadS3Settings(
      "s3://maps",
      In({{"AWS_S3_ENDPOINT", "store:9000"}, {"AWS_HTTPS", "NO"}, {"AWS_VIRTUAL_HOSTING", "TRUE"}}));
  ASSERT_TRUE(settings);
  EXPECT_EQ(settings->scheme, "http");
  EXPECT_EQ(settings->HostOfRequests(), "maps.store:9000");
}

TEST(S3Settings, KeepADottedBucketOutOfTheHostOfACertificate) {
  EXPECT_EQ(ReadS3Settings("s3://maps.example.org", In({}))->PathOf("k"), "/maps.example.org/k");
}

TEST(S3Settings, RefuseWhatIsNoAddress) {
  for (const char* bad : {"", "s3://", "s3://a", "s3:///a", "http://maps/a", "s3://Maps", "s3://maps/../a",
                          "s3://maps//a", "s3://maps/a b", "s3://ma\np/a"}) {
    EXPECT_FALSE(ReadS3Settings(bad, In({}))) << bad;
  }
  for (const char* bad : {"ftp://host", "http://", "http://host/path", "http://a b", "http://user@host"}) {
    EXPECT_FALSE(ReadS3Settings("s3://maps", In({{"AWS_ENDPOINT_URL", bad}}))) << bad;
  }
}

}  // namespace
}  // namespace skyquilt::storage
