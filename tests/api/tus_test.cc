// tus over the real routes: creation, chunks, checksums, breaks.
#include <gtest/gtest.h>

#include "api/uploads/tus_headers.h"
#include "tests/api/sample_service.h"

namespace skyquilt::api {
namespace {

Headers Tus(std::initializer_list<std::pair<const char*, std::string>> more) {
  Headers headers;
  headers.Add("Tus-Resumable", "1.0.0");
  for (const auto& [name, value] : more) headers.Add(name, value);
  return headers;
}

std::string Metadata(const std::string& flight) {
  return "flight " + EncodeBase64(flight) + ",filename " + EncodeBase64("a b.jpg");
}

std::string Create(SampleService& sample, const std::string& flight, const char* length) {
  const Response made = sample.Send(Method::kPost, "/api/v1/uploads", "",
                                    Tus({{"Upload-Length", length}, {"Upload-Metadata", Metadata(flight)}}));
  EXPECT_EQ(made.status, 201) << made.body;
  return std::string(made.headers.Find("Location"));
}

Response Patch(SampleService& sample, const std::string& at, const std::string& offset,
               const std::string& bytes, const std::string& checksum = "") {
  Headers headers = Tus({{"Upload-Offset", offset}, {"Content-Type", "application/offset+octet-stream"}});
  if (!checksum.empty()) headers.Add("Upload-Checksum", checksum);
  return sample.Send(Method::kPatch, at, bytes, headers);
}

std::string OffsetOf(SampleService& sample, const std::string& at) {
  return std::string(sample.Get(at, Tus({})).headers.Find("Upload-Offset"));
}

TEST(Tus, ChunksMakeAFileOfTheFlight) {
  SampleService sample;
  const std::string flight = sample.NewFlight();
  const std::string at = Create(sample, flight, "10");
  const Response first = Patch(sample, at, "0", "01234");
  EXPECT_EQ(first.status, 204);
  EXPECT_EQ(first.headers.Find("Upload-Offset"), "5");
  EXPECT_FALSE(first.headers.Find("Upload-Expires").empty());
  EXPECT_EQ(sample.Get("/api/v1/flights/" + flight + "/files").body, R"({"files":[]})");
  EXPECT_EQ(Patch(sample, at, "4", "x").status, 409);
  EXPECT_EQ(Patch(sample, at, "5", "56789").status, 204);
  EXPECT_EQ(sample.Get("/api/v1/flights/" + flight + "/files").body,
            R"({"files":[{"name":"a b.jpg","bytes":10}]})");
  // Who did not hear of the end asks, and hears.
  EXPECT_EQ(OffsetOf(sample, at), "10");
  EXPECT_TRUE(std::filesystem::is_empty(sample.dir().Uploads()));
}

TEST(Tus, MoreBytesThanPromisedAreRefused) {
  SampleService sample;
  const std::string at = Create(sample, sample.NewFlight(), "3");
  EXPECT_LT(Patch(sample, at, "0", "0123").status, 0);  // the sink stopped the body
  EXPECT_EQ(OffsetOf(sample, at), "0");
}

TEST(Tus, AChecksumCountsForItsChunk) {
  SampleService sample;
  const std::string at = Create(sample, sample.NewFlight(), "5");
  Digest digest(DigestAlgorithm::kSha1);
  const std::string bytes = "01234";
  digest.Add({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
  const std::string good = "sha1 " + EncodeBase64(digest.Finish());
  EXPECT_EQ(Patch(sample, at, "0", "01235", good).status, 460);
  EXPECT_EQ(OffsetOf(sample, at), "0");
  EXPECT_EQ(Patch(sample, at, "0", bytes, "md5 AAAA").status, 400);
  EXPECT_EQ(Patch(sample, at, "0", bytes, good).status, 204);
  EXPECT_EQ(OffsetOf(sample, at), "5");
}

TEST(Tus, TheLengthMayComeLater) {
  SampleService sample;
  const std::string flight = sample.NewFlight();
  const Response made = sample.Send(Method::kPost, "/api/v1/uploads", "01",
                                    Tus({{"Upload-Defer-Length", "1"},
                                         {"Upload-Metadata", Metadata(flight)},
                                         {"Content-Type", "application/offset+octet-stream"}}));
  EXPECT_EQ(made.status, 201);
  EXPECT_EQ(made.headers.Find("Upload-Offset"), "2");
  const std::string at(made.headers.Find("Location"));
  EXPECT_EQ(sample.Get(at, Tus({})).headers.Find("Upload-Defer-Length"), "1");
  Headers last = Tus(
      {{"Upload-Offset", "2"}, {"Upload-Length", "4"}, {"Content-Type", "application/offset+octet-stream"}});
  EXPECT_EQ(sample.Send(Method::kPatch, at, "23", last).status, 204);
  EXPECT_EQ(sample.Get("/api/v1/flights/" + flight + "/files").body,
            R"({"files":[{"name":"a b.jpg","bytes":4}]})");
}

TEST(Tus, AnEndedUploadIsGone) {
  SampleService sample;
  const std::string at = Create(sample, sample.NewFlight(), "5");
  EXPECT_EQ(sample.Send(Method::kDelete, at, "", Tus({})).status, 204);
  EXPECT_EQ(sample.Get(at, Tus({})).status, 404);
  EXPECT_EQ(Patch(sample, at, "0", "01234").status, 404);
  EXPECT_TRUE(std::filesystem::is_empty(sample.dir().Uploads()));
}

TEST(Tus, BadRequestsAreRefused) {
  SampleService sample;
  const std::string good = Metadata(sample.NewFlight());
  const auto post = [&](Headers headers) {
    return sample.Send(Method::kPost, "/api/v1/uploads", "", headers).status;
  };
  EXPECT_EQ(post({}), 412);
  EXPECT_EQ(post(Tus({{"Upload-Metadata", good}})), 400);
  EXPECT_EQ(post(Tus({{"Upload-Length", "5"}, {"Upload-Defer-Length", "1"}, {"Upload-Metadata", good}})),
            400);
  for (const char* length : {"-1", "1e3", "0x5", "99999999999999999999"}) {
    EXPECT_EQ(post(Tus({{"Upload-Length", length}, {"Upload-Metadata", good}})), 400) << length;
  }
  EXPECT_EQ(post(Tus({{"Upload-Length", "5000000000"}, {"Upload-Metadata", good}})), 413);
  EXPECT_EQ(post(Tus({{"Upload-Length", "5"}})), 400);
  EXPECT_EQ(post(Tus({{"Upload-Length", "5"}, {"Upload-Metadata", "flight !!"}})), 400);
  EXPECT_EQ(
      post(Tus({{"Upload-Length", "5"},
                {"Upload-Metadata", "flight " + EncodeBase64("../x") + ",filename " + EncodeBase64("a")}})),
      404);
  const Response options = sample.Send(Method::kOptions, "/api/v1/uploads");
  EXPECT_EQ(options.headers.Find("Tus-Version"), "1.0.0");
}

TEST(TusHeaders, AreReadStrictly) {
  EXPECT_EQ(ParseTusMetadata("a YQ==,b")->at("b"), "");
  EXPECT_EQ(ParseTusMetadata("")->size(), 0u);
  for (const char* bad : {"a YQ==,a YQ==", "a YQ=", "a Y", ",", "a YQ==,", " ", "a YR=="}) {
    EXPECT_FALSE(ParseTusMetadata(bad)) << bad;
  }
  EXPECT_EQ(EncodeBase64(*DecodeBase64("AAEC/w==")), "AAEC/w==");
  EXPECT_EQ(Sha256OfContentDigest("md5=:AA==:, sha-256=:AAEC:"), std::string("\0\1\2", 3));
  EXPECT_FALSE(Sha256OfContentDigest("sha-256=AAEC"));
}

}  // namespace
}  // namespace skyquilt::api
