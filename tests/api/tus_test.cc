// tus over the real routes: creation, chunks, checksums, breaks.
#include "api/uploads/tus_headers.h"
#include "tests/api/sample_service.h"

namespace skyquilt::api {
namespace {

Headers Tus(std::initializer_list<std::pair<const char*, std::string>> more) {
  Headers headers{{"Tus-Resumable", "1.0.0"}};
  for (const auto& [name, value] : more) headers.Add(name, value);
  return headers;
}

std::string Metadata(const std::string& flight, const char* name = "a b.jpg") {
  return "flight " + EncodeBase64(flight) + ",filename " + EncodeBase64(name);
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

TEST(Tus, AnArchiveThatWasNotUnpackedIsNotSaidToHaveArrived) {
  SampleService sample;
  sample.service().unpack = [](const auto&, const auto&, const auto&, std::int64_t) {
    return Result<std::vector<storage::UnpackedFile>>(Error{ErrorCode::kUnavailable, "Stopping.", ""});
  };
  const std::string metadata = Metadata(sample.NewFlight(), "a.zip");
  const Response made = sample.Send(Method::kPost, "/api/v1/uploads", "",
                                    Tus({{"Upload-Length", "5"}, {"Upload-Metadata", metadata}}));
  const std::string at(made.headers.Find("Location"));
  EXPECT_EQ(Patch(sample, at, "0", "bytes").status, 503);
  EXPECT_EQ(sample.Get(at, Tus({})).status, 404);
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
  EXPECT_EQ(sample.Send(Method::kOptions, "/api/v1/uploads").headers.Find("Tus-Version"), "1.0.0");
}

TEST(TusHeaders, AreReadStrictly) {
  EXPECT_EQ(ParseTusMetadata("a YQ==,b")->at("b"), "");
  EXPECT_EQ(ParseTusMetadata("")->size(), 0u);
  for (const char* bad : {"a YQ==,a YQ==", "a YQ=", "a Y", ",", "a YQ==,", " ", "a YR=="}) {
    EXPECT_FALSE(ParseTusMetadata(bad)) << bad;
  }
  EXPECT_EQ(EncodeBase64(*DecodeBase64("AAEC/w==")), "AAEC/w==");
  EXPECT_EQ(DecodeBase64(""), "");
  for (const char* bad : {"YQ=", "YQ", "YR==", "====", "YQ=Q", " YQ==", "YQ==\n\n\n\n", "AAAA    ", "AA-_"}) {
    EXPECT_FALSE(DecodeBase64(bad)) << bad;
  }
  EXPECT_EQ(Sha256OfContentDigest("md5=:AA==:, sha-256=:AAEC:"), std::string("\0\1\2", 3));
  EXPECT_FALSE(Sha256OfContentDigest("sha-256=AAEC"));
}

std::string CreatePart(SampleService& sample, const std::string& bytes, Headers more = Tus({})) {
  more.Add("Upload-Concat", "partial");
  more.Add("Upload-Length", std::to_string(bytes.size()));
  const Response made = sample.Send(Method::kPost, "/api/v1/uploads", "", more);
  EXPECT_EQ(made.status, 201) << made.body;
  return std::string(made.headers.Find("Location"));
}

Response JoinAll(SampleService& sample, const std::string& flight, const std::string& parts,
                 Headers more = Tus({})) {
  more.Add("Upload-Concat", "final;" + parts);
  more.Add("Upload-Metadata", Metadata(flight));
  return sample.Send(Method::kPost, "/api/v1/uploads", "", more);
}

TEST(Tus, PartsBecomeOneFileInTheirOrder) {
  SampleService sample;
  const std::string flight = sample.NewFlight();
  const Response options = sample.Send(Method::kOptions, "/api/v1/uploads");
  EXPECT_NE(options.headers.Find("Tus-Extension").find("concatenation"), std::string_view::npos);
  const std::string one = CreatePart(sample, "01234");
  const std::string two = CreatePart(sample, "567");
  EXPECT_EQ(Patch(sample, two, "0", "567").status, 204);
  EXPECT_EQ(JoinAll(sample, flight, one + " " + two).status, 409);  // one is not complete
  EXPECT_EQ(Patch(sample, one, "0", "01234").status, 204);
  EXPECT_EQ(sample.Get(one, Tus({})).headers.Find("Upload-Concat"), "partial");
  EXPECT_EQ(sample.Get("/api/v1/flights/" + flight + "/files").body, R"({"files":[]})");
  const std::string parts = "http://host" + one + " " + two;
  const Response whole = JoinAll(sample, flight, parts);
  ASSERT_EQ(whole.status, 201) << whole.body;
  const std::string at(whole.headers.Find("Location"));
  EXPECT_EQ(sample.Get("/api/v1/flights/" + flight + "/files/a%20b.jpg").status, 200);
  EXPECT_EQ(sample.Get("/api/v1/flights/" + flight + "/files").body,
            R"({"files":[{"name":"a b.jpg","bytes":8}]})");
  EXPECT_TRUE(std::filesystem::is_empty(sample.dir().Uploads()));
  const Response head = sample.Get(at, Tus({}));
  EXPECT_EQ(head.headers.Find("Upload-Concat"), "final;" + parts);
  EXPECT_EQ(head.headers.Find("Upload-Length"), "8");
  EXPECT_EQ(Patch(sample, at, "8", "x").status, 403);
  EXPECT_EQ(sample.Get(one, Tus({})).status, 404);
  // Who did not hear of it asks again, and there is still one file.
  EXPECT_EQ(JoinAll(sample, flight, parts).headers.Find("Location"), at);
  EXPECT_EQ(JoinAll(sample, flight, one).status, 404);
}

TEST(Tus, RefusalsOfPartsNameTheExtension) {
  SampleService sample;
  const std::string flight = sample.NewFlight();
  const std::string part = CreatePart(sample, "01");
  Patch(sample, part, "0", "01");
  for (const char* bad : {"parts", "final", "final;", "final;/", "Partial"}) {
    const Response refused = sample.Send(
        Method::kPost, "/api/v1/uploads", "",
        Tus({{"Upload-Concat", bad}, {"Upload-Length", "5"}, {"Upload-Metadata", Metadata(flight)}}));
    EXPECT_EQ(refused.status, 400) << bad;
    EXPECT_NE(refused.body.find("concatenation"), std::string::npos) << refused.body;
  }
  EXPECT_EQ(JoinAll(sample, flight, part, Tus({{"Upload-Length", "2"}})).status, 400);
  EXPECT_EQ(JoinAll(sample, flight, part + " " + part).status, 409);
  EXPECT_EQ(JoinAll(sample, flight, "nonsense").status, 404);
  EXPECT_EQ(JoinAll(sample, flight, Create(sample, flight, "5")).status, 409);
  EXPECT_EQ(JoinAll(sample, "", part).status, 400);
  EXPECT_EQ(JoinAll(sample, flight, part).status, 201);
}

TEST(Tus, PartsAreTheirOwnersAndCountForThem) {
  SampleService sample;
  const auto as = [](const Headers& token) {
    Headers headers = Tus({});
    headers.Add("Authorization", std::string(token.Find("Authorization")));
    return headers;
  };
  const Headers one = as(sample.MakeToken("one", storage::Scope::kUpload, 10));
  const Headers other = as(sample.MakeToken("other", storage::Scope::kUpload, 10));
  Headers as_json = one;
  as_json.Add("Content-Type", "application/json");
  const Response made = sample.Send(Method::kPost, "/api/v1/flights", "{}", as_json);
  ASSERT_EQ(made.status, 201) << made.body;
  const std::string flight(made.headers.Find("Location").substr(std::string("/api/v1/flights/").size()));
  const auto patch = [&](const std::string& at, const std::string& bytes, Headers headers) {
    headers.Add("Upload-Offset", "0");
    headers.Add("Content-Type", "application/offset+octet-stream");
    return sample.Send(Method::kPatch, at, bytes, headers).status;
  };
  const std::string part = CreatePart(sample, "012345", one);
  const std::string foreign = CreatePart(sample, "xy", other);
  EXPECT_EQ(patch(part, "012345", one), 204);
  EXPECT_EQ(patch(foreign, "xy", other), 204);
  Headers too_much = one;
  too_much.Add("Upload-Concat", "partial");
  too_much.Add("Upload-Length", "5");
  EXPECT_EQ(sample.Send(Method::kPost, "/api/v1/uploads", "", too_much).status, 413);
  // Without a length the bytes count as they come.
  Headers deferred = one;
  deferred.Add("Upload-Concat", "partial");
  deferred.Add("Upload-Defer-Length", "1");
  const std::string open(
      sample.Send(Method::kPost, "/api/v1/uploads", "", deferred).headers.Find("Location"));
  EXPECT_LT(patch(open, "01234", one), 0);
  EXPECT_EQ(JoinAll(sample, flight, foreign, one).status, 404);
  EXPECT_EQ(JoinAll(sample, flight, part, one).status, 201);
  // The file counts once: there is room for the rest, and no more.
  EXPECT_EQ(sample.Send(Method::kPost, "/api/v1/uploads", "", too_much).status, 413);
  CreatePart(sample, "0123", one);
}

}  // namespace
}  // namespace skyquilt::api
