// The examples that Amazon publishes with the signatures they must have ("Authenticating Requests: Using the
// Authorization Header" and "Using Query Parameters").
#include "storage/blobs/s3/sign_request.h"

#include <gtest/gtest.h>

#include "storage/blobs/sha256.h"

namespace skyquilt::storage {
namespace {

const S3Credentials kExampleKeys{
    "AKIAIOSFODNN7EXAMPLE", "wJalrXUtnFEMI/K7MDENG/bPxRfiCYEXAMPLEKEY", "", {}};  // published, nobody's
constexpr std::chrono::system_clock::time_point kExampleTime{std::chrono::seconds(1'369'353'600)};

RequestToSign Example(const char* method, const char* path) {
  return {method, "examplebucket.s3.amazonaws.com", path, {}, {}, kEmptySha256};
}

std::string ValueOf(const NamedValues& values, const std::string& name) {
  for (const auto& [each, value] : values) {
    if (each == name) return value;
  }
  return "";
}

std::string SignatureOf(const RequestToSign& request) {
  const std::string said =
      ValueOf(SignRequest(request, kExampleKeys, "us-east-1", kExampleTime), "Authorization");
  return said.substr(said.find("Signature=") + 10);
}

TEST(SignRequest, SignsAGetOfARangeAsPublished) {
  RequestToSign request = Example("GET", "/test.txt");
  request.headers = {{"Range", "bytes=0-9"}};
  EXPECT_EQ(SignatureOf(request), "f0e8bdb87c964420e857bd35b5d6ed310bd44f0170aba48dd91039c6036bdb41");
}

TEST(SignRequest, SignsAPutWithADollarInItsKeyAsPublished) {
  RequestToSign request = Example("PUT", "/test$file.text");
  request.headers = {{"Date", "Fri, 24 May 2013 00:00:00 GMT"},
                     {"x-amz-storage-class", "REDUCED_REDUNDANCY"}};
  request.payload_sha256 = Sha256Hex("Welcome to Amazon S3.");
  EXPECT_EQ(request.payload_sha256, "44ce7dd67c959e0d3524ffac1771dfbba87d2b6b4b4e99e42034a8b803f8b072");
  EXPECT_EQ(SignatureOf(request), "98ad721746da40c64f1a55b78f14c238d841ea1380cd77a1b5971af0ece108bd");
}

TEST(SignRequest, SignsAQueryWithoutValueAsPublished) {
  RequestToSign request = Example("GET", "/");
  request.query = {{"lifecycle", ""}};
  EXPECT_EQ(SignatureOf(request), "fea454ca298b7da1c68078a5d1bdbfbbe0d65c699e0f91ac7a200a0136783543");
}

TEST(SignRequest, SignsAListAsPublishedInWhateverOrderItsQueryComes) {
  RequestToSign request = Example("GET", "/");
  request.query = {{"prefix", "J"}, {"max-keys", "2"}};
  EXPECT_EQ(SignatureOf(request), "34b48302e7b5fa45bde8084f4b7868a86f0a534bc59db6670ed5711ef69dc6f7");
}

TEST(SignRequest, SendsTheTokenOfARoleAndNeverTheSecret) {
  S3Credentials keys = kExampleKeys;
  keys.session_token = "token-of-a-role";
  const NamedValues headers = SignRequest(Example("GET", "/a"), keys, "us-east-1", kExampleTime);
  EXPECT_EQ(ValueOf(headers, "x-amz-security-token"), "token-of-a-role");
  EXPECT_NE(ValueOf(headers, "Authorization").find("x-amz-security-token"), std::string::npos);
  for (const auto& [name, value] : headers) EXPECT_EQ(value.find(keys.secret_key), std::string::npos) << name;
}

TEST(UriEncode, KeepsWhatS3Keeps) {
  EXPECT_EQ(UriEncode("a b=c&d+e/~f_-.é", true), "a%20b%3Dc%26d%2Be/~f_-.%C3%A9");
  EXPECT_EQ(UriEncode("a/b", false), "a%2Fb");
  EXPECT_EQ(EncodedQuery({{"uploads", ""}}), "uploads=");
}

}  // namespace
}  // namespace skyquilt::storage
