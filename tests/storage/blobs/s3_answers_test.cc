#include "storage/blobs/s3/s3_answers.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

namespace skyquilt::storage {
namespace {

std::string Listing(const std::string& inside) {
  return "<?xml version=\"1.0\"?><ListBucketResult xmlns=\"http://s3.amazonaws.com/doc/2006-03-01/\">" +
         inside + "</ListBucketResult>";
}

std::string Object(const std::string& key, const std::string& size) {
  return fmt::format(
      "<Contents><Key>{}</Key><LastModified>2013-05-24T00:00:01.500Z</LastModified><Size>{}</Size></Contents>",
      key, size);
}

TEST(ParseListedPage, ReadsObjectsAndWhereItGoesOn) {
  const auto page = ParseListedPage(
      Listing(Object("a/b &amp; c", "12") +
              "<IsTruncated>true</IsTruncated><NextContinuationToken>t/1=</NextContinuationToken>"),
      "a/");
  ASSERT_TRUE(page) << page.error().detail;
  ASSERT_EQ(page->objects.size(), 1U);
  EXPECT_EQ(page->objects[0].key, "a/b & c");
  EXPECT_EQ(page->objects[0].bytes, 12);
  EXPECT_EQ(std::chrono::system_clock::to_time_t(page->objects[0].changed), 1'369'353'601);
  EXPECT_EQ(page->next, "t/1=");
}

TEST(ParseListedPage, RefusesWhatIsNone) {
  std::string many;
  for (int i = 0; i < 1001; ++i) many += Object("a/" + std::to_string(i), "1");
  std::string deep;
  for (int i = 0; i < 20'000; ++i) deep += "<a>";
  for (const std::string& bad :
       {std::string(), std::string("<"), std::string("<html>Sign in</html>"),
        Listing(Object("b/elsewhere", "1")), Listing(Object("a/x", "-1")),
        Listing(Object("a/x", "99999999999999999999")), Listing(Object("a/x", "")),
        Listing(Object("a/x", "1e9")), Listing(Object("", "1")), Listing(many), Listing(deep),
        Listing("<IsTruncated>true</IsTruncated>"), Listing(Object("a/x", "1")).substr(0, 120),
        Listing(Object("a/" + std::string(5000, 'x'), "1")), std::string(std::size_t{9} << 20, ' ')}) {
    const auto page = ParseListedPage(bad, "a/");
    ASSERT_FALSE(page) << bad.substr(0, 80);
    EXPECT_EQ(page.error().code, ErrorCode::kCorrupt);
  }
}

TEST(ParseRefusal, ReadsWhyAndWhere) {
  const auto refusal = ParseRefusal(
      "<Error><Code>AuthorizationHeaderMalformed</Code><Message>m</Message><Region>eu-west-1</Region></Error>");
  ASSERT_TRUE(refusal);
  EXPECT_EQ(refusal->code, "AuthorizationHeaderMalformed");
  EXPECT_EQ(refusal->region, "eu-west-1");
  EXPECT_FALSE(ParseRefusal("<CompleteMultipartUploadResult><ETag>x</ETag></CompleteMultipartUploadResult>"));
  EXPECT_FALSE(ParseRefusal(""));
  EXPECT_FALSE(ParseRefusal("<Error/>"));
}

TEST(ParseUploadId, WantsAnId) {
  EXPECT_EQ(*ParseUploadId("<InitiateMultipartUploadResult><UploadId>u-1</UploadId>"
                           "</InitiateMultipartUploadResult>"),
            "u-1");
  EXPECT_FALSE(ParseUploadId("<InitiateMultipartUploadResult/>"));
}

TEST(ParseDeletionRefusal, SeesTheOneThatStayed) {
  EXPECT_FALSE(ParseDeletionRefusal("<DeleteResult/>"));
  const auto refusal = ParseDeletionRefusal(
      "<DeleteResult><Error><Key>k</Key><Code>AccessDenied</Code></Error></DeleteResult>");
  ASSERT_TRUE(refusal);
  EXPECT_EQ(refusal->code, "AccessDenied");
  EXPECT_TRUE(ParseDeletionRefusal("<html/>"));
}

TEST(DeletionXml, NamesTheKeysAsTheyAre) {
  EXPECT_EQ(DeletionXml({"a&b", "c>"}),
            "<Delete xmlns=\"http://s3.amazonaws.com/doc/2006-03-01/\"><Quiet>true</Quiet>"
            "<Object><Key>a&amp;b</Key></Object><Object><Key>c&gt;</Key></Object></Delete>");
}

TEST(CompletionXml, KeepsTheQuotesOfTagsWithoutLettingThemOut) {
  EXPECT_EQ(CompletionXml({{1, "\"a\"", 5}, {2, "<b&", 1}}),
            "<CompleteMultipartUpload xmlns=\"http://s3.amazonaws.com/doc/2006-03-01/\">"
            "<Part><PartNumber>1</PartNumber><ETag>&quot;a&quot;</ETag></Part>"
            "<Part><PartNumber>2</PartNumber><ETag>&lt;b&amp;</ETag></Part></CompleteMultipartUpload>");
}

}  // namespace
}  // namespace skyquilt::storage
